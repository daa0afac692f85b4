"""Tracker study: every tracker against the Cramer-Rao bound."""
import unittest

import case


class Trackers(case.StudyCase):
    study = "trackers"
    figures = ("trackers", "trackers-photons")

    def test_fit_sits_at_the_bound(self):
        for method in ("vortex, fit", "Shack-Hartmann, fit"):
            for row in self.rows(method=method):
                print(f"\n  {row['light']}, {method}, SNR {row['snr']:.0f}: {row['factor']:.2f} times the bound")
                self.assertLess(row["rms_px"], 1.25 * row["bound_px"] + 2.0 * row["standard_error_px"])
                self.assertEqual(row["lost"], 0)

    def test_nothing_beats_the_bound(self):
        for row in self.summary["rows"]:
            if row["factor"] is not None and row["lost"] == 0:
                self.assertGreater(row["factor"], 0.85, row)


if __name__ == "__main__":
    unittest.main(verbosity=2)
