"""Oracle study: the fast LG tracker agrees with the paper's contour method."""
import itertools
import json
import os
import pty
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
            self.assertEqual(sorted(path.name for path in Path(folder).iterdir()), ["oracle.csv", "oracle.gnuplot", "provenance.json", "summary.json"])
            self.assertEqual(json.loads((Path(folder) / "summary.json").read_text())["agree"], self.summary["agree"])

    def test_a_terminal_shows_the_progress_and_a_used_folder_is_cleared(self):
        with tempfile.TemporaryDirectory() as folder:
            own = [Path(folder) / name for name in ("oracle-old.png", "oracle-old.csv", "oracle-old.gnuplot", "summary.json")]
            others = [Path(folder) / name for name in ("oracle-notes.csv", "oracles.png", "kernel.gnuplot", "kernel.png", "cells.csv")]
            for path in (*own, *others):
                path.write_text("of before")
            terminal, stderr = pty.openpty()
            study = subprocess.Popen([case.OVWS, "study", "oracle", "--quick", "-o", folder], stdout=subprocess.DEVNULL, stderr=stderr)
            self.addCleanup(study.wait)
            self.addCleanup(study.kill)
            os.close(stderr)
            shown = ""
            while part := self.read(terminal):
                shown += part
            os.close(terminal)
            self.assertEqual(study.wait(60), 0, shown)
            for earlier, later in itertools.pairwise(("oracle: preparing", "] 0/", "s left", "oracle: drawing")):
                self.assertLess(shown.index(earlier), shown.index(later), (earlier, later))
            for path in others:
                self.assertEqual(path.read_text(), "of before", path)
            self.assertEqual({path.name for path in Path(folder).iterdir()} - {path.name for path in others},
                             {"oracle.csv", "oracle.gnuplot", "oracle.png", "provenance.json", "summary.json"})
            self.assertIn("agree", (Path(folder) / "summary.json").read_text())

    @staticmethod
    def read(terminal):
        try:
            return os.read(terminal, 4096).decode()
        except OSError:  # end of file of a terminal on Linux
            return ""


if __name__ == "__main__":
    unittest.main(verbosity=2)
