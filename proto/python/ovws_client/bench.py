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
        """A camera image whose exposure began after this call. Raises NoAnswer if none came within `timeout_s` seconds."""
        with self.subscribe(Image) as stream:
            begin_ns, end = self._begin_ns(), time.monotonic() + timeout_s
            while (image := stream.next(max(0.0, end - time.monotonic()))) is not None:
                if image.t_arrival_ns >= begin_ns:
                    return image
        raise NoAnswer(f"no image within {timeout_s} s; does the camera deliver frames (system_status)?")

    def wavefront(self, frames: int = 50, timeout_s: float = 30.0) -> MeanWavefront:
        """Mean wavefront of the next valid frames, with standard errors. Only frames whose exposure began after this call count. Raises
        NoAnswer if there were not as many within `timeout_s` seconds."""
        if frames < 1:
            raise ValueError(f"frames must be at least 1, not {frames}")
        good: list[Wavefront] = []
        skipped = 0
        with self.subscribe(Wavefront) as stream:
            begin_ns, end = self._begin_ns(), time.monotonic() + timeout_s
            while len(good) < frames and (frame := stream.next(max(0.0, end - time.monotonic()))) is not None:
                if frame.t_arrival_ns < begin_ns:
                    continue
                if not frame.valid:
                    skipped += 1
                    continue
                if good and len(frame.j) != len(good[0].j):
                    good.clear()  # the sensor changed
                good.append(frame)
        if len(good) < frames:
            raise NoAnswer(f"{len(good)} of {frames} valid frames within {timeout_s} s, and {skipped} that were not valid; is there a reference?")
        return MeanWavefront.of(good, skipped)

    @contextmanager
    def settings(self, **settings: Any) -> Iterator[dict[str, Any]]:
        """Changes settings of the camera and of the sensor (keys of camera.set and sensor.set) for the `with` block, and restores them after
        it, also after an exception. Gives the settings in use:

            with client.settings(gain_db=12, exposure_us=500):
                noisy = client.wavefront(frames=50)
        """
        before: dict[str, dict[str, Any]] = {"camera.set": self.camera_get()["settings"], "sensor.set": self.sensor_get()}  # type: ignore[dict-item]
        changes: dict[str, dict[str, Any]] = {"camera.set": {}, "sensor.set": {}}
        for key, value in settings.items():
            changes["camera.set" if key in CameraSettings.__annotations__ or key == "clamp" else "sensor.set"][key] = value
        applied: dict[str, Any] = {}
        with ExitStack() as restore:
            for method, change in changes.items():
                if change:
                    applied |= self.call(method, change)["applied"]
                    restore.callback(self.call, method, {key: before[method][key] for key in change if key in before[method]})
            yield applied

    def _begin_ns(self) -> int:
        """Arrival time, by the daemon's clock, of the first frame whose exposure begins after this call."""
        return self.system_status()["t_ns"] + int(1e3 * self.camera_get()["settings"]["exposure_us"])
