"""EPICS PV Access server of the sensor, with p4p: python3 -m ovws_bridges.epics [--prefix OVWS:] [OPTIONS]

PVs are named after the fields: OVWS:coefficients (NTScalarArray), OVWS:rms_waves (NTScalar), OVWS:image and OVWS:phase (NTNDArray), and the
settings OVWS:exposure_us, OVWS:gain_db and OVWS:aberration.
"""
from __future__ import annotations

import argparse
import signal
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from p4p.nt import NTNDArray, NTScalar
from p4p.server import Server
from p4p.server.thread import SharedPV

from ovws_client import Client, ClientError, Image, Message, Phase, Status, Wavefront
from ovws_client.wire import KeyFile

from .field import Field
from .fields import FIELDS
from .frame import NULL_IF_INVALID, camera_setting, frame_seconds, frame_value, introduced_waves
from .link import Link

TYPES = {"number": "d", "integer": "l", "boolean": "?", "string": "s"}
NOTHING: dict[str, Any] = {"number": float("nan"), "integer": 0, "boolean": False, "string": ""}
OF_FRAME = ("coefficients", "sigma", "j", "rms_waves", "valid", "settled", "frame_id", "seq", "gap", "hologram_id", "t_device_ns", "t_arrival_ns")
CAMERA = ("exposure_us", "gain_db")
NO_ALARM, INVALID = 0, 3  # alarm severities
NOT_VALID, NO_DAEMON, NO_SETTING = "the frame is not valid", "the daemon does not answer", "the camera is not connected, or has no such setting"


class Setting:
    """Handler of a writable PV: passes the value to the daemon, and its refusal back."""

    def __init__(self, link: Link, write: Callable[[Client, Any], Any]) -> None:
        self._link = link
        self._write = write

    def put(self, _pv: SharedPV, operation: Any) -> None:
        """Writes a value."""
        try:
            with self._link.client() as client:
                self._write(client, operation.value().raw.value)
        except (ClientError, ValueError) as error:  # ValueError: a number that JSON cannot hold
            operation.done(error=str(error))
        else:
            operation.done()


def described(field: Field, is_array: bool) -> tuple[NTScalar, dict[str, Any]]:
    """The type and the first value of a field's PV."""
    kind = TYPES[field.kind]
    display: dict[str, Any] = {"description": field.description, "units": field.unit}
    value: dict[str, Any] = {"value": [] if is_array else NOTHING[field.kind], "display": display,
                             "alarm": {"severity": INVALID, "message": NO_DAEMON}}
    has_range = field.kind in ("number", "integer") and field.minimum is not None and field.maximum is not None
    if has_range:
        value["control"] = {"limitLow": field.minimum, "limitHigh": field.maximum}
        display |= {"limitLow": field.minimum, "limitHigh": field.maximum}
    return NTScalar(f"a{kind}" if is_array else kind, display=True, control=has_range), value


class Bridge:
    """All PVs of one daemon; `pvs` by name. Endpoint and keys as in ovws_client.Client."""

    def __init__(self, prefix: str = "OVWS:", endpoint: str | None = None, key: KeyFile | None = None, server_key: str | None = None) -> None:
        self.pvs: dict[str, SharedPV] = {}
        self._prefix = prefix
        self._link = Link(Wavefront, Image, Phase, endpoint=endpoint, key=key, server_key=server_key)
        self._hologram_id: int | None = None  # of the aberration that was posted
        for name in OF_FRAME:
            self._add(name, FIELDS["wavefront"][name], FIELDS["wavefront"][name].is_array)
        for name in CAMERA:
            self._add(name, FIELDS["camera.set"][name], False, lambda client, value, name=name: client.call("camera.set", {name: value}))
        self._add("aberration", FIELDS["aberration.set"]["modes.waves"], True, lambda client, value: client.aberration_set(list(value)))
        for name, pixel in (("image", np.uint8), ("phase", np.float32)):
            self.pvs[prefix + name] = SharedPV(nt=NTNDArray(), initial=np.zeros((1, 1), pixel))
        self._link.add_listener(self._listen)

    def close(self) -> None:
        """Ends the connection to the daemon."""
        self._link.close()

    def _add(self, name: str, field: Field, is_array: bool, write: Callable[..., Any] | None = None) -> None:
        nt, value = described(field, is_array)
        self.pvs[self._prefix + name] = SharedPV(nt=nt, initial=value, handler=Setting(self._link, write) if write else None)

    def _post(self, name: str, value: Any, seconds: float, fault: str = "") -> None:
        self.pvs[self._prefix + name].post(value, timestamp=seconds, severity=INVALID if fault else NO_ALARM, message=fault)

    def _listen(self, message: Message | None) -> None:
        if isinstance(message, Wavefront):
            for name in OF_FRAME:
                self._post(name, frame_value(message, name), frame_seconds(message), "" if message.valid or name not in NULL_IF_INVALID else NOT_VALID)
        elif isinstance(message, Image):
            self._post("image", message.pixels, 1e-9 * message.t_arrival_ns)
        elif isinstance(message, Phase):
            self._post("phase", message.waves, 1e-9 * message.t_arrival_ns, "" if message.valid else NOT_VALID)
        elif isinstance(message, Status):
            for name in CAMERA:
                value = camera_setting(message, name)
                self._post(name, value, 1e-9 * message.t_ns, NO_SETTING if np.isnan(value) else "")
            self._post_aberration(message)
        elif message is None:
            self._hologram_id = None
            for pv in self.pvs.values():
                if isinstance(pv.nt, NTNDArray):
                    pv.post(np.asarray(pv.current()), severity=INVALID, message=NO_DAEMON)
                else:
                    pv.post({"alarm": {"severity": INVALID, "message": NO_DAEMON}})

    def _post_aberration(self, status: Status) -> None:
        if status.slm["hologram_id"] != self._hologram_id:
            with suppress(ClientError), self._link.client() as client:  # the next status tries again
                self._post("aberration", introduced_waves(client), 1e-9 * status.t_ns)
                self._hologram_id = status.slm["hologram_id"]


def main() -> None:
    """The server, until SIGINT or SIGTERM."""
    parser = argparse.ArgumentParser(prog="python3 -m ovws_bridges.epics", description="EPICS PV Access server of the wavefront sensor.")
    parser.add_argument("--prefix", default="OVWS:", help="begin of each PV's name (default: OVWS:)")
    parser.add_argument("--control", help="endpoint of the daemon's control socket (default: this machine)")
    parser.add_argument("--key", help="key file of this client")
    parser.add_argument("--server-key", help="the daemon's public key")
    given = parser.parse_args()
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM))  # before threads start
    try:
        bridge = Bridge(given.prefix, given.control, given.key, given.server_key)
    except ClientError as error:  # the endpoint or a key is wrong
        parser.error(str(error))
    with Server(providers=[bridge.pvs]):
        print("serving", *bridge.pvs, flush=True)
        signal.sigwait((signal.SIGINT, signal.SIGTERM))
    bridge.close()


if __name__ == "__main__":
    main()
