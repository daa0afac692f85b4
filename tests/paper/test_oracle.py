"""The fast LG tracker finds what the paper's contour method finds."""
import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import case


class Oracle(case.StudyCase):
    study = "oracle"
    figures = ("oracle",)

    def test_lg_agrees_with_the_contours_where_both_find_one(self):
        both, agree = self.summary["both_found"], self.summary["agree"]
        print(f"\n  {agree} of {both} within {self.summary['agree_px']} px; only lg {self.summary['only_lg']}, only lg_contour {self.summary['only_lg_contour']}")
        self.assertGreaterEqual(both, 0.9 * self.summary["spots"])
        self.assertGreaterEqual(agree, 0.999 * both - 1)

    def test_without_gnuplot_only_the_picture_is_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([case.OVWS, "study", "oracle", "--quick", "-o", folder], capture_output=True, text=True, timeout=280, env={"PATH": folder})
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn("gnuplot-nox", done.stderr)
            self.assertEqual(sorted(path.name for path in Path(folder).iterdir()), ["oracle.csv", "oracle.gnuplot", "summary.json"])
            self.assertEqual(json.loads((Path(folder) / "summary.json").read_text())["agree"], self.summary["agree"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
