"""The paper's figure of localisation precision, at equal peak."""
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

    def test_matched_is_the_best_on_either(self):
        for light in ("equal peak", "equal photons"):
            for noise_e in {row["read_noise_e"] for row in self.rows(light=light)}:
                vortex = self.row(light=light, method="vortex, matched", read_noise_e=noise_e)
                self.assertLess(vortex["rms_px"], self.row(light=light, method="vortex, lg", read_noise_e=noise_e)["rms_px"])
                self.assertEqual(vortex["lost"], 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
