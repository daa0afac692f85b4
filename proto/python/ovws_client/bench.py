"""What one does at a bench, with the streams and the methods together: an image, a mean wavefront, settings for a while."""
from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import Any, TypeVar

from .errors import REFUSED, UNAVAILABLE, NoAnswer, Refused
from .measured import MeanWavefront
from .messages import FrameMessage, Image, Message, Wavefront
from .methods import WAIT_RANGES_S, CameraSettings, GrabStamp, Methods
from .subscription import Subscription
from .values import number, whole
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


class Later:
    """Selects messages of frames exposed after a call, by the frame numbers of camera.grab. The daemon finds the first such frame by its
    monotonic clock: subscribe, then grab with `params`. Frame numbers restart when the camera reconnects, and the wall clock may step. When
    numbers and stamps disagree, the number of another grab decides."""

    @staticmethod
    def params(timeout_s: float) -> dict[str, Any]:
        """Those of the camera.grab: one pixel of the next frame."""
        least, most = WAIT_RANGES_S["camera.grab"]
        return {"region": {"x": 0, "y": 0, "width": 1, "height": 1}, "timeout_s": min(max(timeout_s, least), most)}

    def __init__(self, first: GrabStamp) -> None:
        self._first = first
        self._newest = 0
        self._is_found = False

    def of(self, message: FrameMessage | Image) -> bool | None:
        """Whether this message is of such a frame; None: ask `of_doubtful`. For each message of a stream, in order."""
        is_restart = message.frame_id < self._newest
        self._newest = message.frame_id
        by_number = message.frame_id >= self._first["frame_id"]
        if not self._is_found and (is_restart or by_number != (message.t_arrival_ns >= self._first["t_arrival_ns"])):
            return None
        self._is_found = self._is_found or by_number  # further messages are later, whatever their numbers
        return self._is_found

    def of_doubtful(self, message: FrameMessage | Image, newest: GrabStamp) -> bool:
        """As `of`, by a frame grabbed after the message was received: it has a smaller number only if numbers restarted."""
        first, last = self._first["frame_id"], newest["frame_id"]
        self._is_found = message.frame_id <= last and (first <= message.frame_id or last < first)
        return self._is_found


class Gathering:
    """The valid frames of one measurement, for their mean. Begins again when the measurement changes."""

    def __init__(self, frames: int) -> None:
        self._frames = frames
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
        if frame.exposure_us is None:
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


RETRY_S = 0.05  # time between two requests for a grab


def check_refusal(refused: Refused, left_s: float, missing: str, timeout_s: float) -> None:
    """Returns if a refused camera.grab may be repeated: others use all grabs, or the image changed meanwhile. If it came too late, or no frame
    came, raises NoAnswer with what is `missing` and the daemon's reason; raises other refusals as they are."""
    if refused.code not in (REFUSED, UNAVAILABLE):
        raise refused
    if refused.code == UNAVAILABLE or left_s <= RETRY_S:
        raise NoAnswer(f"{missing} within {timeout_s} s: {refused.reason}") from refused


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
        end = time.monotonic() + number("timeout_s", timeout_s, 0.0)
        with self.subscribe(Image) as stream:
            later = self.later(timeout_s, "no image")
            while (image := stream.next(max(0.0, end - time.monotonic()))) is not None:
                if later(image):
                    return image
        raise no_image(timeout_s)

    def wavefront(self, frames: int = 50, timeout_s: float = 30.0) -> MeanWavefront:
        """Mean wavefront of the next valid frames, with standard errors. Only frames whose exposure began after this call count, and only
        those of one measurement: it begins again when charge, tracker, modes or the introduced aberration that the reference contains change,
        the loop is closed or opened, or another hologram is shown while it is open. Another reference that contains an introduced aberration
        of the same RMS does not show. Raises NoAnswer if there were not as many within `timeout_s` seconds."""
        frames, end = whole("frames", frames), time.monotonic() + number("timeout_s", timeout_s, 0.0)
        with self.subscribe(Wavefront) as stream:
            gathering, later = Gathering(frames), self.later(timeout_s, f"0 of {frames} valid frames")
            while not gathering.is_complete and (frame := stream.next(max(0.0, end - time.monotonic()))) is not None:
                if later(frame):
                    gathering.take(frame)
        return gathering.mean(timeout_s)

    def later(self, timeout_s: float, missing: str = "no frame") -> Callable[[FrameMessage | Image], bool]:
        """Selects messages of frames exposed after this call, of one subscription made before it: call the result with each message, in order.
        Both raise NoAnswer, which begins with what is `missing`, if no frame came within `timeout_s` seconds of this call."""
        end = time.monotonic() + timeout_s

        def grab() -> GrabStamp:
            while True:
                try:
                    return self.camera_grab(**Later.params(end - time.monotonic()))[0]["frames"][0]
                except Refused as refused:
                    check_refusal(refused, end - time.monotonic(), missing, timeout_s)
                time.sleep(RETRY_S)

        later = Later(grab())

        def is_later(message: FrameMessage | Image) -> bool:
            known = later.of(message)
            return later.of_doubtful(message, grab()) if known is None else known

        return is_later

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
