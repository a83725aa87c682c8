"""The result of a calibration: how well its scene predicts shots, its file and its report."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billiard_shot.calibration.estimate import Estimate, write_yaml
from billiard_shot.calibration.launch import (
    CalibrationModel,
    contacts_of,
    FIRST_SCALES,
    middle_launch,
    search_launches,
    SHORT,
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

SPANS = 1.0, 2.0, 5.0, np.inf
"""Times from the strike on over which errors are stated [s]."""

QUANTILES = 0.1, 0.5, 0.9


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

        If less than half a second was seen, many launches explain it: then one is taken whose
        path is in the middle of those of the others, see launch.py.

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
        short = seen < SHORT and shot.command is None and len(self.spins) > 0
        period = 0.0 if short else FIT_PERIOD  # of few samples, all count
        samples = samples_of(shot, self.frames[recording].rate, period, recording)
        if short:
            draw = np.random.default_rng(seed)
            launch = middle_launch(model, samples, seen, self.spins, draw)
            found = None if launch is None else check_of(model, samples, launch)
        else:
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
