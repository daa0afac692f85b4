"""A client's own pictures on the SLM, in place of the sensor, and the camera's frames under them."""
from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .errors import Refused
from .methods import GrabStamp, Methods, PresentReport


@dataclass(frozen=True)
class Grabbed:
    """Frames of camera.grab: images[k] belongs to frames[k]; with `average` there is one image, the mean of all frames."""

    images: npt.NDArray[Any]
    frames: list[GrabStamp]
    significant_bits: int


def grab(client: Methods, timeout_s: float = 10.0, **params: Any) -> Grabbed:
    """Frames of the camera as an array. Waits up to `timeout_s` for them. `params`: those of camera_grab."""
    report, pixels = client.camera_grab(timeout_s=timeout_s, **params)
    return Grabbed(np.frombuffer(bytearray(pixels), report["dtype"]).reshape(report["shape"]), report["frames"], report["significant_bits"])


def pixels_of(picture: npt.ArrayLike) -> tuple[bytes, list[int], Literal["<f4", "<u1"]]:
    """Bytes, shape and dtype of a picture: uint8 is grey levels, float is phases in waves."""
    array = np.asarray(picture)
    if array.ndim != 2:
        raise ValueError(f"a picture has rows and columns; this array has {array.ndim} dimensions")
    if array.dtype != np.uint8 and array.dtype.kind != "f":
        raise ValueError(f"a picture is phases in waves (float; radians / 2 pi) or grey levels (uint8), not {array.dtype}")
    dtype: Literal["<f4", "<u1"] = "<u1" if array.dtype == np.uint8 else "<f4"
    return np.ascontiguousarray(array, dtype).tobytes(), list(array.shape), dtype


class Presentation:
    """Shows pictures in place of the sensor until it is closed, or its lease ends because nothing was called for `lease_s` seconds.

    `options`: those of slm_present: correction, flatness, lut, inside_pupil.
    """

    def __init__(self, client: Methods, lease_s: float = 10.0, **options: bool) -> None:
        self._client = client
        self._options: Mapping[str, Any] = {"lease_s": lease_s, **options}
        self._job: int | None = None
        self.hologram_id = 0  # of the picture shown last

    def show(self, picture: npt.ArrayLike, **options: bool) -> PresentReport:
        """Shows a picture of the SLM's size, phases in waves or grey levels (uint8); returns when the SLM has settled. Begins a new
        presentation if the lease of the previous one has ended."""
        pixels, shape, dtype = pixels_of(picture)
        wish: dict[str, Any] = {**self._options, **options, "shape": shape, "dtype": dtype}
        try:
            report = self._client.slm_present(pixels, job=self._job, **wish)
        except Refused as refused:
            if self._job is None or refused.field != "job":
                raise
            report = self._client.slm_present(pixels, job=None, **wish)
        self._job, self.hologram_id = report["job"], report["hologram_id"]
        return report

    def grab(self, frames: int = 1, **params: Any) -> Grabbed:
        """Frames that were exposed wholly under the picture shown last."""
        if self._job is None:
            raise ValueError("show a picture first")
        return grab(self._client, after_hologram=self.hologram_id, frames=frames, **params)

    def renew(self) -> PresentReport:
        """Begins the lease again; the picture stays."""
        return self._client.slm_present(job=self._job, lease_s=self._options["lease_s"])

    def close(self) -> None:
        """Gives the sensor back, and returns when it is free for other requests."""
        job, self._job = self._job, None
        if job is None:
            return
        try:
            self._client.slm_present(job=job, lease_s=0)
        except Refused as refused:
            if refused.field != "job":  # without a display
                self._client.job_cancel(job)
        while self._runs(job):
            time.sleep(0.005)

    def _runs(self, job: int) -> bool:
        try:
            return self._client.job_get(job)["state"] == "running"
        except Refused:  # by a daemon that was started again
            return False

    def __enter__(self) -> Presentation:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
