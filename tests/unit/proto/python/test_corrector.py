"""A mirror that this program drives: its calibration on a played daemon, the command matrix, and the integrator."""
import unittest
from dataclasses import replace

import numpy as np
from paths import SCHEMAS

from ovws_client import Client, Corrector, MeanWavefront, MirrorCalibration, MirrorLoop, calibrate_mirror, calibrate_sensor, set_matrix
from ovws_client import corrector as module

RNG = np.random.default_rng(1)
INFLUENCE = RNG.standard_normal((5, 8))  # waves of 5 modes by each of 8 actuators


class Bench(Client):
    """A client of a daemon that measures what a mirror of linear influence shows."""

    def __init__(self):
        self.position, self.calls, self.moved = np.zeros(8), [], []

    def drive(self, actuators):
        self.position = np.array(actuators)
        self.moved.append(self.position)

    def call(self, method, params=None, binary=None):
        self.calls.append((method, params, np.frombuffer(binary, "<f4").reshape(params["shape"])))
        return {"matrix": 7}

    def wavefront(self, frames=50, timeout_s=30.0):
        waves = 0.3 + INFLUENCE @ self.position
        return MeanWavefront(frames=frames, skipped=0, hologram_id=1, wavelength_nm=632.0, j=np.arange(1, 6), coefficients_waves=waves,
                             standard_error_waves=np.full(5, 0.01), scatter_waves=np.full(5, 0.02))


def commands(values, valid=True, matrix=7):
    body = SCHEMAS["stream.corrector"]["examples"][0] | {"shape": [len(values)], "valid": valid, "matrix": matrix}
    return Corrector.of(body, np.array(values, "<f4").tobytes())


class Calibration(unittest.TestCase):
    def test_each_actuator_is_poked_about_rest_and_the_mirror_returns_to_it(self):
        bench, rest = Bench(), np.linspace(-1.0, 1.0, 8)
        found = calibrate_mirror(bench, bench.drive, 8, 0.1, frames=2, rest=rest)
        np.testing.assert_allclose(found.interaction, INFLUENCE, atol=1e-9)
        np.testing.assert_allclose(found.standard_error, 0.01 / np.sqrt(2.0) / 0.1)
        self.assertEqual(found.j.tolist(), [1, 2, 3, 4, 5])
        np.testing.assert_array_equal(bench.position, rest)
        np.testing.assert_allclose(np.abs(np.array(bench.moved[:-1]) - rest).sum(axis=1), 0.1)

    def test_the_mirror_returns_to_rest_after_a_failure_too(self):
        bench = Bench()
        bench.wavefront = lambda frames: 1 / 0
        with self.assertRaises(ZeroDivisionError):
            calibrate_mirror(bench, bench.drive, 8, 0.1)
        np.testing.assert_array_equal(bench.position, np.zeros(8))

    def test_the_command_matrix_makes_what_is_measured_and_damps_what_is_hardly_seen(self):
        exact = MirrorCalibration(j=np.arange(1, 6), interaction=INFLUENCE, standard_error=0 * INFLUENCE)
        np.testing.assert_allclose(INFLUENCE @ exact.command_matrix(0.0), np.eye(5), atol=1e-9)
        modes, values, actuators = np.linalg.svd(INFLUENCE, full_matrices=False)
        values[-1] = 1e-4 * values[0]
        weak = replace(exact, interaction=modes @ np.diag(values) @ actuators)
        self.assertGreater(np.abs(weak.command_matrix(0.0)).max(), 100.0)
        self.assertLess(np.abs(weak.command_matrix()).max(), 2.0 / values[-2])
        with self.assertRaises(ValueError):
            replace(exact, interaction=0 * INFLUENCE).command_matrix()

    def test_the_matrix_is_sent_by_rows(self):
        bench = Bench()
        matrix = np.arange(40.0).reshape(5, 8).T
        self.assertEqual(set_matrix(bench, matrix), {"matrix": 7})
        (method, params, sent), = bench.calls
        self.assertEqual((method, params), ("corrector.set", {"shape": [8, 5]}))
        np.testing.assert_array_equal(sent, matrix)

    def test_the_sensor_is_calibrated_by_displacements_and_lost_spots_are_0(self):
        bench, per_actuator = Bench(), RNG.standard_normal((6, 8))  # three spots

        def spots(client, frames):
            at = 100.0 + per_actuator @ bench.position
            at[3] = np.nan if bench.position.any() else 0.0  # y of the second spot
            return at, np.full(6, 0.01)

        module.mean_spots, before = spots, module.mean_spots
        self.addCleanup(setattr, module, "mean_spots", before)
        shapes = RNG.standard_normal((2, 8))
        calibrate_sensor(bench, bench.drive, [3, 4], shapes, amplitude_waves=0.1, frames=5)
        (method, params, sent), = bench.calls
        self.assertEqual((method, params), ("calibration.set", {"shape": [2, 6, 2], "modes": [3, 4], "amplitude_waves": 0.1, "frames": 5}))
        due = per_actuator @ shapes.T
        due[2:4] = 0.0
        np.testing.assert_allclose(sent[0], due, atol=1e-4)
        np.testing.assert_allclose(sent[1, [0, 1, 4, 5]], 0.1 / np.sqrt(2.0), rtol=1e-5)


class Loop(unittest.TestCase):
    def setUp(self):
        self.moved = []

    def loop(self, **more):
        return MirrorLoop(self.moved.append, 2, **({"gain": 0.5} | more))

    def test_it_integrates_against_the_commands(self):
        loop = self.loop(leak=0.1)
        self.assertTrue(loop.step(commands([1.0, -2.0])))
        np.testing.assert_allclose(loop.position, [-0.5, 1.0])
        loop.step(commands([0.0, 0.0]))
        np.testing.assert_allclose(self.moved, [[-0.5, 1.0], [-0.45, 0.9]])
        self.assertEqual(loop.steps, 2)

    def test_what_is_not_valid_or_of_another_matrix_moves_nothing(self):
        loop = self.loop(matrix=7, start=[0.2, 0.3])
        self.assertFalse(loop.step(commands([], valid=False)))
        self.assertFalse(loop.step(commands([1.0, 1.0], matrix=8)))
        np.testing.assert_array_equal(loop.position, [0.2, 0.3])
        self.assertEqual((self.moved, loop.steps), ([], 0))
        self.assertTrue(loop.step(commands([0.2, 0.0])))
        np.testing.assert_allclose(loop.position, [0.1, 0.3])

    def test_at_the_limit_nothing_winds_up(self):
        loop = self.loop(limit=1.0)
        for _ in range(50):
            loop.step(commands([-1.0, 1.0]))
        np.testing.assert_array_equal(loop.position, [1.0, -1.0])
        loop.step(commands([0.4, -0.4]))
        np.testing.assert_allclose(loop.position, [0.8, -0.8], rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
