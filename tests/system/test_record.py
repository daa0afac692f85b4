"""Recordings contain what was published, whatever ends the recording.

    OVWS_RECORD_KILLS=50   number of times to kill the daemon while it records
"""
import contextlib
import hashlib
import json
import os
import random
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy
from case import PATIENCE_S, PROGRAM_PATIENCE_S, ROOT, BenchCase, main, message_since, own_mounts, wait_for
from ovws_client.recording import Recording

KILLS = int(os.environ.get("OVWS_RECORD_KILLS", "3"))


class RecordCase(BenchCase):
    daemon_config = {"camera": {"frame_rate_hz": 100}, "record": {"directory": "recordings"}}
    twin_config = {"noise": "pool"}

    def record(self, name, frames, **more):
        self.call("record.start", {"name": name} | more)
        self.recorded_frames(frames)
        return self.call("record.stop")

    def open(self, name):
        recording = Recording(self.bench.directory / "recordings" / f"{name}.h5")
        self.addCleanup(recording.close)
        return recording

    def check_whole(self, recording):
        """Checks that everything referenced by a row exists, and that documents match their checksums."""
        frames = recording.frames
        self.assertTrue((numpy.diff(frames["frame_id"].astype(int)) - 1 == frames["gap"][1:] + frames["dropped_before"][1:]).all())
        self.assertTrue((frames["picture"] < len(recording.file["pictures"])).all())
        for name in ("spots", "coefficients", "sigma_waves", "time"):
            self.assertGreaterEqual(len(recording.file[name]), len(frames))
        self.assertEqual(list(frames["first_spot"]), list(range(len(frames))))
        for row in recording.file["documents"][:]:
            text = recording._text(row)
            self.assertEqual(hashlib.sha256(text).hexdigest().encode(), row["sha256"])
            json.loads(text)
        for plan_id in numpy.unique(frames["plan_id"]):
            self.assertEqual(recording.plan(int(numpy.argmax(frames["plan_id"] == plan_id)))["plan_id"], plan_id)


class Record(RecordCase):
    def resident_mib(self):
        return int(Path(f"/proc/{self.bench.process('ovwsd').pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

    def test_references_of_the_past_take_no_memory(self):
        """Each would take 1 MB if its image were kept for a recording that no longer needs it."""
        stream = self.stream("wavefront")
        for recording in (False, True):
            if recording:
                self.call("record.start", {"name": "references", "pictures_every": 0})
            self.grown_mib_by(stream, 12)
            self.assertLess(self.grown_mib_by(stream, 40), 15.0, f"recording: {recording}")

    def grown_mib_by(self, stream, references):
        before_mib = self.resident_mib()
        for _ in range(references):
            self.take_reference(10)
        message_since(stream, time.time_ns())
        self.fitted_frames(stream, 5, 300.0)  # the templates' model takes memory, too, and a background thread makes it
        begin = now = self.call("record.get")
        while now["state"] == "recording" and now["frames"] - begin["frames"] <= 50:  # until more frames than a reference takes come without documents
            time.sleep(0.05)
            now = self.call("record.get")
            begin = now if now["bytes"] - begin["bytes"] > 500_000 else begin
        return self.resident_mib() - before_mib

    def test_what_was_published_is_in_the_file(self):
        self.take_reference(20)
        numbers = self.stream("wavefront")
        pictures = self.stream("image", endpoint="tcp://127.0.0.1:7703")
        self.settled_frames(numbers, 1)
        self.call("record.start", {"name": "run"})
        for stream in (numbers, pictures):
            stream.drain()  # what is from before the start
        published = {m["frame_id"]: m for m in self.settled_frames(numbers, 150)}
        shown = {}
        while len(shown) < 15:
            message = pictures.next(PATIENCE_S)
            shown[message["frame_id"]] = message["binary"]
        report = self.call("record.stop")
        self.assertEqual((report["state"], report["reason"]), ("ended", "stopped by record.stop"))
        run = self.open("run")
        self.check_whole(run)
        dropped, missing = report["frames_dropped"], report["pictures_dropped"]  # of a busy machine
        self.assertLessEqual(run.frames["dropped_before"].sum(), dropped)
        self.assertEqual((run.frames["picture"] < 0).sum(), missing)
        self.assertEqual(run.summary | {"t_written_ns": 0}, {"frames": len(run.frames), "frames_dropped": dropped, "pictures": len(run.frames) - missing,
                                                            "pictures_dropped": missing, "documents_dropped": 0, "t_written_ns": 0, "ended": 1})
        ids = list(run.frames["frame_id"])
        coefficients, sigma_waves = run.coefficients(), run.sigma_waves()
        compared = 0
        for frame_id, message in published.items():
            if frame_id not in ids:
                continue  # before the first or after the last recorded frame, or dropped
            row = ids.index(frame_id)
            self.assertEqual([numpy.float32(c) for c in message["coefficients"]], list(coefficients[row]))
            if message["valid"]:
                sigma = numpy.array([numpy.nan if s is None else s for s in message["sigma"]], numpy.float32)
                self.assertTrue(numpy.array_equal(sigma, sigma_waves[row], equal_nan=True))
            self.assertEqual(int(run.frames["t_arrival_ns"][row]), message["t_arrival_ns"])
            self.assertEqual(run.frames["gain_db"][row], message["gain_db"])
            compared += 1
        self.assertGreater(compared + dropped, 100)
        held = [frame_id for frame_id in shown if frame_id in ids and run.picture(ids.index(frame_id)) is not None]
        self.assertTrue(held)
        for frame_id in held:
            self.assertEqual(run.picture(ids.index(frame_id)).tobytes(), bytes(shown[frame_id]))
        self.assertEqual(run.modes(0), next(iter(published.values()))["j"])
        self.assertEqual(run.plan(0)["reference_px"], self.call("reference.get")["positions_px"])
        self.assertEqual(next(run.documents("configuration")), self.call("config.get"))
        self.assertEqual(run.file["frames"].attrs["unit.exposure_us"], "us")
        self.assertEqual((run.file.attrs["schema"], run.file.attrs["pixel_format"]), ("ovws.recording/2", "Mono8"))
        self.check_labels(run)
        print(f"\n  {len(ids)} frames, {report['bytes'] / len(ids) / 1024:.0f} KiB each; {compared} compared with the stream")

    def check_labels(self, run):
        """Checks the dimension scales, as other programs see them."""
        rows, j = len(run.frames), run.modes(0)
        for name, columns, label, unit in (("coefficients", len(j), "mode", "wave"), ("sigma_waves", len(j), "mode", "wave"), ("spots", 19, "spot", None)):
            data = run.file[name]
            self.assertEqual((data.shape, data.dims[0].label, data.dims[1].label), ((rows, columns), "time", label))
            self.assertEqual(len(data.dims[1][label]), columns)
            self.assertEqual(list(data.dims[0]["time"][:]), list(run.frames["t_arrival_ns"]))
            self.assertEqual(data.attrs.get("units"), unit)
        self.assertEqual(list(run.file["mode"][:]), j)
        self.assertEqual(list(run.file["spot"][:]), list(range(19)))
        names = list(run.file["mode_name"].asstr()[:])
        self.assertEqual(names[:4], ["vertical tilt", "horizontal tilt", "oblique astigmatism", "defocus"])
        self.assertEqual(run.file["time"].attrs["units"], "nanoseconds since 1970-01-01T00:00:00Z")
        self.assertTrue(all(isinstance(value, str) for name, value in run.file.attrs.items() if name.startswith("camera_")))

    def test_the_document_reads_it_as_it_says(self):
        self.take_reference(20)
        self.record("run-1", 20)
        (block,) = re.findall(r"^```python\n(.*?)^```$", (ROOT / "proto" / "RECORDING.md").read_text(), re.MULTILINE | re.DOTALL)
        done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, cwd=self.bench.directory / "recordings")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("'oblique astigmatism': ", done.stdout)
        self.assertRegex(done.stdout, r"\(\d+, 19\) spot")

    def test_its_size_is_known_before_and_a_name_is_not_needed(self):
        size = self.call("record.estimate")
        self.assertAlmostEqual(size["bytes_per_hour"], size["bytes_per_frame"] * 100 * 3600)
        self.assertAlmostEqual(size["hours_free"], size["bytes_free"] / size["bytes_per_hour"])
        no_images = self.call("record.estimate", {"pictures_every": 0})
        self.assertAlmostEqual(size["bytes_per_frame"] - no_images["bytes_per_frame"], 512 * 512)
        self.assertAlmostEqual(self.call("record.estimate", {"pictures_every": 8})["bytes_per_frame"], no_images["bytes_per_frame"] + 512 * 64)
        files = []
        for _ in range(3):  # in the same second, too
            files.append(Path(self.call("record.start", {"pictures_every": 0})["file"]))
            self.call("record.stop")
            self.assertRegex(files[-1].name, r"^run-20\d{6}-\d{6}(-\d)?\.h5$")
        self.assertEqual(len(set(files)), 3)
        begun = self.call("record.start", {"pictures_every": 0})
        self.recorded_frames(600)
        ended = self.call("record.stop")
        with Recording(begun["file"]) as run:
            self.assertGreaterEqual(len(run.frames), 600)
            empty = files[0].stat().st_size
            per_frame = (ended["bytes"] - empty) / len(run.frames)
            print(f"\n  {per_frame:.0f} bytes a frame without images, estimated {no_images['bytes_per_frame']:.0f}; {empty / 1024:.0f} KiB empty")
        self.assertLess(per_frame, 2.5 * no_images["bytes_per_frame"])  # the last chunk of each dataset is not full

    def test_it_ends_as_asked_and_only_plain_names_are_taken(self):
        for name in ("../x", "a/b", "", ".hidden", "-x", "x" * 101, "a\n"):
            self.assertEqual(self.refused("record.start", {"name": name}).data["field"], "name", name)
        self.assertIn("nothing is being recorded", str(self.refused("record.stop")))
        self.call("record.start", {"name": "short", "limit_s": 3.5, "pictures_every": 10})
        ended = wait_for(lambda: (now := self.call("system.status")["record"])["state"] == "ended" and now, what="the limit")
        self.assertEqual(ended["reason"], "limit_s of 3.5 s is reached")
        self.assertEqual(self.refused("record.start", {"name": "short"}).data["field"], "name")
        short = self.open("short")
        self.check_whole(short)
        with_picture = numpy.flatnonzero((short.frames["picture"] >= 0) | (short.frames["picture_dropped"] > 0))
        rows, frames = numpy.diff(with_picture), numpy.diff(short.frames["frame_id"][with_picture].astype(int))
        self.assertEqual(set(rows[rows == frames]), {10}, "where no frame is lacking")
        self.call("record.start", {"name": "bare", "pictures_every": 0})
        self.assertIn("is being recorded", str(self.refused("record.start", {"name": "other"})))
        self.recorded_frames(20)
        self.assertEqual(self.call("record.stop")["pictures"], 0)
        self.assertGreater(len(self.open("bare").frames), 10)

    def test_another_image_ends_it_and_changes_of_the_sensor_do_not(self):
        self.take_reference(20)
        self.call("record.start", {"name": "changes"})
        hologram_id = self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})["hologram_id"]
        self.settled_frames(self.stream("wavefront"), 2, hologram_id)
        self.call("sensor.set", {"subapertures_across": 7})
        self.wait_for_frame(subapertures=37)
        self.call("camera.set", {"gain_db": 3.0})
        self.wait_for_frame(gain_db=3.0)
        self.call("camera.set", {"roi": {"x": 16, "y": 16, "width": 480, "height": 480}})
        ended = wait_for(lambda: (now := self.call("record.get"))["state"] == "ended" and now, what="the end")
        self.assertIn("the camera's image changed: it is now 480 x 480 at 16, 16, Mono8", ended["reason"])
        changes = self.open("changes")
        self.check_whole(changes)
        self.assertEqual(set(changes.frames["spots"]), {19, 37}, changes.summary)
        self.assertEqual(changes.file["spots"].shape, (len(changes.frames), 37))
        few = int(numpy.argmax(changes.frames["spots"] == 19))
        self.assertTrue(numpy.isnan(changes.file["spots"]["x"][few, 19:]).all())
        self.assertEqual(len(changes.spots(few)), 19)
        self.assertEqual(list(changes.documents("camera"))[-1]["settings"]["gain_db"], 3.0)
        self.assertIn([{"j": 3, "waves": 0.1}], [plan["aberration"] for plan in changes.documents("plan")])

    def wait_for_frame(self, **wanted):
        """Waits for a settled frame with these values in its message."""
        stream = self.stream("wavefront")
        wait_for(lambda: (m := stream.next(1.0)) and m["settled"] and wanted.items() <= m.items(), what=f"a frame with {wanted}")

    def test_a_file_that_is_taken_away_ends_it(self):
        for name, take_away in (("removed", Path.unlink), ("moved", lambda path: path.rename(path.with_suffix(".old")))):
            self.call("record.start", {"name": name})
            self.recorded_frames(20)
            take_away(self.bench.directory / "recordings" / f"{name}.h5")
            ended = wait_for(lambda: (now := self.call("record.get"))["state"] == "ended" and now, what="the end")
            self.assertIn("its file was removed or moved", ended["reason"])
        self.record("another", 20)
        self.check_whole(self.open("another"))

    def test_a_kill_leaves_all_that_was_reported(self):
        """How much is lacking is printed by tests/bench/record_rate."""
        random.seed(5)
        for k in range(KILLS):
            self.call("record.start", {"name": f"killed-{k}"})
            self.recorded_frames(random.randint(10, 150))
            reported = self.call("record.get")["frames"]
            self.bench.process("ovwsd").popen.kill()
            self.bench.stop("ovwsd")
            run = self.open(f"killed-{k}")
            self.assertEqual(run.summary["ended"], 0)
            print(f"\n  {len(run.frames)} frames are there, {reported} were reported")
            self.assertGreaterEqual(len(run.frames), reported)
            self.check_whole(run)
            with_picture = numpy.flatnonzero(run.frames["picture"] >= 0)
            for row in with_picture[[0, len(with_picture) // 2, -1]]:
                self.assertEqual(run.picture(row).shape, (512, 512))
            self.client.close()
            self.start_daemon()
            self.wait_until("running")


class RecordDisk(RecordCase):
    """A disk of 90 MiB, on which a recording leaves 64 MiB free."""

    def start(self):
        folder = self.bench.directory / "recordings"
        folder.mkdir()
        own_mounts()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=90m", "none", folder], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", folder], check=True)
        super().start()

    def ended(self, name):
        """Waits for the recording's end and returns its report; checks that the file is complete and frames continue."""
        report = wait_for(lambda: (now := self.call("record.get"))["state"] == "ended" and now, what="the end")
        recording = self.open(name)
        self.check_whole(recording)
        self.assertEqual(len(recording.frames), report["frames"])
        recording.close()  # an open file keeps its space after it is removed
        self.assertTrue(self.call("system.status")["record"]["reason"])
        self.settled_frames(self.stream("wavefront"), 5)
        return report

    def fill(self):
        with open(self.bench.directory / "recordings" / "filler", "wb", buffering=0) as file, contextlib.suppress(OSError):
            while True:
                file.write(bytes(4096))

    def test_full(self):
        self.take_reference(20)
        self.call("record.start", {"name": "long"})
        long = self.ended("long")
        self.assertIn("the disk is full: less than 64 MiB are left", long["reason"])
        self.assertGreater(long["bytes"], 20 << 20)
        self.assertIn("64 MiB", str(self.refused("record.start", {"name": "another"})))
        (self.bench.directory / "recordings" / "long.h5").unlink()
        self.call("record.start", {"name": "sudden"})
        self.recorded_frames(30)
        self.fill()
        sudden = self.ended("sudden")
        print(f"\n  {long['frames']} frames, then {sudden['frames']}: {sudden['reason']}")
        self.assertRegex(sudden["reason"], "the disk is full|No space left on device")
        self.assertGreater(sudden["frames"], 20)

    def test_read_only(self):
        folder = self.bench.directory / "recordings"
        subprocess.run(["mount", "-o", "remount,ro", folder], check=True)
        self.assertIn("Read-only file system", str(self.refused("record.start", {"name": "kept"})))
        subprocess.run(["mount", "-o", "remount,rw", folder], check=True)
        self.assertGreater(self.record("kept", 20)["frames"], 10)


if __name__ == "__main__":
    main()
