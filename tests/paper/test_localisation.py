"""Localisation study: the paper's figure of the precision at equal peak, and at equal photons."""
import unittest

import case


class Localisation(case.StudyCase):
    study = "localisation"
    figures = ("localisation", "localisation-photons", "localisation-clouds")

    def test_vortex_and_lg_beat_bright_spot_and_centroid_at_every_level(self):
        for vortex in self.rows(light="equal peak", method="vortex, lg"):
            bright = self.row(light="equal peak", method="Shack-Hartmann, centroid", read_noise_e=vortex["read_noise_e"])
            print(f"\n  read noise {vortex['read_noise_e']:.0f} e: vortex {vortex['rms_px']:.3f} px, centroid {bright['rms_px']:.3f} px")
            self.assertLess(vortex["rms_px"], bright["rms_px"])

    def test_fit_on_the_vortex_is_the_best_at_equal_peak(self):
        for vortex in self.rows(light="equal peak", method="vortex, fit"):
            self.assertEqual(vortex["lost"], 0)
            for other in self.rows(light="equal peak", read_noise_e=vortex["read_noise_e"]):
                if other["method"] != vortex["method"]:
                    self.assertLess(vortex["rms_px"], other["rms_px"], other["method"])

    def test_the_bright_spot_wins_at_equal_photons_in_read_noise(self):
        vortex = self.row(light="equal photons", method="vortex, fit", read_noise_e=85.0)
        self.assertGreater(vortex["rms_px"], self.row(light="equal photons", method="Shack-Hartmann, fit", read_noise_e=85.0)["rms_px"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
