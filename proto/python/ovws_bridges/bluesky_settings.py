"""Settings of the bench as devices for Bluesky plans: camera settings, and the introduced aberration."""
from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from ovws_client import Client, NoAnswer, Wavefront, mode_index, mode_name
from ovws_client.modes import ModeKey

from .action import Action
from .field import Field
from .fields import FIELDS
from .frame import frame_value, frames_of, introduced, introduced_waves
from .link import Link

Readings = dict[str, dict[str, Any]]
DTYPES = {"number": "<f8", "integer": "<i8", "boolean": "|b1"}


class Sensor(Protocol):
    """What a setting needs of its sensor."""

    link: Link
    timeout_s: float

    def key(self, name: str) -> str:
        """Name of a field in readings."""


def data_key(field: Field, source: str, length: int | None = None) -> dict[str, Any]:
    """A data key of the event model, with the unit and the range of a field; `length`: number of items of an array."""
    key: dict[str, Any] = {"source": source, "dtype": "array" if field.is_array else field.kind,
                           "shape": [length] if field.is_array else [], "dtype_numpy": DTYPES[field.kind]}
    if field.unit:
        key["units"] = field.unit
    if field.minimum is not None and field.maximum is not None:
        key["limits"] = {"control": {"low": field.minimum, "high": field.maximum}}
    return key


class Setting:
    """A settable value of the bench: Movable, Readable, Locatable, Checkable and Stageable. The status of `set` is done when a frame exposed
    wholly with the new value has arrived; a refused value fails with the daemon's reason."""

    parent = None  # a child would not be read beside its parent
    field: Field

    def __init__(self, sensor: Sensor, name: str) -> None:
        self._sensor = sensor
        self.name = sensor.key(name)
        self._name = name
        self._link = sensor.link

    @property
    def hints(self) -> dict[str, Any]:
        """The value itself."""
        return {"fields": [self.name]}

    @property
    def position(self) -> Any:
        """The value in use."""
        with self._link.client() as client:
            return self._get(client)

    def set(self, value: Any) -> Action:
        """Sets the value."""
        return Action(lambda: self._set_and_wait(value), f"{self.name} set")

    def read(self) -> Readings:
        """The value in use."""
        return {self.name: {"value": self.position, "timestamp": time.time()}}

    def describe(self) -> dict[str, dict[str, Any]]:
        """Its data key."""
        return {self.name: data_key(self.field, self._source())}

    def read_configuration(self) -> Readings:
        """Nothing."""
        return {}

    describe_configuration = read_configuration

    def locate(self) -> dict[str, Any]:
        """The value in use; the daemon keeps no other."""
        value = self.position
        return {"setpoint": value, "readback": value}

    def check_value(self, value: Any) -> None:
        """Raises ValueError if no bench accepts the value. The camera may allow less."""
        low, high = self.field.minimum, self.field.maximum
        if low is not None and high is not None and not np.all((low <= np.asarray(value)) & (np.asarray(value) <= high)):
            raise ValueError(f"{self._name}: must be from {low:g} to {high:g} {self.field.unit}, not {value}")

    def stage(self) -> list[object]:
        """Waits until the daemon answers."""
        self._link.wait_until_connected(self._sensor.timeout_s)
        return [self]

    def unstage(self) -> list[object]:
        """Leaves the value as it is."""
        return [self]

    def _source(self) -> str:
        raise NotImplementedError

    def _get(self, client: Client) -> Any:
        raise NotImplementedError

    def _set(self, client: Client, value: Any) -> tuple[Callable[[Wavefront], bool], float]:
        """Sets the value; returns what recognises a frame exposed wholly with it, among those of `_later`, and the exposure time, microseconds."""
        raise NotImplementedError

    def _later(self, client: Client, timeout_s: float) -> Callable[[Wavefront], bool]:
        """Selects the frames to be looked at, of messages that are received already. Called after `_set`."""
        return lambda frame: True

    def _set_and_wait(self, value: Any) -> None:
        with self._link.client() as client:
            shows, exposure_us = self._set(client, value)
        timeout_s = self._sensor.timeout_s + 3e-6 * exposure_us
        with self._link.messages(timeout_s) as messages, self._link.own_client() as client:
            later = self._later(client, timeout_s)
            if not any(later(frame) and shows(frame) for frame in frames_of(messages)):
                raise NoAnswer(f"{self.name}: no frame exposed with {value} within {timeout_s:g} s; does another client change it?")


class CameraSetting(Setting):
    """A number among the settings of the camera."""

    def __init__(self, sensor: Sensor, name: str) -> None:
        super().__init__(sensor, name)
        self.field = FIELDS["camera.set"][name]

    def _source(self) -> str:
        return f"ovws+{self._link.endpoint}/camera.set/{self._name}"

    def _get(self, client: Client) -> float:
        value = client.camera_get()["settings"][self._name]  # type: ignore[literal-required]
        return float("nan") if value is None else float(value)

    def _set(self, client: Client, value: Any) -> tuple[Callable[[Wavefront], bool], float]:
        settings = client.call("camera.set", {self._name: value})["applied"]
        wanted = settings[self._name]
        return lambda frame: bool(np.isclose(frame_value(frame, self._name), wanted, rtol=1e-6)), settings["exposure_us"]

    def _later(self, client: Client, timeout_s: float) -> Callable[[Wavefront], bool]:
        return client.later(timeout_s)


class Aberration(Setting):
    """The introduced aberration: coefficients of j = 1, 2, …, or {mode: waves}, as in ovws_client."""

    field = FIELDS["aberration.set"]["modes.waves"]

    def __init__(self, sensor: Sensor, name: str = "aberration") -> None:
        super().__init__(sensor, name)

    def describe(self) -> dict[str, dict[str, Any]]:
        """Its data key: an array of the coefficients of j = 1, 2, …"""
        return {self.name: data_key(self.field, self._source()) | {"dtype": "array", "shape": [len(self.position)]}}

    def check_value(self, value: Any) -> None:
        """Raises ValueError if no bench accepts the value."""
        super().check_value(list(value.values()) if isinstance(value, dict) else value)

    def _source(self) -> str:
        return f"ovws+{self._link.endpoint}/aberration.set/modes"

    def _get(self, client: Client) -> Any:
        return introduced_waves(client)

    def _set(self, client: Client, value: Any) -> tuple[Callable[[Wavefront], bool], float]:
        hologram_id = client.aberration_set(value)["hologram_id"]
        return (lambda frame: frame.settled and frame.hologram_id >= hologram_id), client.camera_get()["settings"]["exposure_us"]


class AberrationMode(Aberration):
    """One mode of the introduced aberration, waves RMS; the others stay as they are."""

    def __init__(self, sensor: Sensor, mode: ModeKey) -> None:
        self._j = mode_index(mode)
        super().__init__(sensor, f"aberration-{mode_name(self._j).replace(' ', '_')}")

    def describe(self) -> dict[str, dict[str, Any]]:
        """Its data key."""
        return Setting.describe(self)

    def _source(self) -> str:
        return f"{super()._source()}/{self._j}"

    def _get(self, client: Client) -> float:
        return introduced(client).get(self._j, 0.0)

    def _set(self, client: Client, value: Any) -> tuple[Callable[[Wavefront], bool], float]:
        return super()._set(client, introduced(client) | {self._j: value})
