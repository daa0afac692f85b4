"""Operator study: each better model of the slopes reduces the error of the modes."""
import unittest

import case


class Operators(case.StudyCase):
    study = "operators"
    figures = ("operators", "operators-noise-free", "operators-shack-hartmann", "operators-shack-hartmann-photons", "operators-shack-hartmann-noise-free")

    def mean_error(self, operator, **wanted):
        rows = self.rows(operator=operator, **wanted)
        self.assertEqual(sum(row["undetermined"] for row in rows), 0, rows)
        return sum(row["error_waves"] for row in rows) / len(rows)

    def test_without_noise_each_better_model_errs_less(self):
        errors = {name: self.mean_error(name, charge=1, noisy=False) for name in ("G-tilt", "tracker's own", "fit")}
        print("\n  0.3 wave of one mode, no noise: " + ", ".join(f"{name} {error:.5f}" for name, error in errors.items()))
        self.assertGreaterEqual(errors["G-tilt"], errors["tracker's own"])
        self.assertGreaterEqual(errors["tracker's own"], errors["fit"])
        self.assertLess(errors["fit"], 0.0002)
        for row in self.rows(operator="fit", noisy=False):
            self.assertLessEqual(row["error_waves"], 0.002, row)

    def test_fit_sits_at_the_bound_of_all_pixels(self):
        for row in self.rows(operator="fit", noisy=True):
            print(f"\n  charge {row['charge']}, {row['light']}, j {row['j']}: {row['error_waves']:.5f} wave, bound {row['bound_waves']:.5f}")
            self.assertLess(row["error_waves"], 1.7 * row["bound_waves"], row)


if __name__ == "__main__":
    unittest.main(verbosity=2)
