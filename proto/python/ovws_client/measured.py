"""The mean of several frames' wavefronts."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import display
from .messages import Wavefront
from .modes import ModeKey, coefficient, mode_name
from .zernike import phase_map_waves

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class MeanWavefront:
    """Mean wavefront of some frames, RMS-normalised waves of `wavelength_nm`."""

    frames: int
    """number of valid frames that were averaged"""
    skipped: int
    """frames between them that were not valid"""
    hologram_id: int
    wavelength_nm: float
    j: NDArray[np.int64]
    """OSA/ANSI indices, without piston"""
    coefficients_waves: Floats
    """means, as many as `j`"""
    standard_error_waves: Floats
    """standard errors of the means: the scatter of the frames divided by the root of their number; NaN of a single frame. Drift slower than
    the frames is not contained"""
    scatter_waves: Floats
    """standard deviations of the frames"""

    @classmethod
    def of(cls, frames: Sequence[Wavefront], skipped: int = 0) -> MeanWavefront:
        """Mean of valid frames with the same modes."""
        waves = np.array([frame.coefficients_waves for frame in frames])
        count = len(frames)
        scatter = waves.std(axis=0, ddof=1) if count > 1 else np.full(waves.shape[1], np.nan)
        return cls(frames=count, skipped=skipped, hologram_id=frames[-1].hologram_id, wavelength_nm=frames[-1].wavelength_nm, j=frames[-1].j,
                   coefficients_waves=waves.mean(axis=0), standard_error_waves=scatter / np.sqrt(count), scatter_waves=scatter)

    @property
    def rms_waves(self) -> float:
        """Root sum square of the coefficients without tilts, as in the wavefront stream."""
        return float(np.sqrt(np.sum(self.coefficients_waves[self.j > 2] ** 2)))

    @property
    def names(self) -> list[str]:
        """Names of the modes."""
        return [mode_name(j) for j in self.j.tolist()]

    def waves(self, mode: ModeKey) -> float:
        """Coefficient of a mode, given by name, index or orders (n, m). Raises ValueError if it was not measured."""
        return coefficient(self.j, self.coefficients_waves, mode)

    def phase_waves(self, size_px: int = 128) -> Floats:
        """Wavefront over the pupil, waves, shape (size_px, size_px); NaN outside the pupil."""
        return phase_map_waves(self.j, self.coefficients_waves, size_px)

    def _repr_html_(self) -> str:
        title = f"Mean of {self.frames} frames: {self.rms_waves:.4f} waves RMS without tilts, at {self.wavelength_nm:g} nm"
        return display.wavefront(title, self.names, self.coefficients_waves, self.standard_error_waves, self.phase_waves())
