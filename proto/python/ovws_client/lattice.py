"""Geometry of the lattice: subaperture centres, and spot displacement per wavefront slope, for fits of a custom basis to the spots."""
from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from .methods import Config, KnownRegistration, Roi

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
    return px_per_cycle(config, registration) / (0.5 * config["sensor"]["pupil_diameter_px"])


def px_per_cycle(config: Config, registration: KnownRegistration) -> Floats:
    """The 2 x 2 matrix M: a grating of f cycles per SLM pixel moves light by M @ f camera pixels. From the active registration, else from the
    configuration."""
    optics, slm = config["optics"], config["slm"]
    matrix = registration["px_per_cycle"] or optics["px_per_cycle"]
    scale = optics["wavelength_nm"] * optics["focal_length_mm"] * optics["magnification"] / (slm["pitch_um"] * optics["camera_pitch_um"])
    return scale * np.eye(2) if matrix is None else np.array(matrix).reshape(2, 2)


def zeroth_order_px(config: Config, registration: KnownRegistration, roi: Roi) -> Floats:
    """Where light that no grating diffracts falls: (x, y) in pixels of the camera's region, which may be outside of it."""
    slm, grooves = config["slm"], config["sensor"]["grooves"]
    corner = np.array([roi["x"], roi["y"]])
    if registration["base_px"] is not None:
        base = np.array(registration["base_px"]) - corner
    else:
        base = np.array(config["optics"]["centre_px"] or [0.5 * (roi["width"] - 1), 0.5 * (roi["height"] - 1)])
    place: Floats = base - px_per_cycle(config, registration) @ [grooves[0] / slm["width"], grooves[1] / slm["height"]]
    return place
