"""The bases of objects that people look at: in notebooks, and as tables of pandas."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar


class Shown:
    """An object that notebooks show as HTML."""

    __slots__ = ()
    pictures: ClassVar[Callable[[str], Any]]
    """Module of `billiard_shot.pictures`, by its name; set by the package, which knows them."""

    def _repr_html_(self) -> str:
        html: str = Shown.pictures('notebook').html_of(self)
        return html


class Tabular:
    """An object that is a table: lengths in m, times in s, spins in rad/s, angles in degrees."""

    __slots__ = ()

    def columns(self) -> Mapping[str, Any]:
        """Return the columns by their names."""
        raise NotImplementedError

    def to_frame(self) -> Any:
        """
        Make a pandas DataFrame of `columns`, with NaN for numbers that are infinite.

        An infinite time is that of an event that did not happen; `describe` leaves NaN out of
        means.

        Raises
        ------
        ValueError
            If pandas is not installed, with the command that installs it.

        """
        try:
            import pandas as pd
        except ImportError:
            raise ValueError(
                "pandas is not installed; it is an extra: pip install 'billiard_shot[frame]'"
            ) from None
        return pd.DataFrame(self.columns()).replace([float('inf'), float('-inf')], float('nan'))
