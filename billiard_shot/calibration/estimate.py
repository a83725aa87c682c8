"""What a calibration found out about a number."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Estimate:
    """
    A number that was sought.

    Attributes
    ----------
    name, unit : str
    value : float
        The one before, if these shots do not decide the number.
    before : float
    interval : (float, float), optional
        Holds the truth in 95 % of calibrations; None if these shots do not decide the number.
    shots : tuple of str
        Those that decide it, the most important one first.
    published : (float, float), optional
        Range of published values.

    """

    name: str
    unit: str
    value: float
    before: float
    interval: tuple[float, float] | None = None
    shots: tuple[str, ...] = ()
    published: tuple[float, float] | None = None
