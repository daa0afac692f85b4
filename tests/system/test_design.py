"""`ovws design`: what it accepts is measured on the twin; what it refuses names the reason and a change that helps."""
import json
import re
import statistics
import subprocess
import tempfile
import unittest

from case import PROGRAM_PATIENCE_S, BenchCase, Client, bench_module, main, merged, wait_for
from PIL import Image

# (options, subapertures): an SLM, a camera and a lens that a lab may have.
REAL = {
    "hamamatsu": ("--slm hamamatsu-x13138 --camera imx273 --focal-length 200 --wavelength 633", 19),
    "holoeye": ("--slm holoeye-pluto-2 --camera imx265 --focal-length 150 --wavelength 532 --beam 8", 19),
    "thorlabs": ("--slm thorlabs-exulus-hd2 --camera imx548 --focal-length 100 --wavelength 633 --modes 28", 19),
    "many": ("--slm thorlabs-exulus-hd2 --camera imx548 --focal-length 100 --wavelength 633 --modes 48", 37),
}
# (options, the limit, an option of a change that helps)
IMPOSSIBLE = [
    ("--slm holoeye-pluto-2 --camera imx287 --focal-length 1000 --modes 18", "region", "--focal-length"),
    ("--slm holoeye-lc-r2500 --camera python5000 --focal-length 30", "scale", "--focal-length"),
    ("--slm 400x300@20 --camera imx252 --focal-length 50 --modes 40 --charge 0", "orders", "--modes 28"),
    ("--slm holoeye-pluto-2 --camera imx252 --focal-length 50 --beam 0.5", "beam", "--beam"),
    ("--slm holoeye-gaea --camera imx252 --modes 500", "modes", "--modes"),
    ("--slm 1272x1024@12.5 --camera imx265 --focal-length 300 --wavelength 532 --beam 10 --modes 60", "orders", "--modes 46"),
]
INTRODUCED_WAVES = 0.1
BOUND_WAVES = 0.002
FRAMES = 10


def design(*arguments, programs=None):
    """The exit code and the JSON that `ovws design` prints."""
    ovws = (programs or bench_module.find_programs()) / "ovws"
    done = subprocess.run([ovws, "--json", "design", *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
    return done.returncode, json.loads(done.stdout)


def changed(options, change):
    """The options with those of the change in place of the former ones."""
    pairs = dict(zip(options[::2], options[1::2])) | dict(zip(change[::2], change[1::2]))
    return [part for pair in pairs.items() for part in pair]


class Impossible(unittest.TestCase):
    def test_each_is_refused_with_the_reason_and_changes_that_help(self):
        for text, limit, helps in IMPOSSIBLE:
            with self.subTest(options=text):
                options = text.split()
                code, refused = design(*options)
                self.assertEqual((code, refused["accepted"], refused["finding"]["limit"]), (1, False, limit), refused)
                print(f"\n{text}\n  {limit}: {refused['finding']['reason']}")
                self.assertIn(helps, " ".join(change["options"] for change in refused["changes"]))
                for change in refused["changes"]:
                    print("  helps:", change["options"], "-", change["meaning"])
                    code, accepted = design(*changed(options, change["options"].split()))
                    self.assertEqual(code, 0, accepted)

    def test_wrong_options_name_what_is_possible(self):
        code, error = design("--slm", "holoeye-plut", "--camera", "imx252")
        self.assertEqual(code, 2)
        self.assertIn("holoeye-pluto-2", json.dumps(error))
        code, error = design("--slm", "1920x1080", "--camera", "imx252")
        self.assertEqual(code, 2)
        self.assertIn("WIDTHxHEIGHT@PITCH", json.dumps(error))


class Advice(unittest.TestCase):
    def advise(self, *arguments):
        ovws = bench_module.find_programs() / "ovws"
        done = subprocess.run([ovws, "--json", "advise", *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads(done.stdout)

    def test_the_best_sensor_comes_first_with_its_exposure(self):
        advice = self.advise("--modes", "44", "--photons", "1e8")
        best = advice["best_first"][0]
        self.assertEqual((best["subapertures"], best["charge"], best["limited_by"]), (19, 1, "frame rate"))
        errors = [one["error_waves"] for one in advice["best_first"]]
        self.assertEqual(errors, sorted(errors))
        self.assertEqual(best["config"]["camera"]["exposure_us"], best["exposure_us"])
        self.assertTrue(all(one["reason"] for one in advice["unfit"]))
        configured = advice["configured"]
        self.assertEqual((configured["subapertures"], configured["charge"], configured["warning"]), (19, 1, None))
        self.assertAlmostEqual(configured["error_waves"], best["error_waves"], delta=0.1 * best["error_waves"])
        self.assertTrue(self.advise("--modes", "44", "--photons", "1e8", "--camera", "imx252")["best_first"])

    def test_the_configurations_own_sensor_is_never_left_out(self):
        config = json.loads(subprocess.run([bench_module.find_programs() / "ovwsd", "--check-config"], capture_output=True, text=True,
                                           timeout=PROGRAM_PATIENCE_S, check=True).stdout)
        config["sensor"]["grooves"] = [130, 20]
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump(config, file)
            file.flush()
            ovws = bench_module.find_programs() / "ovws"
            text = subprocess.run([ovws, "advise", "--modes", "30", "--photons", "1e9", "--config", file.name], capture_output=True, text=True,
                                  timeout=PROGRAM_PATIENCE_S, check=True).stdout
        self.assertRegex(text, r"the configuration as it is:\n +5 +19 +1 .*\n  warning: .*zeroth order")

    def test_sensors_of_one_charge_are_compared_whatever_the_configurations_has(self):
        sensor = {"charges": [0, 1, -1] * 6 + [0], "mask": {"modes": [{"j": 4, "waves": 0.05}], "subapertures": [18]}}
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump({"sensor": sensor}, file)
            file.flush()
            advice = self.advise("--modes", "5", "--photons", "1e9", "--config", file.name)
        self.assertIn(3, [one["subapertures_across"] for one in advice["best_first"]])
        self.assertNotIn("charges", json.dumps(advice["unfit"]))

    def test_bright_light_is_limited_by_the_full_well(self):
        advice = self.advise("--modes", "18", "--photons", "1e12")
        self.assertEqual({one["limited_by"] for one in advice["best_first"]}, {"full well"})
        self.assertTrue(all(abs(one["peak_e"] - 7000.0) < 1.0 for one in advice["best_first"]))

    def test_light_too_low_for_any_sensor_is_an_error(self):
        ovws = bench_module.find_programs() / "ovws"
        arguments = ("advise", "--modes", "18", "--photons")
        done = subprocess.run([ovws, *arguments, "10"], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("the light is too low for any sensor", done.stderr)
        self.assertNotIn("best", done.stdout)
        self.assertIn("the configuration as it is, 5 across of charge 1, is left out: the light is too low", done.stdout)
        needed = float(re.search(r"([0-9.e+]+) are needed", done.stderr)[1])
        best = self.advise(*arguments[1:], f"{1.1 * needed}")["best_first"]
        self.assertGreater(best[0]["peak_e"], 5.0)
        self.assertLess(best[0]["error_waves"], 0.25)
        done = subprocess.run([ovws, "--json", *arguments, f"{0.9 * needed}"], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        none = json.loads(done.stdout)
        self.assertEqual((done.returncode, none["best_first"], none["configured"]["charge"]), (1, [], 1))
        self.assertIn("the light is too low", none["configured"]["reason"])


class DesignedCase(BenchCase):
    def start(self):
        """Each test designs its bench and starts it."""

    def design(self, options):
        path, picture = (self.bench.directory / name for name in ("designed.json", "farfield.png"))
        code, made = design(*options.split(), "-o", path, "--farfield", picture, programs=self.bench.programs)
        self.assertEqual(code, 0, made)
        for finding in made["findings"]:
            print("  limited by", finding["limit"], "-", finding["reason"])
        ovwsd = [self.bench.programs / "ovwsd", "--check-config", "--config", path]
        self.assertEqual(subprocess.run(ovwsd, capture_output=True, timeout=PROGRAM_PATIENCE_S).returncode, 0)
        roi = made["config"]["camera"]["roi"]
        with Image.open(picture) as image:
            self.assertEqual(image.size, (roi["width"], roi["height"]))
        code, refused = design(*options.split(), "-o", path, programs=self.bench.programs)
        self.assertEqual(code, 1, "an existing file was replaced")
        return path.read_text(), made

    def start_designed(self, text, config, options, twin=None):
        """Starts the designed bench; `twin`: keys of the twin that differ from an ideal one's."""
        slm, roi = config["slm"], config["camera"]["roi"]
        width, height = re.search(r'"name": "%s", "width": (\d+), "height": (\d+)' % options.split()[3],
                                  (bench_module.SOURCE / "config/devices.json").read_text()).groups()
        self.bench.start_display(slm_size=(slm["width"], slm["height"]))
        self.bench.start_twin(merged({
            "noise": "pool", "camera": {"sensor_width": int(width), "sensor_height": int(height)},
            "slm": {key: slm[key] for key in ("width", "height", "pitch_um")}, "sensor": config["sensor"],
            "optics": {key: config["optics"][key] for key in ("wavelength_nm", "focal_length_mm", "magnification", "camera_pitch_um")}
            | {"centre_px": [roi["x"] + (roi["width"] - 1) / 2, roi["y"] + (roi["height"] - 1) / 2]}}, twin or {}))
        self.bench.start_daemon(text)
        self.client = Client()
        self.addCleanup(self.client.close)
        self.wait_until("running")


class Real(DesignedCase):
    def check(self, name):
        options, spots = REAL[name]
        print(f"\n{options}")
        text, made = self.design(options)
        self.assertEqual(made["figures"]["subapertures"], spots)
        self.start_designed(text, made["config"], options)
        self.take_reference()
        stream = self.stream("wavefront")
        for j in (3, 4, 7, 12, made["figures"]["modes"]):
            shown = self.call("aberration.set", {"modes": [{"j": j, "waves": INTRODUCED_WAVES}]})
            self.settled_frames(stream, 1, shown["hologram_id"])
            # The first frames are measured by the former templates, until those about this wavefront are rendered.
            found, errors, spots_found = wait_for(lambda j=j: self.within_bound(stream, j), what=f"j = {j} within {BOUND_WAVES} wave")
            worst = max(errors, key=lambda k: abs(errors[k]))
            print(f"  j={j:2d}: {found:+.4f}, largest error {errors[worst]:+.4f} (j={worst}), spots {spots_found}/{spots}")
            self.assertEqual(spots_found, spots)

    def within_bound(self, stream, j):
        """The mean of mode j, the errors of all modes and the least number of spots, once no error exceeds the bound."""
        stream.drain()
        frames = self.fitted_frames(stream, FRAMES)
        found = {k: statistics.fmean(frame["coefficients"][i] for frame in frames) for i, k in enumerate(frames[0]["j"])}
        errors = {k: value - INTRODUCED_WAVES * (k == j) for k, value in found.items()}
        if max(map(abs, errors.values())) < BOUND_WAVES:
            return found[j], errors, min(frame["tracked"] for frame in frames)
        return None

    def test_hamamatsu(self):
        self.check("hamamatsu")

    def test_holoeye(self):
        self.check("holoeye")

    def test_thorlabs(self):
        self.check("thorlabs")

    def test_many_modes(self):
        self.check("many")


if __name__ == "__main__":
    main()
