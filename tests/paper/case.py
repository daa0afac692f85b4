"""Base class of the study tests: runs `ovws study NAME --quick` and checks that its figures are there."""
import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

OVWS = Path(os.environ["OVWS_BUILD"]) / "bin" / "ovws"


class StudyCase(unittest.TestCase):
    study = ""
    figures = ()

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        done = subprocess.run([OVWS, "study", cls.study, "--quick", "-o", cls.folder.name], capture_output=True, text=True, timeout=280)
        assert done.returncode == 0, done.stdout + done.stderr
        assert done.stderr == "", done.stderr
        cls.summary = json.loads((Path(cls.folder.name) / "summary.json").read_text())

    def rows(self, **wanted):
        found = [row for row in self.summary["rows"] if all(row[key] == value for key, value in wanted.items())]
        self.assertTrue(found, wanted)
        return found

    def row(self, **wanted):
        (found,) = self.rows(**wanted)
        return found

    def test_the_figures_are_drawn(self):
        for name in self.figures:
            picture = (Path(self.folder.name) / (name + ".png")).read_bytes()
            self.assertTrue(picture.startswith(b"\x89PNG") and len(picture) > 5000, name)
            self.assertGreater(len((Path(self.folder.name) / (name + ".csv")).read_text().splitlines()), 4)
