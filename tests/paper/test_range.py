"""Range study: the largest aberration that is acquired without history, and what limits it."""
import unittest

import case

REASONS = {"nothing", "sampling of the SLM", "spots leaving the image", "spots crossing", "wrong spots", "refused spots"}


class Range(case.StudyCase):
    study = "range"
    figures = ("range", "range-photons")

    def test_the_vortex_is_found_under_two_waves_of_defocus_and_astigmatism(self):
        for j in (3, 4):
            for row in [row for method in ("vortex, lg", "vortex, fit") for row in self.rows(light="equal peak", method=method, j=j)]:
                print(f"\n  {row['method']}, {row['name']}, {row['sign']:+}: {row['unit_waves']:.2f} waves unit amplitude ({row['waves']:.2f} RMS), limited by {row['limited_by']}")
                self.assertGreaterEqual(row["unit_waves"], 2.0, row)

    def test_both_intensities_and_charges_are_reported_with_their_limit(self):
        for light in ("equal peak", "equal photons"):
            for method in ("vortex, lg", "vortex, fit", "Shack-Hartmann, thresholded", "Shack-Hartmann, fit"):
                for row in self.rows(light=light, method=method):
                    self.assertIn(row["limited_by"], REASONS)
                    self.assertEqual(row["limited_by"] == "nothing", row["waves"] >= self.summary["most_waves"] - 1e-9, row)


if __name__ == "__main__":
    unittest.main(verbosity=2)
