"""What one does at a bench, with the streams and the methods together: an image, a mean wavefront, settings for a while."""
from __future__ import annotations

import re
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any, TypeVar

from .errors import NoAnswer
from .measured import MeanWavefront
from .messages import Image, Message, Wavefront
from .methods import CameraSettings, Methods
from .subscription import Subscription
from .wire import KeyFile

M = TypeVar("M", bound=Message)


def as_seen_from(control: str, endpoint: str) -> str:
    """An endpoint of the daemon, whose control socket a client reaches at `control`: of TCP, the same host with the other port."""
    here, there = (re.fullmatch(r"tcp://(.+):(\d+)", text) for text in (control, endpoint))
    return f"tcp://{here[1]}:{there[2]}" if here and there else endpoint


def measurement(frame: Wavefront) -> tuple[object, ...]:
    """What frames must have in common to be averaged. A closed loop shows a new hologram at each step."""
    hologram = frame.hologram_id if frame.loop == "open" else None
    return frame.charge, frame.tracker, frame.j.tolist(), frame.reference_introduced_rms_waves, hologram


class Gathering:
    """The valid frames of one measurement, for their mean: those whose exposure began after `earliest_ns` (the earliest arrival minus exposure
    time). Begins again when the measurement changes."""

    def __init__(self, frames: int, earliest_ns: float) -> None:
        if frames < 1:
            raise ValueError(f"frames must be at least 1, not {frames}")
        self._frames = frames
        self._earliest_ns = earliest_ns
        self._good: list[Wavefront] = []
        self._skipped = 0

    @property
    def is_complete(self) -> bool:
        return len(self._good) == self._frames

    @property
    def newest(self) -> Wavefront:
        """The frame that was taken last."""
        return self._good[-1]

    def take(self, frame: Wavefront) -> None:
        if frame.exposure_us is None or frame.t_arrival_ns - 1e3 * frame.exposure_us < self._earliest_ns:
            return
        if not frame.valid:
            self._skipped += 1
            return
        if self._good and measurement(frame) != measurement(self._good[0]):
            self._good.clear()
            self._skipped = 0
        self._good.append(frame)

    def mean(self, timeout_s: float) -> MeanWavefront:
        """The mean; raises NoAnswer if frames are missing after `timeout_s`."""
        if self.is_complete:
            return MeanWavefront.of(self._good, self._skipped)
        raise NoAnswer(f"{len(self._good)} of {self._frames} valid frames within {timeout_s} s, and {self._skipped} that were not valid; is there a reference?")


def no_image(timeout_s: float) -> NoAnswer:
    return NoAnswer(f"no image within {timeout_s} s; does the camera deliver frames (system_status)?")


class SettingsChange:
    """Settings of camera and sensor for a while: which method gets which keys, and what restores them."""

    def __init__(self, settings: Mapping[str, Any], camera: Mapping[str, Any], sensor: Mapping[str, Any]) -> None:
        self._before = {"camera.set": camera, "sensor.set": sensor}
        self._changes: dict[str, dict[str, Any]] = {"camera.set": {}, "sensor.set": {}}
        self._clamp = {"clamp": settings["clamp"]} if "clamp" in settings else {}
        for key, value in settings.items():
            if key != "clamp":
                self._changes["camera.set" if key in CameraSettings.__annotations__ else "sensor.set"][key] = value

    def calls(self) -> Iterator[tuple[str, dict[str, Any], dict[str, Any]]]:
        """(method, params, params that restore the former values) of each method to be called."""
        for method, change in self._changes.items():
            if change:
                yield method, change | self._clamp, {key: self._before[method][key] for key in change if key in self._before[method]}


def earliest_ns(status: Mapping[str, Any], config: Mapping[str, Any]) -> float:
    """Of a frame whose exposure begins after these answers: the earliest arrival minus exposure time, by the daemon's clock. The transfer takes
    up to camera.transfer_ms, as the daemon assumes, too."""
    return float(status["t_ns"] + 1e6 * config["camera"]["transfer_ms"])


class Bench(Methods):
    """Methods of a client that need the streams, too. They find the streams' endpoints in the daemon's configuration."""

    endpoint: str
    keys: dict[str, KeyFile | str | None]

    def subscribe(self, *kinds: type[M], timeout_s: float | None = None) -> Subscription[M]:
        """A subscription to this client's daemon, with the same keys."""
        streams = self.config_get()["stream"]
        return Subscription(*kinds, endpoint=as_seen_from(self.endpoint, streams["endpoint"]),
                            image_endpoint=as_seen_from(self.endpoint, streams["image_endpoint"]), timeout_s=timeout_s,
                            key=self.keys["key"], server_key=self.keys["server_key"])  # type: ignore[arg-type]

    def image(self, timeout_s: float = 10.0) -> Image:
        """A camera image whose exposure began after this call; an image does not tell its exposure time, so that in use is assumed: the first
        one after a change from a longer one may be older. Raises NoAnswer if none came within `timeout_s` seconds."""
        with self.subscribe(Image) as stream:
            earliest, end = self._earliest_ns(), time.monotonic() + timeout_s
            exposure_us = self.camera_get()["settings"]["exposure_us"]
            while (image := stream.next(max(0.0, end - time.monotonic()))) is not None:
                if image.t_arrival_ns - 1e3 * exposure_us >= earliest:
                    return image
        raise no_image(timeout_s)

    def wavefront(self, frames: int = 50, timeout_s: float = 30.0) -> MeanWavefront:
        """Mean wavefront of the next valid frames, with standard errors. Only frames whose exposure began after this call count, and only
        those of one measurement: it begins again when charge, tracker, modes or the introduced aberration that the reference contains change,
        the loop is closed or opened, or another hologram is shown while it is open. Another reference that contains an introduced aberration
        of the same RMS does not show. Raises NoAnswer if there were not as many within `timeout_s` seconds."""
        gathering = Gathering(frames, self._earliest_ns())
        with self.subscribe(Wavefront) as stream:
            end = time.monotonic() + timeout_s
            while not gathering.is_complete and (frame := stream.next(max(0.0, end - time.monotonic()))) is not None:
                gathering.take(frame)
        return gathering.mean(timeout_s)

    @contextmanager
    def settings(self, **settings: Any) -> Iterator[dict[str, Any]]:
        """Changes settings of the camera and of the sensor (keys of camera.set and sensor.set) for the `with` block, and restores them after
        it, also after an exception. `clamp` applies to all of them. Gives the settings in use:

            with client.settings(gain_db=12, exposure_us=500):
                noisy = client.wavefront(frames=50)
        """
        change = SettingsChange(settings, self.camera_get()["settings"], self.sensor_get())
        applied: dict[str, Any] = {}
        with ExitStack() as restore:
            for method, params, before in change.calls():
                if before:
                    restore.callback(self.call, method, before)  # before the call: one without an answer may still be carried out
                applied |= self.call(method, params)["applied"]
            yield applied

    def _earliest_ns(self) -> float:
        return earliest_ns(self.system_status(), self.config_get())
