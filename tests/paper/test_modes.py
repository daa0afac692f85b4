"""Modes study: 19 vortices determine 44 modes by their shapes, near the bound of all pixels."""
import unittest

import case

# Bounds of an independent model of the whole sensor (numpy), error without tilts in waves, for a peak of 500 e and for 19 x 20,000 photons.
BOUNDS = {(1, 18): (0.0005, 0.0035), (1, 27): (0.0007, 0.0047), (1, 44): (0.0015, 0.0095), (0, 27): (0.0028, 0.0102), (0, 44): (0.0051, 0.0189)}
LIGHTS = ("equal peak", "equal photons")


class Modes(case.StudyCase):
    study = "modes"
    figures = ("modes-19", "modes-19-photons")

    def test_the_bound_is_that_of_an_independent_model(self):
        for (charge, modes), bounds in BOUNDS.items():
            for light, bound in zip(LIGHTS, bounds):
                row = self.row(charge=charge, modes=modes, light=light)
                self.assertAlmostEqual(row["bound_waves"], bound, delta=0.08 * bound + 0.00006, msg=str(row))

    def test_shapes_reach_the_bound(self):
        for modes, factor in ((18, 1.15), (27, 1.15), (35, 1.25), (44, 1.25)):
            for light in LIGHTS:
                row = self.row(charge=1, modes=modes, light=light)
                print(f"\n  {light}, {modes} modes: {row['shapes_waves']:.5f} wave, {row['shapes_waves'] / row['bound_waves']:.2f} of the bound")
                self.assertLess(row["shapes_waves"], factor * row["bound_waves"] + 3.0 * row["shapes_standard_error_waves"])
                self.assertLess(row["shapes_expected_waves"], factor * row["bound_waves"])

    def test_44_modes_of_19_vortices_at_20000_photons_each(self):
        self.assertLess(self.row(charge=1, modes=44, light="equal photons")["shapes_waves"], 0.012)

    def test_positions_do_not_determine_them(self):
        for charge in (0, 1):
            for light in LIGHTS:
                self.assertIsNone(self.row(charge=charge, modes=44, light=light)["positions_waves"])
                row = self.row(charge=charge, modes=27, light=light)
                self.assertGreater(row["positions_waves"], 10.0 * row["shapes_waves"])

    def test_which_sensor_wins_at_equal_photons_depends_on_the_number_of_modes(self):
        ratios = [self.row(charge=1, modes=m, light="equal photons")["shapes_waves"] / self.row(charge=0, modes=m, light="equal photons")["shapes_waves"]
                  for m in (18, 27, 44)]
        print("\n  vortex over bright spot at 18, 27, 44 modes: " + ", ".join(f"{ratio:.2f}" for ratio in ratios))
        self.assertGreater(ratios[0], 1.1)
        self.assertLess(ratios[1], 0.75)
        self.assertLess(ratios[2], 0.75)


if __name__ == "__main__":
    unittest.main(verbosity=2)
