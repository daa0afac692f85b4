"""An external corrector, such as a deformable mirror, that this program drives: its calibration, and an integrator that closes the loop.

The daemon publishes the measured modes times a matrix (corrector_set) as commands of the actuators; the state of the loop is here.
"""
from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .bench import Bench
from .errors import NoAnswer
from .messages import Corrector, Spots
from .methods import KnownCalibration, KnownCorrector
from .values import number, whole

Floats = npt.NDArray[np.float64]
Drive = Callable[[Floats], object]
"""Moves all actuators to these positions, in the mirror's own unit; returns when it has accepted them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MirrorCalibration:
    """How the measured modes answer to each actuator."""

    j: npt.NDArray[np.int64]
    """OSA/ANSI indices of the rows"""
    interaction: Floats
    """(modes, actuators): RMS-normalised waves per unit of the actuator"""
    standard_error: Floats
    """of each element of `interaction`"""

    def command_matrix(self, regularisation: float = 0.05) -> Floats:
        """(actuators, modes), for set_matrix: the inverse of `interaction`. Combinations of actuators that the sensor hardly sees are damped
        (Tikhonov): those whose singular value is below `regularisation` times the largest one."""
        modes, values, actuators = np.linalg.svd(self.interaction, full_matrices=False)
        if values[0] == 0.0:
            raise ValueError("no actuator moves a mode; does `drive` reach the mirror?")
        damped = values / (values**2 + (regularisation * values[0]) ** 2)
        return np.asarray(actuators.T @ (damped[:, None] * modes.T))


def set_matrix(client: Bench, matrix: npt.ArrayLike) -> KnownCorrector:
    """Sets a command matrix (actuators, modes): from now on, each valid frame gives commands."""
    values = np.ascontiguousarray(matrix, "<f4")
    return client.corrector_set(values.tobytes(), shape=list(values.shape))


def _push_pull(sample: Callable[[], tuple[Floats, Floats]], drive: Drive, pokes: Floats, rest: Floats, settle_s: float) -> tuple[Floats, Floats]:
    """Half the difference of what is sampled under rest + poke and rest - poke, one column for each poke, and its standard error."""
    columns, errors = [], []
    settle_s = number("settle_s", settle_s, 0.0)
    try:
        for poke in pokes:
            both = []
            for position in (rest + poke, rest - poke):
                drive(position)
                time.sleep(settle_s)
                both.append(sample())
            columns.append(0.5 * (both[0][0] - both[1][0]))
            errors.append(0.5 * np.hypot(both[0][1], both[1][1]))
    finally:
        drive(rest)
    return np.array(columns).T, np.array(errors).T


def calibrate_mirror(client: Bench, drive: Drive, actuators: int, amplitude: float, frames: int = 20, settle_s: float = 0.0,
                     rest: npt.ArrayLike | None = None) -> MirrorCalibration:
    """Pokes each actuator by +amplitude and -amplitude about `rest` (0), and averages `frames` valid frames each time. Needs a reference.

    `settle_s`: time from the return of `drive` until the mirror is at rest. The mirror is at `rest` afterwards.
    """
    j: list[int] = []
    actuators, frames, amplitude = whole("actuators", actuators), whole("frames", frames), number("amplitude", amplitude)

    def sample() -> tuple[Floats, Floats]:
        mean = client.wavefront(frames)
        j[:] = mean.j.tolist()
        return mean.coefficients_waves, mean.standard_error_waves

    middle = np.zeros(actuators) if rest is None else np.asarray(rest, np.float64)
    moved, error = _push_pull(sample, drive, amplitude * np.eye(actuators), middle, settle_s)
    return MirrorCalibration(j=np.array(j, np.int64), interaction=moved / amplitude, standard_error=error / amplitude)


def mean_spots(client: Bench, frames: int, timeout_s: float = 30.0) -> tuple[Floats, Floats]:
    """Mean positions x, y, x, y, … of the spots in the next settled frames, camera pixels, and their standard errors. Only frames whose exposure
    began after this call count. NaN: lost in a frame. Raises NoAnswer if there were not as many within `timeout_s` seconds."""
    frames, end = whole("frames", frames), time.monotonic() + number("timeout_s", timeout_s, 0.0)
    rows: list[Floats] = []
    with client.subscribe(Spots) as stream:
        later = client.later(timeout_s, f"0 of {frames} settled frames")
        while len(rows) < frames:
            spots = stream.next(max(0.0, end - time.monotonic()))
            if spots is None:
                raise NoAnswer(f"{len(rows)} of {frames} settled frames within {timeout_s} s")
            if later(spots) and spots.settled and spots.exposure_us is not None:
                rows.append(spots.x_y_px.ravel().astype(np.float64))
    table = np.array(rows)
    return table.mean(axis=0), table.std(axis=0, ddof=1) / math.sqrt(frames)


def calibrate_sensor(client: Bench, drive: Drive, modes: Sequence[int], commands_per_wave: npt.ArrayLike, amplitude_waves: float = 0.15,
                     frames: int = 20, settle_s: float = 0.0, rest: npt.ArrayLike | None = None) -> KnownCalibration:
    """Calibrates the sensor by a mirror whose shapes are known, in place of calibration_run: pokes each mode, and gives the displacements of the
    spots to the daemon (calibration_set). Needs a tracker of positions.

    `commands_per_wave`: (modes, actuators), the commands that make one RMS-normalised wave of each of `modes` (j, ascending).
    """
    frames, amplitude_waves = whole("frames", frames), number("amplitude_waves", amplitude_waves)
    commands = np.asarray(commands_per_wave, np.float64)
    middle = np.zeros(commands.shape[1]) if rest is None else np.asarray(rest, np.float64)
    moved, error = _push_pull(lambda: mean_spots(client, frames), drive, amplitude_waves * commands, middle, settle_s)
    both = np.array([moved, error]) / amplitude_waves
    x_y_lost = np.isnan(both).any(axis=(0, 2)).reshape(-1, 2).any(axis=1)
    both[:, np.repeat(x_y_lost, 2)] = 0.0
    matrix = np.ascontiguousarray(both, "<f4")
    return client.calibration_set(matrix.tobytes(), shape=list(matrix.shape), modes=list(modes), amplitude_waves=amplitude_waves, frames=frames)


class MirrorLoop:
    """An integrator for each actuator: position <- (1 - leak) position - gain commands, from -limit to limit.

    The mirror stays where it is when this program ends; `start` continues from there. `matrix`: the number of the matrix whose commands count;
    None: whatever was set last.
    """

    def __init__(self, drive: Drive, actuators: int, gain: float = 0.4, leak: float = 0.0, limit: float = math.inf,
                 start: npt.ArrayLike | None = None, matrix: int | None = None) -> None:
        self._drive = drive
        self._gain, self._leak, self._limit = number("gain", gain), number("leak", leak), number("limit", limit)
        self._matrix = None if matrix is None else whole("matrix", matrix, 0)
        self.position: Floats = np.zeros(whole("actuators", actuators)) if start is None else np.array(start, np.float64)
        self.steps = 0

    def step(self, message: Corrector) -> bool:
        """Takes one step. False, and the mirror stays: the frame is not valid, or the commands are of another matrix."""
        if not message.valid or self._matrix not in (None, message.matrix):
            return False
        self.position = np.clip((1.0 - self._leak) * self.position - self._gain * message.commands, -self._limit, self._limit)
        self._drive(self.position)
        self.steps += 1
        return True

    def run(self, client: Bench, seconds: float = math.inf, timeout_s: float = 5.0) -> None:
        """Takes a step for each frame, the newest one if this program is slower. Raises NoAnswer if no message came within `timeout_s` seconds."""
        end = time.monotonic() + number("seconds", seconds)
        with client.subscribe(Corrector) as stream:
            while time.monotonic() < end:
                message = stream.newest(timeout_s)
                if message is None:
                    raise NoAnswer(f"no commands within {timeout_s} s; was a matrix set (corrector_get)?")
                self.step(message)
