"""The shots of recordings that can be used, and what is ignored."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.recording import RecordedShot, Recording
from billiard_shot.calibration.watched import FIT_PERIOD, watch, Watched
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import refused

MOST_OUTSIDE = 0.05
"""Part of the places that may be outside of the table, by errors of the tracker."""

Recordings = Recording | str | Path | Sequence[Recording | str | Path]


class Usable(NamedTuple):
    """A shot that can be used: number of its recording, as it was read, and as fits take it."""

    recording: int
    shot: RecordedShot
    watched: Watched


def read_recordings(recordings: Recordings) -> list[Recording]:
    """Read recordings; ValueError names the file, line and field of what is wrong."""
    if isinstance(recordings, Recording | str | Path):
        recordings = [recordings]
    read = [each if isinstance(each, Recording) else read_recording(each) for each in recordings]
    if not read:
        raise refused(recordings, 'at least one recording', 'recordings')
    return read


def named_scene(recordings: Sequence[Recording]) -> Scene:
    """Load the scene that a recording names; ValueError if none does."""
    for each in recordings:
        if each.scene is not None:
            return Scene.load(each.scene)
    raise ValueError(
        f'scene is missing: {recordings[0].name} has no description (.yaml) that names one'
    )


def check_places(scene: Scene, usable: Sequence[Usable], recordings: Sequence[Recording]) -> None:
    """
    Check that balls are on the table.

    Raises
    ------
    ValueError
        Naming a recording whose balls are not: it has another unit or frame.

    """
    if scene.table is None:
        raise ValueError('scene must have a table, got an endless cloth')
    half = np.array([scene.table.length, scene.table.width]) / 2.0
    for number, recording in enumerate(recordings):
        seen = [each.watched.place for each in usable if each.recording == number]
        if not seen:
            continue
        places = recording.frame.to_table(np.concatenate(seen))
        outside = (np.abs(places) > half).any(axis=-1).mean()
        if outside > MOST_OUTSIDE:
            low, high = places.min(axis=0), places.max(axis=0)
            raise ValueError(
                f'{recording.name}: {outside:.0%} of the places are outside of the table, x from '
                f'{low[0]:.3g} to {high[0]:.3g} and y from {low[1]:.3g} to {high[1]:.3g} m; is '
                'the frame or the unit another one?'
            )


def check_enough(count: int, least: int, what: str, ignored: Sequence[str]) -> None:
    """Raise ValueError if there are too few shots; it names what is ignored."""
    if count < least:
        got = '\n  '.join([str(count), *ignored])
        raise ValueError(f'recordings must have at least {least} {what}, got {got}')


def usable_shots(recordings: Sequence[Recording]) -> tuple[list[Usable], list[str]]:
    """Return the shots that can be used, and what is ignored and why."""
    found, ignored = [], []
    for number, recording in enumerate(recordings):
        ignored += [f'{recording.name}: {each}' for each in recording.ignored]
        for shot in recording.shots:
            try:
                watched = watch(shot, recording.frame.rate, FIT_PERIOD)
            except ValueError as error:
                ignored.append(f'{recording.name}: {error}')
            else:
                ignored += [f'{recording.name}: {each}' for each in watched.left_out]
                found.append(Usable(number, shot, watched))
    return found, ignored
