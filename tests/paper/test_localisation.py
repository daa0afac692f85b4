"""Localisation study: the paper's figure of the precision at equal peak, and at equal photons."""
import itertools
import json
import os
import pty
import subprocess
import tempfile
import unittest
from pathlib import Path

import case


class Localisation(case.StudyCase):
    study = "localisation"
    figures = ("localisation", "localisation-photons", "localisation-clouds")

    def test_vortex_and_lg_beat_bright_spot_and_centroid_at_every_level(self):
        for vortex in self.rows(light="equal peak", method="vortex, lg"):
            bright = self.row(light="equal peak", method="Shack-Hartmann, centroid", read_noise_e=vortex["read_noise_e"])
            print(f"\n  read noise {vortex['read_noise_e']:.0f} e: vortex {vortex['rms_px']:.3f} px, centroid {bright['rms_px']:.3f} px")
            self.assertLess(vortex["rms_px"], bright["rms_px"])

    def test_fit_on_the_vortex_is_the_best_at_equal_peak(self):
        for vortex in self.rows(light="equal peak", method="vortex, fit"):
            self.assertEqual(vortex["lost"], 0)
            for other in self.rows(light="equal peak", read_noise_e=vortex["read_noise_e"]):
                if other["method"] != vortex["method"]:
                    self.assertLess(vortex["rms_px"], other["rms_px"], other["method"])

    def test_the_bright_spot_wins_at_equal_photons_in_read_noise(self):
        vortex = self.row(light="equal photons", method="vortex, fit", read_noise_e=85.0)
        self.assertGreater(vortex["rms_px"], self.row(light="equal photons", method="Shack-Hartmann, fit", read_noise_e=85.0)["rms_px"])

    def test_without_gnuplot_only_the_picture_is_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([case.OVWS, "study", "localisation", "--quick", "-o", folder], capture_output=True, text=True, timeout=280, env={"PATH": folder})
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn("gnuplot-nox", done.stderr)
            self.assertEqual({path.name for path in Path(folder).iterdir()}, {"provenance.json", "summary.json"} | self.files("csv", "gnuplot"))
            self.assertEqual(json.loads((Path(folder) / "summary.json").read_text())["rows"], self.summary["rows"])

    def test_a_terminal_shows_the_progress_and_a_used_folder_is_cleared(self):
        with tempfile.TemporaryDirectory() as folder:
            own = [Path(folder) / name for name in ("localisation-old.png", "localisation-old.csv", "localisation-old.gnuplot", "summary.json")]
            others = [Path(folder) / name for name in ("localisation-notes.csv", "localisations.png", "kernel.gnuplot", "kernel.png", "cells.csv")]
            for path in (*own, *others):
                path.write_text("of an earlier run")
            terminal, stderr = pty.openpty()
            study = subprocess.Popen([case.OVWS, "study", "localisation", "--quick", "-o", folder], stdout=subprocess.DEVNULL, stderr=stderr)
            self.addCleanup(study.wait)
            self.addCleanup(study.kill)
            os.close(stderr)
            shown = ""
            while part := self.read(terminal):
                shown += part
            os.close(terminal)
            self.assertEqual(study.wait(60), 0, shown)
            for earlier, later in itertools.pairwise(("localisation: preparing", "] 0/", "s left", "localisation: drawing")):
                self.assertLess(shown.index(earlier), shown.index(later), (earlier, later))
            for path in others:
                self.assertEqual(path.read_text(), "of an earlier run", path)
            self.assertEqual({path.name for path in Path(folder).iterdir()} - {path.name for path in others},
                             {"provenance.json", "summary.json"} | self.files("csv", "gnuplot", "png"))
            self.assertIn("rows", (Path(folder) / "summary.json").read_text())

    def files(self, *endings):
        return {f"{name}.{ending}" for name in self.figures for ending in endings}

    @staticmethod
    def read(terminal):
        try:
            return os.read(terminal, 4096).decode()
        except OSError:  # end of file of a terminal on Linux
            return ""


if __name__ == "__main__":
    unittest.main(verbosity=2)
