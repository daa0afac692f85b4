"""Zernike modes of the client against ANSI Z80.28 (RMS-normalised), and its lattice."""
import unittest

import paths  # noqa: F401  the client's folder

import numpy as np

from ovws_client import orders, osa_index, phase_map_waves, pupil_grid, zernike
from ovws_client.zernike import MAX_J


class Zernike(unittest.TestCase):
    def test_first_modes_are_the_text_books(self):
        x, y = np.array([0.0, 0.3, -0.5]), np.array([0.2, 0.0, 0.4])
        square = x**2 + y**2
        known = {0: np.ones(3), 1: 2 * y, 2: 2 * x, 3: 2 * np.sqrt(6) * x * y, 4: np.sqrt(3) * (2 * square - 1),
                 5: np.sqrt(6) * (x**2 - y**2), 7: np.sqrt(8) * (3 * square - 2) * y, 8: np.sqrt(8) * (3 * square - 2) * x,
                 12: np.sqrt(5) * (6 * square**2 - 6 * square + 1)}
        for j, value in known.items():
            np.testing.assert_allclose(zernike(j, x, y), value, atol=1e-14, err_msg=f"j = {j}")

    def test_indices_go_both_ways(self):
        self.assertEqual([orders(j) for j in range(6)], [(0, 0), (1, -1), (1, 1), (2, -2), (2, 0), (2, 2)])
        self.assertEqual([osa_index(*orders(j)) for j in range(MAX_J + 1)], list(range(MAX_J + 1)))
        for wrong in (lambda: orders(-1), lambda: orders(MAX_J + 1), lambda: osa_index(2, 1), lambda: osa_index(2, 4)):
            self.assertRaises(ValueError, wrong)

    def test_rms_one_and_orthogonal_up_to_the_last(self):
        # Gauss-Legendre in r^2 and equidistant angles integrate these polynomials exactly.
        nodes, weights = np.polynomial.legendre.leggauss(24)
        radius, angle = np.meshgrid(np.sqrt(0.5 * (nodes + 1.0)), 2.0 * np.pi * np.arange(64) / 64)
        x, y, weight = (radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel(), np.tile(0.5 * weights / 64, 64)
        modes = np.array([zernike(j, x, y) for j in range(MAX_J + 1)])
        np.testing.assert_allclose((modes * weight) @ modes.T, np.eye(MAX_J + 1), atol=1e-8)

    def test_a_map_of_the_pupil(self):
        waves = phase_map_waves([2, 4], [0.1, 0.2], 9)
        x, y = pupil_grid(9)
        self.assertEqual((waves.shape, waves[4, 4]), ((9, 9), 0.1 * 0.0 - 0.2 * np.sqrt(3.0)))
        np.testing.assert_array_equal(np.isnan(waves), np.hypot(x, y) > 1.0)
        self.assertGreater(waves[4, 8], waves[4, 0], "x runs right along the columns")
        self.assertGreater(phase_map_waves([1], [0.1], 9)[8, 4], 0.0, "y runs down along the rows")
        with self.assertRaises(ValueError):
            phase_map_waves([1, 2], [0.1])


if __name__ == "__main__":
    unittest.main()
