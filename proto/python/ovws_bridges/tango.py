"""Tango device server of the sensor, with PyTango: python3 -m ovws_bridges.tango INSTANCE [OPTIONS] [TANGO OPTIONS]

Without a Tango database: … bench -nodb -dlist ovws/bench/1 -ORBendPoint giop:tcp::45450
"""
from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

import numpy as np
import tango
from tango import AttrQuality, DevState
from tango.server import Device, attribute, command, device_property, run

from ovws_client import Client, ClientError, Message, Refused, Status, Wavefront
from ovws_client.errors import NoAnswer
from ovws_client.zernike import MAX_J

from .fields import FIELDS
from .frame import NULL_IF_INVALID, camera_setting, frame_seconds, frame_value, introduced_waves
from .link import Link

DTYPES = {"number": float, "integer": "int64", "boolean": bool, "string": str}
CAMERA = ("exposure_us", "gain_db")
STATES = {"starting": DevState.INIT, "waiting_for_camera": DevState.STANDBY, "waiting_for_display": DevState.STANDBY,
          "running": DevState.ON, "job_running": DevState.RUNNING, "fault": DevState.FAULT, "stopping": DevState.OFF}
EVERY_FRAME = ("coefficients", "sigma", "rms_waves", "valid", "settled", "frame_id", "seq", "hologram_id", "t_arrival_ns")  # pushed as events
MAX_IMAGE_PX, PHASE_PX = 8192, 128
BURST_S = 0.2  # frames that arrive late together have their events as long as the rate over this time allows it
OPTIONS: dict[str, Any] = {"control": "", "key": "", "server_key": "", "max_event_rate_hz": 200.0}  # of this process, for devices without properties
Value = tuple[Any, float, AttrQuality]


def passed_on(error: ClientError) -> tango.DevFailed:
    """A Tango error with the daemon's reason."""
    reason = "OVWS_Refused" if isinstance(error, Refused) else "OVWS_NoAnswer" if isinstance(error, NoAnswer) else "OVWS_Error"
    try:
        tango.Except.throw_exception(reason, str(error), "ovwsd")
    except tango.DevFailed as failed:
        return failed
    raise AssertionError("not reached")


def of_frame(name: str) -> attribute:
    """A read-only attribute of the newest frame."""
    field = FIELDS["wavefront"][name]
    kind = DTYPES[field.kind]
    return attribute(dtype=(kind,) if field.is_array else kind, max_dim_x=MAX_J, unit=field.unit, doc=field.description,
                     format="%9.5f" if kind is float else "%d", fget=lambda device: device.value_of(name))


def setting(name: str) -> attribute:
    """A writable camera setting."""
    field = FIELDS["camera.set"][name]
    made = attribute(dtype=float, unit=field.unit, doc=field.description, min_value=field.minimum, max_value=field.maximum,
                     access=tango.AttrWriteType.READ_WRITE, fget=lambda device: device.value_of(name))
    made.fset = lambda device, value: device.ask("camera.set", {name: value})
    return made


def of_daemon(method: str) -> Any:
    """A command that calls a method without params; returns the result as JSON."""
    name = method.replace(".", "_")

    def ask(device: WavefrontSensor) -> str:
        return json.dumps(device.ask(method, {}))

    ask.__name__ = name
    return command(ask, dtype_out=str, doc_out=getattr(Client, name).__doc__)


class WavefrontSensor(Device):
    """The wavefront sensor. Attributes of frames have the quality INVALID while frames are not valid or the daemon does not answer."""

    control = device_property(dtype=str, default_value="", doc="endpoint of the daemon's control socket")
    key = device_property(dtype=str, default_value="", doc="key file of this client, if the daemon requires keys")
    server_key = device_property(dtype=str, default_value="", doc="the daemon's public key")
    max_event_rate_hz = device_property(dtype=float, default_value=0.0, doc="events of an attribute per second, at most")

    coefficients, sigma, rms_waves, valid, settled = (of_frame(name) for name in ("coefficients", "sigma", "rms_waves", "valid", "settled"))
    j, frame_id, seq, gap, hologram_id = (of_frame(name) for name in ("j", "frame_id", "seq", "gap", "hologram_id"))
    t_device_ns, t_arrival_ns, saturated = (of_frame(name) for name in ("t_device_ns", "t_arrival_ns", "saturated"))
    exposure_us, gain_db = (setting(name) for name in CAMERA)
    reference_clear, aberration_clear, correction_clear = (of_daemon(f"{what}.clear") for what in ("reference", "aberration", "correction"))
    loop_close, loop_open = of_daemon("loop.close"), of_daemon("loop.open")

    def init_device(self) -> None:
        """Starts the connection; the daemon may start later."""
        super().init_device()
        given = {name: getattr(self, name) or value for name, value in OPTIONS.items()}
        self._period_s = 1.0 / given["max_event_rate_hz"]
        self._next_s = 0.0  # earliest monotonic time of the next events
        self._skipped = 0
        self._pushed: dict[str, float] = {}
        self._state: tuple[DevState, str] = (DevState.UNKNOWN, "")
        for name in (*EVERY_FRAME, *CAMERA, "State", "Status"):
            self.set_change_event(name, True, False)
        self._link = Link(Wavefront, endpoint=given["control"] or None, key=given["key"] or None, server_key=given["server_key"] or None)
        self._show(None)
        self._link.add_listener(self._listen)

    def delete_device(self) -> None:
        """Ends the connection."""
        self._link.remove_listener(self._listen)
        self._link.close()

    def value_of(self, name: str) -> Value:
        """Value, time and quality of an attribute."""
        if name in CAMERA:
            status = self._link.newest(Status)
            if isinstance(status, Status):
                value = camera_setting(status, name)
                return value, 1e-9 * status.t_ns, AttrQuality.ATTR_INVALID if np.isnan(value) else AttrQuality.ATTR_VALID
        elif isinstance(frame := self._link.newest(Wavefront), Wavefront):
            valid = frame.valid or name not in NULL_IF_INVALID
            return frame_value(frame, name), frame_seconds(frame), AttrQuality.ATTR_VALID if valid else AttrQuality.ATTR_INVALID
        return [] if FIELDS["wavefront"][name].is_array else 0, 0.0, AttrQuality.ATTR_INVALID

    def ask(self, method: str, params: dict[str, Any]) -> Any:
        """Calls a method of the daemon; its refusal becomes a Tango error."""
        return self._with_client(lambda client: client.call(method, params))

    @attribute(dtype=(float,), max_dim_x=MAX_J, unit=FIELDS["aberration.set"]["modes.waves"].unit, access=tango.AttrWriteType.READ_WRITE,
               doc="introduced aberration: coefficients of j = 1, 2, … (OSA/ANSI), RMS-normalised")
    def aberration(self) -> Any:
        """The introduced aberration."""
        return self._with_client(introduced_waves)

    @aberration.write
    def aberration(self, waves: Any) -> None:
        """Replaces the introduced aberration."""
        self._with_client(lambda client: client.aberration_set(list(waves)))

    @attribute(dtype=(("uint16",),), max_dim_x=MAX_IMAGE_PX, max_dim_y=MAX_IMAGE_PX, unit="DN", doc="the next camera image")
    def image(self) -> Any:
        """An image whose exposure began after the request."""
        return self._with_client(lambda client: client.image(timeout_s=2.0).pixels.astype(np.uint16))

    @attribute(dtype=((float,),), max_dim_x=PHASE_PX, max_dim_y=PHASE_PX, unit="wave", doc="wavefront of the newest frame; NaN outside the pupil")
    def phase(self) -> Any:
        """The wavefront map."""
        frame = self._link.newest(Wavefront)
        if not isinstance(frame, Wavefront) or not frame.valid:
            return np.full((PHASE_PX, PHASE_PX), np.nan), 0.0, AttrQuality.ATTR_INVALID
        return frame.phase_waves(PHASE_PX), frame_seconds(frame), AttrQuality.ATTR_VALID

    @attribute(dtype="int64", doc="frames whose events were skipped to keep max_event_rate_hz, and messages lost on the way to this server")
    def lost(self) -> int:
        """Losses since the start."""
        return self._skipped + self._link.lost_messages

    @command(dtype_in=int, doc_in=FIELDS["reference.take"]["frames"].description, dtype_out=int, doc_out="number of the job, see `call`")
    def reference_take(self, frames: int) -> int:
        """Takes a reference."""
        return int(self.ask("reference.take", {"frames": frames})["job"])

    @command(dtype_in=(str,), doc_in="name of a method of the daemon, and its params as JSON", dtype_out=str, doc_out="its result as JSON")
    def call(self, request: list[str]) -> str:
        """Calls any method of the daemon."""
        try:
            params = json.loads(request[1]) if len(request) > 1 else {}
        except ValueError as error:
            raise passed_on(ClientError(f"the second string must be JSON: {error}")) from None
        return json.dumps(self.ask(request[0], params))

    def _with_client(self, work: Any) -> Any:
        try:
            with self._link.client() as client:
                return work(client)
        except ClientError as error:
            raise passed_on(error) from None
        except ValueError as error:  # a number that JSON cannot hold
            raise passed_on(ClientError(f"the values must be finite numbers: {error}")) from None

    def _listen(self, message: Message | None) -> None:
        with tango.EnsureOmniThread():  # a thread that Tango has not started
            if isinstance(message, Wavefront):
                self._push_frame(message)
            elif message is None:
                self._show(None)
                self._pushed.clear()
                for name in (*EVERY_FRAME, *CAMERA):
                    self.push_change_event(name, *self.value_of(name))
            elif isinstance(message, Status):
                self._show(message)
                self._push_settings(message)

    def _push_frame(self, frame: Wavefront) -> None:
        now_s = time.monotonic()
        if now_s < self._next_s:
            self._skipped += 1
            return
        self._next_s = max(self._next_s + self._period_s, now_s - BURST_S)
        for name in EVERY_FRAME:
            valid = frame.valid or name not in NULL_IF_INVALID
            self.push_change_event(name, frame_value(frame, name), frame_seconds(frame), AttrQuality.ATTR_VALID if valid else AttrQuality.ATTR_INVALID)

    def _push_settings(self, status: Status) -> None:
        for name in CAMERA:
            value = camera_setting(status, name)
            if self._pushed.get(name) != value:
                self._pushed[name] = value
                self.push_change_event(name, *self.value_of(name))

    def _show(self, status: Status | None) -> None:
        """State and status text."""
        if status is None:
            state, text = DevState.UNKNOWN, f"the daemon at {self._link.endpoint} does not answer"
        else:
            invalid: Any = status.sensor.get("invalid") or {}
            parts = [status.state, status.fault, invalid.get("reason"), invalid.get("action")]
            state = DevState.ALARM if invalid and status.state == "running" else STATES.get(status.state, DevState.UNKNOWN)
            text = "; ".join(filter(None, parts))
        if (state, text) != self._state:
            self._state = state, text
            self.set_state(state)
            self.set_status(text)
            self.push_change_event("State")
            self.push_change_event("Status")


def main() -> None:
    """The device server."""
    parser = argparse.ArgumentParser(prog="python3 -m ovws_bridges.tango", description="Tango device server of the wavefront sensor. Further options are Tango's.")
    parser.add_argument("instance", help="name of this server in the Tango database")
    parser.add_argument("--control", help="endpoint of the daemon's control socket (default: this machine)")
    parser.add_argument("--key", help="key file of this client")
    parser.add_argument("--server-key", help="the daemon's public key")
    parser.add_argument("--max-event-rate-hz", type=float, help=f"events of an attribute per second, at most (default: {OPTIONS['max_event_rate_hz']:g})")
    own, others = parser.parse_known_args()
    if own.max_event_rate_hz is not None and own.max_event_rate_hz <= 0.0:
        parser.error("--max-event-rate-hz must be above 0")
    OPTIONS.update({name: value for name, value in vars(own).items() if name in OPTIONS and value is not None})
    run((WavefrontSensor,), args=[sys.argv[0], own.instance, *others])


if __name__ == "__main__":
    main()
