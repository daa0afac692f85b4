"""Replay and export: a recording gives the same numbers again in the pipeline and in exported files."""
import contextlib
import csv
import hashlib
import io
import json
import re
import resource
import shutil
import subprocess
import sys
import time

import h5py
import numpy
import PIL.Image
from astropy.io import fits
from case import PROGRAM_PATIENCE_S, BenchCase, bench_module, main, next_message, wait_for
from ovws_client import export
from ovws_client.recording import Recording, RecordingError


def places(content, path=()):
    """The paths of all values of a document; of lists only the first element."""
    inner = content.items() if isinstance(content, dict) else enumerate(content[:1]) if isinstance(content, list) else ()
    for key, value in inner:
        yield (*path, key)
        yield from places(value, (*path, key))


def change_document(path, kind, place, value):
    """Changes a value in the first document of this kind, and its checksum everywhere."""
    with h5py.File(path, "r+") as file:
        changed = {}
        for number, row in enumerate(file["documents"][:]):
            text = file["text"][int(row["first_byte"]):int(row["first_byte"]) + int(row["bytes"])].tobytes().decode()
            for old, new in changed.items():
                text = text.replace(old, new)
            if row["kind"] == kind.encode():
                content = json.loads(text)
                inner = content
                for key in place[:-1]:
                    inner = inner[key]
                inner[place[-1]] = value
                text = json.dumps(content)
            sha256 = hashlib.sha256(text.encode()).hexdigest()
            changed[row["sha256"].decode()] = sha256
            row["first_byte"], row["bytes"], row["sha256"] = len(file["text"]), len(text.encode()), sha256.encode()
            file["text"].resize((len(file["text"]) + len(text.encode()),))
            file["text"][-len(text.encode()):] = numpy.frombuffer(text.encode(), numpy.uint8)
            file["documents"][number] = row


def change_field(table, field, value):
    """Returns a function that damages a recording: it changes a field in the fourth row."""
    def damage(file):
        row = file[table][3]
        row[field] = value
        file[table][3] = row
    return damage


def forget(name):
    def damage(file):
        del file[name]
    return damage


def cut(name, rows):
    def damage(file):
        file[name].resize(rows, axis=0)
    return damage


def forget_attribute(name):
    def damage(file):
        del file.attrs[name]
    return damage


def change_text(file):
    """Flips one bit of the plan."""
    plan = next(row for row in file["documents"][:] if row["kind"] == b"plan")
    file["text"][int(plan["first_byte"]) + 100] ^= 1


DAMAGES = {
    "no frames": forget("frames"), "no spots": forget("spots"), "no coefficients": forget("coefficients"), "no documents": forget("documents"),
    "no text": forget("text"), "no pictures": forget("pictures"), "spots cut off": cut("spots", 3), "pictures cut off": cut("pictures", 2),
    "coefficients cut off": cut("coefficients", 3), "errors cut off": cut("sigma_waves", 3), "documents cut off": cut("documents", 0), "text cut off": cut("text", 50),
    "another text": change_text, "a plan that is not there": change_field("frames", "plan_id", 99),
    "a picture that is not there": change_field("frames", "picture", 10**6), "another number of spots": change_field("frames", "spots", 7),
    "no camera": forget_attribute("camera_vendor"), "no pixel format": forget_attribute("pixel_format"), "no schema": forget_attribute("schema")}


class Replay(BenchCase):
    daemon_config = {"camera": {"frame_rate_hz": 100}, "record": {"directory": "recordings"}, "state": {"directory": "state"}}
    twin_config = {"noise": "pool", "aberration": [{"n": 2, "m": 2, "waves": 0.2}]}

    def path(self, name):
        return self.bench.directory / "recordings" / f"{name}.h5"

    def open(self, name):
        recording = Recording(self.path(name))
        self.addCleanup(recording.close)
        return recording

    def replay(self, path, *arguments, **more):
        return subprocess.run([self.bench.programs / "ovws", "--json", "replay", path, *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, **more)

    def replayed(self, name, *arguments):
        done = self.replay(self.path(name), *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout[-300:])
        return json.loads(done.stdout.splitlines()[-1])

    def wait_for_templates(self):
        """Takes a reference; afterwards templates measure the frames, which takes a moment on a busy machine."""
        self.take_reference(20)
        self.fitted_frames(self.stream("wavefront"), 1)

    def start_recording(self, name):
        self.late_before = self.call("system.status")["counters"]["frames_late"]
        self.call("record.start", {"name": name})

    def stop_recording(self, name):
        """Returns the number of images that a busy machine had no time for. All others are in the file, as many as there are frames."""
        lacking = self.call("record.stop")["pictures_dropped"]
        frames = self.open(name).frames
        self.assertEqual((frames["picture"] < 0).sum(), lacking)
        self.assertEqual(frames["picture_dropped"].sum(), lacking)
        return lacking

    def check_late(self, frames):
        """Checks that all frames of a scene that does not change are valid, but for the late ones of a busy machine."""
        self.assertEqual(list(frames["valid"]), list(frames["settled"]))
        late = self.call("system.status")["counters"]["frames_late"] - self.late_before
        self.assertLessEqual((frames["valid"] == 0).sum(), late)
        self.assertTrue(frames["valid"].any())

    def test_the_same_numbers_come_out_bit_for_bit(self):
        self.wait_for_templates()
        self.start_recording("still")
        self.recorded_frames(100)
        lacking = self.stop_recording("still")
        still = self.replayed("still")
        self.assertGreaterEqual(still["frames"], 100)
        self.assertEqual((still["replayed"], still["same"]), (still["frames"] - lacking,) * 2, still)
        frames = self.open("still").frames
        self.assertEqual(still["valid"], ((frames["valid"] == 1) & (frames["picture"] >= 0)).sum(), still)
        self.check_late(frames)
        self.assertIsNone(still["first_difference"])
        if lacking == 0:
            self.assertIsNone(still["first_not_replayed"])
        begun = time.monotonic()
        self.replayed("still", "--speed", "1")
        played = frames["t_arrival_mono_ns"][frames["picture"] >= 0]
        self.assertGreater(time.monotonic() - begun, 1e-9 * (int(played[-1]) - int(played[0])))
        shutil.copy(self.path("still"), self.path("altered"))
        with h5py.File(self.path("altered"), "r+") as file:
            run = self.open("still")
            sigma_waves, replayed = run.sigma_waves(), run.frames["picture"] >= 0
            row = numpy.flatnonzero(replayed & numpy.isfinite(sigma_waves[:, 0]))[-1]
            file["sigma_waves"][row, 0] += numpy.float32(1e-6)
        changed = self.replay(self.path("altered"))
        self.assertEqual((changed.returncode, json.loads(changed.stdout.splitlines()[-1])["same"]), (1, still["same"] - 1))
        stepped = self.replay(self.path("still"), "--step", input="\n\n")
        self.assertEqual(len(stepped.stdout.splitlines()), 4)  # three frames and the summary

    def test_changes_come_out_bit_for_bit(self):
        self.wait_for_templates()
        self.start_recording("changes")
        stream = self.stream("wavefront")
        hologram_id = self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.15}]})["hologram_id"]
        self.settled_frames(stream, 10, hologram_id)
        self.call("camera.set", {"exposure_us": 1500.0})
        self.take_reference(20, allow_aberration=True)
        self.call("sensor.set", {"tracker": "lg"})
        self.take_reference(10, allow_aberration=True)
        self.call("sensor.set", {"charge": 0, "tracker": "thresholded"})
        self.call("camera.set", {"exposure_us": 500.0})
        self.take_reference(10, allow_aberration=True)
        self.settled_frames(stream, 10)
        lacking = self.stop_recording("changes")
        changes = self.replayed("changes")
        print("\n ", changes, len(list(self.open("changes").documents("plan"))), "plans")
        self.assertEqual(changes["same"], changes["frames"] - lacking)
        self.assertGreater(changes["frames"], changes["valid"])
        frames = self.open("changes").frames
        for name in ("rms_waves", "fit_residual_px"):
            self.assertFalse(numpy.isnan(frames[name][frames["valid"] == 1]).any())
        self.assertTrue(numpy.isnan(frames["rms_waves"][frames["valid"] == 0]).all(), "not known is not 0")

    def test_the_daemon_measures_it_as_a_camera(self):
        self.call("sensor.set", {"tracker": "lg"})  # templates are rendered about whatever frame comes first
        self.take_reference(20)
        self.call("record.start", {"name": "camera"})
        self.recorded_frames(150)
        self.call("record.stop")
        self.bench.stop("ovwsd")
        self.client.close()
        run = self.open("camera")
        ids = [int(row["frame_id"]) for row in run.frames if row["picture"] >= 0]  # of the frames that are replayed, again and again
        then = {int(row["frame_id"]): coefficients for row, coefficients in zip(run.frames, run.coefficients()) if row["settled"]}
        config = json.loads(json.dumps(self.daemon_config))
        config["camera"] |= {"driver": "replay", "id": str(self.path("camera"))}
        config["tracking"] = {"tracker": "lg"}
        self.daemon_config = config
        self.start_daemon()
        stream = self.stream("wavefront")
        self.wait_until("running")
        self.assertEqual(self.call("camera.get")["info"]["serial"], "TWIN0001")
        same, in_a_row, last = [], 0, None
        while len(same) < 30:
            message = self.settled_frames(stream, 1)[0]
            number = ids[0] + (message["frame_id"] - ids[0]) % (ids[-1] + 1 - ids[0])
            in_a_row = in_a_row + 1 if number in then and number - 1 in then and last == number - 1 else 0
            if in_a_row > 5:  # the search of the first frames after an acquisition, a lost or a late frame starts elsewhere
                same.append(list(then[number]) == [numpy.float32(c) for c in message["coefficients"]])
            last = number
        print(f"\n  {sum(same)} of {len(same)} the same bit for bit")
        self.assertTrue(all(same), same)
        self.call("camera.set", {"frame_rate_hz": 300})
        wait_for(lambda: -next_message(stream)["t_device_ns"] + next_message(stream)["t_device_ns"] < 5e6, what="a faster pace")
        self.assertIn("roi.width", str(self.refused("camera.set", {"roi": {"width": 256}})))

    def test_other_programs_read_it(self):
        self.wait_for_templates()
        self.start_recording("out")
        self.recorded_frames(50)
        self.stop_recording("out")
        self.check_late(self.open("out").frames)
        run, folder = self.open("out"), self.bench.directory
        coefficients = run.coefficients().copy()
        coefficients[run.frames["valid"] == 0] = numpy.nan  # frames that were late, on a busy machine
        sigma_waves = numpy.where(run.frames["valid"][:, None] == 1, run.sigma_waves(), numpy.nan)
        for known in (coefficients, sigma_waves):
            self.assertEqual(list(numpy.isfinite(known[:, 2])), list(run.frames["valid"] == 1))
        self.export("out", "--npz", folder / "out.npz", "--fits", folder / "out.fits", "--pictures")
        made = self.export_csv("out", "--csv", "--spots", "--images")
        self.assertEqual(made[:2], ["out.csv", "out-spots.csv"])
        before = self.csv("out")
        status, said = self.run_export("out", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)), restore_signals=False)
        self.assertEqual((status, self.csv("out"), list(folder.glob("*.part"))), (1, before, []), said)  # as on a full disk
        lines = list(csv.DictReader(io.StringIO(before)))
        for name, known in (("j3", coefficients), ("sigma_j3", sigma_waves), ("rms_waves", run.frames["rms_waves"][:, None].repeat(3, axis=1))):
            written = numpy.array([float(line[name] or "nan") for line in lines]).astype(known.dtype)
            self.assertTrue(numpy.array_equal(written, known[:, 2], equal_nan=True), name)
        self.assertEqual([int(line["t_arrival_ns"]) for line in lines], list(run.frames["t_arrival_ns"]))
        self.assertEqual({(line["unit"], line["wavelength_nm"], line["basis"], line["orientation"]) for line in lines},
                         {("wave", "632", "zernike-osa-rms", "x-right-y-down")})
        spots = list(csv.DictReader(io.StringIO(self.csv("out-spots"))))
        self.assertEqual({(spot["first_pixel"], spot["orientation"]) for spot in spots}, {("0", "x-right-y-down")})
        self.assertTrue(numpy.array_equal(numpy.array([spot["x_px"] for spot in spots], numpy.float32).reshape(-1, 19), run.spots()["x"]))
        row = int(numpy.flatnonzero(run.frames["picture"] >= 0)[3])
        with PIL.Image.open(folder / f"out-{row:08}.png") as image:
            self.assertTrue((numpy.asarray(image) == run.picture(row)).all())
        self.assertEqual(len(made) - 2, int((run.frames["picture"] >= 0).sum()))
        with numpy.load(folder / "out.npz") as arrays:
            self.assertTrue(numpy.array_equal(arrays["coefficients"], coefficients, equal_nan=True))
            self.assertTrue(numpy.array_equal(arrays["sigma_waves"], sigma_waves, equal_nan=True))
            self.assertEqual(list(arrays["frames"]["frame_id"]), list(run.frames["frame_id"]))
            self.assertEqual([arrays[name].item() for name in ("unit", "wavelength_nm", "basis", "orientation", "first_pixel")],
                             ["wave", 632.0, "zernike-osa-rms", "x-right-y-down", 0])
        with fits.open(folder / "out.fits") as hdus:
            hdus.verify("exception")
            sensor = hdus["AOT_WAVEFRONT_SENSORS"].data[0]
            self.assertEqual((sensor["TYPE"], sensor["MEASUREMENTS"], sensor["N_VALID_SUBAPERTURES"]), ("Shack-Hartmann", "INTREF<SPOTS>", 19))
            self.assertEqual(hdus["SPOTS"].data.shape, (len(run.frames), 2, 19))
            self.assertTrue(numpy.array_equal(hdus["COEFFICIENTS"].data, coefficients, equal_nan=True))
            self.assertTrue(numpy.array_equal(hdus["SIGMA"].data, sigma_waves, equal_nan=True))
            self.assertEqual(list(hdus["AOT_TIME"].data["FRAME_NUMBERS"][0]), list(run.frames["frame_id"]))
            self.assertTrue((hdus["PICTURES"].data[3] == run.picture(row)).all())
            for name in ("SPOTS", "LEVELS", "REFERENCE", "COEFFICIENTS", "SIGMA", "PICTURES"):
                self.assertEqual((hdus[name].header["ORIENT"], hdus[name].header.get("PIXBASE")),
                                 ("x-right-y-down", 0 if name in ("SPOTS", "REFERENCE") else None), name)
            for name in ("COEFFICIENTS", "SIGMA"):
                self.assertEqual((hdus[name].header["BASIS"], hdus[name].header["WAVELEN"]), ("zernike-osa-rms", 632e-9))

    def test_an_export_that_cannot_be_written_says_so(self):
        self.take_reference(20)
        self.call("record.start", {"name": "good"})
        self.recorded_frames(20)
        self.call("record.stop")
        folder = self.bench.directory
        limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)), "restore_signals": False}
        for option in ("--npz", "--fits"):
            out = folder / f"out{option}"
            out.write_text("the previous file")
            for path, more in ((out, limit), (folder / "nowhere" / "out", {}), (folder, {})):  # as on a full disk; no such folder; a folder
                said = self.export("good", option, path, status=1, **more).stderr
                self.assertIn(f"{path} cannot be written: ", said)
                self.assertNotIn("damaged", said)
            self.assertEqual((out.read_text(), list(folder.glob("*.part"))), ("the previous file", []))
            self.export("good", option, out)
            self.assertGreater(out.stat().st_size, 4096)

    def test_fits_of_a_camera_with_a_name_in_other_letters(self):
        self.take_reference(20)
        self.call("record.start", {"name": "letters"})
        self.recorded_frames(20)
        self.call("record.stop")
        with h5py.File(self.path("letters"), "r+") as file:
            file.attrs["camera_vendor"], file.attrs["camera_model"] = "Süd", "光 2"
        out = self.bench.directory / "letters.fits"
        self.export("letters", "--fits", out)
        with fits.open(out) as hdus:
            self.assertEqual(hdus["AOT_DETECTORS"].data["TYPE"][0], "Sud ? 2")

    def test_fits_has_no_place_for_some(self):
        self.take_reference(20)
        self.call("record.start", {"name": "every_third", "pictures_every": 3})
        self.recorded_frames(20)
        self.call("record.stop")
        out = self.bench.directory / "third.fits"
        self.export("every_third", "--fits", out, "--pictures")
        with fits.open(out) as hdus:
            times = hdus["AOT_TIME"].data
            self.assertEqual(list(times["UID"]), ["frames", "pictures"])
            run = self.open("every_third")
            self.assertEqual(list(times["FRAME_NUMBERS"][1]), list(run.frames["frame_id"][run.frames["picture"] >= 0]))
            self.assertEqual((len(times["FRAME_NUMBERS"][1]), hdus["PICTURES"].header["TIME_UID"]), (len(hdus["PICTURES"].data), "ROWREF<pictures>"))
        self.call("record.start", {"name": "two"})
        self.recorded_frames(1)
        self.record_sensor({"charge": 2})
        self.call("record.stop")
        self.assertIn("charge: changed", self.export("two", "--fits", out, status=1).stderr)
        self.call("record.start", {"name": "wider"})
        self.recorded_frames(1)
        self.record_sensor({"charge": 1, "subapertures_across": 7})
        self.call("record.stop")
        self.export_csv("wider")  # the modes of the larger sensor continue those of the smaller one
        counts = self.open("wider").frames["coefficients"]
        self.assertEqual(len(self.csv("wider").splitlines()[0].split(",")), 15 + 2 * counts.max())
        self.assertIn("read them frame by frame", self.export("wider", "--npz", out, status=1).stderr)
        self.assertIn("No such file", self.export("nothing", "--npz", out, status=1).stderr)
        self.assertIn("No such file", self.run_export("nothing")[1])
        self.assertIn("give at least one of", self.export("two", status=2).stderr)
        self.call("record.start", {"name": "none", "pictures_every": 0})
        self.recorded_frames(10)
        self.call("record.stop")
        self.assertIn("pictures: the recording has none", self.export("none", "--fits", out, "--pictures", status=1).stderr)
        status, said = self.run_export("none", "--csv", "--images")
        self.assertEqual(status, 1, said)
        self.assertIn("no images", said)
        self.assertFalse((self.bench.directory / "none.csv").exists())

    def record_sensor(self, params):
        """Changes the sensor and waits for 10 settled frames of it, which the recording then contains."""
        hologram_id = self.call("sensor.set", params)["hologram_id"]
        stream = self.stream("wavefront")
        for _ in range(10):
            wait_for(lambda: (m := stream.next(1.0)) and m["settled"] and m["hologram_id"] == hologram_id, what=f"a frame with {params}")

    def run_export(self, name, *arguments, **more):
        done = subprocess.run([self.bench.programs / "ovws", "export", self.path(name) if isinstance(name, str) else name, *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S,
                              cwd=self.bench.directory, **more)
        return done.returncode, done.stdout + done.stderr

    def export_csv(self, name, *arguments):
        """Runs `ovws export` in the bench's folder; returns the names of the files that it wrote."""
        status, said = self.run_export(name, *arguments)
        self.assertEqual(status, 0, said)
        return said.splitlines()

    def csv(self, name):
        return (self.bench.directory / f"{name}.csv").read_text()

    def export(self, name, *arguments, status=0, **more):
        done = subprocess.run([sys.executable, "-m", "ovws_client.export", self.path(name), *arguments], cwd=bench_module.find_programs().parent / "python",
                              capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, **more)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def test_plans_with_absurd_numbers_are_reported(self):
        """The checksums are correct; only the values are wrong."""
        self.take_reference(20)
        self.call("record.start", {"name": "honest"})
        self.recorded_frames(20)
        self.call("record.stop")
        absurd = self.bench.directory / "absurd.h5"
        tried, statuses = 0, set()
        for kind in ("plan", "operator"):
            for place in places(next(self.open("honest").documents(kind))):
                for value in (-1, 0, 2**31 - 1, 2**63, 1e300, "x", None, [], {}):
                    if (tried := tried + 1) % 7:  # testing all of them takes minutes
                        continue
                    shutil.copy(self.path("honest"), absurd)
                    change_document(absurd, kind, place, value)
                    done = self.replay(absurd)
                    self.assertIn(done.returncode, (0, 1), (kind, place, value, done))
                    statuses.add(done.returncode)
                    self.assertTrue(done.stdout.strip(), (kind, place, value))
        print(f"\n  {tried // 7} changes")
        self.assertIn(1, statuses)

    def test_an_operating_point_with_impossible_higher_modes_is_reported(self):
        self.wait_for_templates()
        self.call("record.start", {"name": "point"})
        self.recorded_frames(20)
        self.call("record.stop")
        changed = self.bench.directory / "changed_point.h5"
        for field, value, text in (("higher_waves", -0.01, "do not belong together"), ("higher_waves", 1e9, "do not belong together"),
                                   ("higher_waves", "x", "number"), ("corrected_at", [0.0], "cannot be read"),
                                   ("corrected_at", [0.0] * 18, "cannot be read"), ("measured", True, "cannot be read")):
            with self.subTest(field=field, value=value):
                shutil.copy(self.path("point"), changed)
                change_document(changed, "operating_point", (field,), value)
                done = self.replay(changed)
                self.assertEqual(done.returncode, 1, done)
                self.assertIn(text, done.stdout + done.stderr)

    def test_a_plan_of_another_region_is_reported_at_once(self):
        self.call("record.start", {"name": "region"})
        self.recorded_frames(70)  # with 5 s for each, as it once was, the replay exceeds its time-out
        self.call("record.stop")
        plans = [place for place in places(next(self.open("region").documents("plan"))) if place[-1] == "width" and "roi" in place]
        other = self.bench.directory / "region.h5"
        shutil.copy(self.path("region"), other)
        change_document(other, "plan", plans[0], 320)
        done = self.replay(other)
        report = json.loads(done.stdout.splitlines()[-1])
        self.assertEqual((done.returncode, report["replayed"]), (1, 0), report)
        self.assertRegex(report["first_not_replayed"], "its plan is for an image of 320 x .*; the recording's are")

    def test_export_of_a_damaged_recording_says_what_is_damaged(self):
        self.call("record.start", {"name": "whole"})
        self.recorded_frames(21)
        self.call("record.stop")
        damaged, out = self.bench.directory / "damaged.h5", self.bench.directory / "damaged"
        wanted = ["--npz", f"{out}.npz", "--fits", f"{out}.fits", "--pictures"]
        for what, damage in DAMAGES.items():
            with self.subTest(what):
                shutil.copy(self.path("whole"), damaged)
                with h5py.File(damaged, "r+") as file:
                    damage(file)
                said = io.StringIO()
                with contextlib.redirect_stderr(said), self.assertRaises(SystemExit) as ended:
                    export.main([str(damaged), *wanted])
                self.assertEqual(ended.exception.code, 1)
                self.assertRegex(said.getvalue(), "^.*damaged.h5: .+")
                status, text = self.run_export(damaged, "--csv", "--spots", "--images", "-o", out)
                self.assertIn(status, (0, 1), text)
                out.with_suffix(".fits").unlink(missing_ok=True)

    def test_what_is_no_recording_is_reported(self):
        self.call("record.start", {"name": "short"})
        self.recorded_frames(20)
        self.call("record.stop")
        whole = self.path("short").read_bytes()
        broken = self.bench.directory / "broken.h5"
        for content in (b"", b"not HDF5", whole[:len(whole) // 2], whole[:100], whole[:48] + b"\xff" * 64 + whole[112:]):
            broken.write_bytes(content)
            done = self.replay(broken)
            self.assertEqual(done.returncode, 1, done)
            self.assertIn("broken.h5", done.stdout)
        self.assertEqual(self.replay("/nowhere.h5").returncode, 1)
        for header in re.finditer(b"OHDR", whole):  # of HDF5's objects: the client does not read a damaged one for ever
            damaged = bytearray(whole)
            damaged[header.end() + 2] ^= 1
            broken.write_bytes(damaged)
            with contextlib.suppress(RecordingError), Recording(broken) as run:
                run.coefficients()


if __name__ == "__main__":
    main()
