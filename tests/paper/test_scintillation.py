"""The study of scintillation: the light's statistics, and what the number of subapertures costs."""
import unittest

import case


class Scintillation(case.StudyCase):
    study = "scintillation"
    figures = ("scintillation-bright", "scintillation-dim")

    def left(self, method, subapertures, rytov, bright=True):
        light = max(row["light_e"] for row in self.summary["rows"]) if bright else min(row["light_e"] for row in self.summary["rows"])
        return self.row(method=method, subapertures=subapertures, rytov_variance=rytov, light_e=light)

    def test_the_light_is_as_theory_says(self):
        index = {row["rytov_variance"]: row["scintillation_index"] for row in self.summary["rows"]}
        print(f"\n  scintillation index {index}")
        self.assertLess(index[0.0], 1e-6)
        self.assertAlmostEqual(index[0.1], 0.1, delta=0.04)  # weak: the Rytov variance
        self.assertTrue(0.4 < index[1.0] < 1.1, index)

    def test_without_scintillation_a_fine_lattice_leaves_least(self):
        for method in ("bright, lg", "vortex, lg"):
            coarse, fine = (self.left(method, count, 0.0) for count in (21, 113))
            print(f"\n  {method}: {coarse['residual_rad2']:.2f} rad^2 with 21, {fine['residual_rad2']:.2f} with 113")
            self.assertLess(fine["residual_rad2"], 0.6 * coarse["residual_rad2"])

    def test_fixed_cells_want_a_coarser_lattice_when_light_scintillates(self):
        weak, strong = (self.left("bright, centroid of a fixed cell", 29, rytov)["below_finest"] for rytov in (0.0, 1.0))
        print(f"\n  29 below 113: {weak:+.2f} without, {strong:+.2f} with scintillation")
        self.assertLess(weak, 0.0)
        self.assertGreater(strong, weak + 0.2)

    def test_vortices_are_lost_first(self):
        bright, vortex = (self.left(method, 29, 1.0)["lost_fraction"] for method in ("bright, lg", "vortex, lg"))
        self.assertGreater(vortex, bright + 0.05)


if __name__ == "__main__":
    unittest.main(verbosity=2)
