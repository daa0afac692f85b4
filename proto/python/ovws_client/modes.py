"""Modes as people give them: by OSA/ANSI index, by orders (n, m), or by name; as dict, array or list."""
from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .mode_names import MODE_NAMES
from .zernike import MAX_J, orders, osa_index

ModeKey = int | str | tuple[int, int]
#: {mode: waves}, coefficients of j = 1, 2, … (as in `Wavefront.coefficients_waves`), or a list of {"j", "waves"} or {"n", "m", "waves"}.
Modes = Mapping[ModeKey, float] | Mapping[int, float] | Mapping[str, float] | Sequence[float] | Sequence[Mapping[str, Any]] | NDArray[np.floating[Any]]


def mode_name(j: int) -> str:
    """Name of a mode: "oblique astigmatism", "vertical coma", …; "Z(n,m)" if it has no common name."""
    n, m = orders(j)
    return MODE_NAMES[j] if j < len(MODE_NAMES) else f"Z({n},{m})"


def mode_index(mode: ModeKey) -> int:
    """OSA/ANSI index of a mode given by index, orders (n, m) or name. Capitals do not matter, and _ and - are spaces. Words of a name suffice
    if no other name has them: "spherical". Raises ValueError with the names that are possible."""
    if isinstance(mode, tuple):
        return osa_index(*mode)
    if not isinstance(mode, str):
        j = int(mode)
        if j != mode or not 0 <= j <= MAX_J:
            raise ValueError(f"mode {mode}: the OSA/ANSI index must be an integer from 0 to {MAX_J}")
        return j
    if found := re.fullmatch(r"\s*Z\(\s*(\d+)\s*,\s*([-+]?\d+)\s*\)\s*", mode, re.IGNORECASE):
        return osa_index(int(found[1]), int(found[2]))
    wanted = mode.lower().replace("_", " ").replace("-", " ").split()
    if " ".join(wanted) in MODE_NAMES:
        return MODE_NAMES.index(" ".join(wanted))
    near = [j for j, name in enumerate(MODE_NAMES) if wanted and set(wanted) <= set(name.split())]
    if len(near) == 1:
        return near[0]
    names = ", ".join(f"{MODE_NAMES[j]} (j = {j})" for j in near or range(len(MODE_NAMES)))
    raise ValueError(f"mode {mode!r}: give one of {names}; or j, or (n, m)")


def mode_indices(modes: Any) -> Any:
    """A list of OSA/ANSI indices; other values than lists unchanged."""
    if modes is None or isinstance(modes, (str, bytes)) or not isinstance(modes, Iterable):
        return modes
    return [mode_index(mode) for mode in modes]


def mode_list(modes: Any) -> Any:
    """Modes as the daemon takes them, a list of {"j", "waves"}; lists of dicts, and values of other types, unchanged."""
    if isinstance(modes, Mapping):
        return [{"j": mode_index(mode), "waves": waves} for mode, waves in modes.items()]
    if isinstance(modes, (np.ndarray, list, tuple)) and len(modes) and not isinstance(modes[0], Mapping):
        return [{"j": j, "waves": waves} for j, waves in enumerate(modes, 1)]
    return modes


def coefficient(j: NDArray[np.int64], waves: NDArray[np.float64], mode: ModeKey) -> float:
    """Coefficient of a mode among those of `j`. Raises ValueError if it is not there."""
    found = np.flatnonzero(j == mode_index(mode))
    if not found.size:
        raise ValueError(f"mode {mode!r} is not measured; the modes are j = {j.tolist()}")
    return float(waves[found[0]])
