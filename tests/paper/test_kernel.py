"""The LG kernel's radius: the default one is a good one, on vortices and on bright spots."""
import unittest

import case

DEFAULT_RADIUS = 0.3


class Kernel(case.StudyCase):
    study = "kernel"
    figures = ("kernel", "kernel-photons")

    def test_the_best_radius_is_no_end_of_the_scale_on_a_vortex(self):
        for best in self.summary["best"]:
            if best["charge"] == 1:
                print(f"\n  SNR {best['snr']:.0f}: best radius {best['radius']} lambda/d, {best['rms_px']:.4f} px, bound {best['bound_px']:.4f} px")
                self.assertTrue(0.2 <= best["radius"] <= 0.4, best)

    def test_the_default_is_near_the_best_on_a_vortex(self):
        for snr in (2.0, 5.0, 22.0):
            (best,) = (b for b in self.summary["best"] if b["charge"] == 1 and b["light"] == "equal peak" and b["snr"] == snr)
            default = self.row(light="equal peak", charge=1, snr=snr, radius=DEFAULT_RADIUS)
            print(f"\n  SNR {snr:.0f}: default {default['rms_px'] / best['rms_px']:.3f} of the best")
            self.assertLess(default["rms_px"], 1.1 * best["rms_px"])

    def test_no_kernel_beats_the_bound(self):
        for row in self.summary["rows"]:
            if row["lost"] == 0:
                self.assertGreater(row["rms_px"] + 2.0 * row["standard_error_px"], row["bound_px"], row)

    def test_more_photons_make_the_bright_spot_better(self):
        for poor in self.rows(light="equal peak", charge=0):
            rich = self.row(light="equal photons", charge=0, snr=poor["snr"], radius=poor["radius"])
            if poor["lost"] == rich["lost"] == 0:
                self.assertLess(rich["rms_px"], poor["rms_px"], rich)


if __name__ == "__main__":
    unittest.main(verbosity=2)
