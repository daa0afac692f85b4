"""Zernike modes in the daemon's convention: OSA/ANSI index j, RMS 1 over the pupil, x right, y down, in units of the pupil's radius."""
from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .values import whole

Floats = NDArray[np.float64]
MAX_J = 230  # n = 20: beyond it the radial sums lose precision


def osa_index(n: int, m: int) -> int:
    """OSA/ANSI index j of radial order n and azimuthal frequency m (negative: sine)."""
    if n < 0 or abs(m) > n or (n - m) % 2:
        raise ValueError(f"(n, m) = ({n}, {m}) is not a mode: |m| <= n, and n - m even")
    return (n * (n + 2) + m) // 2


def orders(j: int) -> tuple[int, int]:
    """Radial order n and azimuthal frequency m of the OSA/ANSI index j."""
    if not 0 <= j <= MAX_J:
        raise ValueError(f"j must be from 0 to {MAX_J}, not {j}")
    n = next(n for n in range(j + 1) if (n + 1) * (n + 2) // 2 > j)
    return n, 2 * j - n * (n + 2)


def zernike(j: int, x: ArrayLike, y: ArrayLike) -> Floats:
    """Value of the RMS-normalised mode Z_j at the points (x, y), in units of the pupil's radius."""
    n, m = orders(j)
    z = np.asarray(x, float) + 1j * np.asarray(y, float)
    square, radial = np.abs(z) ** 2, np.zeros(z.shape)
    half = (n - abs(m)) // 2
    for k in range(half + 1):  # Horner's scheme, from the highest power
        radial = radial * square + (-1) ** k * comb(n - k, k) * comb(n - 2 * k, half - k)
    turned = z ** abs(m)
    value: Floats = np.sqrt((1 if m == 0 else 2) * (n + 1)) * radial * (turned.imag if m < 0 else turned.real)
    return value


def pupil_grid(size_px: int) -> tuple[Floats, Floats]:
    """Pixel coordinates x and y of a square image whose edges touch the pupil's circle, in units of the pupil's radius, each of shape
    (size_px, size_px): y by rows, x by columns."""
    size_px = whole("size_px", size_px)
    line = (2.0 * np.arange(size_px) + 1.0) / size_px - 1.0
    x, y = np.meshgrid(line, line)
    return x, y


@lru_cache(maxsize=4)
def _basis(j: tuple[int, ...], size_px: int) -> tuple[NDArray[np.bool_], Floats]:
    x, y = pupil_grid(size_px)
    inside = np.hypot(x, y) <= 1.0
    return inside, np.array([zernike(mode, x[inside], y[inside]) for mode in j])


def phase_map_waves(j: Sequence[int] | NDArray[np.int64], coefficients_waves: ArrayLike, size_px: int = 128) -> Floats:
    """Wavefront over the pupil in waves on pupil_grid(size_px); NaN outside the pupil. `coefficients_waves`: RMS-normalised, as many as
    `j`."""
    size_px = whole("size_px", size_px)
    coefficients = np.asarray(coefficients_waves, float)
    modes = tuple(int(mode) for mode in j)
    if coefficients.shape != (len(modes),):
        raise ValueError(f"{len(modes)} modes need as many coefficients, not an array of shape {coefficients.shape}")
    inside, basis = _basis(modes, size_px)
    waves = np.full((size_px, size_px), np.nan)
    waves[inside] = coefficients @ basis if modes else 0.0
    return waves
