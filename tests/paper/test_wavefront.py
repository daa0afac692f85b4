"""Wavefront study: the paper's figure of residual phase variance against SNR, with `fit`."""
import unittest

import case


class Wavefront(case.StudyCase):
    study = "wavefront"
    figures = ("wavefront-astigmatism", "wavefront-defocus", "wavefront-astigmatism-photons", "wavefront-defocus-photons")

    def variances(self, aberration, snr, undetermined=0):
        """Residual variance of each method that left at most `undetermined` of 30 images without an estimate."""
        rows = self.rows(light="equal peak", aberration=aberration, snr=snr)
        return {row["method"]: (row["variance_rad2"], row["standard_error_rad2"]) for row in rows if row["undetermined"] <= undetermined}

    def test_the_vortex_beats_the_text_book_sensor_at_every_snr(self):
        for aberration in ("astigmatism", "defocus"):
            for snr in (2.0, 5.0, 22.0):
                found = self.variances(aberration, snr, undetermined=2 if snr == 2.0 else 0)  # there `lg` loses too many spots now and then
                print(f"\n  {aberration}, SNR {snr:.0f}: " + ", ".join(f"{name} {value:.2g}" for name, (value, _) in found.items()))
                self.assertLess(found["vortex, lg"][0], found["Shack-Hartmann, centroid of a fixed cell"][0])

    def test_fitted_vortices_leave_less_than_half_of_the_best_tracker_of_bright_spots(self):
        for aberration in ("astigmatism", "defocus"):
            found = self.variances(aberration, 5.0)
            best = min(value for name, (value, _) in found.items() if name.startswith("Shack"))
            vortex, _ = found["vortex, fit"]
            print(f"\n  {aberration}, SNR 5, fit: {vortex / best:.2f} of the best Shack-Hartmann tracker's variance")
            self.assertLess(vortex, 0.5 * best, aberration)


if __name__ == "__main__":
    unittest.main(verbosity=2)
