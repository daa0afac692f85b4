"""Numbers as callers give them: Python's and numpy's. Wrong ones are refused by the name of their parameter."""
from __future__ import annotations

import math
from typing import Any

import numpy as np

MAX_MS = 2**31 - 1  # of a time-out of ZeroMQ


def plain(value: Any) -> Any:
    """A numpy number as Python's; other values unchanged."""
    return value.item() if isinstance(value, (np.generic, np.ndarray)) and value.ndim == 0 else value


def number(name: str, value: Any, least: float = -math.inf) -> float:
    """A number that is at least `least`; may be infinite. Raises ValueError with the parameter's `name`."""
    given = plain(value)
    if not isinstance(given, (int, float)) or not given >= least:
        raise ValueError(f"{name}: must be a number" + (f" of at least {least:g}" if math.isfinite(least) else "") + f", not {given!r}")
    return float(given)


def whole(name: str, value: Any, least: int = 1) -> int:
    """A whole number that is at least `least`; 5.0 is 5. Raises ValueError with the parameter's `name`."""
    given = plain(value)
    if not isinstance(given, (int, float)) or not math.isfinite(given) or given != int(given) or given < least:
        raise ValueError(f"{name}: must be a whole number of at least {least}, not {given!r}")
    return int(given)


def milliseconds(name: str, seconds: float | None) -> int | None:
    """A time-out for ZeroMQ; None, forever, of None and of infinity. Raises ValueError with the parameter's `name`."""
    if seconds is None or (given := number(name, seconds, 0.0)) == math.inf:
        return None
    return int(min(1e3 * given, MAX_MS))
