"""`billiard-shot predict`: predict the shot of a stroke."""

import argparse
from dataclasses import dataclass
import json
import math
from pathlib import Path
import sys
from typing import Any, ClassVar

from billiard_shot import effects_of, save_shot, Shot
from billiard_shot.cli.options import option
from billiard_shot.cli.output import OfFormat, print_csv
from billiard_shot.cli.shots import of_each, SHOT_OPTIONS, shots_of, title_of
from billiard_shot.pictures.history import draw_history, draw_strike
from billiard_shot.pictures.table import draw_shot
from billiard_shot.pictures.trails import trails_of
from billiard_shot.planning.result import why_missed
from billiard_shot.scene.errors import must_be_one_of
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import OFFSETS
from billiard_shot.shot.shot import wrapped_fact
from billiard_shot.table.run.results import POCKET_NAMES


@dataclass(frozen=True)
class OfMiss:
    """
    The ball that should fall.

    Parameters
    ----------
    pot : BALL
        Say why this ball does not fall (into --pocket): thick or thin, and why (default: the ball
        of --aim, if --pocket is given).

    """

    pot: str | None = None


@dataclass(frozen=True)
class OfShotFiles:
    """
    The files.

    Parameters
    ----------
    output : FILE.json
        Write the shot: the complete input and result.
    picture : FILE.png
        Draw the table from above.
    history : FILE.png
        Draw speed, spin and energy over time.
    close_up : FILE.png
        Draw the strike: forces, friction, slip and energy.

    """

    TITLE: ClassVar = 'files; FILE-NAME for each of several strokes'
    output: Path | None = option('-o')
    picture: Path | None = None
    history: Path | None = None
    close_up: Path | None = None


OPTIONS = *SHOT_OPTIONS, OfFormat(), OfMiss(), OfShotFiles()


def run(options: argparse.Namespace) -> int:
    """Predict, write the files, and print; 1 if a stroke was refused."""
    if options.aim and options.pocket and options.pot is None:
        options.pot = options.aim[0]
    shots = shots_of(options)
    misses = {name: _why_missed(shot, options) for name, shot in shots.items()}
    for name, shot in shots.items():
        _write(name, shot, shots, options)
    if options.json:
        for name, shot in shots.items():
            said = _as_json(name, shot) | ({'miss': misses[name]} if options.pot else {})
            print(json.dumps(said, allow_nan=False))
    elif options.csv:
        rows = [_as_row(name, shot) for name, shot in shots.items()]
        print_csv(rows, list(rows[0]))
    else:
        for name, shot in shots.items():
            if shot.status.refused:
                continue  # it is reported below
            if len(shots) > 1:
                print(f'stroke {name}')
            print(shot)
            if misses[name]:
                print(wrapped_fact('missed', misses[name]))
            if len(shots) > 1:
                print()
    for name, shot in shots.items():
        if shot.status.refused:
            text = f'{shot.status.name}: {shot.message}'
            print(title_of(name, text, shots), file=sys.stderr)
    return 1 if any(shot.status.refused for shot in shots.values()) else 0


def _write(name: str, shot: Shot, shots: dict[str, Shot], options: argparse.Namespace) -> None:
    """Write the files of a shot; of a refused one, no pictures."""
    if options.output:
        save_shot(shot, of_each(options.output, name, shots))
    if shot.status.refused:
        return
    title = f'{shot.status.name}: {shot.message}'
    if options.picture:
        draw_shot(shot, of_each(options.picture, name, shots))
    if options.history:
        draw_history(trails_of(shot), of_each(options.history, name, shots), title)
    if options.close_up:
        draw_strike(shot, of_each(options.close_up, name, shots), title)


def _strike(name: str, shot: Shot) -> dict[str, Any]:
    """Make the part that JSON and CSV share."""
    return {
        'stroke': name,
        **dict(zip(OFFSETS, shot.stroke.offsets, strict=True)),
        'status': shot.status.name,
        'miscue': shot.miscue,
        'message': shot.message,
        'velocity': shot.velocity.tolist(),
        'spin': shot.spin.tolist(),
        'cue_speed': shot.cue_speed,
    }


def _as_json(name: str, shot: Shot) -> dict[str, Any]:
    """Make the object of a shot for JSON; a ball that is not on the cloth has no place."""
    places = {
        ball: None if ball in {*shot.pocketed, *shot.off_table} else place.tolist()
        for ball, place in shot.final_position.items()
    }
    return _strike(name, shot) | {
        'phases': [list(phase.active) for phase in shot.impact.phases],
        'dissipated': shot.impact.dissipated.tolist(),
        'first_contact': shot.first_contact,
        'pocketed': shot.pocketed,
        'off_table': list(shot.off_table),
        'scratched': shot.scratched,
        'rest': places[CUE_BALL],
        'duration': shot.trajectory.duration,
        'balls': places,
        'events': [
            {
                'time': event.time,
                'kind': event.kind,
                'balls': list(event.balls),
                'place': event.place,
                'position': event.position.tolist(),
            }
            for event in shot.events
        ],
        'effects': [
            {'name': effect.name, 'simulated': effect.simulated, 'reason': effect.reason}
            for effect in effects_of(shot)
        ],
        'error_estimate': shot.error_estimate,
        'evaluations': shot.evaluations,
        'wall_time': shot.wall_time,
    }


def _as_row(name: str, shot: Shot) -> dict[str, Any]:
    """Make the row of a shot for CSV."""
    return _strike(name, shot) | {
        'rest': [math.nan] * 3 if shot.scratched else shot.trajectory.final_position.tolist(),
        'duration': shot.run.duration,
        'first_contact': shot.first_contact,
        'pocketed': ' '.join(shot.pocketed),
        'scratched': shot.scratched,
        'error_estimate': shot.error_estimate,
    }


def _why_missed(shot: Shot, options: argparse.Namespace) -> str:
    """Explain why the ball of --pot does not fall; '' if it falls, or without --pot."""
    if options.pot is None:
        return ''
    table = shot.scene.table
    balls = list(shot.scene.object_balls)
    if options.pot not in balls or table is None or not table.pockets:
        raise ValueError(
            f'--pot {must_be_one_of(balls, options.pot, "ball")}, on a table with pockets'
        )
    pockets = [options.pocket] if options.pocket else POCKET_NAMES
    return why_missed(shot, options.pot, pockets)
