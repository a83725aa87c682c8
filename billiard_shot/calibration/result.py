"""The result of a calibration: its numbers, how well its scene predicts shots, file and report."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from billiard_shot.calibration.launch import (
    CalibrationModel,
    contacts_of,
    FIRST_SCALES,
    likely_spins,
    search_launches,
    ways_of,
)
from billiard_shot.calibration.recording import (
    FIT_PERIOD,
    Floats,
    Frame,
    RecordedShot,
    Samples,
    samples_of,
)
from billiard_shot.notebook import Shown
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import printable

USUAL_NAMES = {
    'cloth.sliding_friction': 'straight shots with draw that meet nothing for a metre',
    'cloth.rolling_resistance': 'slow balls that roll to rest without meeting anything',
    'cloth.rolling_rise': 'balls that roll without meeting anything, slow ones and fast ones',
    'cloth.spin_deceleration': 'slow shots with much side that come back from a far cushion',
    'contacts.ball_ball.restitution': 'full hits on a ball, and how far both balls go',
    'contacts.ball_ball.friction_fast': 'fast cuts of 30 to 60 degrees without side',
    'contacts.ball_ball.friction_slow': 'slow cuts of 30 to 60 degrees without side',
    'table.cushion.restitution': 'rolling balls straight at a cushion, slow ones and fast ones',
    'table.cushion.friction': 'rolling balls at 30 to 60 degrees at a cushion, and side',
    'table.cushion.early_fading': 'slow balls straight at a cushion, at 0.2 to 1 m/s',
    'table.cushion.fading': 'balls straight at a cushion at 2 m/s and more',
    'table.cushion.frequency_ratio': 'balls that still slide when they meet a cushion',
    'table.length': 'balls that bounce off both short cushions',
    'table.width': 'balls that bounce off both long cushions',
}
"""Numbers that recordings of whole shots can decide, and the shots that do."""

ANYTHING = 'more shots that go over the whole table'
KEPT = 'not identifiable from these shots: default kept'

SPANS = 1.0, 2.0, 5.0, np.inf
"""Times from the strike on over which errors are stated [s]."""

QUANTILES = 0.1, 0.5, 0.9

SHORT = 0.5
"""If no more than this was seen [s], all samples count."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """
    A number that was sought.

    Attributes
    ----------
    name, unit : str
    before : float
        The value with which the calibration began.
    published : (float, float), optional
        Range of published values.
    value : float
        The one before, if these shots do not decide the number.
    interval : (float, float), optional
        Holds the truth in 95 % of calibrations; None if these shots do not decide the number.
    shots : tuple of str
        Those that decide it, the most important one first.

    """

    name: str
    unit: str
    before: float
    published: tuple[float, float] | None
    value: float
    interval: tuple[float, float] | None
    shots: tuple[str, ...]


def write_yaml(
    path: str | Path,
    content: Mapping[str, Any],
    estimates: Sequence[Estimate],
    heading: Sequence[str],
) -> None:
    """
    Write a file such as that of a scene.

    Parameters
    ----------
    path : str or Path
    content : mapping
        Sections and their keys.
    estimates : sequence of Estimate
        Those of the content get a comment beside their key, all others above it.
    heading : sequence of str
        Lines above it.

    """
    about = {each.name: comment_on(each) for each in estimates}
    lines = list(_lines(content, (), about))
    others = [f'{name} {text}' for name, text in about.items()]  # of frames
    comments = [f'# {printable(line)}' for line in (*heading, *others)]
    Path(path).write_text('\n'.join([*comments, *lines]) + '\n', encoding='utf-8')


def comment_on(estimate: Estimate) -> str:
    """Say the interval of a number, and which shots decide it."""
    if estimate.interval is None:
        return KEPT
    low, high = estimate.interval
    unit = f' {estimate.unit}' if estimate.unit else ''
    shots = f'; decided by shots {", ".join(estimate.shots)}' if estimate.shots else ''
    return (
        f'{estimate.value:.4g}{unit}, 95 %: {low:.4g} to {high:.4g}, before: '
        f'{estimate.before:.4g}{shots}'
    )


def _lines(
    section: Mapping[str, Any], path: tuple[str, ...], about: dict[str, str]
) -> Iterator[str]:
    """Yield the lines of a section; comments that are used are taken from `about`."""
    indent = '  ' * len(path)
    for key, value in section.items():
        here = (*path, key)
        name = yaml.safe_dump(key, default_flow_style=True).split('\n')[0]
        if isinstance(value, Mapping) and value:
            yield f'{indent}{name}:'
            yield from _lines(value, here, about)
            continue
        if comment := about.pop('.'.join(here), None):
            yield f'{indent}# {printable(comment)}'
        text = yaml.safe_dump(value, default_flow_style=True, width=1000).split('\n')[0]
        yield f'{indent}{name}: {text}'


def advice(estimates: Iterable[Estimate]) -> list[tuple[str, str]]:
    """Return what to film for each number that is not known, by its name."""
    unknown = [each.name for each in estimates if each.interval is None]
    return [(name, USUAL_NAMES.get(name, ANYTHING)) for name in unknown]


@dataclass(frozen=True, slots=True, eq=False)
class Check:
    """
    A recorded shot beside the same shot as it is predicted after its best launch.

    Attributes
    ----------
    samples : Samples
    launch : (numbers,) float array
        See launch.py.
    places : (samples, 2) float array
        Where its samples lie as predicted, in the frame of the recording [m].
    contacts : (contacts,) float array
        Times at which balls meet balls and cushions, as predicted [s].

    """

    samples: Samples
    launch: Floats
    places: Floats
    contacts: Floats

    @property
    def times(self) -> Floats:
        """Times of the samples, from the strike on [s]."""
        return self.samples.time

    @property
    def errors(self) -> Floats:
        """Distances of the samples from their predicted places [m]."""
        errors: Floats = np.linalg.norm(self.places - self.samples.place, axis=-1)
        return errors

    def rmse(self, until: float = np.inf) -> float:
        """Root of the mean square of the errors of all balls up to a time [s], in m."""
        inside = self.times <= until
        share = self.samples.share[inside]
        return float(np.sqrt(share @ self.errors[inside] ** 2 / share.sum()))


def searched_check(
    model: CalibrationModel, seen: float, item: tuple[Samples, Sequence[int]]
) -> Check | None:
    """
    Predict a shot after its best launch; None if no launch can be simulated.

    The launch is searched with the samples up to a time [s], from a seed.
    """
    samples, seed = item
    draw = np.random.default_rng(seed)
    found = search_launches(model, samples, FIRST_SCALES, seen, draw)
    return check_of(model, samples, found.launches[0]) if len(found.costs) else None


def check_of(model: CalibrationModel, samples: Samples, launch: Floats) -> Check:
    """Compare all that was recorded of a shot with the path of a launch (numbers,)."""
    samples = samples_of(samples.shot, model.frame(samples).rate, 0.0, samples.recording)
    places = ways_of(model, samples, launch[np.newaxis])[0]
    return Check(samples, launch, places, contacts_of(model, samples, launch))


def quantiles(checks: Sequence[Check]) -> Floats:
    """Return the quantiles (spans, quantiles) of the errors of shots [m]."""
    errors = np.array([[each.rmse(span) for span in SPANS] for each in checks])
    found: Floats = np.quantile(errors, QUANTILES, axis=0).T
    return found


def checks_in_words(checks: Sequence[Check]) -> str:
    """Say how large the errors of whole shots are."""
    low, median, high = (100.0 * quantiles(checks)[-1]).tolist()
    return f'median {median:.1f} cm (10 %: {low:.1f}, 90 %: {high:.1f})'


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """
    A scene that was fitted to recorded shots.

    Attributes
    ----------
    scene : Scene
    estimates : tuple of Estimate
        Of the scene and of the frames of the recordings.
    frames : tuple of Frame
        Of the recordings.
    recordings : tuple of str
        Their names.
    doubts : tuple of str
        Why the fit did not converge; empty if it did.
    fitted : tuple of str
        Names of the shots that were fitted.
    spins : (shots, 3) float array
        Follow, side and masse relative to the speed of those whose stroke was not commanded.
    checks, checks_before : tuple of Check
        The shots that were held out: as the scene predicts them, and as the scene did with which
        the calibration began.
    notes : tuple of str
        How exact the recorded places are, and which numbers are at one of their bounds.
    ignored : tuple of str
        What was left out, and why.

    """

    scene: Scene
    estimates: tuple[Estimate, ...]
    frames: tuple[Frame, ...]
    recordings: tuple[str, ...]
    doubts: tuple[str, ...]
    fitted: tuple[str, ...]
    spins: Floats
    checks: tuple[Check, ...]
    checks_before: tuple[Check, ...]
    notes: tuple[str, ...]
    ignored: tuple[str, ...]

    def __repr__(self) -> str:
        known = sum(each.interval is not None for each in self.estimates)
        state = 'converged' if self.converged else 'NOT converged'
        text = f'{known} of {len(self.estimates)} numbers identified'
        return f'Calibration({state}, {text}, {len(self.fitted)} shots fitted)'

    @property
    def converged(self) -> bool:
        """Whether the fit found the minimum; if not, values and intervals say little."""
        return not self.doubts

    @property
    def state(self) -> str:
        """Whether the fit converged, in words."""
        if self.converged:
            return 'converged'
        return '; '.join(['NOT converged: do not rely on values and intervals', *self.doubts])

    def predict(
        self, shot: RecordedShot, seen: float = np.inf, recording: int = 0, seed: int = 1
    ) -> Check:
        """
        Predict a recorded shot after the launch that explains it best.

        Likely spins are those of the shots that were fitted: the first samples tell hardly more.

        Parameters
        ----------
        shot : RecordedShot
        seen : float
            Time from the strike on until which samples tell the launch [s]; by default all do.
        recording : int
            Number of the recording whose frame the shot has.
        seed : int
            Of the search.

        Raises
        ------
        ValueError
            If the shot cannot be used, or no launch of it can be simulated.

        """
        model = CalibrationModel(self.scene, self.frames)
        period = 0.0 if seen < SHORT else FIT_PERIOD
        samples = samples_of(shot, self.frames[recording].rate, period, recording)
        samples = replace(samples, spins=likely_spins(self.spins))
        found = searched_check(model, seen, (samples, (seed,)))
        if found is None:
            raise ValueError(f'shot {shot.name!r}: no launch can be simulated')
        return found

    def save(self, path: str | Path) -> None:
        """Write the scene as YAML, with a comment for each number that was sought."""
        heading = [
            f'Fitted to {len(self.fitted)} shots of {", ".join(self.recordings)}: {self.state}.',
            'Intervals: each shot left out in turn.',
        ]
        write_yaml(path, self.scene.to_dict(), self.estimates, heading)

    def report(self, path: str | Path) -> None:
        """Write a page for a browser: how well the scene predicts, and what is known."""
        Shown.pictures('calibration').write_report(self, Path(path))
