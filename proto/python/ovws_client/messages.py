"""Stream messages as dataclasses. Unknown values are None, or NaN in an array. One wave is one `wavelength_nm`."""
from __future__ import annotations

import copyreg
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import display
from .errors import NotUnderstood
from .methods import FailedJob, Latency, Rates, RecordReport, StatusCamera, StatusRefine, StatusSensor, StatusSlm, StatusStore
from .modes import ModeKey, coefficient, mode_name
from .wire import IMAGES, NUMBERS
from .zernike import phase_map_waves

Self = TypeVar("Self", bound="Message")
Binary = bytes | memoryview | None
Floats = NDArray[np.float64]


def _array(body: Mapping[str, Any], binary: Binary) -> NDArray[Any]:
    """The binary part as an array, without a copy."""
    if binary is None or body["dtype"] not in ("<u1", "<u2", "<f4"):
        raise ValueError(f"unexpected binary part of {body['dtype']}")
    return np.frombuffer(binary, body["dtype"]).reshape(body["shape"])


def _floats(values: list[float | None]) -> Floats:
    return np.array(values, np.float64)  # None becomes NaN


@dataclass(frozen=True, kw_only=True, eq=False)
class Message:
    """Base of all messages. `lost_messages`: messages of its topic lost on the way to this subscriber just before this one."""

    topic: ClassVar[str]
    endpoint: ClassVar[str] = NUMBERS
    seq: int
    lost_messages: int = 0

    @classmethod
    def of(cls: type[Self], body: Mapping[str, Any], binary: Binary = None, lost_messages: int = 0) -> Self:
        """Decodes the JSON and binary parts. Raises NotUnderstood if they do not match the schema; unknown keys are ignored."""
        form = f"ovws.{cls.topic.partition('.')[0]}/1"
        if body.get("schema") != form:
            raise NotUnderstood(f"a message of schema {body.get('schema')}, but {form} is supported: use the client that came with the daemon")
        try:
            return cls(**cls._values(body, binary) | {"lost_messages": lost_messages})
        except (KeyError, TypeError, ValueError) as error:
            raise NotUnderstood(f"a message of {cls.topic} does not match {form}: {error}") from error

    @classmethod
    def _values(cls, body: Mapping[str, Any], binary: Binary) -> dict[str, Any]:
        return {field.name: body[field.name] for field in fields(cls) if field.name in body}


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameMessage(Message):
    """Fields common to the messages of each processed frame; WIRE.md documents every field."""

    frame_id: int
    gap: int
    """frames lost between the camera and the daemon since the previous message"""
    t_device_ns: int
    t_arrival_ns: int
    t_publish_ns: int
    latency_us: float
    hologram_id: int
    settled: bool
    pattern: int | None = None
    """number of the pattern of aberration.sequence in this frame, from 0; None: none is shown, or it is not certain"""
    charge: int
    tracker: str
    subapertures: int
    tracked: int
    valid: bool
    verdict: str
    """"valid", or why the frame is not (WIRE.md)"""
    wavelength_nm: float
    rms_waves: float | None
    """root sum square of the coefficients without tilts, waves; None if not valid"""
    fit_residual_px: float | None
    """RMS residual of the fit of the modes, camera pixels"""
    gain_db: float | None
    gain_raw: float | None = None
    """gain in device-specific steps, if the camera has no gain in dB"""
    exposure_us: float | None
    saturated: float
    """fraction of spots with a saturated pixel, 0 to 1"""
    loop: Literal["open", "closed"]
    reference_introduced_rms_waves: float
    """RMS of the introduced aberration that the reference contains and the coefficients therefore exclude; 0: none"""

    @classmethod
    @cache
    def of_beam(cls: type[Self], name: str) -> type[Self]:
        """The kind of these messages of a further light source: subscribe to Wavefront.of_beam("b"). For Wavefront and Spots."""
        return _BeamKind(cls.__name__, (cls,), {"topic": f"{cls.topic}.{name}"})


class _BeamKind(type):
    """Type of the kinds that of_beam makes, which pickle cannot find by their names."""


def _reduce_beam_kind(kind: type[FrameMessage]) -> tuple[Any, ...]:
    base, name = kind.__bases__[0], kind.topic.partition(".")[2]
    return getattr(base, "of_beam"), (name,)


copyreg.pickle(_BeamKind, _reduce_beam_kind)


@dataclass(frozen=True, kw_only=True, eq=False)
class Wavefront(FrameMessage):
    """Zernike coefficients of one frame."""

    topic = "wavefront"
    j: NDArray[np.int64]
    """OSA/ANSI indices, without piston"""
    coefficients_waves: Floats
    """present aberration minus the reference, RMS-normalised waves, as many as `j`; all NaN if not valid"""
    sigma_waves: Floats
    """standard errors of the coefficients, waves; all NaN if the frame was measured by positions only"""
    branch_points: Floats
    """phase singularities of the incoming light, rows x, y (pupil radii), charge; empty: none recognised"""

    def phase_waves(self, size_px: int = 128) -> Floats:
        """Wavefront over the pupil, waves, shape (size_px, size_px); NaN outside the pupil, and everywhere if not valid."""
        return phase_map_waves(self.j, self.coefficients_waves, size_px)

    def waves(self, mode: ModeKey) -> float:
        """Coefficient of a mode, given by name, index or orders (n, m); NaN if not valid. Raises ValueError if it is not measured."""
        return coefficient(self.j, self.coefficients_waves, mode)

    def _repr_html_(self) -> str:
        state = f"{self.rms_waves:.4f} waves RMS without tilts" if self.rms_waves is not None else "not valid"
        return display.wavefront(f"Frame {self.frame_id}: {state}, {self.tracked} of {self.subapertures} spots, at {self.wavelength_nm:g} nm",
                                 [mode_name(j) for j in self.j.tolist()], self.coefficients_waves, self.sigma_waves, self.phase_waves())

    @classmethod
    def _values(cls, body: Mapping[str, Any], binary: Binary) -> dict[str, Any]:
        return super()._values(body, binary) | {"j": np.array(body["j"], np.int64), "coefficients_waves": _floats(body["coefficients"]),
                                                "sigma_waves": _floats(body["sigma"]),
                                                "branch_points": _floats(body.get("branch_points", [])).reshape(-1, 3)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Spots(FrameMessage):
    """Spots of one frame, one row per subaperture, by rows of increasing V_y, then V_x; NaN: lost spot, or no reference."""

    topic = "spots"
    x_y_px: NDArray[np.float32]
    """spot positions, camera pixels, (subapertures, 2)"""
    ref_x_y_px: NDArray[np.float32]
    """reference positions, camera pixels, (subapertures, 2)"""
    peak_dn: NDArray[np.float32]
    """brightest pixel of each spot, DN"""
    quality: NDArray[np.float32]
    """contrast, 0 to 1"""

    @property
    def displacements_px(self) -> NDArray[np.float32]:
        """Spot minus reference, camera pixels, (subapertures, 2)."""
        return self.x_y_px - self.ref_x_y_px

    @classmethod
    def _values(cls, body: Mapping[str, Any], binary: Binary) -> dict[str, Any]:
        table = _array(body, binary)
        column = body["columns"].index
        if body["column_units"] != ["px", "px", "px", "px", "DN", "1"]:
            raise ValueError(f"unexpected units of columns: {body['column_units']}")
        x, ref_x = column("x"), column("ref_x")
        return super()._values(body, binary) | {"x_y_px": table[:, x:x + 2], "ref_x_y_px": table[:, ref_x:ref_x + 2],
                                                "peak_dn": table[:, column("peak")], "quality": table[:, column("quality")]}


@dataclass(frozen=True, kw_only=True, eq=False)
class Corrector(FrameMessage):
    """Commands of one frame for an external corrector: the matrix of corrector_set times its coefficients. Not valid: none."""

    topic = "corrector"
    matrix: int
    """number of the matrix, from the result of corrector_set"""
    commands: NDArray[np.float32]
    """one for each actuator, in the unit of the matrix; empty if not valid"""

    @classmethod
    def _values(cls, body: Mapping[str, Any], binary: Binary) -> dict[str, Any]:
        commands = _array(body, binary) if body["valid"] else np.empty(0, np.float32)
        return super()._values(body, binary) | {"commands": commands}


@dataclass(frozen=True, kw_only=True, eq=False)
class Refined(Message):
    """Maximum-likelihood fit of the diffraction model to all pixels of a frame, published when the fit has ended."""

    topic = "refined"
    frame_id: int
    t_arrival_ns: int
    t_publish_ns: int
    hologram_id: int
    charge: int
    valid: bool
    reason: str | None
    against: Literal["reference", "model"]
    wavelength_nm: float
    rms_waves: float | None
    gain_db: float | None
    gain_raw: float | None = None
    """gain in device-specific steps, if the camera has no gain in dB"""
    exposure_us: float | None
    chi2_per_pixel: float | None
    peak_e: float | None
    """brightest pixel of the model above the background, electrons"""
    background_e: float | None
    """background above the black level, electrons"""
    iterations: int | None
    duration_ms: float
    j: NDArray[np.int64]
    coefficients_waves: Floats
    """RMS-normalised waves, as many as `j`; all NaN if not valid"""
    sigma_waves: Floats
    """standard errors of the coefficients, waves; all NaN if not valid"""

    @classmethod
    def _values(cls, body: Mapping[str, Any], binary: Binary) -> dict[str, Any]:
        return super()._values(body, binary) | {"j": np.array(body["j"], np.int64), "coefficients_waves": _floats(body["coefficients"]),
                                                "sigma_waves": _floats(body["sigma"])}


@dataclass(frozen=True, kw_only=True, eq=False)
class Image(Message):
    """A camera image."""

    topic = "image"
    endpoint = IMAGES
    frame_id: int
    t_arrival_ns: int
    hologram_id: int
    pattern: int | None = None
    """as in Wavefront"""
    pixel_format: str
    significant_bits: int
    pixels: NDArray[np.uint8] | NDArray[np.uint16]
    """grey levels, DN, (rows, columns), in the received memory (no copy)"""

    def _repr_html_(self) -> str:
        top, full = int(self.pixels.max()), (1 << self.significant_bits) - 1
        saturated = int((self.pixels >= full).sum())
        caption = f"frame {self.frame_id}: {self.pixels.shape[1]} x {self.pixels.shape[0]} {self.pixel_format}, brightest pixel {top} of {full} DN, {saturated} saturated"
        return display.img(display.grey(self.pixels, self.significant_bits), caption)

    @classmethod
    def _values(cls, body: Mapping[str, Any], binary: Binary) -> dict[str, Any]:
        return super()._values(body, binary) | {"pixels": _array(body, binary)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Phase(Message):
    """Wavefront map over the pupil, computed by the daemon."""

    topic = "phase"
    endpoint = IMAGES
    frame_id: int
    t_arrival_ns: int
    hologram_id: int
    valid: bool
    wavelength_nm: float
    waves: NDArray[np.float32]
    """waves, (rows, columns) of pupil_grid; NaN outside the pupil"""

    def _repr_html_(self) -> str:
        scale = float(np.nanmax(np.abs(self.waves))) if self.valid else 0.0
        return display.img(display.signed(self.waves, scale), f"frame {self.frame_id}: -{scale:.3f} (blue) to +{scale:.3f} waves (red)")

    @classmethod
    def _values(cls, body: Mapping[str, Any], binary: Binary) -> dict[str, Any]:
        return super()._values(body, binary) | {"waves": _array(body, binary)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Status(Message):
    """Status of the daemon, once a second and immediately on change; the parts are dicts as in `system.status`."""

    topic = "status"
    t_ns: int
    uptime_s: float
    state: str
    fault: str | None
    camera: StatusCamera
    slm: StatusSlm
    sensor: StatusSensor
    refine: StatusRefine
    record: RecordReport
    store: StatusStore
    loop: Literal["open", "closed"]
    failed_job: FailedJob | None
    rates: Rates
    counters: dict[str, int]
    latency: dict[str, Latency]
    versions: dict[str, str]


@dataclass(frozen=True, kw_only=True, eq=False)
class Event(Message):
    """An event: state change, fault, or progress of a job."""

    topic = "event"
    t_ns: int
    kind: str
    severity: Literal["info", "warning", "error"]
    text: str
    data: dict[str, Any] | None
