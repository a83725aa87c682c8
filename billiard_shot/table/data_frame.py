"""Tables of numbers for pandas, which is an extra."""

from collections.abc import Mapping
from typing import Any


def data_frame(columns: Mapping[str, Any]) -> Any:
    """Make a pandas DataFrame; ValueError if there is no pandas, with what installs it."""
    try:
        import pandas as pd
    except ImportError:
        raise ValueError(
            "pandas is not installed; it is an extra: pip install 'billiard_shot[frame]'"
        ) from None
    return pd.DataFrame(columns)
