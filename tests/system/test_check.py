"""ovws check: a good bench passes and is left as it was; what is wrong with a bench is named first."""
import json
import signal
import subprocess
import time

from case import PROGRAM_PATIENCE_S, BenchCase, main, message_since, wait_for

SENSOR = {"sensor": {"subapertures_across": 3}}  # few modes, so that a check is short
QUICK = ("--quick", "--seconds", "3", "--no-loop")


class CheckCase(BenchCase):
    small = True
    daemon_config = SENSOR | {"slm": {"settle_ms": 60}}  # on a busy machine the twin sees a hologram later than usual
    twin_config = SENSOR

    def start(self):
        super().start()
        self.take_reference(30)

    def command(self, *words):
        return self.ovws_command("check", *words)

    def check(self, *words):
        """Exit code and the report as JSON."""
        done = subprocess.run(self.command("--json", *words), capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertTrue(done.stdout, done.stderr)
        return done.returncode, json.loads(done.stdout)

    def first(self, report):
        """The finding that the report says to improve first."""
        return next(one for one in report["findings"] if one["name"] == report["improve_first"][0])

    def state(self):
        keys = {"aberration.get": "modes", "correction.get": "modes", "loop.get": "closed", "lut.get": "source"}
        return {method: self.call(method)[key] for method, key in keys.items()}


class GoodBench(CheckCase):
    def test_it_passes_and_is_left_as_it_was(self):
        self.call("aberration.set", {"modes": [{"j": 5, "waves": 0.004}]})
        before, page = self.state(), self.bench.directory / "report.html"
        code, report = self.check("--seconds", "3", "-o", str(page))
        self.assertEqual(code, 0, report["findings"])
        self.assertEqual(self.state(), before)
        verdicts = {one["name"]: one["verdict"] for one in report["findings"]}
        for name in ("response", "noise", "motion", "drift", "loop", "frames", "saturation", "lut", "reference"):
            self.assertEqual(verdicts[name], "good", report["findings"])
        for mode in report["response"]["modes"]:
            self.assertAlmostEqual(mode["slope"], 1.0, delta=0.01)
        self.assertGreater(report["loop"]["step"]["p50_ms"], 10)
        text = page.read_text()
        self.assertEqual(text.count("<svg"), 6)  # the matrix, slopes, noise, drift, Allan deviation, loop
        self.assertNotIn("src=", text)
        self.assert_closed_loop_is_refused_or_borrowed()

    def assert_closed_loop_is_refused_or_borrowed(self):
        self.close_loop(gain=0.3)
        code, report = self.check(*QUICK)
        self.assertEqual(code, 1)
        self.assertIn("--open-loop", report["error"]["message"])
        running = subprocess.Popen(self.command("--seconds", "3", "--no-loop", "--open-loop"), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(running.kill)
        self.addCleanup(running.stdout.close)
        wait_for(lambda: any(mode["waves"] > 0.09 for mode in self.call("aberration.get")["modes"]), PROGRAM_PATIENCE_S, "a poke")
        running.send_signal(signal.SIGINT)
        self.assertEqual(running.wait(PROGRAM_PATIENCE_S), 1)
        self.assertIn("interrupted", running.stdout.read())
        loop = self.call("loop.get")
        self.assertTrue(loop["closed"])
        self.assertEqual(loop["gain"], 0.3)
        self.assertEqual([mode["waves"] for mode in self.call("aberration.get")["modes"]], [0.004])

    def test_it_says_why_it_cannot_measure(self):
        self.call("reference.clear")
        code, report = self.check(*QUICK)
        self.assertEqual(code, 1)
        self.assertIn("ovws reference 100", report["error"]["message"])
        self.call("slm.show", {"pattern": "flat"})
        self.assertIn("pattern=sensor", self.check(*QUICK)[1]["error"]["message"])
        done = subprocess.run(self.command("-o", "/nonexistent/report.html"), capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertEqual(done.returncode, 1)
        self.assertIn("cannot be written", done.stderr)


class Disturbed(CheckCase):
    def test_a_vibration_and_saturation_come_first(self):
        self.twin.call("twin.set", {"turbulence": {"rms_waves": 0, "vibrations": [{"j": 4, "rms_waves": 0.03, "frequency_hz": 9.0}]}})
        report = self.check(*QUICK)[1]
        first = self.first(report)
        self.assertEqual(first["name"], "motion", report["findings"])
        self.assertAlmostEqual(first["cost_waves"], 0.03, delta=0.006)
        self.assertIn("defocus", first["text"])
        self.assertIn(" Hz", first["text"])
        self.twin.call("twin.set", {"turbulence": None})
        self.call("camera.set", {"exposure_us": 6000})
        message_since(self.stream("wavefront"), time.time_ns())
        code, report = self.check(*QUICK)
        self.assertEqual(code, 1)
        self.assertEqual(self.first(report)["name"], "saturation", report["findings"])


class Slow(CheckCase):
    daemon_config = SENSOR
    twin_config = SENSOR | {"slm": {"settle_ms": 150}}

    def test_a_short_settle_time_comes_first(self):
        code, report = self.check(*QUICK)
        first = self.first(report)
        self.assertEqual((code, first["name"], first["verdict"]), (1, "settle", "bad"), report["findings"])
        self.assertGreater(first["cost_waves"], 0.03)
        self.assertRegex(first["fix"], r"^ovws call slm\.(set settle_ms=[12]\d\d|settle watch_ms=1000 --wait)$")


class Shallow(CheckCase):
    twin_config = SENSOR | {"slm": {"depth_waves": 0.95}}

    def test_an_uncorrected_table_comes_first(self):
        report = self.check("--seconds", "2", "--no-loop")[1]
        first = self.first(report)
        self.assertEqual((first["name"], first["verdict"]), ("lut", "warning"), report["findings"])
        self.assertAlmostEqual(first["cost_waves"], 0.05 / 12**0.5, delta=0.002)
        self.assertEqual(self.call("lut.get")["source"], "linear")  # the check keeps no table


if __name__ == "__main__":
    main()
