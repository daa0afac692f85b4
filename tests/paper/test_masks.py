"""Masks study: which phase mask in every subaperture is best depends on the light and on the number of modes."""
import unittest

import case


class Masks(case.StudyCase):
    study = "masks"
    figures = ("masks-18", "masks-27", "masks-44", "masks-18-photons", "masks-27-photons", "masks-44-photons")

    def expected(self, mask, strength, light, modes):
        return self.row(mask=mask, strength_waves=strength, light=light, modes=modes)["shapes_expected_waves"]

    def test_without_a_mask_the_errors_are_those_of_the_study_modes(self):
        for mask, modes, bound in (("vortex, defocus", 44, 0.0015), ("vortex, defocus", 27, 0.0007), ("bright, defocus", 27, 0.0028), ("bright, defocus", 44, 0.0051)):
            row = self.row(mask=mask, strength_waves=0.0, light="equal peak", modes=modes)
            self.assertAlmostEqual(row["bound_waves"], bound, delta=0.08 * bound + 0.00006, msg=str(row))

    def test_templates_reach_the_bound_of_weak_masks(self):
        for row in self.rows(light="equal peak", modes=44):
            self.assertGreater(row["shapes_expected_waves"], 0.98 * row["bound_waves"], row)
            self.assertLess(row["shapes_expected_waves"], 1.25 * row["bound_waves"], row)

    def test_at_equal_peak_masks_measure_44_modes_with_less_error_than_a_vortex(self):
        vortex = self.expected("vortex, defocus", 0.0, "equal peak", 44)
        defocused = self.expected("vortex, defocus", 0.15, "equal peak", 44)
        astigmatic = self.expected("bright, astigmatism", 0.3, "equal peak", 44)
        print(f"\n  44 modes: vortex {vortex:.5f}, with defocus {defocused:.5f}, astigmatic bright spot {astigmatic:.5f} wave")
        self.assertLess(defocused, 0.8 * vortex)
        self.assertLess(astigmatic, 0.75 * vortex)

    def test_at_equal_photons_no_mask_is_better_than_the_bare_charge(self):
        for modes, bare in ((18, "bright, defocus"), (27, "vortex, defocus"), (44, "vortex, defocus")):
            least = min(row["shapes_expected_waves"] for row in self.rows(light="equal photons", modes=modes))
            self.assertLess(self.expected(bare, 0.0, "equal photons", modes), 1.03 * least)

    def test_alternating_signs_change_nothing(self):
        for light in ("equal peak", "equal photons"):
            ratio = self.expected("charges 1 and -1, astigmatism", 0.0, light, 44) / self.expected("vortex, astigmatism", 0.0, light, 44)
            self.assertLess(abs(ratio - 1.0), 0.05)


if __name__ == "__main__":
    unittest.main(verbosity=2)
