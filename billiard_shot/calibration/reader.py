"""Recordings with their descriptions, from files of all kinds."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Mapping
import dataclasses
from dataclasses import dataclass, replace
import math
from pathlib import Path
from typing import Any

from billiard_shot.calibration.carom_json import read_carom_json
from billiard_shot.calibration.csv_file import read_csv
from billiard_shot.calibration.recording import Frame, RecordedShot, Recording, USUAL_SIGMA
from billiard_shot.scene import Noise
from billiard_shot.scene.checks import check, read
from billiard_shot.scene.errors import InputError, must_be, refused
from billiard_shot.scene.fields import name, number, section, TAKES
from billiard_shot.scene.yaml_file import read_document
from billiard_shot.shot.stroke import Stroke
from billiard_shot.shot.stroke_file import stroke_from


def _texts(value: object) -> Mapping[str, str]:
    if not isinstance(value, Mapping):
        raise refused(value, 'a mapping of names in the recording to names of balls')
    return {str(key): str(each) for key, each in value.items()}


def _strokes(value: object) -> Mapping[str, Stroke]:
    if not isinstance(value, Mapping):
        raise refused(value, 'a mapping of shots to strokes, such as {1: {a: 0.2, speed: 1.5}}')
    return {
        str(key): each if isinstance(each, Stroke) else stroke_from(each, (0.0, 0.0, 0.0))
        for key, each in value.items()
    }


def _field(convert: Any, default: Any) -> Any:
    return dataclasses.field(default_factory=lambda: default, metadata={TAKES: convert})


@dataclass(frozen=True, slots=True)
class _Frame:
    """As `Frame`, but in degrees, which people type."""

    x: float = number('m', default=0.0)
    y: float = number('m', default=0.0)
    angle_deg: float = number('degrees', minimum=-360.0, maximum=360.0, default=0.0)
    scale: float = number('', above=0.0, default=1.0)
    rate: float = number('', above=0.0, default=1.0)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Description:
    """
    The description of a recording: the content of a YAML file of its name, beside it.

    Parameters
    ----------
    scene : str, optional
        Name or path of the scene with which a calibration begins.
    struck : str, optional
        The ball that the cue hits in all shots; by default the one that moves first.
    balls : mapping of str to str
        Names of balls by those that the recording has.
    sigma : float
        Standard deviation of x and y, if the recording states none [m].
    frame : section
        As `Frame`, with the angle in degrees: `angle_deg`.
    strokes : mapping
        Commanded or measured strokes by the names of shots, as in files of strokes.
    noise : section, optional
        Errors with which the commanded strokes were played, as in scenes; see `RecordedShot`.

    """

    scene: str | None = _field(lambda value: None if value is None else str(value), None)
    struck: str | None = name(nullable=True)
    balls: Mapping[str, str] = _field(_texts, {})
    sigma: float = number('m', above=0.0, maximum=0.1, default=USUAL_SIGMA)
    frame: _Frame = section(_Frame, optional=True)
    strokes: Mapping[str, Stroke] = _field(_strokes, {})
    noise: Noise | None = section(Noise, nullable=True)

    def __post_init__(self) -> None:
        check(self)


def read_recording(path: str | Path) -> Recording:
    """
    Read a recording, and the description beside it.

    Parameters
    ----------
    path : str or Path
        A file .csv, see csv_file.py, or .json, see carom_json.py. A file of the same name that
        ends in .yaml is its `Description`.

    Raises
    ------
    ValueError
        Naming the file, the line and the field of what is wrong.

    """
    path = Path(path)
    about = _description(path.with_suffix('.yaml'))
    if path.suffix == '.csv':
        recording = read_csv(path, about.sigma)
    elif path.suffix == '.json':
        recording = read_carom_json(path)
    else:
        raise ValueError(f'a recording {must_be("a file .csv or .json", str(path))}')
    if unknown := about.strokes.keys() - {shot.name for shot in recording.shots}:
        raise ValueError(f'{path.with_suffix(".yaml")}: strokes: no shot {min(unknown)!r}')
    frame = Frame(
        about.frame.x,
        about.frame.y,
        math.radians(about.frame.angle_deg),
        about.frame.scale,
        about.frame.rate,
    )
    shots = tuple(_named(shot, about) for shot in recording.shots)
    return replace(recording, shots=shots, frame=frame, scene=about.scene)


def _description(path: Path) -> Description:
    if not path.exists():
        return Description()
    document = read_document(path)
    mistakes = list(document.mistakes)
    try:
        found = read(Description, document.data or {})
    except InputError as error:
        mistakes += error.mistakes
    if mistakes:
        raise InputError(mistakes, str(path), document.lines)
    return found


def _named(shot: RecordedShot, about: Description) -> RecordedShot:
    """Name the balls of a shot, and add its struck ball and its stroke with errors."""
    tracks = {about.balls.get(ball, ball): track for ball, track in shot.tracks.items()}
    if len(tracks) < len(shot.tracks):
        raise ValueError(f'balls: shot {shot.name!r} has two balls with the same name')
    return RecordedShot(shot.name, tracks, about.struck, about.strokes.get(shot.name), about.noise)
