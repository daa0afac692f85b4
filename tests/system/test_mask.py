"""Phase masks and charges per subaperture: measured on the twin; what the tracker cannot find is refused, and nothing changes."""
import json
import math
import statistics
import subprocess

from case import PROGRAM_PATIENCE_S, BenchCase, main, wait_for

MODES = {3: 0.08, 4: -0.06, 7: 0.05, 12: 0.04}  # waves
BOUND_WAVES = 0.006
POSITIONS_BOUND_WAVES = 0.02  # lg with the operator slopes
PARAMS = -32602


def write_map(path, width, height):
    """Writes a map as text: 0.05 wave RMS of oblique astigmatism over the square around a subaperture."""
    def waves(x, y):
        return 0.05 * 6 ** 0.5 * 2 * ((x + 0.5) * 2 / width - 1) * ((y + 0.5) * 2 / height - 1)
    path.write_text("\n".join(" ".join(f"{waves(x, y):.5f}" for x in range(width)) for y in range(height)) + "\n")


# Another mask in each subaperture, and one in all.
OF_EACH = [{"modes": [{"j": 3 + i % 3, "waves": 0.006 * (i - 9)}], "subapertures": [i]} for i in range(19)] + [{"axicon_waves": 0.03}]


class MaskCase(BenchCase):
    small = True
    daemon_config = {"camera": {"exposure_us": 700.0}}

    def sensor_with(self, change):
        """Sets the sensor's charges and mask; what `change` does not give is the default."""
        return self.call("sensor.set", {"charge": 1, "alternate_charge": None, "charges": [], "mask": None} | change)["applied"]

    def error_waves(self, stream, fitted):
        """Median of the next 20 valid frames; infinite if they have not all spots, but for one in a few, which noise may make an outlier.
        Until templates of the new wavefront are made, those of the last one err and may leave out the spots that it changed most."""
        frames = (self.fitted_frames if fitted else self.settled_frames)(stream, 20)
        tracked = [frame["tracked"] for frame in frames]
        if statistics.median(tracked) < 19 or min(tracked) < 18:
            return math.inf
        return statistics.median(sum((value - MODES.get(j, 0.0)) ** 2 for j, value in zip(frame["j"], frame["coefficients"])) ** 0.5
                                 for frame in frames)

    def check_measured(self, what, fitted=True):
        self.take_reference(30)
        stream = self.stream("wavefront")
        shown = self.call("aberration.set", {"modes": [{"j": j, "waves": waves} for j, waves in MODES.items()]})
        self.settled_frames(stream, 1, shown["hologram_id"])
        bound = BOUND_WAVES if fitted else POSITIONS_BOUND_WAVES
        error = wait_for(lambda: (error := self.error_waves(stream, fitted)) < bound and error, what=f"{what}: an error below {bound} wave")
        print(f"\n  {what}: error {error:.5f} wave")
        self.call("aberration.clear")


class Mask(MaskCase):
    def test_wavefronts_are_measured_behind_masks_and_alternating_charges(self):
        for change in ({"alternate_charge": -1}, {"mask": {"modes": [{"j": 4, "waves": 0.15}]}}, {"charge": 0, "mask": {"modes": [{"j": 3, "waves": 0.15}]}},
                       {"mask": {"modes": [{"j": 4, "waves": 0.15}], "subapertures": [0, 4, 9, 13, 16]}}, {"mask": OF_EACH}):
            with self.subTest(change=change):
                applied = self.sensor_with(change)
                self.assertEqual(applied["alternate_charge"], change.get("alternate_charge"))
                self.check_measured(json.dumps(change))

    def test_what_the_tracker_cannot_find_is_refused_and_nothing_changes(self):
        before = self.call("sensor.get")
        for change, field, word in (({"alternate_charge": 9}, "alternate_charge", "8"),
                                    ({"charges": [0, 1]}, "charges", "19"),
                                    ({"charges": [0] * 18 + [-9]}, "charges[18]", "8"),
                                    ({"charges": [0, 1] * 9 + [0], "alternate_charge": 0}, "charges", "alternate_charge"),
                                    ({"charge": 0, "alternate_charge": 1, "tracker": "thresholded"}, "tracker", "vortex"),
                                    ({"alternate_charge": 8}, "spacing", "charges up to 8"),
                                    ({"mask": {"modes": [{"j": 4, "waves": 0.1}], "subapertures": [19]}}, "mask.subapertures", "18"),
                                    ({"mask": {"modes": [{"j": 3, "waves": 0.3}]}}, "mask", "19"),
                                    ({"mask": {"modes": [{"j": 4, "waves": 11.0}]}}, "mask.modes", "10"),
                                    ({"mask": {"file": "/nowhere/mask.txt"}}, "mask.file", "configuration"),
                                    ({"mask": [{}, {"subapertures": [19]}]}, "mask[1].subapertures", "18"),
                                    ({"mask": [{}, {"axicon_wave": 0.1}]}, "mask[1].axicon_wave", "axicon_waves"),
                                    ({"mask": [{}] * 65}, "mask", "64"),
                                    ({"mask": [{"modes": [{"j": 9, "waves": 0.0}] * 45}] * 2}, "mask[1].modes", "45"),
                                    ({"mask": 5}, "mask", "array"),
                                    ({"mask": {"axicon": 0.1}}, "mask.axicon", "axicon_waves")):
            with self.subTest(change=change):
                refusal = self.refused("sensor.set", change)
                print(f"\n  {refusal}")
                self.assertEqual(refusal.code, PARAMS)
                self.assertTrue(refusal.data["field"].endswith(field), refusal.data)
                self.assertIn(word, str(refusal) + json.dumps(refusal.data))
                self.assertEqual(self.call("sensor.get"), before)


class Charges(MaskCase):
    def test_wavefronts_are_measured_with_charges_of_different_size(self):
        self.call("camera.set", {"exposure_us": 180.0})  # a bright spot is four times as bright as a vortex
        for tracker in ("fit", "lg"):
            for change in ({"charge": 0, "alternate_charge": 1}, {"charges": [0, 1, -1] * 6 + [0]}, {"charge": 1, "charges": [0] * 19}):
                with self.subTest(tracker=tracker, change=change):
                    applied = self.sensor_with(change | {"tracker": tracker})
                    self.assertEqual(applied["charges"], change.get("charges", []))
                    self.check_measured(f"{tracker} {json.dumps(change)}", tracker == "fit")


class MaskFile(Mask):
    def start(self):
        self.file = self.bench.directory / "mask.txt"
        write_map(self.file, 64, 64)
        self.daemon_config = {"sensor": {"mask": {"file": str(self.file)}}, "state": {"directory": "state"}, "camera": {"exposure_us": 700.0}}
        super().start()

    def check_config(self, width, height):
        """The exit code and the output of --check-config with a map of this size."""
        path, other = self.bench.directory / "checked.json", self.bench.directory / "other.txt"
        write_map(other, width, height)
        path.write_text(json.dumps({"sensor": {"mask": {"file": str(other)}}}))
        done = subprocess.run([self.bench.programs / "ovwsd", "--check-config", "--config", path], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        return done.returncode, done.stdout + done.stderr

    def test_wavefronts_are_measured_behind_masks_and_alternating_charges(self):
        mask = self.call("sensor.get")["mask"]
        self.assertEqual((mask["file"], len(mask["sha256"])), (str(self.file), 64))
        self.check_measured("map of 64 x 64")
        reference = self.call("reference.get")["sha256"]
        self.call("sensor.set", {"mask": None})
        self.assertFalse(self.call("reference.get")["taken"])  # it belongs to the mask
        self.call("sensor.set", {"mask": {"file": str(self.file)}})
        self.assertEqual(self.call("sensor.get")["mask"], mask)
        self.assertEqual(self.call("reference.get")["sha256"], reference)

    def test_what_the_tracker_cannot_find_is_refused_and_nothing_changes(self):
        for width, height in ((64, 63), (8, 8)):
            code, output = self.check_config(width, height)
            print("\n ", output.strip())
            self.assertEqual(code, 1)
            self.assertIn("sensor.mask.file", output)
            self.assertIn(f"{width} x {height}", output)
        self.assertEqual(self.check_config(16, 16)[0], 0)
        other = {"modes": [{"j": 3, "waves": 0.05}], "axicon_waves": 0.0, "file": None, "sha256": None, "subapertures": []}
        self.call("sensor.set", {"mask": other})
        self.assertEqual(self.call("config.save")["saved"], ["sensor.mask"])
        self.assertEqual(self.call("config.get")["sensor"]["mask"], other)


class MaskFiles(MaskCase):
    def start(self):
        self.one, self.other = (self.bench.directory / name for name in ("one.txt", "other.txt"))
        write_map(self.one, 64, 64)
        write_map(self.other, 32, 32)
        self.masks = [{"file": str(self.one), "subapertures": [0, 4, 9]}, {"file": str(self.other), "subapertures": [1, 2]}, {"axicon_waves": 0.02}]
        configured = [self.masks[0] | {"file": "one.txt"}, *self.masks[1:]]  # relative to the folder of the configuration
        self.daemon_config = {"sensor": {"mask": configured}, "state": {"directory": "state"}, "camera": {"exposure_us": 700.0}}
        super().start()

    def test_files_of_several_masks_and_their_reference_survive_a_change_and_a_restart(self):
        masks = self.call("sensor.get")["mask"]
        self.assertEqual([mask["file"] for mask in masks], [str(self.one), str(self.other), None])
        self.assertIn("absolute path", self.refused("sensor.set", {"mask": {"file": "one.txt"}}).reason)
        self.check_measured("two files")
        reference = self.call("reference.get")["sha256"]
        other = self.sensor_with({"mask": [self.masks[1], {"file": str(self.one), "subapertures": [5]}]})["mask"]
        self.assertEqual([mask["sha256"] for mask in other], [masks[1]["sha256"], masks[0]["sha256"]])
        self.assertFalse(self.call("reference.get")["taken"])
        self.sensor_with({"mask": masks})
        self.assertEqual(self.call("reference.get")["sha256"], reference)
        self.sensor_with({"mask": other})
        self.assertEqual(self.call("config.save")["saved"], ["sensor.mask"])
        for shown in (other, masks):
            self.bench.stop("ovwsd")
            self.start_daemon()
            self.wait_until("running")
            self.assertEqual(self.call("sensor.get")["mask"], other)
            self.sensor_with({"mask": shown})
        self.assertEqual(self.call("reference.get")["sha256"], reference)
        write_map(self.other, 32, 31)
        self.bench.stop("ovwsd")
        checked = self.bench.directory / "checked.json"
        checked.write_text(json.dumps({"sensor": {"mask": self.masks}}))
        done = subprocess.run([self.bench.programs / "ovwsd", "--check-config", "--config", checked], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertIn("sensor.mask[1].file", done.stdout + done.stderr)


if __name__ == "__main__":
    main()
