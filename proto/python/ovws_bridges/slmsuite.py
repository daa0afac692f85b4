"""slmsuite on the bench of ovwsd: its SLM shows phases through the daemon's table, its camera returns the frames under them.

    from ovws_bridges.slmsuite import Bench
    with Bench() as bench:
        system = FourierSLM(bench.cam, bench.slm)
        system.fourier_calibrate(array_shape=10, array_pitch=30, autoexposure=True)

The sensor is at rest meanwhile, and returns when the block ends, or when nothing was shown or grabbed for `lease_s` seconds.
"""
from __future__ import annotations

from typing import Any

import warnings

import numpy as np
import numpy.typing as npt
from slmsuite.hardware.cameras.camera import Camera
from slmsuite.hardware.slms.slm import SLM

from ovws_client import Client, Presentation, grab, zernike
from ovws_client.lattice import zeroth_order_px
from ovws_client.wire import CONTROL

LEVELS = 256
RAW = {"correction": False, "flatness": False}


def flatness_phase(client: Client) -> npt.NDArray[np.float64] | None:
    """The phase in radians that flattens the SLM, from flatness.get: minus the measured error inside the pupil, 0 outside. None: not measured."""
    config, measured = client.config_get(), client.flatness_get()
    if not measured["measured"]:
        return None
    rows, columns = config["slm"]["height"], config["slm"]["width"]
    y, x = np.mgrid[:rows, :columns]
    radius = 0.5 * measured["pupil_diameter_px"]
    x, y = (x - 0.5 * (columns - 1)) / radius, (y - 0.5 * (rows - 1)) / radius
    inside = np.hypot(x, y) <= 1.0
    waves = np.zeros((rows, columns))
    for mode in measured["modes"]:
        waves[inside] -= mode["waves"] * zernike(mode["j"], x[inside], y[inside])
    return 2.0 * np.pi * waves


def check_zeroth_order(client: Client) -> None:
    """Warns if the camera's region does not hold the zeroth order, without which slmsuite's Fourier calibration finds a wrong place."""
    roi = client.camera_get()["settings"]["roi"]
    x, y = zeroth_order_px(client.config_get(), client.registration_get(), roi)
    if not (0 <= x < roi["width"] and 0 <= y < roi["height"]):
        warnings.warn(f"the zeroth order is at ({x:.0f}, {y:.0f}), outside of the image of {roi['width']} x {roi['height']} pixels: a Fourier "
                      "calibration will be wrong. Move the region or the camera, or give it by fourier_calibrate_analytic", stacklevel=3)


class OvwsSLM(SLM):
    """The SLM of a daemon. A phase of slmsuite is shown as that phase, through the daemon's look-up table; slm.source["phase"] begins with the
    measured flatness, and nothing else is added."""

    def __init__(self, client: Client, lease_s: float = 60.0, name: str = "ovws", **kwargs: Any) -> None:
        config = client.config_get()
        slm = config["slm"]
        self._presentation = Presentation(client, lease_s, **RAW)
        super().__init__((slm["width"], slm["height"]), 8, name, wav_um=1e-3 * config["optics"]["wavelength_nm"], pitch_um=slm["pitch_um"],
                         settle_time_s=0.0, **kwargs)  # the daemon answers when the SLM has settled
        flat = flatness_phase(client)
        if flat is not None:
            self.source["phase"] = flat
        self.set_phase(None)

    @property
    def hologram_id(self) -> int:
        """Number of the hologram that shows the phase set last."""
        return self._presentation.hologram_id

    def _set_phase_hw(self, display: npt.NDArray[np.uint8]) -> None:
        # slmsuite's levels fall with the phase, from 255 for phase 0; those of the daemon rise, from 0.
        self._presentation.show(LEVELS - 1 - np.asarray(display, np.uint8))

    def renew(self) -> None:
        """Begins the lease again."""
        self._presentation.renew()

    def close(self) -> None:
        """Gives the sensor back."""
        self._presentation.close()


class OvwsCamera(Camera):
    """The camera of a daemon. With `slm`, images are of frames that were exposed wholly under the phase set last. A window of interest is cut
    out of the daemon's image; the camera's own region stays as it is."""

    def __init__(self, client: Client, slm: OvwsSLM | None = None, name: str = "ovws", **kwargs: Any) -> None:
        self._client = client
        self._slm = slm
        camera, config = client.camera_get(), client.config_get()
        seen = grab(client)
        limits = camera["limits"]["exposure_us"]
        rows, columns = seen.images.shape[1:]
        super().__init__((columns, rows), seen.significant_bits, config["optics"]["camera_pitch_um"], name,
                         exposure_bounds_s=(1e-6 * limits["min"], 1e-6 * limits["max"]), **kwargs)

    def _get_exposure_hw(self) -> float:
        return 1e-6 * float(self._client.camera_get()["settings"]["exposure_us"])

    def _set_exposure_hw(self, exposure_s: float) -> None:
        self._client.camera_set(exposure_us=1e6 * float(exposure_s))

    def set_woi(self, woi: tuple[int, int, int, int] | None = None) -> tuple[int, int, int, int]:
        """Window of interest (x, width, y, height) in pixels of the daemon's image; None: the whole image."""
        rows, columns = self.default_shape
        self.woi = (0, columns, 0, rows) if woi is None else tuple(int(value) for value in woi)
        self.shape = (self.woi[3], self.woi[1])
        return self.woi

    def _get_images_hw(self, image_count: int, timeout_s: float, out: npt.NDArray[Any] | None = None) -> npt.NDArray[Any]:
        x, width, y, height = self.woi
        if self._slm:
            self._slm.renew()
        images = grab(self._client, after_hologram=self._slm.hologram_id if self._slm else None, frames=int(image_count),
                      region={"x": x, "y": y, "width": width, "height": height}, timeout_s=max(1.0, timeout_s * image_count)).images
        if out is None:
            return images
        out[...] = images
        return out

    def _get_image_hw(self, timeout_s: float = 1.0) -> npt.NDArray[Any]:
        return self._get_images_hw(1, timeout_s)[0]

    def flush(self, timeout_s: float = 1) -> None:
        """Nothing to do: every image was exposed after its request."""

    def close(self) -> None:
        """The camera stays the daemon's."""


class Bench:
    """SLM and camera of a daemon, for a `with` block. Keyword arguments are those of Client."""

    def __init__(self, endpoint: str = CONTROL, lease_s: float = 60.0, timeout_s: float = 20.0, **keys: Any) -> None:
        self.client = Client(endpoint, timeout_s=timeout_s, **keys)
        try:
            check_zeroth_order(self.client)
            self.slm = OvwsSLM(self.client, lease_s)
        except BaseException:
            self.client.close()
            raise
        try:
            self.cam = OvwsCamera(self.client, self.slm)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Gives the sensor back and ends the connection."""
        self.slm.close()
        self.client.close()

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
