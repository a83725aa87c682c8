"""The numbers that a calibration seeks: of a scene, and of the frames of its recordings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from billiard_shot.calibration.recording import Floats, Frame, Recording
from billiard_shot.scene import Scene
from billiard_shot.scene.parameters import Parameter

USUAL_NAMES = (
    'cloth.sliding_friction',
    'cloth.rolling_resistance',
    'cloth.rolling_rise',
    'cloth.spin_deceleration',
    'contacts.ball_ball.restitution',
    'contacts.ball_ball.friction_fast',
    'contacts.ball_ball.friction_slow',
    'table.cushion.restitution',
    'table.cushion.friction',
    'table.cushion.early_fading',
    'table.cushion.fading',
    'table.length',
    'table.width',
)
"""Numbers that recordings of whole shots can decide."""

CUE_NAMES = 'contacts.cue_ball.restitution', 'cue.mass', 'cue.end_mass'
"""Numbers that shots can decide whose strokes were commanded."""

UNPUBLISHED = 0.5
"""Width of the range in which a number without published range is sought, relative to it."""

WIDTHS = {
    'cloth.rolling_rise': 3e-3,
    'contacts.ball_ball.friction_fast': 0.06,
    'contacts.ball_ball.friction_slow': 0.1,
    'table.cushion.early_fading': 0.1,
    'table.cushion.fading': 0.04,
    'table.length': 0.03,
    'table.width': 0.03,
}
"""Widths of ranges that are not relative to the number: it may be 0, or it is measured."""

SQUARED = ('table.cushion.fading',)
"""Numbers that act by their squares: a fit of these moves away from 0 too. So are their widths."""

LEAST_END_MASS = 5e-4
"""Lighter ends of cues meet the ball again and again, and deflect it no less [kg]."""

STEP = 1e-3
"""Step for differences, relative to the width of the range."""

FRAME_WIDTHS = {'x': 0.03, 'y': 0.03, 'angle': 0.02}
"""Ranges in which numbers of frames are sought: m, m and rad."""


@dataclass(frozen=True, slots=True)
class Sought:
    """
    A number that is sought.

    Attributes
    ----------
    name : str
    unit : str
    start : float
    low, high : float
        Bounds of allowed values.
    width : float
        Of the range of values that are likely before the calibration, around `start`.
    published : (float, float), optional
        Range of published values.
    recording : int
        Number of the recording whose frame has it; -1: it is one of the scene.
    squared : bool
        Whether a fit seeks its square: then start, bounds and width are those of the square.

    """

    name: str
    unit: str
    start: float
    low: float
    high: float
    width: float
    published: tuple[float, float] | None = None
    recording: int = -1
    squared: bool = False

    def stated(self, value: float) -> float:
        """Return the number that a value of the fit stands for."""
        return math.sqrt(value) if self.squared else value


@dataclass(frozen=True, slots=True)
class Model:
    """A scene without balls, and the frames of the recordings."""

    scene: Scene
    frames: tuple[Frame, ...]

    def with_values(self, sought: Sequence[Sought], values: Floats) -> 'Model':
        """Return the model with other numbers."""
        own = [k for k, each in enumerate(sought) if each.recording < 0]
        scene = self.scene.with_parameters(
            [sought[k].name for k in own], [sought[k].stated(float(values[k])) for k in own]
        )
        frames = list(self.frames)
        for each, value in zip(sought, values.tolist(), strict=True):
            if each.recording >= 0:
                field = each.name.split('.')[1]
                frames[each.recording] = replace(frames[each.recording], **{field: value})
        return Model(scene, tuple(frames))


def model_of(scene: Scene, recordings: Sequence[Recording]) -> Model:
    """Return the model with which a calibration begins."""
    return Model(replace(scene, balls={}), tuple(each.frame for each in recordings))


def sought_in(
    scene: Scene, recordings: Sequence[Recording], names: Sequence[str] | None
) -> tuple[Sought, ...]:
    """
    Return the numbers to seek: those of a scene, and places and angles of the frames.

    Raises
    ------
    ValueError
        If a name is unknown.

    """
    if names is None:
        known = {each.name for each in scene.parameters()}
        commanded = any(shot.command for each in recordings for shot in each.shots)
        usual = (*USUAL_NAMES, *CUE_NAMES) if commanded else USUAL_NAMES
        names = [name for name in usual if name in known]
    found = [_of_scene(each) for each in scene.parameters(names)]
    for number, recording in enumerate(recordings):
        for field, width in FRAME_WIDTHS.items():
            start = getattr(recording.frame, field)
            name = f'frame.{field}' if len(recordings) == 1 else f'frame.{field}.{number + 1}'
            unit = 'rad' if field == 'angle' else 'm'
            bounds = start - width, start + width
            found.append(Sought(name, unit, start, *bounds, width, recording=number))
    return tuple(found)


def _of_scene(parameter: Parameter) -> Sought:
    width = WIDTHS.get(parameter.name, UNPUBLISHED * abs(parameter.value))
    if parameter.published is not None and parameter.name not in WIDTHS:
        width = parameter.published[1] - parameter.published[0]
    power = 2.0 if parameter.name in SQUARED else 1.0
    return Sought(
        parameter.name,
        parameter.unit,
        parameter.value**power,
        LEAST_END_MASS if parameter.name == 'cue.end_mass' else parameter.low**power,
        parameter.high**power,
        width,
        parameter.published,
        squared=power == 2.0,
    )


def values_of(sought: Sequence[Sought]) -> Floats:
    """Return the values with which a calibration begins."""
    return np.array([each.start for each in sought])


def widths_of(sought: Sequence[Sought]) -> Floats:
    """Return the widths of the ranges."""
    return np.array([each.width for each in sought])


def within(sought: Sequence[Sought], values: Floats) -> Floats:
    """Return values moved into their bounds, with room for a difference."""
    room = STEP * widths_of(sought)
    low = np.array([each.low for each in sought]) + room
    high = np.array([each.high for each in sought]) - room
    return np.clip(values, low, high)
