"""How accurately strokes are played."""

from typing import NamedTuple

DEFAULT_SHOT_TOLERANCE = 1e-4  # m


class Accuracy(NamedTuple):
    """How accurately strokes are played."""

    tolerance: float  # m, of trajectories
    # Whether errors are estimated, and a stroke that does not keep the tolerance is told.
    checked: bool = True
    fast_rebounds: bool = False  # see `TableTask`


USUAL_ACCURACY = Accuracy(DEFAULT_SHOT_TOLERANCE)
