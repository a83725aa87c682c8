"""The estimate of a number that a calibration seeks."""

from dataclasses import dataclass


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
