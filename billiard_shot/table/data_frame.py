"""Tables of numbers for pandas, which is an extra."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def data_frame(columns: Mapping[str, Any]) -> Any:
    """
    Make a pandas DataFrame, with NaN for numbers that are infinite.

    An infinite time is that of an event that did not happen; `describe` leaves NaN out of means.

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
    return pd.DataFrame(columns).replace([np.inf, -np.inf], np.nan)
