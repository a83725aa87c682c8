"""Arguments of entries, as JSON has them."""

import math
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """Return arguments as JSON has them; arrays of zeros as their shapes."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value).replace('inf', 'Infinity')  # JSON has none; this is one in JavaScript
    if isinstance(value, dict):
        return {name: plain(each) for name, each in value.items()}
    if hasattr(value, '_asdict'):
        return plain(value._asdict())
    if not isinstance(value, np.ndarray):
        return value
    if not any(value.tobytes()):
        return {'shape': value.shape}
    rows, names = value.ravel().tolist(), value.dtype.names
    if names:
        rows = [dict(zip(names, map(_field, row), strict=True)) for row in rows]
    return {'shape': value.shape, 'values': [plain(row) for row in rows]}


def _field(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value
