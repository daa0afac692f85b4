"""Values of a frame and settings of the bench, by their names on the wire."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ovws_client import Client, Message, Status, Wavefront

CLIENT_NAMES = {"coefficients": "coefficients_waves", "sigma": "sigma_waves"}  # of ovws_client, where they differ from the wire's
NULL_IF_INVALID = ("coefficients", "sigma", "rms_waves")


def frame_value(frame: Wavefront, name: str) -> Any:
    """The value of a field of a `wavefront` message; NaN if it is null."""
    value = getattr(frame, CLIENT_NAMES.get(name, name))
    return float("nan") if value is None else value


def frame_seconds(frame: Wavefront) -> float:
    """Time of arrival, seconds since the UNIX epoch."""
    return 1e-9 * frame.t_arrival_ns


def frames_of(messages: Iterator[Message]) -> Iterator[Wavefront]:
    """The frames among messages."""
    return (message for message in messages if isinstance(message, Wavefront))


def camera_setting(status: Status, name: str) -> float:
    """A camera setting in use; NaN if the camera has none, or is not connected."""
    settings: Any = status.camera["settings"] or {}
    value = settings.get(name)
    return float("nan") if value is None else float(value)


def introduced(client: Client) -> dict[int, float]:
    """The introduced aberration, RMS-normalised waves by OSA/ANSI index."""
    return {mode["j"]: mode["waves"] for mode in client.aberration_get()["modes"]}


def introduced_waves(client: Client) -> NDArray[np.float64]:
    """The introduced aberration of j = 1, 2, … up to the last measured or introduced mode."""
    shown = introduced(client)
    waves = np.zeros(max([*client.sensor_get()["modes_j"], *shown]))
    for j, value in shown.items():
        if j > 0:
            waves[j - 1] = value
    return waves
