"""Description of one field of a stream, or of one param of a method."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Field:
    """One field, from the daemon's field tables. Of an array, `kind` and the range are those of its items."""

    kind: str
    """JSON type: number, integer, boolean or string"""
    is_array: bool
    unit: str
    """"" if there is none"""
    description: str
    minimum: float | None
    maximum: float | None
