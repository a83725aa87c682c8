"""How well a scene predicts recorded shots that it was not fitted to."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from billiard_shot.calibration.comparison import FIRST_SCALES
from billiard_shot.calibration.launch import contacts_of, ways_of
from billiard_shot.calibration.launch_search import search_launches
from billiard_shot.calibration.model import Model
from billiard_shot.calibration.recording import Floats, RecordedShot
from billiard_shot.calibration.watched import FIT_PERIOD, watch, Watched

SPANS = 1.0, 2.0, 5.0, np.inf
"""Times from the strike on over which errors are stated [s]."""

QUANTILES = 0.1, 0.5, 0.9


@dataclass(frozen=True, slots=True, eq=False)
class Check:
    """
    A recorded shot beside the same shot as it is predicted after its best launch.

    Attributes
    ----------
    watched : Watched
    recording : int
        Number of its recording.
    launch : (numbers,) float array
        See launch.py.
    places : (samples, 2) float array
        Where its samples lie as predicted, in the frame of the recording [m].
    contacts : (contacts,) float array
        Times at which balls meet balls and cushions, as predicted [s].

    """

    watched: Watched
    recording: int
    launch: Floats
    places: Floats
    contacts: Floats

    @property
    def times(self) -> Floats:
        """Times of the samples, from the strike on [s]."""
        return self.watched.times[self.watched.at]

    @property
    def errors(self) -> Floats:
        """Distances of the samples from their predicted places [m]."""
        errors: Floats = np.linalg.norm(self.places - self.watched.place, axis=-1)
        return errors

    def rmse(self, until: float = np.inf) -> float:
        """Root of the mean square of the errors of all balls up to a time [s], in m."""
        inside = self.times <= until
        share = self.watched.share[inside]
        return float(np.sqrt(share @ self.errors[inside] ** 2 / share.sum()))


def check(item: tuple[Model, int, RecordedShot, float, Sequence[int]]) -> Check | None:
    """
    Predict a shot of a recording after its best launch; None if no launch can be simulated.

    The launch is searched with the samples up to a time [s], from a seed.

    Raises
    ------
    ValueError
        If the shot cannot be used.

    """
    model, recording, shot, seen, seed = item
    frame = model.frames[recording]
    watched = watch(shot, frame.rate, FIT_PERIOD)
    draw = np.random.default_rng(seed)
    found = search_launches(model.scene, frame, watched, FIRST_SCALES, seen, draw)
    return checked(model, recording, shot, found.launches[0]) if len(found.costs) else None


def checked(model: Model, recording: int, shot: RecordedShot, launch: Floats) -> Check:
    """Compare a recorded shot with the path of a launch (numbers,)."""
    frame = model.frames[recording]
    watched = watch(shot, frame.rate)
    places = ways_of(model.scene, frame, watched, launch[np.newaxis])[0]
    contacts = contacts_of(model.scene, frame, watched, launch)
    return Check(watched, recording, launch, places, contacts)


def quantiles(checks: Sequence[Check]) -> Floats:
    """Return the quantiles (spans, quantiles) of the errors of shots [m]."""
    errors = np.array([[each.rmse(span) for span in SPANS] for each in checks])
    found: Floats = np.quantile(errors, QUANTILES, axis=0).T
    return found


def in_words(checks: Sequence[Check]) -> str:
    """Say how large the errors of whole shots are."""
    low, median, high = (100.0 * quantiles(checks)[-1]).tolist()
    return f'median {median:.1f} cm (10 %: {low:.1f}, 90 %: {high:.1f})'
