"""The paper's experiment on the twin: the ranking of the sensors, and that no result is lost.

The twin has 250 electrons in the brightest pixel of a charge-1 spot (975 for charge 0 with the same laser) and 30 electrons of
read noise, so the peak SNR is 7 and 22. At 16 dB the brightest spot fills three quarters of 8 bits; at 10 dB a vortex has 40 DN
with 2 DN of noise. Above 20 dB the bright spots saturate first, as on the paper's bench.
"""
import csv
import hashlib
import json
import re
import signal
import subprocess
import time

from case import PROGRAM_PATIENCE_S, TWIN, BenchCase, Client, main, wait_for

LIGHT = {"light": {"peak_electrons": 250}, "detector": {"read_noise_e": 30}}
SWEEP = {"gains_db": [10, 20, 40], "frames": 10, "reference_frames": 30,
         "aberrations": [{"modes": [{"n": 2, "m": -2, "waves": waves}], "norm": "unit"} for waves in (0.5, 2.0)], "picture_gains_db": [10]}
CELLS = 24  # of the sweep QUICK: margin for those that end before the camera is taken away
QUICK = {**SWEEP, "gains_db": [10, 16, 22, 28, 34, 40], "arms": [{"charge": 1, "tracker": "lg"}, {"charge": 0, "tracker": "cell_centroid"}]}


class Experiment(BenchCase):
    twin_config = LIGHT
    daemon_config = {"state": {"directory": "state"}, "stream": {"image_rate_hz": 0}, "camera": {"gain_db": 3.0}}

    def setUp(self):
        super().setUp()
        self.folder = self.bench.directory / "out"
        self.twin = Client(TWIN)
        self.addCleanup(self.twin.close)

    def study(self, params, *more):
        return subprocess.Popen(self.ovws_command("study", "experiment", "-o", self.folder, "--params", json.dumps(params), *more),
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def everything(self):
        sensor = {key: value for key, value in self.call("sensor.get").items() if key != "hologram_id"}
        return (self.call("camera.get")["settings"], sensor, self.call("aberration.get")["modes"], self.call("reference.get"),
                self.call("correction.get")["modes"])

    def cells_done(self):
        return self.call("experiment.get")["cells_done"]

    def hold_after(self, cells):
        """Lets the sweep finish this many cells at least, then takes its camera away, so that it cannot reach its end. `release` gives it back."""
        wait_for(lambda: self.cells_done() >= cells, what=f"{cells} cells")
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 600.0})
        wait_for(lambda: not self.call("system.status")["camera"]["connected"], what="a lost camera")
        self.assertFalse(self.call("experiment.get")["complete"])

    def release(self):
        self.twin.call("twin.fault", {"kind": "none"})

    def kept_cells(self):
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in (self.bench.directory / "state").glob("experiment-*.cell-*") if path.suffix != ".ovws-tmp"}

    def test_the_order_of_the_sensors_and_everything_put_back(self):
        twin = json.loads(json.dumps(LIGHT))
        print(f"\n  twin: {twin}")
        self.take_reference(20)
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.05}]})
        before = self.everything()
        study = self.study(SWEEP)
        output, _ = study.communicate(timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(study.returncode, 0, output)
        print(re.sub(r".*\r", "", output))
        self.assertEqual(self.everything(), before)
        with open(self.folder / "cells.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 2 * 3 * 4)
        variance = {(row["aberration"], row["gain_db"], row["charge"], row["tracker"]): row for row in rows}
        for aberration in "01":
            for gain in ("10.0", "20.0", "40.0"):
                with self.subTest(aberration=aberration, gain=gain):
                    lg, fit, cell, bright = (variance[aberration, gain, *arm]
                                             for arm in (("1", "lg"), ("1", "fit"), ("0", "cell_centroid"), ("0", "fit")))
                    self.assertEqual((lg["undetermined_frames"], cell["undetermined_frames"]), ("0", "0"))
                    self.assertLess(float(lg["variance_rad2"]), 0.1 * float(cell["variance_rad2"]))
                    self.assertLess(float(fit["variance_rad2"]), float(lg["variance_rad2"]))
                    self.assertEqual(bright["undetermined_frames"], "0")  # at 40 dB the light is ten times the full scale
                    self.assertLess(float(bright["variance_rad2"]), float(lg["variance_rad2"]))
                    # 1/20 wave RMS for every wavefront.
                    self.assertLess(float(lg["variance_rad2"]), 0.1)
        self.assertEqual(variance["0", "10.0", "1", "lg"]["saturated_frames"], "0")
        self.assertEqual(variance["0", "40.0", "0", "cell_centroid"]["saturated_frames"], "10")
        with open(self.folder / "frames.csv", encoding="utf-8") as file:
            self.assertEqual(len(list(csv.DictReader(file))), len(rows) * SWEEP["frames"])
        for name in ("experiment-variance-1.png", "experiment-variance-2.png", "experiment-residual.png", "experiment-images-charge-0.png",
                     "experiment-images-charge-1.png", "table.txt"):
            self.assertGreater((self.folder / name).stat().st_size, 500, name)
        summary = json.loads((self.folder / "summary.json").read_text())
        self.assertEqual((summary["cells_done"], summary["comparisons"][1]["lower"], summary["comparisons"][1]["cells"]), (24, 6, 6))
        self.check_what_is_refused()

    def check_what_is_refused(self):
        refused = self.refused("experiment.gain_sweep", {"gains_db": [10, 60]})
        self.assertEqual((refused.data["field"], refused.data["min"], refused.data["max"]), ("gains_db", 0.0, 48.0))
        job = self.call("experiment.gain_sweep", {**QUICK, "gains_db": [10, 60], "clamp": True})["job"]
        wait_for(lambda: (got := self.call("experiment.get"))["known"] and got["request"]["gains_db"] == [10])
        self.call("job.cancel", {"job": job})
        self.call("camera.set", {"exposure_us": 8000.0})  # saturates the reference
        job = self.call("experiment.gain_sweep", QUICK)["job"]
        ended = self.job_ended(job)
        self.assertEqual((ended["state"], ended["error"]["data"]["field"]), ("failed", "camera.exposure_us"))
        self.assertEqual(self.call("camera.get")["settings"]["gain_db"], 3.0)
        findings = {path.name: path.read_bytes() for path in self.folder.iterdir()}
        study = self.study(QUICK)
        output, _ = study.communicate(timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(study.returncode, 1, output)
        self.assertIn("saturated", output)
        self.assertEqual({path.name: path.read_bytes() for path in self.folder.iterdir()}, findings)

    def test_nothing_is_lost(self):
        before = self.everything()
        others = self.leave_another_run_in_the_folder()
        study = self.study(QUICK)
        self.addCleanup(study.stdout.close)
        wait_for(lambda: self.cells_done() >= 2, what="two cells")
        study.send_signal(signal.SIGINT)
        output, _ = study.communicate(timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(study.returncode, 1, output)
        self.assertIn("repeat the command to continue", output)
        self.assertEqual({path.name for path in self.folder.iterdir()}, {"cells.csv", "frames.csv", *others})
        self.assertNotIn("of another run", (self.folder / "cells.csv").read_text() + (self.folder / "frames.csv").read_text())
        self.assertEqual(self.everything(), before)
        after_cancel = self.kept_cells()
        self.assertGreaterEqual(len(after_cancel), 2)
        job = self.call("experiment.gain_sweep", QUICK)["job"]
        self.assertEqual(self.call("experiment.gain_sweep", QUICK)["job"], job)  # joins the running job
        self.hold_after(len(after_cancel) + 1)
        self.bench.process("ovwsd").popen.send_signal(signal.SIGKILL)
        self.bench.stop("ovwsd")
        killed = self.kept_cells()
        self.assertGreater(len(killed), len(after_cancel))
        self.assertLess(len(killed), CELLS)
        self.release()
        self.client.close()
        self.start_daemon()
        self.wait_until("running")
        found = self.call("experiment.get")
        self.assertEqual((found["cells_done"], found["complete"]), (len(killed), False))
        replies = {cell["cell"]: self.call("experiment.cell", {"cell": cell["cell"]}) for cell in found["cells"]}
        study = self.study(QUICK)
        self.addCleanup(study.stdout.close)
        self.hold_after(len(killed) + 1)
        self.assertEqual(self.call("job.get", {"job": self.call("experiment.get")["job"]})["state"], "running")
        self.release()  # the sweep continues when the camera returns
        output, _ = study.communicate(timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(study.returncode, 0, output)
        self.wait_until("running")
        kept = self.kept_cells()
        print(f"\n  {len(after_cancel)} cells at the cancel, {len(killed)} at the kill, {len(kept)} at the end")
        self.assertEqual(len(kept), CELLS)
        for name, digest in {**after_cancel, **killed}.items():
            self.assertEqual(kept[name], digest, name)
        for number, reply in replies.items():
            self.assertEqual(self.call("experiment.cell", {"cell": number}), reply)
        self.assertEqual(self.everything(), before)
        written = {name: (self.folder / name).read_bytes() for name in ("cells.csv", "frames.csv")}
        begun = time.monotonic()  # complete: it ends at once
        study = self.study(QUICK)
        output, _ = study.communicate(timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(study.returncode, 0, output)
        self.assertEqual(self.kept_cells(), kept)
        self.assertEqual({name: (self.folder / name).read_bytes() for name in written}, written)
        print(f"  all of it again in {time.monotonic() - begun:.1f} s")

    def leave_another_run_in_the_folder(self):
        """Writes files of an earlier run, and unrelated files; returns the names of the latter."""
        others = ("experiment-notes.txt", "experiment-variance-2.csv", "localisation.png", "localisation.gnuplot")
        self.folder.mkdir()
        for name in (*others, "cells.csv", "frames.csv", "table.txt", "summary.json", "experiment-residual.png", "experiment-images-charge--1.png",
                     "experiment-variance-16.csv", "experiment-variance-16.gnuplot", "experiment-variance-16.png"):
            (self.folder / name).write_text("of another run")
        return others

    def moved_by(self, twin, change):
        """Mean displacement of the twin's true spots by this change, pixels."""
        def places():
            return [(spot["x"], spot["y"]) for spot in twin.call("twin.get")["spots"]]
        before = places()
        twin.call("twin.set", change)
        moved = [(x - x0, y - y0) for (x, y), (x0, y0) in zip(places(), before, strict=True)]
        return [sum(axis) / len(moved) for axis in zip(*moved, strict=True)]

    def test_what_moved_meanwhile_is_seen(self):
        before = self.everything()
        job = self.call("experiment.gain_sweep", QUICK)["job"]
        wait_for(lambda: self.cells_done() >= 2, what="two cells")
        self.call("job.cancel", {"job": job})
        self.job_ended(job)
        kept = self.kept_cells()
        twin = self.twin
        x, y = twin.call("twin.get")["geometry"]["centre_px"]
        there = {"geometry": {"centre_px": [x, y]}, "aberration": []}
        moves = ({"geometry": {"centre_px": [x + 1.0, y]}}, {"aberration": [{"n": 1, "m": -1, "waves": 0.2}]},
                 {"geometry": {"rotation_deg": 0.6}})  # rotation about the base spot: small mean displacement
        for move in moves:
            with self.subTest(move):
                truth = self.moved_by(twin, move)
                ended = self.job_ended(self.call("experiment.gain_sweep", QUICK)["job"])
                self.assertEqual((ended["state"], ended["error"]["data"]["field"]), ("failed", "anew"), ended)
                message = ended["error"]["message"]
                figures = re.search(r"subaperture \d+ by ([\d.]+) px, all spots by \(([-+\d.]+), ([-+\d.]+)\) px on average, and ([\d.]+) px", message)
                self.assertIsNotNone(figures, message)
                largest, *mean, limit = map(float, figures.groups())
                print(f"\n  {move}: truth ({truth[0]:+.2f}, {truth[1]:+.2f}) px; {message}")
                for axis in (0, 1):
                    self.assertAlmostEqual(mean[axis], truth[axis], delta=0.1)
                self.assertGreater(largest, limit)
                self.assertEqual(self.kept_cells(), kept)
                self.assertEqual(self.cells_done(), len(kept))
                self.assertEqual(self.everything(), before)
                twin.call("twin.set", {**there, "geometry": {**there["geometry"], "rotation_deg": 0}})
        study = self.study_of_a_moved_bench(twin, moves[0])
        self.assertIn('"anew": true', study)
        self.assertNotIn("repeat the command to continue", study)
        twin.call("twin.set", {"geometry": {"centre_px": [x + 0.2, y]}})  # below the limit
        ended = self.job_ended(self.call("experiment.gain_sweep", QUICK)["job"])
        self.assertEqual(ended["state"], "done", ended)
        after = self.kept_cells()
        self.assertEqual(len(after), CELLS)
        self.assertEqual({name: after[name] for name in kept}, kept)

    def study_of_a_moved_bench(self, twin, move):
        twin.call("twin.set", move)
        study = self.study(QUICK)
        output, _ = study.communicate(timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(study.returncode, 1, output)
        return output


if __name__ == "__main__":
    main()
