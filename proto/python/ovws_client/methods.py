"""Every method of the daemon, with its types and its words. Made by make_methods.py from proto/schema: change it there.

What is LEFT_OUT stays as it is, or is the default. Results are dicts, as the wire has them.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any, Final, Literal, NotRequired, TypedDict


class LeftOut(Enum):
    """The type of LEFT_OUT: None would be a value, the wire's null."""

    LEFT_OUT = "left out"

    def __repr__(self) -> str:
        return "LEFT_OUT"


LEFT_OUT: Final = LeftOut.LEFT_OUT


def _given(**params: object) -> dict[str, object]:
    return {name: value for name, value in params.items() if value is not LEFT_OUT}


class Mode(TypedDict):
    # OSA/ANSI index; from 0 to 230
    j: int
    # radial order; from 0 to 20
    n: int
    # azimuthal frequency; negative: sine; from -20 to 20
    m: int
    # common name, or Z(n,m)
    name: str
    # coefficient, waves RMS at the laser's wavelength
    waves: float


class AberrationResult(TypedDict):
    # the wavefront added on purpose, RMS-normalised
    modes: list[Mode]
    # normalisation of the coefficients given back
    norm: Literal["rms"]
    # number of the hologram, as in every stream message; 0: none
    hologram_id: int


class ModeByJ(TypedDict):
    # OSA/ANSI index; from 0 to 230
    j: int
    # coefficient in the normalisation given by norm, waves at the laser's wavelength; from -1000 to 1000
    waves: float


class ModeByOrders(TypedDict):
    # radial order; from 0 to 20
    n: int
    # azimuthal frequency, |m| <= n, n - |m| even; negative: sine; from -20 to 20
    m: int
    # coefficient in the normalisation given by norm, waves at the laser's wavelength; from -1000 to 1000
    waves: float


class CalibrationMode(TypedDict):
    # OSA/ANSI index
    j: int
    # of its push and pull, RMS-normalised waves: half or a quarter of what was asked for if the SLM cannot show that, or it lost spots
    amplitude_waves: float
    # RMS over the spots, x and y, of the column: camera pixels per RMS-normalised wave
    signal_px_per_wave: float
    # RMS of its standard errors
    standard_error_px_per_wave: float
    # regression: the measured column is so many times the model's (operator slopes); null: the model has none
    factor: float | None
    # of factor, from the noise
    factor_standard_error: float | None
    # of the measured column with the model's, -1 to 1
    correlation: float | None


class Dropped(TypedDict):
    # OSA/ANSI index
    j: int
    # why, for a person
    reason: str


class Camera(TypedDict):
    """The camera, null: it was not known."""

    # maker
    vendor: str
    # model
    model: str
    # serial number
    serial: str


class Settings(TypedDict):
    """Of the camera, null: they were not known."""

    # analogue gain, dB; null: the camera has none in dB
    gain_db: float | None
    # of a camera without gain in dB: in steps of its own
    gain_raw: NotRequired[float]
    # exposure time, microseconds
    exposure_us: float
    # GenICam name
    pixel_format: str


class Registration(TypedDict):
    """In force then; null: none was, and the map was the configuration's."""

    # UNIX epoch UTC, nanoseconds
    t_taken_ns: int
    # [x, y] of the base spot, pixels of the camera's sensor
    base_px: list[float]
    # [xx, xy, yx, yy]: camera pixels per cycle per SLM pixel
    px_per_cycle: list[float]


class Slm(TypedDict):
    """The spatial light modulator."""

    # pixels
    width: int
    # pixels
    height: int
    # distance of its pixels, micrometres
    pitch_um: float
    # of its 256 grey levels; null: none
    lut_sha256: str | None
    # of its float32 waves; null: none
    flatness_sha256: str | None


class CalibrationAberration(TypedDict):
    # OSA/ANSI index
    j: int
    # RMS-normalised
    waves: float


class Origin(TypedDict):
    """What it was measured with."""

    # version of the daemon
    program: str
    # the camera, null: it was not known
    camera: Camera | None
    # of the camera, null: they were not known
    settings: Settings | None
    # in force then; null: none was, and the map was the configuration's
    registration: Registration | None
    # as in camera.set
    roi: dict[str, Any]
    # as in the configuration
    sensor: dict[str, Any]
    # as in the configuration
    tracking: dict[str, Any]
    # as in the configuration
    optics: dict[str, Any]
    # the spatial light modulator
    slm: Slm
    # shown on purpose, RMS-normalised waves
    aberration: list[CalibrationAberration]
    # of the grey picture shown, row by row; null: of the model
    hologram_sha256: str | None


class CalibrationResult(TypedDict):
    # whether a calibration of this sensor, camera, region, tracker and registration is known; if not, all else is false or null
    calibrated: bool
    # whether modes are read with it: the operator is measured
    in_force: bool
    # UNIX epoch UTC, nanoseconds
    t_taken_ns: int | None
    # the same as text, ISO 8601
    t_taken: str | None
    # checksum of the file that keeps it over a restart; null: it is not kept, and status (store) says why
    sha256: str | None
    # asked for, of each push and pull, RMS-normalised waves
    amplitude_waves: float | None
    # how many were averaged for each picture
    frames: int | None
    # spots of the sensor
    subapertures: int | None
    # numbers of the spots that were lost in a picture: their rows of the matrix are 0, and modes are read without them
    lost_spots: list[int] | None
    # one for each column of the matrix
    modes: list[CalibrationMode] | None
    # modes that were asked for and are not read
    dropped: list[Dropped] | None
    # of the matrix, largest first, camera pixels per RMS-normalised wave
    singular_values_px_per_wave: list[float] | None
    # the largest over the smallest of them
    condition_number: float | None
    # RMS over the spots, x and y, of how far they moved from the beginning to the end without a push, camera pixels
    drift_px: float | None
    # what the standard errors alone make of drift_px
    drift_noise_px: float | None
    # in what the matrix is not the model's: sign (of all, of x, of y or of single modes), axes (x and y exchanged), scale, rotation, parity
    # (modes are turned over as by a camera that sees the lattice mirrored or from the other side), order (of the modes), single_modes
    # (other factors), unlike (nothing of these); none: they agree
    disagreement: Literal["none", "sign", "axes", "scale", "rotation", "parity", "order", "single_modes", "unlike", None]
    # the same for a person, and what to do; null: they agree
    disagreement_reason: str | None
    # what it was measured with; aberration: shown below the pushes, less the correction
    origin: Origin | None


class JobStarted(TypedDict):
    # number of the job; from 1 to 2147483647
    job: int


class Info(TypedDict):
    """Which camera it is."""

    # maker
    vendor: str
    # model
    model: str
    # serial number
    serial: str
    # network address or bus, empty if unknown
    address: str


class Roi(TypedDict):
    """Region of interest of the sensor."""

    # left edge, sensor pixels; from 0 to 65535
    x: int
    # top edge, sensor pixels; from 0 to 65535
    y: int
    # sensor pixels; from 1 to 65535
    width: int
    # sensor pixels; from 1 to 65535
    height: int


class CameraSettings(TypedDict):
    """The camera's settings."""

    # analogue gain, dB; null: the camera has none in dB; from -100 to 100
    gain_db: float | None
    # gain in steps of the camera's own, if it has no gain in dB; otherwise null
    gain_raw: float | None
    # exposure time, microseconds; from 0.1 to 60000000
    exposure_us: float
    # frames per second; from 0.001 to 100000
    frame_rate_hz: float
    # GenICam name; of a Bayer format the pixels that see the laser are measured
    pixel_format: Literal["Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10", "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12", "BayerRG10p", "BayerGR10p", "BayerGB10p", "BayerBG10p", "BayerRG12p", "BayerGR12p", "BayerGB12p", "BayerBG12p"]
    # region of interest of the sensor
    roi: Roi


class Range(TypedDict):
    """Frames per second."""

    # smallest
    min: float
    # largest
    max: float
    # step; 0: continuous
    increment: float


class CameraRoiWidth(TypedDict):
    """Sensor pixels."""

    # smallest
    min: int
    # largest
    max: int
    # step; 0: continuous
    increment: int


class Limits(TypedDict):
    """What the connected camera allows now."""

    # dB; null: the camera has no gain in dB
    gain_db: Range | None
    # gain in steps of the camera's own, if it has no gain in dB; otherwise null
    gain_raw: Range | None
    # microseconds
    exposure_us: Range
    # frames per second
    frame_rate_hz: Range
    # sensor pixels
    roi_width: CameraRoiWidth
    # sensor pixels
    roi_height: CameraRoiWidth
    # sensor pixels
    sensor_width: int
    # sensor pixels
    sensor_height: int
    # formats that both camera and daemon know
    pixel_formats: list[Literal["Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10", "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12", "BayerRG10p", "BayerGR10p", "BayerGB10p", "BayerBG10p", "BayerRG12p", "BayerGR12p", "BayerGB12p", "BayerBG12p"]]


class CameraGetResult(TypedDict):
    # answers now
    connected: bool
    # which camera it is
    info: Info | None
    # the camera's settings
    settings: CameraSettings
    # what the connected camera allows now
    limits: Limits | None


class CameraRoi(TypedDict):
    """Region of interest of the sensor."""

    # left edge, sensor pixels; from 0 to 65535
    x: NotRequired[int]
    # top edge, sensor pixels; from 0 to 65535
    y: NotRequired[int]
    # sensor pixels; from 1 to 65535
    width: NotRequired[int]
    # sensor pixels; from 1 to 65535
    height: NotRequired[int]


class Requested(TypedDict):
    """As it was asked for."""

    # analogue gain, dB
    gain_db: NotRequired[float | None]
    # gain in steps of the camera's own
    gain_raw: NotRequired[float | None]
    # exposure time, microseconds
    exposure_us: NotRequired[float]
    # frames per second
    frame_rate_hz: NotRequired[float]
    # GenICam name; of a Bayer format the pixels that see the laser are measured
    pixel_format: NotRequired[Literal["Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10", "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12", "BayerRG10p", "BayerGR10p", "BayerGB10p", "BayerBG10p", "BayerRG12p", "BayerGR12p", "BayerGB12p", "BayerBG12p"]]
    # region of interest of the sensor
    roi: NotRequired[Roi]


class CameraSetResult(TypedDict):
    # as it was asked for
    requested: Requested
    # the camera's settings
    applied: CameraSettings
    # what the connected camera allows now
    limits: Limits | None


class ConfigCamera(TypedDict):
    """The camera."""

    # which driver
    driver: str
    # GenICam id or address
    id: str
    # GenICam name; of a Bayer format the pixels that see the laser are measured
    pixel_format: Literal["Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10", "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12", "BayerRG10p", "BayerGR10p", "BayerGB10p", "BayerBG10p", "BayerRG12p", "BayerGR12p", "BayerGB12p", "BayerBG12p"]
    # exposure time, microseconds; from 0.1 to 60000000
    exposure_us: float
    # analogue gain, dB; from -100 to 100
    gain_db: float
    # gain in steps of the camera's own, for a camera without gain in dB, whose gain_db stays 0; null: as the camera has it; from
    # -1000000000 to 1000000000
    gain_raw: float | None
    # frames per second; from 0.001 to 100000
    frame_rate_hz: float
    # region of interest of the sensor
    roi: Roi
    # GigE Vision packet size, bytes; from 576 to 65000
    packet_size_bytes: int
    # longest time from the end of an exposure to the frame's arrival, milliseconds; from 0 to 10000
    transfer_ms: float


class ConfigSlm(TypedDict):
    """The spatial light modulator."""

    # which driver
    driver: str
    # name of the output, e.g. HDMI-1
    display: str
    # pixels; from 16 to 16384
    width: int
    # pixels; from 16 to 16384
    height: int
    # distance of pixels, micrometres; from 0.1 to 1000
    pitch_um: float
    # file of 256 grey levels; null: linear
    lut: str | None
    # file of the phase that flattens the SLM; null: none
    flatness: str | None
    # from present to settled, milliseconds; from 0 to 10000
    settle_ms: float
    # whether the only or primary display may be the SLM
    allow_primary: bool


class Optics(TypedDict):
    """Lens and camera."""

    # laser, nanometres; from 100 to 20000
    wavelength_nm: float
    # Fourier lens, millimetres; from 1 to 100000
    focal_length_mm: float
    # from the lens' focal plane to the camera; from 0.001 to 1000
    magnification: float
    # distance of pixels, micrometres; from 0.1 to 100
    camera_pitch_um: float
    # [x, y] of the base subaperture's spot in the image, camera pixels; null: the image's centre
    centre_px: list[float] | None
    # [xx, xy, yx, yy]: a slope of (u, v) cycles per SLM pixel moves a spot by (xx u + xy v, yx u + yy v) camera pixels; null: from the keys
    # above, without rotation
    px_per_cycle: list[float] | None


class Sensor(TypedDict):
    """The sensor shown."""

    # topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how the subapertures lie
    grid: Literal["hexagonal", "square"]
    # M, along the pupil's diameter; from 1 to 31
    subapertures_across: int
    # D, SLM pixels; from 8 to 16384
    pupil_diameter_px: float
    # n_x, n_y: grooves of the base grating over the SLM's width and height
    grooves: list[float]
    # s: how far the spots are spread on the camera, grooves per SLM pixel of a subaperture's position; from 0.001 to 16
    spacing: float


class Tracking(TypedDict):
    """How spots are found."""

    # how spots are found
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched"]
    # of the tracker matched: the model's spot, or each spot as the reference shows it
    template: Literal["model", "reference"]
    # from displacements to modes: slopes, the tracker's own tilt of each mode; diffractive, each mode through the diffraction model, exact
    # for aberrations up to about 0.1 wave, beyond that the slopes are better; relinearised: offline only, the daemon refuses it; measured:
    # each mode as the bench itself showed it to calibration.run
    operator: Literal["slopes", "diffractive", "relinearised", "measured"]
    # the LG kernel's 1/e radius in units of lambda/d on the camera; from 0.1 to 2
    kernel_radius: float


class Refine(TypedDict):
    """Every pixel against the diffraction model, beside the fast estimate."""

    # whether frames are refined
    enabled: bool
    # at most so many frames a second are refined; from 0.001 to 100
    rate_hz: float
    # electrons of one DN of the pixel format in use, at a gain of 0 dB; null: not known, and nothing can be refined; from 1e-06 to 1000000
    electrons_per_dn: float | None
    # electrons RMS of a pixel; the rounding to whole DN is added; from 0 to 1000000
    read_noise_e: float
    # DN of a pixel without light; from 0 to 65535
    black_level_dn: float
    # from here on a pixel is left out; null: the full scale of the pixel format; from 1 to 65535
    saturation_dn: float | None
    # whether each subaperture's amplitude is fitted, too: uneven light
    spot_amplitudes: bool


class Stream(TypedDict):
    """What is published."""

    # ZeroMQ endpoint
    endpoint: str
    # ZeroMQ endpoint
    image_endpoint: str
    # images and phase maps per second; 0: none; from 0 to 1000
    image_rate_hz: float


class Control(TypedDict):
    """Commands."""

    # ZeroMQ endpoint
    endpoint: str


class Security(TypedDict):
    """Who may connect; both files, or none."""

    # file of the daemon's keys; null: no client needs a key
    secret_key: str | None
    # file of those who may connect, and what each may
    clients: str | None


class State(TypedDict):
    """What is kept over a restart."""

    # folder; null: $STATE_DIRECTORY
    directory: str | None


class Record(TypedDict):
    """Recordings."""

    # folder; null: recordings in the state's folder
    directory: str | None
    # memory for pictures that wait for the disk, MiB; from 8 to 4096
    buffer_mib: int


class Pipeline(TypedDict):
    """The frame path."""

    # tracker threads; 0: the frame path runs in one thread; from 0 to 16
    workers: int
    # frames on their way at once, a power of two; from 8 to 4096
    records: int
    # processors that the threads of the frame path keep to; empty: any
    cpus: list[int]


class Log(TypedDict):
    """The log."""

    # least severe line that is written
    level: Literal["trace", "debug", "info", "warn", "error"]


class ConfigGetResult(TypedDict):
    # the camera
    camera: ConfigCamera
    # the spatial light modulator
    slm: ConfigSlm
    # lens and camera
    optics: Optics
    # the sensor shown
    sensor: Sensor
    # how spots are found
    tracking: Tracking
    # every pixel against the diffraction model, beside the fast estimate
    refine: Refine
    # what is published
    stream: Stream
    # commands
    control: Control
    # who may connect; both files, or none
    security: Security
    # what is kept over a restart
    state: State
    # recordings
    record: Record
    # what a missing real-time privilege is: an error or a warning
    realtime: Literal["enforce", "ignore"]
    # the frame path
    pipeline: Pipeline
    # the log
    log: Log


class ConfigSaveResult(TypedDict):
    # the overlay, a file in the state directory; with an empty saved it does not exist, because nothing differs
    path: str
    # dotted keys of the values that differ from the configuration file, sorted
    saved: list[str]


class Picture(TypedDict):
    """A frame of the cell, where one is kept."""

    # pixels
    width: int
    # pixels
    height: int
    # 8 bit grey, row by row; 255: the format's full scale
    base64: str


class ExperimentCellResult(TypedDict):
    # its number, from 0: arms change fastest, aberrations slowest; from 0 to 16383
    cell: int
    # place in the request's arms
    arm: int
    # topological charge, 0: the Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how spots are found: as in sensor.set, or cell_centroid, the centroid of all light in a fixed cell around the reference: the text-book
    # Shack-Hartmann sensor, and the paper's
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched", "cell_centroid"]
    # place in the request's aberrations
    aberration: int
    # dB, as read back
    gain_db: float
    # exposure time, microseconds
    exposure_us: float
    # frames a second
    frame_rate_hz: float
    # UNIX epoch UTC, nanoseconds
    t_begun_ns: int
    # settled frames, all of which count
    frames: int
    # mean over the frames of the residual variance, rad^2: 4 pi^2 times the sum of the squares of the measured less the introduced
    # coefficients, RMS-normalised waves, tilts included; null: no frame told its modes
    variance_rad2: float | None
    # of single frames, rad^2
    standard_deviation_rad2: float | None
    # of the mean, rad^2
    standard_error_rad2: float | None
    # the mean over frames without a saturated spot; null: none
    unsaturated_variance_rad2: float | None
    # frames with too few spots to tell the modes, which are not in the mean
    undetermined_frames: int
    # frames with a spot at the format's full scale
    saturated_frames: int
    # of all frames together
    lost_spots: int
    # median over spots and frames of a spot's bright part above its background, camera units
    level_dn: float | None
    # median RMS noise of a pixel about a spot, camera units
    noise_dn: float | None
    # the brightest pixel of any spot, camera units
    peak_dn: float | None
    # OSA/ANSI indices, the order of coefficients_waves
    modes_j: list[int]
    # of each frame; null: too few spots
    variances_rad2: list[float | None]
    # of each frame, minus the reference, RMS-normalised waves to a millionth; empty: too few spots
    coefficients_waves: list[list[float | None]]
    # the fraction of the spots that hold a saturated pixel, frame by frame
    saturated_fractions: list[float]
    # spots found in each frame
    tracked: list[int]
    # a frame of the cell, where one is kept
    picture: Picture | None


class Aberration(TypedDict):
    # by j, or by n and m
    modes: list[ModeByJ | ModeByOrders]
    # rms: RMS 1 over the pupil; unit: amplitude 1 at its edge; default "rms"
    norm: NotRequired[Literal["rms", "unit"]]


class Arm(TypedDict):
    # topological charge, 0: the Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how spots are found: as in sensor.set, or cell_centroid, the centroid of all light in a fixed cell around the reference: the text-book
    # Shack-Hartmann sensor, and the paper's
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched", "cell_centroid"]


class ExperimentGainSweepResult(TypedDict):
    # number of the job; its result is the run's name; from 1 to 2147483647
    job: int


class Request(TypedDict):
    """The params, complete; aberrations RMS-normalised, gains that were left out are not in it."""

    # dB, the cells' gains in their order
    gains_db: list[float]
    # settled frames of each cell; from 2 to 1000
    frames: int
    # dB, at which the references are taken; from -100 to 100
    reference_gain_db: float
    # settled frames of each reference; from 2 to 1000
    reference_frames: int
    # what is introduced, each as the params of aberration.set; left out: the paper's oblique astigmatism of 0.5, 1.5 and 2 waves, unit
    # amplitude
    aberrations: list[Aberration]
    # ways to measure; left out: charge 1 with lg and matched, charge 0 with cell_centroid and matched
    arms: list[Arm]
    # dB, at which a frame of each charge is kept, with the first aberration
    picture_gains_db: list[float]


class Bench(TypedDict):
    """What the numbers are of."""

    # version of the daemon
    program: str
    # vendor, model and serial number
    camera: Camera | None
    # of every cell, microseconds
    exposure_us: float
    # GenICam name
    pixel_format: str
    # as in camera.set
    roi: dict[str, Any]
    # as in sensor.get, without the charge
    sensor: dict[str, Any]
    # of the tracker lg, units of lambda/d
    kernel_radius: float
    # as in the configuration
    optics: dict[str, Any]
    # its geometry, and checksums of the LUT and the flatness in force
    slm: dict[str, Any]
    # of the registration in force; null: none
    registration_t_taken_ns: int | None
    # subtracted from every hologram
    correction: list[CalibrationAberration]


class Reference(TypedDict):
    # place in the request's arms
    arm: int
    # topological charge, 0: the Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how spots are found: as in sensor.set, or cell_centroid, the centroid of all light in a fixed cell around the reference: the text-book
    # Shack-Hartmann sensor, and the paper's
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched", "cell_centroid"]
    # dB, as read back
    gain_db: float
    # UNIX epoch UTC, nanoseconds
    t_begun_ns: int
    # averaged
    frames: int
    # frames with a spot at full scale
    saturated_frames: int
    # as of a cell
    level_dn: float | None
    # as of a cell
    noise_dn: float | None
    # as of a cell
    peak_dn: float | None
    # [x, y] of each spot, camera pixels of the region
    positions_px: list[list[float | None]]
    # [x, y] of each cell's centre; empty: not of cell_centroid
    cells_px: list[list[float | None]]


class Cell(TypedDict):
    # its number, from 0: arms change fastest, aberrations slowest; from 0 to 16383
    cell: int
    # place in the request's arms
    arm: int
    # topological charge, 0: the Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how spots are found: as in sensor.set, or cell_centroid, the centroid of all light in a fixed cell around the reference: the text-book
    # Shack-Hartmann sensor, and the paper's
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched", "cell_centroid"]
    # place in the request's aberrations
    aberration: int
    # dB, as read back
    gain_db: float
    # exposure time, microseconds
    exposure_us: float
    # frames a second
    frame_rate_hz: float
    # UNIX epoch UTC, nanoseconds
    t_begun_ns: int
    # settled frames, all of which count
    frames: int
    # mean over the frames of the residual variance, rad^2: 4 pi^2 times the sum of the squares of the measured less the introduced
    # coefficients, RMS-normalised waves, tilts included; null: no frame told its modes
    variance_rad2: float | None
    # of single frames, rad^2
    standard_deviation_rad2: float | None
    # of the mean, rad^2
    standard_error_rad2: float | None
    # the mean over frames without a saturated spot; null: none
    unsaturated_variance_rad2: float | None
    # frames with too few spots to tell the modes, which are not in the mean
    undetermined_frames: int
    # frames with a spot at the format's full scale
    saturated_frames: int
    # of all frames together
    lost_spots: int
    # median over spots and frames of a spot's bright part above its background, camera units
    level_dn: float | None
    # median RMS noise of a pixel about a spot, camera units
    noise_dn: float | None
    # the brightest pixel of any spot, camera units
    peak_dn: float | None


class ExperimentGetResult(TypedDict):
    # whether there is one
    known: bool
    # whether every cell was measured
    complete: bool
    # its name, 16 hexadecimal digits: the same for the same request on the same bench
    run: str | None
    # that measures it now
    job: int | None
    # UNIX epoch UTC, nanoseconds, when it was asked for first
    t_begun_ns: int | None
    # the same as text, ISO 8601
    t_begun: str | None
    # seconds, by the cells that its job has measured; null: none yet, or no job
    time_left_s: float | None
    # why cells would not survive a restart; null: they would
    not_kept_reason: str | None
    # the params, complete; aberrations RMS-normalised, gains that were left out are not in it
    request: Request | None
    # what the numbers are of
    bench: Bench | None
    # those taken so far, one an arm
    references: list[Reference] | None
    # of the request
    cells_total: int
    # of them measured
    cells_done: int
    # those measured so far, by their numbers
    cells: list[Cell] | None


class FlatnessMode(TypedDict):
    # OSA/ANSI index
    j: int
    # RMS-normalised
    waves: float
    # by what the modes leave of the places
    standard_error_waves: float


class FlatnessResult(TypedDict):
    # slm.flatness of the configuration, which is in force, too
    path: str | None
    # whether a measured flatness is in force; if not, all that follows is null
    measured: bool
    # UNIX epoch UTC, nanoseconds
    t_taken_ns: int | None
    # the same, ISO 8601
    t_taken: str | None
    # checksum of the file that keeps it; null if it is not kept
    sha256: str | None
    # averaged for each place of the spot's aperture
    frames: int | None
    # scans of the pupil until nothing changed
    iterations: int | None
    # of the circle over which the modes are normalised, SLM pixels
    pupil_diameter_px: float | None
    # the error that was found; the hologram shows the opposite
    modes: list[FlatnessMode] | None
    # root sum square of the modes, waves
    rms_waves: float | None
    # how far the last scan's modes are from those before, root sum square, waves
    residual_rms_waves: float | None
    # what it was measured with
    origin: Origin | None


class Error(TypedDict):
    """Why it failed; null unless failed."""

    # as of an error reply
    code: int
    # one sentence
    message: str
    # field, reason, limits
    data: dict[str, Any]


class JobResult(TypedDict):
    # number of the job; from 1 to 2147483647
    job: int
    # the method that started it
    kind: str
    # where it is
    state: Literal["running", "done", "failed", "cancelled"]
    # part done; from 0 to 1
    progress: float
    # what it found; null unless done
    result: dict[str, Any] | list[Any] | None
    # why it failed; null unless failed
    error: Error | None


class Gain(TypedDict):
    # OSA/ANSI index; from 1 to 230
    j: int
    # of this mode, in place of gain: the part of the residual that a step takes away; from 0 to 1
    gain: float


class LoopResult(TypedDict):
    # whether the loop is closed
    closed: bool
    # part of the residual that a step corrects; from 0.001 to 1
    gain: float
    # part of the correction that a step forgets; from 0 to 0.99
    leak: float
    # OSA indices that are corrected; null: all that are measured
    modes: list[int] | None
    # gains of single modes
    gains: list[Gain]
    # of each mode's correction, RMS-normalised waves; from 0.001 to 100
    limit_waves: float
    # seconds without a usable frame, at the limit, or with a growing residual after which the loop opens by itself; from 0.1 to 3600
    patience_s: float
    # since the loop was closed last
    steps: int
    # root sum square of the corrected modes before the last step, waves
    residual_rms_waves: float | None
    # root sum square of the correction, waves
    correction_rms_waves: float
    # why the loop is open; null: it is closed, or never was
    opened_because: str | None
    # when it was opened, ns since 1970; null like opened_because
    t_opened_ns: int | None
    # the same, ISO 8601, UTC
    t_opened: str | None


class LutResult(TypedDict):
    # where the table in force comes from
    source: Literal["linear", "file", "measured"]
    # slm.lut of the configuration
    path: str | None
    # the table in force: the k-th is shown for the phase 2 pi k/256
    grey_levels: list[int]
    # whether a measured table is in force; if not, all that follows is null
    measured: bool
    # UNIX epoch UTC, nanoseconds
    t_taken_ns: int | None
    # the same, ISO 8601
    t_taken: str | None
    # checksum of the file that keeps it; null if it is not kept
    sha256: str | None
    # averaged for each picture
    frames: int | None
    # grey levels that were measured, each twice; from 2 to 256
    levels: int | None
    # phase of each grey level, 0 at grey level 0, rising or falling throughout, radians; its sign is the one with which a blazed grating
    # brings its light to the camera
    phase_rad: list[float] | None
    # of each of them against grey level 0, radians
    standard_error_rad: list[float] | None
    # RMS error of one measured level, radians
    noise_rad: float | None
    # RMS of the measured levels about phase_rad, radians
    residual_rad: float | None
    # phase of grey level 255, radians, without its sign
    depth_rad: float | None
    # whether the phase falls with the grey level; the table then falls too
    falls: bool | None
    # whether every phase can be shown
    reaches_2pi: bool | None
    # how many of the table's 256 steps lie more than half a step beyond the depth; they are shown by grey level 255 or 0, whichever is
    # nearer; from 0 to 255
    steps_out_of_reach: int | None
    # what is lacking of 2 pi, and what is done then; null if it is reached
    reason: str | None
    # what it was measured with
    origin: Origin | None


class RecordResult(TypedDict):
    """The recording that is on, or the last one."""

    # off: nothing was recorded since the start; recording; ended: the last one has, and this is of it
    state: Literal["off", "recording", "ended"]
    # path on the daemon's machine; null: there was none
    file: str | None
    # since its begin, or as long as it was, seconds
    duration_s: float
    # in the file
    frames: int
    # published meanwhile and not in the file: the recorder was behind
    frames_dropped: int
    # in the file
    pictures: int
    # frames in the file that lack the picture they were to have: the disk could not follow
    pictures_dropped: int
    # size of the file
    bytes: int
    # why it ended; null: it has not
    reason: str | None


class Stale(TypedDict):
    # key of camera.set
    field: Literal["gain_db", "gain_raw", "exposure_us", "pixel_format"]
    # when it was taken
    then: float | str | None
    # in use
    now: float | str | None


class ReferenceOrigin(TypedDict):
    """What it was taken with."""

    # version of the daemon
    program: str
    # the camera, null: it was not known
    camera: Camera | None
    # of the camera, null: they were not known
    settings: Settings | None
    # in force then; null: none was, and the map was the configuration's
    registration: Registration | None
    # as in camera.set
    roi: dict[str, Any]
    # as in the configuration
    sensor: dict[str, Any]
    # as in the configuration
    tracking: dict[str, Any]
    # as in the configuration
    optics: dict[str, Any]
    # the spatial light modulator
    slm: Slm
    # shown on purpose, RMS-normalised waves
    aberration: list[CalibrationAberration]
    # the part of aberration that was introduced, and is no correction; left out: none
    introduced: NotRequired[list[CalibrationAberration]]
    # of the grey picture shown, row by row; null: of the model
    hologram_sha256: str | None


class ReferenceResult(TypedDict):
    # whether there is a reference
    taken: bool
    # measured: averaged from frames; model: where the configuration says that spots are, so that misalignment is in the coefficients
    source: Literal["measured", "model", None]
    # how many frames were averaged
    frames: int | None
    # charge that it was taken with; from -8 to 8
    charge: int | None
    # tracker that it was taken with
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched", None]
    # UNIX epoch UTC, nanoseconds
    t_taken_ns: int | None
    # the same as text, ISO 8601
    t_taken: str | None
    # [x, y] of each subaperture's spot, camera pixels of the region of interest
    positions_px: list[list[float | None]] | None
    # [x, y] standard error of each position, camera pixels; null: the spot was lost, its position is where it is expected, and it is not
    # used
    standard_error_px: list[list[float | None]] | None
    # checksum of the file that keeps it over a restart; null: it is not kept, and status (store) says why
    sha256: str | None
    # introduced aberration that it holds, so that coefficients do not, RMS-normalised waves; 0: none
    introduced_rms_waves: float | None
    # settings of the camera that are not those it was taken with; it is in force all the same
    stale: list[Stale]
    # what it was taken with
    origin: ReferenceOrigin | None


class RefineResult(TypedDict):
    """As it is now."""

    # whether frames are refined
    enabled: bool
    # at most so many frames a second are refined; from 0.001 to 100
    rate_hz: float
    # electrons of one DN of the pixel format in use, at a gain of 0 dB; null: not known, and nothing can be refined; from 1e-06 to 1000000
    electrons_per_dn: float | None
    # electrons RMS of a pixel; the rounding to whole DN is added; from 0 to 1000000
    read_noise_e: float
    # DN of a pixel without light; from 0 to 65535
    black_level_dn: float
    # from here on a pixel is left out; null: the full scale of the pixel format; from 1 to 65535
    saturation_dn: float | None
    # whether each subaperture's amplitude is fitted, too: uneven light
    spot_amplitudes: bool
    # the camera's, whose DN these are
    pixel_format: Literal["Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10", "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12", "BayerRG10p", "BayerGR10p", "BayerGB10p", "BayerBG10p", "BayerRG12p", "BayerGR12p", "BayerGB12p", "BayerBG12p"]


class RefineRequested(TypedDict):
    """As it was asked for."""

    # whether frames are refined
    enabled: NotRequired[bool]
    # at most so many frames a second are refined
    rate_hz: NotRequired[float]
    # electrons of one DN of the pixel format in use, at a gain of 0 dB; null: not known, and nothing can be refined
    electrons_per_dn: NotRequired[float | None]
    # electrons RMS of a pixel; the rounding to whole DN is added
    read_noise_e: NotRequired[float]
    # DN of a pixel without light
    black_level_dn: NotRequired[float]
    # from here on a pixel is left out; null: the full scale of the pixel format
    saturation_dn: NotRequired[float | None]
    # whether each subaperture's amplitude is fitted, too: uneven light
    spot_amplitudes: NotRequired[bool]


class RefineSetResult(TypedDict):
    # as it was asked for
    requested: RefineRequested
    # as it is now
    applied: RefineResult


class RegistrationResult(TypedDict):
    # whether a registration is in force; if not, all else is null
    registered: bool
    # UNIX epoch UTC, nanoseconds
    t_taken_ns: int | None
    # [x, y] of the base subaperture's spot, pixels of the camera's whole sensor
    base_px: list[float] | None
    # [x, y] standard error of base_px
    base_standard_error_px: list[float] | None
    # [xx, xy, yx, yy]: a slope of (u, v) cycles per SLM pixel moves a spot by (xx u + xy v, yx u + yy v) camera pixels
    px_per_cycle: list[float] | None
    # standard error of each, camera pixels per cycle per SLM pixel
    px_per_cycle_standard_error: list[float] | None
    # square root of the map's determinant
    scale_px_per_cycle: float | None
    # by how much the camera sees the SLM's +x turned towards its own +y, degrees
    rotation_deg: float | None
    # whether the camera sees the SLM mirrored
    mirrored: bool | None
    # RMS of what the map leaves of the places where the spot was found, camera pixels
    residual_px: float | None
    # slopes for which the spot was found
    sights: int | None


class SensorGetResult(TypedDict):
    # topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how the subapertures lie
    grid: Literal["hexagonal", "square"]
    # M, along the pupil's diameter; from 1 to 31
    subapertures_across: int
    # D, SLM pixels; from 8 to 16384
    pupil_diameter_px: float
    # n_x, n_y: grooves of the base grating over the SLM's width and height
    grooves: list[float]
    # s: how far the spots are spread on the camera, grooves per SLM pixel of a subaperture's position; from 0.001 to 16
    spacing: float
    # how spots are found
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched"]
    # of the tracker matched: the model's spot, or each spot as the reference shows it
    template: Literal["model", "reference"]
    # from displacements to modes: slopes, the tracker's own tilt of each mode; diffractive, each mode through the diffraction model, exact
    # for aberrations up to about 0.1 wave, beyond that the slopes are better; relinearised: offline only, the daemon refuses it; measured:
    # each mode as the bench itself showed it to calibration.run
    operator: Literal["slopes", "diffractive", "relinearised", "measured"]
    # spots that are found by a template of their own, from the reference, and not by the model's
    own_templates: int
    # why that is not every spot though template is reference, and the way out; null: it is, or was not asked for
    template_reason: str | None
    # what turns displacements into modes now
    operator_in_force: Literal["slopes", "diffractive", "measured"]
    # why that is not the operator asked for: it is being made, or why it cannot be; null: it is
    operator_reason: str | None
    # how many there are
    subapertures: int
    # OSA/ANSI indices that are reconstructed
    modes_j: list[int]
    # number of the hologram, as in every stream message; 0: none
    hologram_id: int


class SensorRequested(TypedDict):
    """As it was asked for."""

    # topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor
    charge: NotRequired[int]
    # how the subapertures lie
    grid: NotRequired[Literal["hexagonal", "square"]]
    # M, along the pupil's diameter
    subapertures_across: NotRequired[int]
    # D, SLM pixels
    pupil_diameter_px: NotRequired[float]
    # n_x, n_y: grooves of the base grating over the SLM's width and height
    grooves: NotRequired[list[float]]
    # s: how far the spots are spread on the camera, grooves per SLM pixel of a subaperture's position
    spacing: NotRequired[float]
    # how spots are found
    tracker: NotRequired[Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched"]]
    # of the tracker matched: the model's spot, or each spot as the reference shows it
    template: NotRequired[Literal["model", "reference"]]
    # from displacements to modes: slopes, the tracker's own tilt of each mode; diffractive, each mode through the diffraction model, exact
    # for aberrations up to about 0.1 wave, beyond that the slopes are better; relinearised: offline only, the daemon refuses it; measured:
    # each mode as the bench itself showed it to calibration.run
    operator: NotRequired[Literal["slopes", "diffractive", "relinearised", "measured"]]


class Applied(TypedDict):
    """As it is now."""

    # topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how the subapertures lie
    grid: Literal["hexagonal", "square"]
    # M, along the pupil's diameter; from 1 to 31
    subapertures_across: int
    # D, SLM pixels; from 8 to 16384
    pupil_diameter_px: float
    # n_x, n_y: grooves of the base grating over the SLM's width and height
    grooves: list[float]
    # s: how far the spots are spread on the camera, grooves per SLM pixel of a subaperture's position; from 0.001 to 16
    spacing: float
    # how spots are found
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched"]
    # of the tracker matched: the model's spot, or each spot as the reference shows it
    template: Literal["model", "reference"]
    # from displacements to modes: slopes, the tracker's own tilt of each mode; diffractive, each mode through the diffraction model, exact
    # for aberrations up to about 0.1 wave, beyond that the slopes are better; relinearised: offline only, the daemon refuses it; measured:
    # each mode as the bench itself showed it to calibration.run
    operator: Literal["slopes", "diffractive", "relinearised", "measured"]


class SensorSetResult(TypedDict):
    # as it was asked for
    requested: SensorRequested
    # as it is now
    applied: Applied
    # number of the hologram, as in every stream message; 0: none
    hologram_id: int


class SlmShowResult(TypedDict):
    # as set
    pattern: Literal["sensor", "grating", "flat", "identify"]
    # number of the hologram, as in every stream message; 0: none
    hologram_id: int


class SlmVerifyResult(TypedDict):
    # presented last
    hologram_id: int
    # CRC-32 (zlib's) of its grey levels, row by row; from 0 to 4294967295
    crc32: int
    # of the output's pixels (their blue); from 0 to 4294967295
    crc32_shown: int
    # whether every pixel is grey and of the level presented
    equal: bool
    # how many are not
    differing_pixels: int


class DescribeMethods(TypedDict):
    # short
    title: str
    # what it does
    description: str
    # JSON Schema
    params: dict[str, Any]
    # JSON Schema
    result: dict[str, Any]


class SystemDescribeResult(TypedDict):
    # of the daemon and its libraries
    versions: dict[str, str]
    # by name
    methods: dict[str, DescribeMethods]
    # of each method by name: the least role of a client that may call it, where clients need keys
    roles: dict[str, Literal["read", "control"]]
    # JSON Schema of each topic's JSON part
    streams: dict[str, dict[str, Any]]


class StatusCamera(TypedDict):
    """The camera."""

    # answers now
    connected: bool
    # frames are asked for
    streaming: bool
    # which camera it is
    info: Info | None
    # the camera's settings
    settings: CameraSettings
    # what is wrong and the way out; null: nothing
    fault: str | None


class StatusInfo(TypedDict):
    """Which display it is."""

    # name of the output, e.g. HDMI-1
    output: str
    # x11, wayland or KMSDRM
    driver: str
    # pixels
    width: int
    # pixels
    height: int
    # pictures per second
    refresh_hz: float


class StatusSlm(TypedDict):
    """The spatial light modulator."""

    # the display is there
    connected: bool
    # which display it is
    info: StatusInfo | None
    # what is shown
    pattern: Literal["sensor", "grating", "flat", "identify", "test"]
    # shown now; 0: none
    hologram_id: int
    # false while it changes
    settled: bool
    # what is wrong and the way out; null: nothing
    fault: str | None


class Invalid(TypedDict):
    """Why no frame is valid although settled frames come and there is a reference; null: frames are valid, or another field says why
    not."""

    # when the first frame of them came, UTC
    t_since_ns: int
    # what such a frame lacks
    reason: str
    # what the daemon does about it, and when
    action: str
    # of the whole image, since then
    searches: int
    # when the same image is searched again at the latest, UTC; an image that changes is searched at once; null: a search is running
    t_next_search_ns: int | None


class StatusSensor(TypedDict):
    """The sensor shown."""

    # topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor; from -8 to 8
    charge: int
    # how the subapertures lie
    grid: Literal["hexagonal", "square"]
    # M, along the pupil's diameter; from 1 to 31
    subapertures_across: int
    # D, SLM pixels; from 8 to 16384
    pupil_diameter_px: float
    # n_x, n_y: grooves of the base grating over the SLM's width and height
    grooves: list[float]
    # s: how far the spots are spread on the camera, grooves per SLM pixel of a subaperture's position; from 0.001 to 16
    spacing: float
    # how spots are found
    tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched"]
    # of the tracker matched: the model's spot, or each spot as the reference shows it
    template: Literal["model", "reference"]
    # from displacements to modes: slopes, the tracker's own tilt of each mode; diffractive, each mode through the diffraction model, exact
    # for aberrations up to about 0.1 wave, beyond that the slopes are better; relinearised: offline only, the daemon refuses it; measured:
    # each mode as the bench itself showed it to calibration.run
    operator: Literal["slopes", "diffractive", "relinearised", "measured"]
    # spots that are found by a template of their own, from the reference, and not by the model's
    own_templates: int
    # why that is not every spot though template is reference, and the way out; null: it is, or was not asked for
    template_reason: str | None
    # what turns displacements into modes now
    operator_in_force: Literal["slopes", "diffractive", "measured"]
    # why that is not the operator asked for: it is being made, or why it cannot be; null: it is
    operator_reason: str | None
    # how many there are
    subapertures: int
    # how many are reconstructed
    modes: int
    # whether there is a reference
    referenced: bool
    # stale: in force, and taken with another gain, exposure or pixel format; reference.get says which
    reference: Literal["none", "in_force", "stale"]
    # introduced aberration that the reference holds, so that coefficients do not, RMS-normalised waves; 0: none
    reference_introduced_rms_waves: float
    # why the camera's region cannot see the spots, or the tracker cannot tell them apart, with values that work; null: nothing is known to
    # be wrong
    layout_fault: str | None
    # numbers of the spots that the wavefront has torn, followed by the shapes that it gives them
    torn: list[int]
    # why no frame is valid although settled frames come and there is a reference; null: frames are valid, or another field says why not
    invalid: Invalid | None


class StatusRefine(TypedDict):
    """The refinement of frames beside the fast estimate."""

    # waiting: for a frame, or until the next is due
    state: Literal["off", "waiting", "refining"]
    # frames refined, since the start
    done: int
    # frames that could not be, since the start
    refused: int
    # of the last fit, milliseconds
    last_duration_ms: float | None
    # why nothing is refined now, or why the last frame could not be; null: nothing is in the way
    reason: str | None


class Store(TypedDict):
    """What is kept over a restart."""

    # where; null: nothing is kept
    directory: str | None
    # why something is not kept, and the way out; null: all is
    reason: str | None


class FailedJob(TypedDict):
    """The job that failed last since the start, of those after which none of the same kind was done; null: none."""

    # number of the job
    job: int
    # the method that started it
    kind: str
    # what was at fault; empty: nothing by name
    field: str
    # what was wrong and the way out
    reason: str
    # when, ns since 1970
    t_failed_ns: int
    # the same, ISO 8601, UTC
    t_failed: str


class Rates(TypedDict):
    """Since the last status."""

    # frames taken from the camera, per second
    grabbed_hz: float
    # frames published, per second
    published_hz: float
    # images published, per second
    images_hz: float


class SinceStart(TypedDict):
    """All since the start: for histograms that are added up over time."""

    # frames
    count: int
    # of all latencies, microseconds
    sum_us: float
    # rising, microseconds
    edges_us: list[float]
    # how many took less than each edge
    below: list[int]


class Latency(TypedDict):
    # frames
    count: int
    # median, microseconds
    p50_us: float
    # 99th percentile, microseconds
    p99_us: float
    # 99.9th percentile, microseconds
    p999_us: float
    # microseconds
    max_us: float
    # all since the start: for histograms that are added up over time
    since_start: SinceStart


class SystemStatusResult(TypedDict):
    # UNIX epoch UTC, nanoseconds
    t_ns: int
    # since the start, seconds
    uptime_s: float
    # what the daemon is doing: starting, waiting_for_camera, waiting_for_display, running, job_running, fault, stopping
    state: str
    # what is wrong and the way out; null: nothing
    fault: str | None
    # the camera
    camera: StatusCamera
    # the spatial light modulator
    slm: StatusSlm
    # the sensor shown
    sensor: StatusSensor
    # the refinement of frames beside the fast estimate
    refine: StatusRefine
    # the recording that is on, or the last one
    record: RecordResult
    # what is kept over a restart
    store: Store
    # whether the correction follows the measurement
    loop: Literal["open", "closed"]
    # the job that failed last since the start, of those after which none of the same kind was done; null: none
    failed_job: FailedJob | None
    # since the last status
    rates: Rates
    # every counter, since the start
    counters: dict[str, int]
    # by stage, since the last status: tracked, reconstructed and published from the frame's arrival; arrived from when it would have
    # arrived had nothing held it up, of a camera with device stamps
    latency: dict[str, Latency]
    # of the daemon and its libraries
    versions: dict[str, str]


class Methods:
    """What a client inherits: one Python method for each of the daemon's, carried out by `call`."""

    def call(self, method: str, params: Mapping[str, object] | None = None) -> Any:
        raise NotImplementedError

    def aberration_clear(self) -> AberrationResult:
        """`aberration.clear`. Takes the wavefront added on purpose away.

        Result: modes: the wavefront added on purpose, RMS-normalised; norm: normalisation of the coefficients given back; hologram_id:
                number of the hologram, as in every stream message; 0: none
        """
        result: AberrationResult = self.call("aberration.clear")
        return result

    def aberration_get(self) -> AberrationResult:
        """`aberration.get`. The wavefront added on purpose.

        Result: modes: the wavefront added on purpose, RMS-normalised; norm: normalisation of the coefficients given back; hologram_id:
                number of the hologram, as in every stream message; 0: none
        """
        result: AberrationResult = self.call("aberration.get")
        return result

    def aberration_set(
        self,
        modes: Sequence[ModeByJ | ModeByOrders],
        *,
        norm: Literal["rms", "unit"] | LeftOut = LEFT_OUT,
    ) -> AberrationResult:
        """`aberration.set`. Replaces the wavefront added on purpose. No mode may be given twice. The answer is in RMS normalisation
        whatever was given.

        modes: by j, or by n and m
        norm: rms: RMS 1 over the pupil; unit: amplitude 1 at its edge; default "rms"
        Result: modes: the wavefront added on purpose, RMS-normalised; norm: normalisation of the coefficients given back; hologram_id:
                number of the hologram, as in every stream message; 0: none
        """
        result: AberrationResult = self.call("aberration.set", _given(modes=modes, norm=norm))
        return result

    def calibration_clear(self) -> CalibrationResult:
        """`calibration.clear`. Forgets the calibration of the sensor as it is now, on the disk, too: its matrix is then the slopes'.

        Result: calibrated: whether a calibration of this sensor, camera, region, tracker and registration is known; if not, all else is
                false or null; in_force: whether modes are read with it: the operator is measured; t_taken_ns: UNIX epoch UTC, nanoseconds;
                t_taken: the same as text, ISO 8601; sha256: checksum of the file that keeps it over a restart; null: it is not kept, and
                status (store) says why; amplitude_waves: asked for, of each push and pull, RMS-normalised waves; frames: how many were
                averaged for each picture; subapertures: spots of the sensor; lost_spots: numbers of the spots that were lost in a picture:
                their rows of the matrix are 0, and modes are read without them; modes: one for each column of the matrix; dropped: modes
                that were asked for and are not read; singular_values_px_per_wave: of the matrix, largest first, camera pixels per
                RMS-normalised wave; condition_number: the largest over the smallest of them; drift_px: RMS over the spots, x and y, of how
                far they moved from the beginning to the end without a push, camera pixels; drift_noise_px: what the standard errors alone
                make of drift_px; disagreement: in what the matrix is not the model's: sign (of all, of x, of y or of single modes), axes (x
                and y exchanged), scale, rotation, parity (modes are turned over as by a camera that sees the lattice mirrored or from the
                other side), order (of the modes), single_modes (other factors), unlike (nothing of these); none: they agree;
                disagreement_reason: the same for a person, and what to do; null: they agree; origin: what it was measured with; aberration:
                shown below the pushes, less the correction
        """
        result: CalibrationResult = self.call("calibration.clear")
        return result

    def calibration_get(self) -> CalibrationResult:
        """`calibration.get`. The interaction matrix that was measured for the sensor as it is now, in figures, against the model's; or
        nulls.

        Result: calibrated: whether a calibration of this sensor, camera, region, tracker and registration is known; if not, all else is
                false or null; in_force: whether modes are read with it: the operator is measured; t_taken_ns: UNIX epoch UTC, nanoseconds;
                t_taken: the same as text, ISO 8601; sha256: checksum of the file that keeps it over a restart; null: it is not kept, and
                status (store) says why; amplitude_waves: asked for, of each push and pull, RMS-normalised waves; frames: how many were
                averaged for each picture; subapertures: spots of the sensor; lost_spots: numbers of the spots that were lost in a picture:
                their rows of the matrix are 0, and modes are read without them; modes: one for each column of the matrix; dropped: modes
                that were asked for and are not read; singular_values_px_per_wave: of the matrix, largest first, camera pixels per
                RMS-normalised wave; condition_number: the largest over the smallest of them; drift_px: RMS over the spots, x and y, of how
                far they moved from the beginning to the end without a push, camera pixels; drift_noise_px: what the standard errors alone
                make of drift_px; disagreement: in what the matrix is not the model's: sign (of all, of x, of y or of single modes), axes (x
                and y exchanged), scale, rotation, parity (modes are turned over as by a camera that sees the lattice mirrored or from the
                other side), order (of the modes), single_modes (other factors), unlike (nothing of these); none: they agree;
                disagreement_reason: the same for a person, and what to do; null: they agree; origin: what it was measured with; aberration:
                shown below the pushes, less the correction
        """
        result: CalibrationResult = self.call("calibration.get")
        return result

    def calibration_run(
        self,
        *,
        amplitude_waves: float | LeftOut = LEFT_OUT,
        frames: int | LeftOut = LEFT_OUT,
        modes: Sequence[int] | LeftOut = LEFT_OUT,
    ) -> JobStarted:
        """`calibration.run`. Measures how far each mode moves each spot: it is shown with both signs, on top of the aberration that is
        shown. Answers at once; the job's result is that of calibration.get, and modes are read with it from then on (operator measured).

        amplitude_waves: of each push and pull, RMS-normalised waves; from 0.005 to 0.2; default 0.15
        frames: how many settled frames to average for each picture; from 2 to 10000; default 20
        modes: OSA/ANSI indices of the modes to measure, which are then the only ones read; left out: every mode that the lattice tells
        Result: job: number of the job
        """
        result: JobStarted = self.call("calibration.run", _given(amplitude_waves=amplitude_waves, frames=frames, modes=modes))
        return result

    def camera_get(self) -> CameraGetResult:
        """`camera.get`. What is in use and what the camera allows.

        Result: connected: answers now; info: which camera it is; settings: the camera's settings; limits: what the connected camera allows
                now
        """
        result: CameraGetResult = self.call("camera.get")
        return result

    def camera_set(
        self,
        *,
        gain_db: float | None | LeftOut = LEFT_OUT,
        gain_raw: float | None | LeftOut = LEFT_OUT,
        exposure_us: float | LeftOut = LEFT_OUT,
        frame_rate_hz: float | LeftOut = LEFT_OUT,
        pixel_format: Literal["Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10", "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12", "BayerRG10p", "BayerGR10p", "BayerGB10p", "BayerBG10p", "BayerRG12p", "BayerGR12p", "BayerGB12p", "BayerBG12p"] | LeftOut = LEFT_OUT,
        roi: CameraRoi | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
    ) -> CameraSetResult:
        """`camera.set`. All or nothing; what is left out stays. The stream survives it. The camera may allow less than the ranges here: its
        limits are in the result and in the error.

        gain_db: analogue gain, dB; null leaves it; from -100 to 100
        gain_raw: gain in steps of the camera's own, for a camera without gain in dB; null leaves it; not together with gain_db; from
                  -1000000000 to 1000000000
        exposure_us: exposure time, microseconds; from 0.1 to 60000000
        frame_rate_hz: frames per second; from 0.001 to 100000
        pixel_format: GenICam name; of a Bayer format the pixels that see the laser are measured
        roi: region of interest of the sensor
        clamp: true: a number out of range becomes the nearest limit instead of being refused; the ranges stated here then do not bind;
               default false
        Result: requested: as it was asked for; applied: the camera's settings; limits: what the connected camera allows now
        """
        result: CameraSetResult = self.call("camera.set", _given(
            gain_db=gain_db, gain_raw=gain_raw, exposure_us=exposure_us, frame_rate_hz=frame_rate_hz, pixel_format=pixel_format, roi=roi,
            clamp=clamp
        ))
        return result

    def config_get(self) -> ConfigGetResult:
        """`config.get`. The effective configuration: the file's keys, every default, and what was set since.

        Result: camera: the camera; slm: the spatial light modulator; optics: lens and camera; sensor: the sensor shown; tracking: how spots
                are found; refine: every pixel against the diffraction model, beside the fast estimate; stream: what is published; control:
                commands; security: who may connect; both files, or none; state: what is kept over a restart; record: recordings; realtime:
                what a missing real-time privilege is: an error or a warning; pipeline: the frame path; log: the log
        """
        result: ConfigGetResult = self.call("config.get")
        return result

    def config_save(self) -> ConfigSaveResult:
        """`config.save`. Saves the settings in use that differ from the configuration file, atomically, to an overlay in the state
        directory. The daemon lays it over the file at its start and at every reload.

        Result: path: the overlay, a file in the state directory; with an empty saved it does not exist, because nothing differs; saved:
                dotted keys of the values that differ from the configuration file, sorted
        """
        result: ConfigSaveResult = self.call("config.save")
        return result

    def correction_clear(self) -> AberrationResult:
        """`correction.clear`. Nothing is subtracted any more. Not while the loop is closed.

        Result: modes: the wavefront added on purpose, RMS-normalised; norm: normalisation of the coefficients given back; hologram_id:
                number of the hologram, as in every stream message; 0: none
        """
        result: AberrationResult = self.call("correction.clear")
        return result

    def correction_get(self) -> AberrationResult:
        """`correction.get`. What is subtracted from the hologram, by the loop or by a person.

        Result: modes: the wavefront added on purpose, RMS-normalised; norm: normalisation of the coefficients given back; hologram_id:
                number of the hologram, as in every stream message; 0: none
        """
        result: AberrationResult = self.call("correction.get")
        return result

    def correction_set(
        self,
        modes: Sequence[ModeByJ | ModeByOrders],
        *,
        norm: Literal["rms", "unit"] | LeftOut = LEFT_OUT,
    ) -> AberrationResult:
        """`correction.set`. Subtracts these modes from the hologram, in place of the correction of before. Not while the loop is closed.

        modes: by j, or by n and m
        norm: rms: RMS 1 over the pupil; unit: amplitude 1 at its edge; default "rms"
        Result: modes: the wavefront added on purpose, RMS-normalised; norm: normalisation of the coefficients given back; hologram_id:
                number of the hologram, as in every stream message; 0: none
        """
        result: AberrationResult = self.call("correction.set", _given(modes=modes, norm=norm))
        return result

    def experiment_cell(self, cell: int) -> ExperimentCellResult:
        """`experiment.cell`. One measured cell of the gain sweep, frame by frame.

        cell: its number, from 0; from 0 to 16383
        Result: cell: its number, from 0: arms change fastest, aberrations slowest; arm: place in the request's arms; charge: topological
                charge, 0: the Shack-Hartmann sensor; tracker: how spots are found: as in sensor.set, or cell_centroid, the centroid of all
                light in a fixed cell around the reference: the text-book Shack-Hartmann sensor, and the paper's; aberration: place in the
                request's aberrations; gain_db: dB, as read back; exposure_us: exposure time, microseconds; frame_rate_hz: frames a second;
                t_begun_ns: UNIX epoch UTC, nanoseconds; frames: settled frames, all of which count; variance_rad2: mean over the frames of
                the residual variance, rad^2: 4 pi^2 times the sum of the squares of the measured less the introduced coefficients,
                RMS-normalised waves, tilts included; null: no frame told its modes; standard_deviation_rad2: of single frames, rad^2;
                standard_error_rad2: of the mean, rad^2; unsaturated_variance_rad2: the mean over frames without a saturated spot; null:
                none; undetermined_frames: frames with too few spots to tell the modes, which are not in the mean; saturated_frames: frames
                with a spot at the format's full scale; lost_spots: of all frames together; level_dn: median over spots and frames of a
                spot's bright part above its background, camera units; noise_dn: median RMS noise of a pixel about a spot, camera units;
                peak_dn: the brightest pixel of any spot, camera units; modes_j: OSA/ANSI indices, the order of coefficients_waves;
                variances_rad2: of each frame; null: too few spots; coefficients_waves: of each frame, minus the reference, RMS-normalised
                waves to a millionth; empty: too few spots; saturated_fractions: the fraction of the spots that hold a saturated pixel,
                frame by frame; tracked: spots found in each frame; picture: a frame of the cell, where one is kept
        """
        result: ExperimentCellResult = self.call("experiment.cell", _given(cell=cell))
        return result

    def experiment_gain_sweep(
        self,
        *,
        gains_db: Sequence[float] | LeftOut = LEFT_OUT,
        frames: int | LeftOut = LEFT_OUT,
        reference_gain_db: float | LeftOut = LEFT_OUT,
        reference_frames: int | LeftOut = LEFT_OUT,
        aberrations: Sequence[Aberration] | LeftOut = LEFT_OUT,
        arms: Sequence[Arm] | LeftOut = LEFT_OUT,
        picture_gains_db: Sequence[float] | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
        anew: bool | LeftOut = LEFT_OUT,
    ) -> ExperimentGainSweepResult:
        """`experiment.gain_sweep`. The paper's comparison: the residual variance of each arm against the camera's gain, at the exposure
        that is set, with aberrations shown on purpose. First a reference of each arm without an aberration, then cell by cell, a cell being
        one arm with one aberration at one gain. Answers at once; experiment.get and experiment.cell tell what was measured so far. The same
        params on the same bench go on with the cells that are missing, also after a cancel or a restart, if the spots of the run's first
        reference stand within lambda/(20 d) of where they stood; else the job is refused and the cells stay. Who asks for the run that is
        being measured is given its job. Gain, sensor and aberration are put back at the end, the user's reference is not touched.

        gains_db: dB, the cells' gains in their order; default [10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38, 40]
        frames: settled frames of each cell; from 2 to 1000; default 100
        reference_gain_db: dB, at which the references are taken; from -100 to 100; default 16.0
        reference_frames: settled frames of each reference; from 2 to 1000; default 100
        aberrations: what is introduced, each as the params of aberration.set; left out: the paper's oblique astigmatism of 0.5, 1.5 and 2
                     waves, unit amplitude
        arms: ways to measure; left out: charge 1 with lg and matched, charge 0 with cell_centroid and matched
        picture_gains_db: dB, at which a frame of each charge is kept, with the first aberration; default [10, 20, 30]
        clamp: gains that the camera has not are left out instead of refused; default false
        anew: what was measured of this run before is let go, and measured again; default false
        Result: job: number of the job; its result is the run's name
        """
        result: ExperimentGainSweepResult = self.call("experiment.gain_sweep", _given(
            gains_db=gains_db, frames=frames, reference_gain_db=reference_gain_db, reference_frames=reference_frames,
            aberrations=aberrations, arms=arms, picture_gains_db=picture_gains_db, clamp=clamp, anew=anew
        ))
        return result

    def experiment_get(self) -> ExperimentGetResult:
        """`experiment.get`. The gain sweep that was asked for last, and what was measured of it so far; or nulls.

        Result: known: whether there is one; complete: whether every cell was measured; run: its name, 16 hexadecimal digits: the same for
                the same request on the same bench; job: that measures it now; t_begun_ns: UNIX epoch UTC, nanoseconds, when it was asked
                for first; t_begun: the same as text, ISO 8601; time_left_s: seconds, by the cells that its job has measured; null: none
                yet, or no job; not_kept_reason: why cells would not survive a restart; null: they would; request: the params, complete;
                aberrations RMS-normalised, gains that were left out are not in it; bench: what the numbers are of; references: those taken
                so far, one an arm; cells_total: of the request; cells_done: of them measured; cells: those measured so far, by their
                numbers
        """
        result: ExperimentGetResult = self.call("experiment.get")
        return result

    def flatness_clear(self) -> FlatnessResult:
        """`flatness.clear`. From now on the flatness is that of the configuration's file alone, or none. The measured one is gone from the
        disk, too.

        Result: path: slm.flatness of the configuration, which is in force, too; measured: whether a measured flatness is in force; if not,
                all that follows is null; t_taken_ns: UNIX epoch UTC, nanoseconds; t_taken: the same, ISO 8601; sha256: checksum of the file
                that keeps it; null if it is not kept; frames: averaged for each place of the spot's aperture; iterations: scans of the
                pupil until nothing changed; pupil_diameter_px: of the circle over which the modes are normalised, SLM pixels; modes: the
                error that was found; the hologram shows the opposite; rms_waves: root sum square of the modes, waves; residual_rms_waves:
                how far the last scan's modes are from those before, root sum square, waves; origin: what it was measured with
        """
        result: FlatnessResult = self.call("flatness.clear")
        return result

    def flatness_get(self) -> FlatnessResult:
        """`flatness.get`. What was measured of the SLM's flatness, as modes.

        Result: path: slm.flatness of the configuration, which is in force, too; measured: whether a measured flatness is in force; if not,
                all that follows is null; t_taken_ns: UNIX epoch UTC, nanoseconds; t_taken: the same, ISO 8601; sha256: checksum of the file
                that keeps it; null if it is not kept; frames: averaged for each place of the spot's aperture; iterations: scans of the
                pupil until nothing changed; pupil_diameter_px: of the circle over which the modes are normalised, SLM pixels; modes: the
                error that was found; the hologram shows the opposite; rms_waves: root sum square of the modes, waves; residual_rms_waves:
                how far the last scan's modes are from those before, root sum square, waves; origin: what it was measured with
        """
        result: FlatnessResult = self.call("flatness.get")
        return result

    def flatness_run(self, *, frames: int | LeftOut = LEFT_OUT) -> JobStarted:
        """`flatness.run`. Reads the modes of the SLM's flatness, and of the optics between SLM and camera, from a lone spot whose aperture
        is moved all over the pupil; shows their opposite, and scans again until nothing changes. Needs a registration. Answers at once; the
        job's result is that of flatness.get, and in force from then on.

        frames: how many settled frames to average for each place of the spot's aperture; from 1 to 100; default 5
        Result: job: number of the job
        """
        result: JobStarted = self.call("flatness.run", _given(frames=frames))
        return result

    def job_cancel(self, job: int) -> JobResult:
        """`job.cancel`. Ends a job that runs; one that has ended stays as it is.

        job: number of the job; from 1 to 2147483647
        Result: job: number of the job; kind: the method that started it; state: where it is; progress: part done; result: what it found;
                null unless done; error: why it failed; null unless failed
        """
        result: JobResult = self.call("job.cancel", _given(job=job))
        return result

    def job_get(self, job: int) -> JobResult:
        """`job.get`. How far a job is.

        job: number of the job; from 1 to 2147483647
        Result: job: number of the job; kind: the method that started it; state: where it is; progress: part done; result: what it found;
                null unless done; error: why it failed; null unless failed
        """
        result: JobResult = self.call("job.get", _given(job=job))
        return result

    def loop_close(
        self,
        *,
        gain: float | LeftOut = LEFT_OUT,
        leak: float | LeftOut = LEFT_OUT,
        modes: Sequence[int] | LeftOut = LEFT_OUT,
        gains: Sequence[Gain] | LeftOut = LEFT_OUT,
        limit_waves: float | LeftOut = LEFT_OUT,
        patience_s: float | LeftOut = LEFT_OUT,
    ) -> LoopResult:
        """`loop.close`. From now on what is measured is subtracted from the hologram, a step a settled and valid frame, beginning from the
        correction that is shown. Needs a reference. The loop opens by itself, with an event, when it cannot go on.

        gain: part of the residual that a step corrects; from 0.001 to 1; default 0.5
        leak: part of the correction that a step forgets; from 0 to 0.99; default 0.0
        modes: OSA indices to correct; left out: all that are measured
        gains: gains of single modes
        limit_waves: of each mode's correction, RMS-normalised waves; from 0.001 to 100; default 5.0
        patience_s: seconds without a usable frame, at the limit, or with a growing residual after which the loop opens by itself; from 0.1
                    to 3600; default 2.0
        Result: closed: whether the loop is closed; gain: part of the residual that a step corrects; leak: part of the correction that a
                step forgets; modes: OSA indices that are corrected; null: all that are measured; gains: gains of single modes; limit_waves:
                of each mode's correction, RMS-normalised waves; patience_s: seconds without a usable frame, at the limit, or with a growing
                residual after which the loop opens by itself; steps: since the loop was closed last; residual_rms_waves: root sum square of
                the corrected modes before the last step, waves; correction_rms_waves: root sum square of the correction, waves;
                opened_because: why the loop is open; null: it is closed, or never was; t_opened_ns: when it was opened, ns since 1970; null
                like opened_because; t_opened: the same, ISO 8601, UTC
        """
        result: LoopResult = self.call("loop.close", _given(
            gain=gain, leak=leak, modes=modes, gains=gains, limit_waves=limit_waves, patience_s=patience_s
        ))
        return result

    def loop_get(self) -> LoopResult:
        """`loop.get`. How the loop does.

        Result: closed: whether the loop is closed; gain: part of the residual that a step corrects; leak: part of the correction that a
                step forgets; modes: OSA indices that are corrected; null: all that are measured; gains: gains of single modes; limit_waves:
                of each mode's correction, RMS-normalised waves; patience_s: seconds without a usable frame, at the limit, or with a growing
                residual after which the loop opens by itself; steps: since the loop was closed last; residual_rms_waves: root sum square of
                the corrected modes before the last step, waves; correction_rms_waves: root sum square of the correction, waves;
                opened_because: why the loop is open; null: it is closed, or never was; t_opened_ns: when it was opened, ns since 1970; null
                like opened_because; t_opened: the same, ISO 8601, UTC
        """
        result: LoopResult = self.call("loop.get")
        return result

    def loop_open(self, *, keep: bool | LeftOut = LEFT_OUT) -> LoopResult:
        """`loop.open`. The correction stays as it is, or is cleared.

        keep: whether the correction stays; default true
        Result: closed: whether the loop is closed; gain: part of the residual that a step corrects; leak: part of the correction that a
                step forgets; modes: OSA indices that are corrected; null: all that are measured; gains: gains of single modes; limit_waves:
                of each mode's correction, RMS-normalised waves; patience_s: seconds without a usable frame, at the limit, or with a growing
                residual after which the loop opens by itself; steps: since the loop was closed last; residual_rms_waves: root sum square of
                the corrected modes before the last step, waves; correction_rms_waves: root sum square of the correction, waves;
                opened_because: why the loop is open; null: it is closed, or never was; t_opened_ns: when it was opened, ns since 1970; null
                like opened_because; t_opened: the same, ISO 8601, UTC
        """
        result: LoopResult = self.call("loop.open", _given(keep=keep))
        return result

    def lut_clear(self) -> LutResult:
        """`lut.clear`. From now on the look-up table is that of the configuration: its file's, or the linear one. The measured one is gone
        from the disk, too.

        Result: source: where the table in force comes from; path: slm.lut of the configuration; grey_levels: the table in force: the k-th
                is shown for the phase 2 pi k/256; measured: whether a measured table is in force; if not, all that follows is null;
                t_taken_ns: UNIX epoch UTC, nanoseconds; t_taken: the same, ISO 8601; sha256: checksum of the file that keeps it; null if it
                is not kept; frames: averaged for each picture; levels: grey levels that were measured, each twice; phase_rad: phase of each
                grey level, 0 at grey level 0, rising or falling throughout, radians; its sign is the one with which a blazed grating brings
                its light to the camera; standard_error_rad: of each of them against grey level 0, radians; noise_rad: RMS error of one
                measured level, radians; residual_rad: RMS of the measured levels about phase_rad, radians; depth_rad: phase of grey level
                255, radians, without its sign; falls: whether the phase falls with the grey level; the table then falls too; reaches_2pi:
                whether every phase can be shown; steps_out_of_reach: how many of the table's 256 steps lie more than half a step beyond the
                depth; they are shown by grey level 255 or 0, whichever is nearer; reason: what is lacking of 2 pi, and what is done then;
                null if it is reached; origin: what it was measured with
        """
        result: LutResult = self.call("lut.clear")
        return result

    def lut_get(self) -> LutResult:
        """`lut.get`. The look-up table in force, where it comes from, and, if it was measured, the SLM's phase against its grey level.

        Result: source: where the table in force comes from; path: slm.lut of the configuration; grey_levels: the table in force: the k-th
                is shown for the phase 2 pi k/256; measured: whether a measured table is in force; if not, all that follows is null;
                t_taken_ns: UNIX epoch UTC, nanoseconds; t_taken: the same, ISO 8601; sha256: checksum of the file that keeps it; null if it
                is not kept; frames: averaged for each picture; levels: grey levels that were measured, each twice; phase_rad: phase of each
                grey level, 0 at grey level 0, rising or falling throughout, radians; its sign is the one with which a blazed grating brings
                its light to the camera; standard_error_rad: of each of them against grey level 0, radians; noise_rad: RMS error of one
                measured level, radians; residual_rad: RMS of the measured levels about phase_rad, radians; depth_rad: phase of grey level
                255, radians, without its sign; falls: whether the phase falls with the grey level; the table then falls too; reaches_2pi:
                whether every phase can be shown; steps_out_of_reach: how many of the table's 256 steps lie more than half a step beyond the
                depth; they are shown by grey level 255 or 0, whichever is nearer; reason: what is lacking of 2 pi, and what is done then;
                null if it is reached; origin: what it was measured with
        """
        result: LutResult = self.call("lut.get")
        return result

    def lut_run(self, *, levels: int | LeftOut = LEFT_OUT, frames: int | LeftOut = LEFT_OUT) -> JobStarted:
        """`lut.run`. Measures the phase of the SLM's grey levels: two patches of the pupil with binary gratings beat with each other on the
        camera, one of them with each grey level in turn. Answers at once; the job's result is that of lut.get, and in force from then on.

        levels: how many grey levels, from 0 to 255, are measured, each twice; more are added where the phase changes by more than a
                twenty-fourth of a turn from one to the next; from 9 to 256; default 33
        frames: how many frames to average for each picture; from 1 to 100; default 3
        Result: job: number of the job
        """
        result: JobStarted = self.call("lut.run", _given(levels=levels, frames=frames))
        return result

    def record_get(self) -> RecordResult:
        """`record.get`. What is being recorded, or was last.

        Result: state: off: nothing was recorded since the start; recording; ended: the last one has, and this is of it; file: path on the
                daemon's machine; null: there was none; duration_s: since its begin, or as long as it was, seconds; frames: in the file;
                frames_dropped: published meanwhile and not in the file: the recorder was behind; pictures: in the file; pictures_dropped:
                frames in the file that lack the picture they were to have: the disk could not follow; bytes: size of the file; reason: why
                it ended; null: it has not
        """
        result: RecordResult = self.call("record.get")
        return result

    def record_start(
        self,
        name: str,
        *,
        pictures_every: int | LeftOut = LEFT_OUT,
        limit_s: float | None | LeftOut = LEFT_OUT,
        limit_mib: float | None | LeftOut = LEFT_OUT,
    ) -> RecordResult:
        """`record.start`. Writes every frame from now on into a file: what was measured of it, its stamps, all that was in force, and its
        picture.

        name: of the file, which gets the ending .h5; no file may have it yet
        pictures_every: the camera's picture of every n-th frame; 0: none; from 0 to 1000000; default 1
        limit_s: the recording ends by itself after so many seconds; null: it does not; from 0.1 to 10000000; default null
        limit_mib: it ends when the file has become so many MiB large; null: it does not; from 1 to 1000000000; default null
        Result: state: off: nothing was recorded since the start; recording; ended: the last one has, and this is of it; file: path on the
                daemon's machine; null: there was none; duration_s: since its begin, or as long as it was, seconds; frames: in the file;
                frames_dropped: published meanwhile and not in the file: the recorder was behind; pictures: in the file; pictures_dropped:
                frames in the file that lack the picture they were to have: the disk could not follow; bytes: size of the file; reason: why
                it ended; null: it has not
        """
        result: RecordResult = self.call("record.start", _given(
            name=name, pictures_every=pictures_every, limit_s=limit_s, limit_mib=limit_mib
        ))
        return result

    def record_stop(self) -> RecordResult:
        """`record.stop`. Ends the recording; the file is whole when this answers.

        Result: state: off: nothing was recorded since the start; recording; ended: the last one has, and this is of it; file: path on the
                daemon's machine; null: there was none; duration_s: since its begin, or as long as it was, seconds; frames: in the file;
                frames_dropped: published meanwhile and not in the file: the recorder was behind; pictures: in the file; pictures_dropped:
                frames in the file that lack the picture they were to have: the disk could not follow; bytes: size of the file; reason: why
                it ended; null: it has not
        """
        result: RecordResult = self.call("record.stop")
        return result

    def reference_clear(self) -> ReferenceResult:
        """`reference.clear`. Forgets the reference; the stream is not valid until a new one is taken. It is forgotten on the disk, too; if
        that fails, nothing changes.

        Result: taken: whether there is a reference; source: measured: averaged from frames; model: where the configuration says that spots
                are, so that misalignment is in the coefficients; frames: how many frames were averaged; charge: charge that it was taken
                with; tracker: tracker that it was taken with; t_taken_ns: UNIX epoch UTC, nanoseconds; t_taken: the same as text, ISO 8601;
                positions_px: [x, y] of each subaperture's spot, camera pixels of the region of interest; standard_error_px: [x, y] standard
                error of each position, camera pixels; null: the spot was lost, its position is where it is expected, and it is not used;
                sha256: checksum of the file that keeps it over a restart; null: it is not kept, and status (store) says why;
                introduced_rms_waves: introduced aberration that it holds, so that coefficients do not, RMS-normalised waves; 0: none;
                stale: settings of the camera that are not those it was taken with; it is in force all the same; origin: what it was taken
                with
        """
        result: ReferenceResult = self.call("reference.clear")
        return result

    def reference_get(self) -> ReferenceResult:
        """`reference.get`. The reference in use, or nulls.

        Result: taken: whether there is a reference; source: measured: averaged from frames; model: where the configuration says that spots
                are, so that misalignment is in the coefficients; frames: how many frames were averaged; charge: charge that it was taken
                with; tracker: tracker that it was taken with; t_taken_ns: UNIX epoch UTC, nanoseconds; t_taken: the same as text, ISO 8601;
                positions_px: [x, y] of each subaperture's spot, camera pixels of the region of interest; standard_error_px: [x, y] standard
                error of each position, camera pixels; null: the spot was lost, its position is where it is expected, and it is not used;
                sha256: checksum of the file that keeps it over a restart; null: it is not kept, and status (store) says why;
                introduced_rms_waves: introduced aberration that it holds, so that coefficients do not, RMS-normalised waves; 0: none;
                stale: settings of the camera that are not those it was taken with; it is in force all the same; origin: what it was taken
                with
        """
        result: ReferenceResult = self.call("reference.get")
        return result

    def reference_set(self, source: Literal["model"]) -> ReferenceResult:
        """`reference.set`. Positions count from where the configuration, or the registration in force, says that spots are, instead of from
        a reference that was taken: the coefficients then hold what the bench itself adds, its misalignment included. It takes the place of
        the reference in force, until the next reference.take or reference.clear.

        source: what positions count from
        Result: taken: whether there is a reference; source: measured: averaged from frames; model: where the configuration says that spots
                are, so that misalignment is in the coefficients; frames: how many frames were averaged; charge: charge that it was taken
                with; tracker: tracker that it was taken with; t_taken_ns: UNIX epoch UTC, nanoseconds; t_taken: the same as text, ISO 8601;
                positions_px: [x, y] of each subaperture's spot, camera pixels of the region of interest; standard_error_px: [x, y] standard
                error of each position, camera pixels; null: the spot was lost, its position is where it is expected, and it is not used;
                sha256: checksum of the file that keeps it over a restart; null: it is not kept, and status (store) says why;
                introduced_rms_waves: introduced aberration that it holds, so that coefficients do not, RMS-normalised waves; 0: none;
                stale: settings of the camera that are not those it was taken with; it is in force all the same; origin: what it was taken
                with
        """
        result: ReferenceResult = self.call("reference.set", _given(source=source))
        return result

    def reference_take(self, *, frames: int | LeftOut = LEFT_OUT, allow_aberration: bool | LeftOut = LEFT_OUT) -> JobStarted:
        """`reference.take`. Averages the spots of the next frames as what displacements count from; refused if more than a tenth of the
        spots are saturated, if the spots move meanwhile, or if an aberration is introduced. Answers at once; the job tells how it ends.

        frames: how many frames to average; from 1 to 100000; default 100
        allow_aberration: take it under an introduced aberration, too, which coefficients then do not hold; default false
        Result: job: number of the job
        """
        result: JobStarted = self.call("reference.take", _given(frames=frames, allow_aberration=allow_aberration))
        return result

    def refine_get(self) -> RefineResult:
        """`refine.get`. Whether frames are refined, how often, and how the camera makes numbers of electrons.

        Result: enabled: whether frames are refined; rate_hz: at most so many frames a second are refined; electrons_per_dn: electrons of
                one DN of the pixel format in use, at a gain of 0 dB; null: not known, and nothing can be refined; read_noise_e: electrons
                RMS of a pixel; the rounding to whole DN is added; black_level_dn: DN of a pixel without light; saturation_dn: from here on
                a pixel is left out; null: the full scale of the pixel format; spot_amplitudes: whether each subaperture's amplitude is
                fitted, too: uneven light; pixel_format: the camera's, whose DN these are
        """
        result: RefineResult = self.call("refine.get")
        return result

    def refine_set(
        self,
        *,
        enabled: bool | LeftOut = LEFT_OUT,
        rate_hz: float | LeftOut = LEFT_OUT,
        electrons_per_dn: float | None | LeftOut = LEFT_OUT,
        read_noise_e: float | LeftOut = LEFT_OUT,
        black_level_dn: float | LeftOut = LEFT_OUT,
        saturation_dn: float | None | LeftOut = LEFT_OUT,
        spot_amplitudes: bool | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
    ) -> RefineSetResult:
        """`refine.set`. All or nothing; what is left out stays. What is being refined with other numbers is not published. DN are those of
        the camera's pixel format, and are converted when it changes.

        enabled: whether frames are refined
        rate_hz: at most so many frames a second are refined; from 0.001 to 100
        electrons_per_dn: electrons of one DN of the pixel format in use, at a gain of 0 dB; null: not known, and nothing can be refined;
                          from 1e-06 to 1000000
        read_noise_e: electrons RMS of a pixel; the rounding to whole DN is added; from 0 to 1000000
        black_level_dn: DN of a pixel without light; from 0 to 65535
        saturation_dn: from here on a pixel is left out; null: the full scale of the pixel format; from 1 to 65535
        spot_amplitudes: whether each subaperture's amplitude is fitted, too: uneven light
        clamp: true: a number out of range becomes the nearest limit instead of being refused; the ranges stated here then do not bind;
               default false
        Result: requested: as it was asked for; applied: as it is now
        """
        result: RefineSetResult = self.call("refine.set", _given(
            enabled=enabled, rate_hz=rate_hz, electrons_per_dn=electrons_per_dn, read_noise_e=read_noise_e, black_level_dn=black_level_dn,
            saturation_dn=saturation_dn, spot_amplitudes=spot_amplitudes, clamp=clamp
        ))
        return result

    def registration_clear(self) -> RegistrationResult:
        """`registration.clear`. From now on the configuration says where the camera sees which slope.

        Result: registered: whether a registration is in force; if not, all else is null; t_taken_ns: UNIX epoch UTC, nanoseconds; base_px:
                [x, y] of the base subaperture's spot, pixels of the camera's whole sensor; base_standard_error_px: [x, y] standard error of
                base_px; px_per_cycle: [xx, xy, yx, yy]: a slope of (u, v) cycles per SLM pixel moves a spot by (xx u + xy v, yx u + yy v)
                camera pixels; px_per_cycle_standard_error: standard error of each, camera pixels per cycle per SLM pixel;
                scale_px_per_cycle: square root of the map's determinant; rotation_deg: by how much the camera sees the SLM's +x turned
                towards its own +y, degrees; mirrored: whether the camera sees the SLM mirrored; residual_px: RMS of what the map leaves of
                the places where the spot was found, camera pixels; sights: slopes for which the spot was found
        """
        result: RegistrationResult = self.call("registration.clear")
        return result

    def registration_get(self) -> RegistrationResult:
        """`registration.get`. Where the camera sees which slope, as measured; or nulls: then the configuration says it.

        Result: registered: whether a registration is in force; if not, all else is null; t_taken_ns: UNIX epoch UTC, nanoseconds; base_px:
                [x, y] of the base subaperture's spot, pixels of the camera's whole sensor; base_standard_error_px: [x, y] standard error of
                base_px; px_per_cycle: [xx, xy, yx, yy]: a slope of (u, v) cycles per SLM pixel moves a spot by (xx u + xy v, yx u + yy v)
                camera pixels; px_per_cycle_standard_error: standard error of each, camera pixels per cycle per SLM pixel;
                scale_px_per_cycle: square root of the map's determinant; rotation_deg: by how much the camera sees the SLM's +x turned
                towards its own +y, degrees; mirrored: whether the camera sees the SLM mirrored; residual_px: RMS of what the map leaves of
                the places where the spot was found, camera pixels; sights: slopes for which the spot was found
        """
        result: RegistrationResult = self.call("registration.get")
        return result

    def registration_run(self, *, frames: int | LeftOut = LEFT_OUT) -> JobStarted:
        """`registration.run`. Measures where the camera sees which slope: the base subaperture alone is shown with known gratings, and its
        spot is found. Answers at once; the job's result is that of registration.get, and in force from then on.

        frames: how many frames to average for each picture; from 1 to 100; default 5
        Result: job: number of the job
        """
        result: JobStarted = self.call("registration.run", _given(frames=frames))
        return result

    def sensor_get(self) -> SensorGetResult:
        """`sensor.get`. The sensor shown on the SLM and how its spots are found.

        Result: charge: topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor; grid: how the subapertures lie;
                subapertures_across: M, along the pupil's diameter; pupil_diameter_px: D, SLM pixels; grooves: n_x, n_y: grooves of the base
                grating over the SLM's width and height; spacing: s: how far the spots are spread on the camera, grooves per SLM pixel of a
                subaperture's position; tracker: how spots are found; template: of the tracker matched: the model's spot, or each spot as
                the reference shows it; operator: from displacements to modes: slopes, the tracker's own tilt of each mode; diffractive,
                each mode through the diffraction model, exact for aberrations up to about 0.1 wave, beyond that the slopes are better;
                relinearised: offline only, the daemon refuses it; measured: each mode as the bench itself showed it to calibration.run;
                own_templates: spots that are found by a template of their own, from the reference, and not by the model's; template_reason:
                why that is not every spot though template is reference, and the way out; null: it is, or was not asked for;
                operator_in_force: what turns displacements into modes now; operator_reason: why that is not the operator asked for: it is
                being made, or why it cannot be; null: it is; subapertures: how many there are; modes_j: OSA/ANSI indices that are
                reconstructed; hologram_id: number of the hologram, as in every stream message; 0: none
        """
        result: SensorGetResult = self.call("sensor.get")
        return result

    def sensor_set(
        self,
        *,
        charge: int | LeftOut = LEFT_OUT,
        grid: Literal["hexagonal", "square"] | LeftOut = LEFT_OUT,
        subapertures_across: int | LeftOut = LEFT_OUT,
        pupil_diameter_px: float | LeftOut = LEFT_OUT,
        grooves: Sequence[float] | LeftOut = LEFT_OUT,
        spacing: float | LeftOut = LEFT_OUT,
        tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched"] | LeftOut = LEFT_OUT,
        template: Literal["model", "reference"] | LeftOut = LEFT_OUT,
        operator: Literal["slopes", "diffractive", "relinearised", "measured"] | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
    ) -> SensorSetResult:
        """`sensor.set`. All or nothing; what is left out stays. A reference is set aside by a change of geometry, charge, tracker or (of
        matched) template, and is in force again when the same setting returns.

        charge: topological charge l of the vortices; 0: the conventional Shack-Hartmann sensor; from -8 to 8
        grid: how the subapertures lie
        subapertures_across: M, along the pupil's diameter; from 1 to 31
        pupil_diameter_px: D, SLM pixels; from 8 to 16384
        grooves: n_x, n_y: grooves of the base grating over the SLM's width and height
        spacing: s: how far the spots are spread on the camera, grooves per SLM pixel of a subaperture's position; from 0.001 to 16
        tracker: how spots are found
        template: of the tracker matched: the model's spot, or each spot as the reference shows it
        operator: from displacements to modes: slopes, the tracker's own tilt of each mode; diffractive, each mode through the diffraction
                  model, exact for aberrations up to about 0.1 wave, beyond that the slopes are better; relinearised: offline only, the
                  daemon refuses it; measured: each mode as the bench itself showed it to calibration.run
        clamp: true: a number out of range becomes the nearest limit instead of being refused; the ranges stated here then do not bind;
               default false
        Result: requested: as it was asked for; applied: as it is now; hologram_id: number of the hologram, as in every stream message; 0:
                none
        """
        result: SensorSetResult = self.call("sensor.set", _given(
            charge=charge, grid=grid, subapertures_across=subapertures_across, pupil_diameter_px=pupil_diameter_px, grooves=grooves,
            spacing=spacing, tracker=tracker, template=template, operator=operator, clamp=clamp
        ))
        return result

    def slm_settle(self, *, repetitions: int | LeftOut = LEFT_OUT, watch_ms: float | LeftOut = LEFT_OUT) -> JobStarted:
        """`slm.settle`. Measures how long the SLM takes from the display's taking a picture until the light on the camera stands: a spot is
        moved to and fro, and every frame is watched, settled or not. Answers at once; the job's result is the time, and the slm.settle_ms
        that it proposes: by the changes whose time is no outlier (more than three standard deviations above the median, by the median
        absolute deviation), with the number of those that are. Nothing is changed by it.

        repetitions: changes of the picture; from 3 to 200; default 20
        watch_ms: how long frames are watched after each change, milliseconds; from 20 to 10000; default 200
        Result: job: number of the job
        """
        result: JobStarted = self.call("slm.settle", _given(repetitions=repetitions, watch_ms=watch_ms))
        return result

    def slm_show(self, pattern: Literal["sensor", "grating", "flat", "identify"]) -> SlmShowResult:
        """`slm.show`. What the SLM shows.

        pattern: sensor: the wavefront sensor; grating: base grating and correction only, for using the corrected beam; flat: flatness map
                 only; identify: a picture that tells which screen it is
        Result: pattern: as set; hologram_id: number of the hologram, as in every stream message; 0: none
        """
        result: SlmShowResult = self.call("slm.show", _given(pattern=pattern))
        return result

    def slm_verify(self) -> SlmVerifyResult:
        """`slm.verify`. Reads back what stands on the SLM's output and compares it with the hologram that was presented last. A difference
        is also an event of kind slm.

        Result: hologram_id: presented last; crc32: CRC-32 (zlib's) of its grey levels, row by row; crc32_shown: of the output's pixels
                (their blue); equal: whether every pixel is grey and of the level presented; differing_pixels: how many are not
        """
        result: SlmVerifyResult = self.call("slm.verify")
        return result

    def system_describe(self) -> SystemDescribeResult:
        """`system.describe`. All methods and streams with their JSON Schemas, and versions.

        Result: versions: of the daemon and its libraries; methods: by name; roles: of each method by name: the least role of a client that
                may call it, where clients need keys; streams: JSON Schema of each topic's JSON part
        """
        result: SystemDescribeResult = self.call("system.describe")
        return result

    def system_status(self) -> SystemStatusResult:
        """`system.status`. The body of the status message.

        Result: t_ns: UNIX epoch UTC, nanoseconds; uptime_s: since the start, seconds; state: what the daemon is doing: starting,
                waiting_for_camera, waiting_for_display, running, job_running, fault, stopping; fault: what is wrong and the way out; null:
                nothing; camera: the camera; slm: the spatial light modulator; sensor: the sensor shown; refine: the refinement of frames
                beside the fast estimate; record: the recording that is on, or the last one; store: what is kept over a restart; loop:
                whether the correction follows the measurement; failed_job: the job that failed last since the start, of those after which
                none of the same kind was done; null: none; rates: since the last status; counters: every counter, since the start; latency:
                by stage, since the last status: tracked, reconstructed and published from the frame's arrival; arrived from when it would
                have arrived had nothing held it up, of a camera with device stamps; versions: of the daemon and its libraries
        """
        result: SystemStatusResult = self.call("system.status")
        return result


class AsyncMethods:
    """What a client inherits: one Python method for each of the daemon's, carried out by `call`."""

    async def call(self, method: str, params: Mapping[str, object] | None = None) -> Any:
        raise NotImplementedError

    async def aberration_clear(self) -> AberrationResult:
        """`aberration.clear`. Takes the wavefront added on purpose away.

        Params and result: `Methods.aberration_clear`.
        """
        result: AberrationResult = await self.call("aberration.clear")
        return result

    async def aberration_get(self) -> AberrationResult:
        """`aberration.get`. The wavefront added on purpose.

        Params and result: `Methods.aberration_get`.
        """
        result: AberrationResult = await self.call("aberration.get")
        return result

    async def aberration_set(
        self,
        modes: Sequence[ModeByJ | ModeByOrders],
        *,
        norm: Literal["rms", "unit"] | LeftOut = LEFT_OUT,
    ) -> AberrationResult:
        """`aberration.set`. Replaces the wavefront added on purpose. No mode may be given twice. The answer is in RMS normalisation
        whatever was given.

        Params and result: `Methods.aberration_set`.
        """
        result: AberrationResult = await self.call("aberration.set", _given(modes=modes, norm=norm))
        return result

    async def calibration_clear(self) -> CalibrationResult:
        """`calibration.clear`. Forgets the calibration of the sensor as it is now, on the disk, too: its matrix is then the slopes'.

        Params and result: `Methods.calibration_clear`.
        """
        result: CalibrationResult = await self.call("calibration.clear")
        return result

    async def calibration_get(self) -> CalibrationResult:
        """`calibration.get`. The interaction matrix that was measured for the sensor as it is now, in figures, against the model's; or
        nulls.

        Params and result: `Methods.calibration_get`.
        """
        result: CalibrationResult = await self.call("calibration.get")
        return result

    async def calibration_run(
        self,
        *,
        amplitude_waves: float | LeftOut = LEFT_OUT,
        frames: int | LeftOut = LEFT_OUT,
        modes: Sequence[int] | LeftOut = LEFT_OUT,
    ) -> JobStarted:
        """`calibration.run`. Measures how far each mode moves each spot: it is shown with both signs, on top of the aberration that is
        shown. Answers at once; the job's result is that of calibration.get, and modes are read with it from then on (operator measured).

        Params and result: `Methods.calibration_run`.
        """
        result: JobStarted = await self.call("calibration.run", _given(amplitude_waves=amplitude_waves, frames=frames, modes=modes))
        return result

    async def camera_get(self) -> CameraGetResult:
        """`camera.get`. What is in use and what the camera allows.

        Params and result: `Methods.camera_get`.
        """
        result: CameraGetResult = await self.call("camera.get")
        return result

    async def camera_set(
        self,
        *,
        gain_db: float | None | LeftOut = LEFT_OUT,
        gain_raw: float | None | LeftOut = LEFT_OUT,
        exposure_us: float | LeftOut = LEFT_OUT,
        frame_rate_hz: float | LeftOut = LEFT_OUT,
        pixel_format: Literal["Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8", "BayerRG10", "BayerGR10", "BayerGB10", "BayerBG10", "BayerRG12", "BayerGR12", "BayerGB12", "BayerBG12", "BayerRG10p", "BayerGR10p", "BayerGB10p", "BayerBG10p", "BayerRG12p", "BayerGR12p", "BayerGB12p", "BayerBG12p"] | LeftOut = LEFT_OUT,
        roi: CameraRoi | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
    ) -> CameraSetResult:
        """`camera.set`. All or nothing; what is left out stays. The stream survives it. The camera may allow less than the ranges here: its
        limits are in the result and in the error.

        Params and result: `Methods.camera_set`.
        """
        result: CameraSetResult = await self.call("camera.set", _given(
            gain_db=gain_db, gain_raw=gain_raw, exposure_us=exposure_us, frame_rate_hz=frame_rate_hz, pixel_format=pixel_format, roi=roi,
            clamp=clamp
        ))
        return result

    async def config_get(self) -> ConfigGetResult:
        """`config.get`. The effective configuration: the file's keys, every default, and what was set since.

        Params and result: `Methods.config_get`.
        """
        result: ConfigGetResult = await self.call("config.get")
        return result

    async def config_save(self) -> ConfigSaveResult:
        """`config.save`. Saves the settings in use that differ from the configuration file, atomically, to an overlay in the state
        directory. The daemon lays it over the file at its start and at every reload.

        Params and result: `Methods.config_save`.
        """
        result: ConfigSaveResult = await self.call("config.save")
        return result

    async def correction_clear(self) -> AberrationResult:
        """`correction.clear`. Nothing is subtracted any more. Not while the loop is closed.

        Params and result: `Methods.correction_clear`.
        """
        result: AberrationResult = await self.call("correction.clear")
        return result

    async def correction_get(self) -> AberrationResult:
        """`correction.get`. What is subtracted from the hologram, by the loop or by a person.

        Params and result: `Methods.correction_get`.
        """
        result: AberrationResult = await self.call("correction.get")
        return result

    async def correction_set(
        self,
        modes: Sequence[ModeByJ | ModeByOrders],
        *,
        norm: Literal["rms", "unit"] | LeftOut = LEFT_OUT,
    ) -> AberrationResult:
        """`correction.set`. Subtracts these modes from the hologram, in place of the correction of before. Not while the loop is closed.

        Params and result: `Methods.correction_set`.
        """
        result: AberrationResult = await self.call("correction.set", _given(modes=modes, norm=norm))
        return result

    async def experiment_cell(self, cell: int) -> ExperimentCellResult:
        """`experiment.cell`. One measured cell of the gain sweep, frame by frame.

        Params and result: `Methods.experiment_cell`.
        """
        result: ExperimentCellResult = await self.call("experiment.cell", _given(cell=cell))
        return result

    async def experiment_gain_sweep(
        self,
        *,
        gains_db: Sequence[float] | LeftOut = LEFT_OUT,
        frames: int | LeftOut = LEFT_OUT,
        reference_gain_db: float | LeftOut = LEFT_OUT,
        reference_frames: int | LeftOut = LEFT_OUT,
        aberrations: Sequence[Aberration] | LeftOut = LEFT_OUT,
        arms: Sequence[Arm] | LeftOut = LEFT_OUT,
        picture_gains_db: Sequence[float] | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
        anew: bool | LeftOut = LEFT_OUT,
    ) -> ExperimentGainSweepResult:
        """`experiment.gain_sweep`. The paper's comparison: the residual variance of each arm against the camera's gain, at the exposure
        that is set, with aberrations shown on purpose. First a reference of each arm without an aberration, then cell by cell, a cell being
        one arm with one aberration at one gain. Answers at once; experiment.get and experiment.cell tell what was measured so far. The same
        params on the same bench go on with the cells that are missing, also after a cancel or a restart, if the spots of the run's first
        reference stand within lambda/(20 d) of where they stood; else the job is refused and the cells stay. Who asks for the run that is
        being measured is given its job. Gain, sensor and aberration are put back at the end, the user's reference is not touched.

        Params and result: `Methods.experiment_gain_sweep`.
        """
        result: ExperimentGainSweepResult = await self.call("experiment.gain_sweep", _given(
            gains_db=gains_db, frames=frames, reference_gain_db=reference_gain_db, reference_frames=reference_frames,
            aberrations=aberrations, arms=arms, picture_gains_db=picture_gains_db, clamp=clamp, anew=anew
        ))
        return result

    async def experiment_get(self) -> ExperimentGetResult:
        """`experiment.get`. The gain sweep that was asked for last, and what was measured of it so far; or nulls.

        Params and result: `Methods.experiment_get`.
        """
        result: ExperimentGetResult = await self.call("experiment.get")
        return result

    async def flatness_clear(self) -> FlatnessResult:
        """`flatness.clear`. From now on the flatness is that of the configuration's file alone, or none. The measured one is gone from the
        disk, too.

        Params and result: `Methods.flatness_clear`.
        """
        result: FlatnessResult = await self.call("flatness.clear")
        return result

    async def flatness_get(self) -> FlatnessResult:
        """`flatness.get`. What was measured of the SLM's flatness, as modes.

        Params and result: `Methods.flatness_get`.
        """
        result: FlatnessResult = await self.call("flatness.get")
        return result

    async def flatness_run(self, *, frames: int | LeftOut = LEFT_OUT) -> JobStarted:
        """`flatness.run`. Reads the modes of the SLM's flatness, and of the optics between SLM and camera, from a lone spot whose aperture
        is moved all over the pupil; shows their opposite, and scans again until nothing changes. Needs a registration. Answers at once; the
        job's result is that of flatness.get, and in force from then on.

        Params and result: `Methods.flatness_run`.
        """
        result: JobStarted = await self.call("flatness.run", _given(frames=frames))
        return result

    async def job_cancel(self, job: int) -> JobResult:
        """`job.cancel`. Ends a job that runs; one that has ended stays as it is.

        Params and result: `Methods.job_cancel`.
        """
        result: JobResult = await self.call("job.cancel", _given(job=job))
        return result

    async def job_get(self, job: int) -> JobResult:
        """`job.get`. How far a job is.

        Params and result: `Methods.job_get`.
        """
        result: JobResult = await self.call("job.get", _given(job=job))
        return result

    async def loop_close(
        self,
        *,
        gain: float | LeftOut = LEFT_OUT,
        leak: float | LeftOut = LEFT_OUT,
        modes: Sequence[int] | LeftOut = LEFT_OUT,
        gains: Sequence[Gain] | LeftOut = LEFT_OUT,
        limit_waves: float | LeftOut = LEFT_OUT,
        patience_s: float | LeftOut = LEFT_OUT,
    ) -> LoopResult:
        """`loop.close`. From now on what is measured is subtracted from the hologram, a step a settled and valid frame, beginning from the
        correction that is shown. Needs a reference. The loop opens by itself, with an event, when it cannot go on.

        Params and result: `Methods.loop_close`.
        """
        result: LoopResult = await self.call("loop.close", _given(
            gain=gain, leak=leak, modes=modes, gains=gains, limit_waves=limit_waves, patience_s=patience_s
        ))
        return result

    async def loop_get(self) -> LoopResult:
        """`loop.get`. How the loop does.

        Params and result: `Methods.loop_get`.
        """
        result: LoopResult = await self.call("loop.get")
        return result

    async def loop_open(self, *, keep: bool | LeftOut = LEFT_OUT) -> LoopResult:
        """`loop.open`. The correction stays as it is, or is cleared.

        Params and result: `Methods.loop_open`.
        """
        result: LoopResult = await self.call("loop.open", _given(keep=keep))
        return result

    async def lut_clear(self) -> LutResult:
        """`lut.clear`. From now on the look-up table is that of the configuration: its file's, or the linear one. The measured one is gone
        from the disk, too.

        Params and result: `Methods.lut_clear`.
        """
        result: LutResult = await self.call("lut.clear")
        return result

    async def lut_get(self) -> LutResult:
        """`lut.get`. The look-up table in force, where it comes from, and, if it was measured, the SLM's phase against its grey level.

        Params and result: `Methods.lut_get`.
        """
        result: LutResult = await self.call("lut.get")
        return result

    async def lut_run(self, *, levels: int | LeftOut = LEFT_OUT, frames: int | LeftOut = LEFT_OUT) -> JobStarted:
        """`lut.run`. Measures the phase of the SLM's grey levels: two patches of the pupil with binary gratings beat with each other on the
        camera, one of them with each grey level in turn. Answers at once; the job's result is that of lut.get, and in force from then on.

        Params and result: `Methods.lut_run`.
        """
        result: JobStarted = await self.call("lut.run", _given(levels=levels, frames=frames))
        return result

    async def record_get(self) -> RecordResult:
        """`record.get`. What is being recorded, or was last.

        Params and result: `Methods.record_get`.
        """
        result: RecordResult = await self.call("record.get")
        return result

    async def record_start(
        self,
        name: str,
        *,
        pictures_every: int | LeftOut = LEFT_OUT,
        limit_s: float | None | LeftOut = LEFT_OUT,
        limit_mib: float | None | LeftOut = LEFT_OUT,
    ) -> RecordResult:
        """`record.start`. Writes every frame from now on into a file: what was measured of it, its stamps, all that was in force, and its
        picture.

        Params and result: `Methods.record_start`.
        """
        result: RecordResult = await self.call("record.start", _given(
            name=name, pictures_every=pictures_every, limit_s=limit_s, limit_mib=limit_mib
        ))
        return result

    async def record_stop(self) -> RecordResult:
        """`record.stop`. Ends the recording; the file is whole when this answers.

        Params and result: `Methods.record_stop`.
        """
        result: RecordResult = await self.call("record.stop")
        return result

    async def reference_clear(self) -> ReferenceResult:
        """`reference.clear`. Forgets the reference; the stream is not valid until a new one is taken. It is forgotten on the disk, too; if
        that fails, nothing changes.

        Params and result: `Methods.reference_clear`.
        """
        result: ReferenceResult = await self.call("reference.clear")
        return result

    async def reference_get(self) -> ReferenceResult:
        """`reference.get`. The reference in use, or nulls.

        Params and result: `Methods.reference_get`.
        """
        result: ReferenceResult = await self.call("reference.get")
        return result

    async def reference_set(self, source: Literal["model"]) -> ReferenceResult:
        """`reference.set`. Positions count from where the configuration, or the registration in force, says that spots are, instead of from
        a reference that was taken: the coefficients then hold what the bench itself adds, its misalignment included. It takes the place of
        the reference in force, until the next reference.take or reference.clear.

        Params and result: `Methods.reference_set`.
        """
        result: ReferenceResult = await self.call("reference.set", _given(source=source))
        return result

    async def reference_take(self, *, frames: int | LeftOut = LEFT_OUT, allow_aberration: bool | LeftOut = LEFT_OUT) -> JobStarted:
        """`reference.take`. Averages the spots of the next frames as what displacements count from; refused if more than a tenth of the
        spots are saturated, if the spots move meanwhile, or if an aberration is introduced. Answers at once; the job tells how it ends.

        Params and result: `Methods.reference_take`.
        """
        result: JobStarted = await self.call("reference.take", _given(frames=frames, allow_aberration=allow_aberration))
        return result

    async def refine_get(self) -> RefineResult:
        """`refine.get`. Whether frames are refined, how often, and how the camera makes numbers of electrons.

        Params and result: `Methods.refine_get`.
        """
        result: RefineResult = await self.call("refine.get")
        return result

    async def refine_set(
        self,
        *,
        enabled: bool | LeftOut = LEFT_OUT,
        rate_hz: float | LeftOut = LEFT_OUT,
        electrons_per_dn: float | None | LeftOut = LEFT_OUT,
        read_noise_e: float | LeftOut = LEFT_OUT,
        black_level_dn: float | LeftOut = LEFT_OUT,
        saturation_dn: float | None | LeftOut = LEFT_OUT,
        spot_amplitudes: bool | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
    ) -> RefineSetResult:
        """`refine.set`. All or nothing; what is left out stays. What is being refined with other numbers is not published. DN are those of
        the camera's pixel format, and are converted when it changes.

        Params and result: `Methods.refine_set`.
        """
        result: RefineSetResult = await self.call("refine.set", _given(
            enabled=enabled, rate_hz=rate_hz, electrons_per_dn=electrons_per_dn, read_noise_e=read_noise_e, black_level_dn=black_level_dn,
            saturation_dn=saturation_dn, spot_amplitudes=spot_amplitudes, clamp=clamp
        ))
        return result

    async def registration_clear(self) -> RegistrationResult:
        """`registration.clear`. From now on the configuration says where the camera sees which slope.

        Params and result: `Methods.registration_clear`.
        """
        result: RegistrationResult = await self.call("registration.clear")
        return result

    async def registration_get(self) -> RegistrationResult:
        """`registration.get`. Where the camera sees which slope, as measured; or nulls: then the configuration says it.

        Params and result: `Methods.registration_get`.
        """
        result: RegistrationResult = await self.call("registration.get")
        return result

    async def registration_run(self, *, frames: int | LeftOut = LEFT_OUT) -> JobStarted:
        """`registration.run`. Measures where the camera sees which slope: the base subaperture alone is shown with known gratings, and its
        spot is found. Answers at once; the job's result is that of registration.get, and in force from then on.

        Params and result: `Methods.registration_run`.
        """
        result: JobStarted = await self.call("registration.run", _given(frames=frames))
        return result

    async def sensor_get(self) -> SensorGetResult:
        """`sensor.get`. The sensor shown on the SLM and how its spots are found.

        Params and result: `Methods.sensor_get`.
        """
        result: SensorGetResult = await self.call("sensor.get")
        return result

    async def sensor_set(
        self,
        *,
        charge: int | LeftOut = LEFT_OUT,
        grid: Literal["hexagonal", "square"] | LeftOut = LEFT_OUT,
        subapertures_across: int | LeftOut = LEFT_OUT,
        pupil_diameter_px: float | LeftOut = LEFT_OUT,
        grooves: Sequence[float] | LeftOut = LEFT_OUT,
        spacing: float | LeftOut = LEFT_OUT,
        tracker: Literal["centroid", "thresholded", "weighted", "lg_contour", "lg", "matched"] | LeftOut = LEFT_OUT,
        template: Literal["model", "reference"] | LeftOut = LEFT_OUT,
        operator: Literal["slopes", "diffractive", "relinearised", "measured"] | LeftOut = LEFT_OUT,
        clamp: bool | LeftOut = LEFT_OUT,
    ) -> SensorSetResult:
        """`sensor.set`. All or nothing; what is left out stays. A reference is set aside by a change of geometry, charge, tracker or (of
        matched) template, and is in force again when the same setting returns.

        Params and result: `Methods.sensor_set`.
        """
        result: SensorSetResult = await self.call("sensor.set", _given(
            charge=charge, grid=grid, subapertures_across=subapertures_across, pupil_diameter_px=pupil_diameter_px, grooves=grooves,
            spacing=spacing, tracker=tracker, template=template, operator=operator, clamp=clamp
        ))
        return result

    async def slm_settle(self, *, repetitions: int | LeftOut = LEFT_OUT, watch_ms: float | LeftOut = LEFT_OUT) -> JobStarted:
        """`slm.settle`. Measures how long the SLM takes from the display's taking a picture until the light on the camera stands: a spot is
        moved to and fro, and every frame is watched, settled or not. Answers at once; the job's result is the time, and the slm.settle_ms
        that it proposes: by the changes whose time is no outlier (more than three standard deviations above the median, by the median
        absolute deviation), with the number of those that are. Nothing is changed by it.

        Params and result: `Methods.slm_settle`.
        """
        result: JobStarted = await self.call("slm.settle", _given(repetitions=repetitions, watch_ms=watch_ms))
        return result

    async def slm_show(self, pattern: Literal["sensor", "grating", "flat", "identify"]) -> SlmShowResult:
        """`slm.show`. What the SLM shows.

        Params and result: `Methods.slm_show`.
        """
        result: SlmShowResult = await self.call("slm.show", _given(pattern=pattern))
        return result

    async def slm_verify(self) -> SlmVerifyResult:
        """`slm.verify`. Reads back what stands on the SLM's output and compares it with the hologram that was presented last. A difference
        is also an event of kind slm.

        Params and result: `Methods.slm_verify`.
        """
        result: SlmVerifyResult = await self.call("slm.verify")
        return result

    async def system_describe(self) -> SystemDescribeResult:
        """`system.describe`. All methods and streams with their JSON Schemas, and versions.

        Params and result: `Methods.system_describe`.
        """
        result: SystemDescribeResult = await self.call("system.describe")
        return result

    async def system_status(self) -> SystemStatusResult:
        """`system.status`. The body of the status message.

        Params and result: `Methods.system_status`.
        """
        result: SystemStatusResult = await self.call("system.status")
        return result
