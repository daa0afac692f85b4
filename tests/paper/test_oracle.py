"""The fast LG tracker finds what the paper's contour method finds."""
import unittest

import case


class Oracle(case.StudyCase):
    study = "oracle"
    figures = ("oracle",)

    def test_lg_agrees_with_the_contours_where_both_find_one(self):
        both, agree = self.summary["both_found"], self.summary["agree"]
        print(f"\n  {agree} of {both} within {self.summary['agree_px']} px; only lg {self.summary['only_lg']}, only lg_contour {self.summary['only_lg_contour']}")
        self.assertGreaterEqual(both, 0.9 * self.summary["spots"])
        self.assertGreaterEqual(agree, 0.999 * both - 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
