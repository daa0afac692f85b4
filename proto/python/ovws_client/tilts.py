"""A reference from known tilts of the light, for a sensor that never sees a flat beam: the zero of each spot is where it would be without tilt."""
from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .bench import Bench
from .corrector import mean_spots
from .methods import KnownReference
from .values import number, whole

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class TiltReference:
    """What known tilts of the light say about the spots."""

    zeros_px: Floats
    """(spots, 2): position of each spot without tilt, camera pixels; NaN: lost"""
    standard_error_px: Floats
    """of zeros_px, from the noise of the frames"""
    px_per_tilt: Floats
    """(2, 2): displacement [x, y] of the spots, camera pixels, by a tilt of 1 along each axis: compare it with what the optics should give"""
    residual_px: float
    """RMS of what zeros and tilts leave of the positions, camera pixels: errors of the tilts, motion, and noise"""
    known: KnownReference
    """the reference in use"""


def _solve(tilts: Floats, at_px: Floats) -> tuple[Floats, Floats, Floats]:
    """Least squares of at = zero + px_per_tilt tilt. `at_px`: (tilts, spots, 2). Returns zeros, px_per_tilt, and what they leave."""
    found = np.isfinite(at_px).all(axis=(0, 2))
    middle_tilt, middle_px = tilts.mean(axis=0), at_px.mean(axis=0)
    moved = (at_px - middle_px)[:, found].mean(axis=1)
    px_per_tilt = np.linalg.lstsq(tilts - middle_tilt, moved, rcond=None)[0].T
    zeros = middle_px - px_per_tilt @ middle_tilt
    return zeros, px_per_tilt, (at_px - zeros - (tilts @ px_per_tilt.T)[:, None])[:, found]


def reference_from_tilts(client: Bench, tilt: Callable[[float, float], object], tilts: npt.ArrayLike, frames: int = 20,
                         settle_s: float = 0.0) -> TiltReference:
    """Moves the light through known tilts, and makes the spots' positions without tilt the reference (reference_give). Needs a tracker of positions.

    `tilt`: tilts the light to (x, y); returns when the mirror or stage has accepted it. `tilts`: (tilts, 2), in any unit, not all on one line, and
    small enough that each spot stays its own. `settle_s`: time until the light is at rest. The light is at the first of `tilts` afterwards.
    """
    frames, settle_s = whole("frames", frames), number("settle_s", settle_s, 0.0)
    known = np.asarray(tilts, np.float64)
    if known.ndim != 2 or known.shape[1] != 2 or np.linalg.matrix_rank(known - known.mean(axis=0)) < 2:
        raise ValueError("tilts must be pairs (x, y) that do not all lie on one line")
    means, errors = [], []
    try:
        for x, y in known:
            tilt(float(x), float(y))
            time.sleep(settle_s)
            mean, error = mean_spots(client, frames)
            means.append(mean.reshape(-1, 2))
            errors.append(error.reshape(-1, 2))
    finally:
        tilt(float(known[0, 0]), float(known[0, 1]))
    zeros, px_per_tilt, left = _solve(known, np.array(means))
    standard_error = np.sqrt((np.array(errors) ** 2).sum(axis=0)) / len(known)
    both = np.ascontiguousarray([zeros, np.where(np.isfinite(zeros), standard_error, 0.0)], "<f4")
    reference = client.reference_give(both.tobytes(), frames=min(frames * len(known), 100000))
    return TiltReference(zeros_px=zeros, standard_error_px=standard_error, px_per_tilt=px_per_tilt, residual_px=float(np.sqrt(np.mean(left**2))),
                         known=reference)
