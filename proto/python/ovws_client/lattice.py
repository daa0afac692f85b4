"""Geometry of the lattice: subaperture centres, and spot displacement per wavefront slope, for fits of a custom basis to the spots."""
from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from .methods import Config, KnownRegistration

Floats = NDArray[np.float64]


def subaperture_centres(config: Config) -> Floats:
    """Subaperture centres in units of the pupil's radius, x right, y down, shape (subapertures, 2), in the order of `Spots`."""
    sensor = config["sensor"]
    pitch = 2.0 / sensor["subapertures_across"]
    hexagonal = sensor["grid"] == "hexagonal"
    row_pitch = pitch * (sqrt(0.75) if hexagonal else 1.0)
    reach = (1.0 - 0.5 * pitch) * (1.0 + 1e-9)
    rows, columns = int(reach / row_pitch), int(reach / pitch) + 1
    centres = [((column + (0.5 if hexagonal and row % 2 else 0.0)) * pitch, row * row_pitch)
               for row in range(-rows, rows + 1) for column in range(-columns, columns + 1)]
    return np.array([centre for centre in centres if np.hypot(*centre) <= reach])


def px_per_slope(config: Config, registration: KnownRegistration) -> Floats:
    """The 2 x 2 matrix S: a wavefront slope g in waves per pupil radius moves a spot by S @ g camera pixels. From the active registration,
    else from the configuration."""
    optics, slm = config["optics"], config["slm"]
    matrix = registration["px_per_cycle"] or optics["px_per_cycle"]
    scale = optics["wavelength_nm"] * optics["focal_length_mm"] * optics["magnification"] / (slm["pitch_um"] * optics["camera_pitch_um"])
    per_cycle = scale * np.eye(2) if matrix is None else np.array(matrix).reshape(2, 2)
    return per_cycle / (0.5 * config["sensor"]["pupil_diameter_px"])
