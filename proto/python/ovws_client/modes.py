"""Modes as people give them: by OSA/ANSI index, by orders (n, m), or by name; as dict, array or list."""
from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .mode_names import MODE_NAMES
from .values import plain
from .zernike import MAX_J, orders, osa_index

ModeKey = int | str | tuple[int, int]
#: {mode: waves}, coefficients of j = 1, 2, … (as in `Wavefront.coefficients_waves`), or a list of {"j", "waves"} or {"n", "m", "waves"}.
Modes = Mapping[ModeKey, float] | Mapping[int, float] | Mapping[str, float] | Sequence[float] | Sequence[Mapping[str, Any]] | NDArray[np.floating[Any]]


def mode_name(j: int) -> str:
    """Name of a mode: "oblique astigmatism", "vertical coma", …; "Z(n,m)" if it has no common name."""
    n, m = orders(j)
    return MODE_NAMES[j] if j < len(MODE_NAMES) else f"Z({n},{m})"


def mode_index(mode: ModeKey) -> int:
    """OSA/ANSI index of a mode given by index, orders (n, m) or text. Text as in `ovws`: "7", "3,-1", or a name, whose words may have any
    order and capitals, with spaces, _ or - between them. Words may be left out if only one name has the others: "spherical"; "secondary" is
    never implied. Also "Z(n,m)", as mode_name gives it. Raises ValueError with the names that are possible."""
    if isinstance(mode, str):
        if found := re.fullmatch("(-?[0-9]+),(-?[0-9]+)", re.sub(r"^Z\((.*)\)$", r"\1", mode)):
            return mode_index((int(found[1]), int(found[2])))
        return mode_index(int(mode)) if re.fullmatch("-?[0-9]+", mode) else _named(mode)
    j = osa_index(*mode) if isinstance(mode, tuple) else int(mode)
    if not isinstance(mode, tuple) and j != mode or not 0 <= j <= MAX_J:
        raise ValueError(f"mode {mode}: the OSA/ANSI index must be an integer from 0 to {MAX_J}")
    return j


def _named(text: str) -> int:
    """OSA/ANSI index of the mode with this name."""
    wanted = set(re.split("[-_ ]+", text.lower())) - {""}
    near = []
    for j, name in enumerate(MODE_NAMES):
        words = set(name.split())
        if words == wanted:
            return j
        if wanted and wanted <= words and ("secondary" in wanted or "secondary" not in words):
            near.append(j)
    if len(near) == 1:
        return near[0]
    names = ", ".join(f"{MODE_NAMES[j]} (j = {j})" for j in near or range(len(MODE_NAMES)))
    raise ValueError(f"mode {text!r}: give one of {names}; or j, or (n, m)")


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
        raise ValueError(f"mode {plain(mode)!r} is not measured; the modes are j = {j.tolist()}")
    return float(waves[found[0]])
