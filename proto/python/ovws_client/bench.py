"""What one does at a bench, with the streams and the methods together: an image, a mean wavefront, settings for a while."""
from __future__ import annotations

import re
import time
from collections.abc import Iterator
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
            earliest_ns, end = self._earliest_ns(), time.monotonic() + timeout_s
            exposure_us = self.camera_get()["settings"]["exposure_us"]
            while (image := stream.next(max(0.0, end - time.monotonic()))) is not None:
                if image.t_arrival_ns - 1e3 * exposure_us >= earliest_ns:
                    return image
        raise NoAnswer(f"no image within {timeout_s} s; does the camera deliver frames (system_status)?")

    def wavefront(self, frames: int = 50, timeout_s: float = 30.0) -> MeanWavefront:
        """Mean wavefront of the next valid frames, with standard errors. Only frames whose exposure began after this call count, and only
        those of one measurement: it begins again when charge, tracker, modes or the introduced aberration that the reference contains change,
        the loop is closed or opened, or another hologram is shown while it is open. Another reference that contains an introduced aberration
        of the same RMS does not show. Raises NoAnswer if there were not as many within `timeout_s` seconds."""
        if frames < 1:
            raise ValueError(f"frames must be at least 1, not {frames}")
        good: list[Wavefront] = []
        skipped = 0
        with self.subscribe(Wavefront) as stream:
            earliest_ns, end = self._earliest_ns(), time.monotonic() + timeout_s
            while len(good) < frames and (frame := stream.next(max(0.0, end - time.monotonic()))) is not None:
                if frame.exposure_us is None or frame.t_arrival_ns - 1e3 * frame.exposure_us < earliest_ns:
                    continue
                if not frame.valid:
                    skipped += 1
                    continue
                if good and measurement(frame) != measurement(good[0]):
                    good.clear()
                    skipped = 0
                good.append(frame)
        if len(good) < frames:
            raise NoAnswer(f"{len(good)} of {frames} valid frames within {timeout_s} s, and {skipped} that were not valid; is there a reference?")
        return MeanWavefront.of(good, skipped)

    @contextmanager
    def settings(self, **settings: Any) -> Iterator[dict[str, Any]]:
        """Changes settings of the camera and of the sensor (keys of camera.set and sensor.set) for the `with` block, and restores them after
        it, also after an exception. `clamp` applies to all of them. Gives the settings in use:

            with client.settings(gain_db=12, exposure_us=500):
                noisy = client.wavefront(frames=50)
        """
        before: dict[str, dict[str, Any]] = {"camera.set": self.camera_get()["settings"], "sensor.set": self.sensor_get()}  # type: ignore[dict-item]
        changes: dict[str, dict[str, Any]] = {"camera.set": {}, "sensor.set": {}}
        clamp = {"clamp": settings.pop("clamp")} if "clamp" in settings else {}
        for key, value in settings.items():
            changes["camera.set" if key in CameraSettings.__annotations__ else "sensor.set"][key] = value
        applied: dict[str, Any] = {}
        with ExitStack() as restore:
            for method, change in changes.items():
                if old := {key: before[method][key] for key in change if key in before[method]}:
                    restore.callback(self.call, method, old)  # before the call: one without an answer may still be carried out
                if change:
                    applied |= self.call(method, change | clamp)["applied"]
            yield applied

    def _earliest_ns(self) -> float:
        """Of a frame whose exposure begins after this call: the earliest arrival minus exposure time, by the daemon's clock. The transfer takes
        up to camera.transfer_ms, as the daemon assumes, too."""
        return self.system_status()["t_ns"] + 1e6 * self.config_get()["camera"]["transfer_ms"]
