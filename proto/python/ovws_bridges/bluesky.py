"""Devices for Bluesky plans by its protocols alone; neither Bluesky nor ophyd is imported.

    sensor = WavefrontSensor("ovws")
    RE(scan([sensor], sensor.mode("defocus"), -0.1, 0.1, 11))
"""
from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from ovws_client import ClientError, MeanWavefront, Message, NoAnswer, Wavefront
from ovws_client.bench import Gathering
from ovws_client.modes import ModeKey
from ovws_client.values import number, whole
from ovws_client.wire import KeyFile

from .action import Action
from .bluesky_settings import Aberration, AberrationMode, CameraSetting, Readings, data_key
from .fields import FIELDS
from .frame import frame_seconds, frame_value, frames_of
from .link import Link

READ = ("coefficients", "sigma", "rms_waves", "valid", "frame_id", "seq", "gap", "hologram_id", "t_device_ns", "t_arrival_ns")
CONFIGURATION = ("j", "charge", "subapertures", "wavelength_nm")


class WavefrontSensor:
    """The sensor: Readable, Triggerable, Stageable, Configurable and Subscribable. Its settings are devices of their own.

    trigger: waits for the mean of the next `frames` valid frames whose exposure began after the call
    read: that mean, and number and stamps of its last frame; before the first trigger, the newest frame
    subscribe: a reading for every frame, valid or not; `RE` offers it as `monitor`

    frames: number of frames to average
    timeout_s: time for an action to end, besides the exposures; then its status fails
    endpoint, key, server_key: as in ovws_client.Client
    """

    parent = None

    def __init__(self, name: str = "ovws", *, frames: int = 1, timeout_s: float = 20.0, endpoint: str | None = None,
                 key: KeyFile | None = None, server_key: str | None = None) -> None:
        self.name = name
        self.frames = whole("frames", frames)
        self.timeout_s = number("timeout_s", timeout_s, 0.0)
        self.link = Link(Wavefront, endpoint=endpoint, timeout_s=self.timeout_s, key=key, server_key=server_key)
        self.exposure_us = CameraSetting(self, "exposure_us")
        self.gain_db = CameraSetting(self, "gain_db")
        self.aberration = Aberration(self)
        self._mean: MeanWavefront | None = None
        self._frame: Wavefront | None = None
        self._modes: list[int] | None = None  # described to the run
        self._listeners: dict[Callable[..., None], Callable[[Message | None], None]] = {}

    def mode(self, mode: ModeKey) -> AberrationMode:
        """One mode of the introduced aberration as a settable device: the axis of a scan."""
        return AberrationMode(self, mode)

    @property
    def hints(self) -> dict[str, Any]:
        """Fields to plot."""
        return {"fields": [self.key("rms_waves")]}

    def key(self, name: str) -> str:
        """Name of a field in readings."""
        return f"{self.name}-{name}"

    def stage(self) -> list[object]:
        """Begins: waits until the daemon answers, and forgets earlier readings."""
        self.link.wait_until_connected(self.timeout_s)
        self._mean = self._frame = self._modes = None
        return [self]

    def unstage(self) -> list[object]:
        """Ends; settings stay as they are."""
        self._modes = None
        return [self]

    def trigger(self) -> Action:
        """Its status is done when the frames have arrived; it fails if there were not as many valid ones in time."""
        return Action(self._take, f"{self.name} trigger")

    def read(self) -> Readings:
        """The reading of the last trigger."""
        frame = self._frame or self._newest()
        return self._readings(frame, self._mean if self._frame is not None else None)

    def describe(self) -> dict[str, dict[str, Any]]:
        """Data keys of `read`."""
        self._modes = modes = self._newest().j.tolist()
        keys = {self.key(name): data_key(FIELDS["wavefront"][name], self._source(f"wavefront/{name}"), len(modes)) for name in READ}
        keys[self.key("frames")] = {"source": self._source("wavefront"), "dtype": "integer", "shape": [], "dtype_numpy": "<i8"}
        return keys

    def read_configuration(self) -> Readings:
        """What the coefficients depend on."""
        frame = self._newest()
        stamp = frame_seconds(frame)
        return {self.key(name): {"value": frame_value(frame, name), "timestamp": stamp} for name in CONFIGURATION}

    def describe_configuration(self) -> dict[str, dict[str, Any]]:
        """Data keys of `read_configuration`."""
        length = len(self._newest().j)
        return {self.key(name): data_key(FIELDS["wavefront"][name], self._source(f"wavefront/{name}"), length) for name in CONFIGURATION}

    def subscribe(self, function: Callable[..., None]) -> None:
        """Calls `function` with the reading of each frame, in the receiving thread; frames of other modes than described are left out."""
        def listen(message: Message | None) -> None:
            if isinstance(message, Wavefront) and self._modes in (None, message.j.tolist()):
                function(self._readings(message, None))

        self._listeners[function] = listen
        self.link.add_listener(listen)

    def clear_sub(self, function: Callable[..., None]) -> None:
        """Ends a subscription."""
        self.link.remove_listener(self._listeners.pop(function))

    def close(self) -> None:
        """Ends the connection to the daemon."""
        self.link.close()

    def _source(self, path: str) -> str:
        return f"ovws+{self.link.endpoint}/{path}"

    def _newest(self) -> Wavefront:
        end = time.monotonic() + self.timeout_s
        while not isinstance(frame := self.link.newest(Wavefront), Wavefront):
            if time.monotonic() > end:
                raise NoAnswer(f"no frame from the daemon at {self.link.endpoint} within {self.timeout_s} s; see its system.status")
            time.sleep(0.01)
        return frame

    def _take(self) -> None:
        frames = whole("frames", self.frames)
        with self.link.client() as client:
            camera = client.camera_get()["settings"]
        timeout_s = self.timeout_s + (frames + 2) * max(1e-6 * camera["exposure_us"], 1.0 / camera["frame_rate_hz"])
        with self.link.messages(timeout_s) as messages, self.link.own_client() as client:
            gathering, later = Gathering(frames), client.later(timeout_s, f"0 of {frames} valid frames")
            for frame in frames_of(messages):
                if later(frame):
                    gathering.take(frame)
                if gathering.is_complete:
                    break
        mean = gathering.mean(timeout_s)
        if self._modes not in (None, mean.j.tolist()):
            raise ClientError(f"the measured modes changed during the run, from {len(self._modes or [])} to {len(mean.j)}; begin another run")
        self._mean, self._frame = mean, gathering.newest

    def _readings(self, frame: Wavefront, mean: MeanWavefront | None) -> Readings:
        values = {name: frame_value(frame, name) for name in READ} | {"frames": 1}
        if mean is not None and mean.frames > 1:
            values |= {"coefficients": mean.coefficients_waves, "sigma": mean.standard_error_waves, "rms_waves": mean.rms_waves,
                       "frames": mean.frames}
        stamp = frame_seconds(frame)
        return {self.key(name): {"value": value, "timestamp": stamp} for name, value in values.items()}
