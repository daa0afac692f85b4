"""Between the tests of a class the shared display and twin are as at their start, whatever a test has done to them."""
import os
import signal
import subprocess
import sys
import unittest

from case import ROOT, TWIN, BenchCase, Client, bench_module, main, twin_settings

DISTURBED = {"aberration": [{"j": 4, "waves": 0.3}], "shades": [{"x_px": 640, "y_px": 384, "radius_px": 50}],
             "branch_points": [{"x": 0.1, "y": 0.2}], "sources": [{"offset_px": [0.0, 90.0]}], "peak_electrons": 500.0,
             "geometry": {"rotation_deg": 3.0, "mirror": "x", "magnification": 1.1}, "turbulence": {"rms_waves": 0.2},
             "scintillation": {"variance": 0.2}, "quantum_efficiency": 0.5, "prnu": 0.05, "shot_noise": False, "dark_current_e_per_s": 9.0,
             "read_noise_e": 20.0, "full_well_e": 900.0, "black_level_dn": 9.0, "bits": 8, "left_justified": True, "noise": "none"}


class SharedBenchIsRestored(BenchCase):
    def renew(self):
        self.client.close()
        self.shared_bench.give_back()
        self.bench = self.shared_bench.take()
        self.start()

    def facts(self):
        with Client(TWIN) as twin:
            report = twin.call("twin.get")
        answers = {method: self.call(method) for method in ("config.get", "camera.get", "sensor.get", "reference.get", "record.get")}
        for counted in (answers["sensor.get"], report["fault"]):  # numbers of holograms and faults rise
            counted.pop("hologram_id", None)
        return twin_settings(report), report["fault"], answers, sorted(path.name for path in self.bench.directory.iterdir())

    def test_a_disturbed_bench_is_as_at_its_start(self):
        before, twin = self.facts(), self.bench.process("ovws-twin")
        with Client(TWIN) as client:
            client.call("twin.set", DISTURBED)
            client.call("twin.fault", {"kind": "drop", "seconds": 3600})
        self.call("camera.set", {"exposure_us": 900.0, "gain_db": 6.0, "pixel_format": "Mono8", "roi": {"x": 8, "y": 8, "width": 256, "height": 256}})
        self.call("sensor.set", {"charge": 0, "subapertures_across": 3})
        (self.bench.directory / "folder").mkdir()
        (self.bench.directory / "folder" / "file").write_text("left")
        self.bench.start("sleep", ["sleep", "600"])
        self.assertNotEqual(self.facts(), before)
        self.renew()
        self.assertEqual(self.facts(), before)
        self.assertIs(self.bench.process("ovws-twin"), twin)
        self.assertIsNone(self.bench.process("sleep"))
        self.take_reference(10)

    def test_programs_that_a_test_has_stopped_are_started_again(self):
        before = self.facts()
        self.bench.stop("ovwsd")
        self.bench.stop("ovws-twin")
        self.renew()
        self.assertEqual(self.facts(), before)
        self.bench.process("xorg").popen.kill()
        self.bench.process("xorg").popen.wait()
        self.renew()
        self.assertEqual(self.facts(), before)
        subprocess.run(["xrandr", "-display", self.bench.display, "--output", "DUMMY1", "--off"], check=True, capture_output=True)
        self.renew()
        self.assertEqual(self.facts(), before)

    def test_a_program_that_crashes_fails_its_test(self):
        for name, number in (("ovwsd", signal.SIGSEGV), ("ovws-twin", signal.SIGABRT)):
            os.kill(self.bench.process(name).pid, number)
        with self.assertRaisesRegex(bench_module.BenchError, r"(?s)ovwsd: crashed \(Segmentation fault\)\n.*running.*ovws-twin: crashed \(Aborted\)"):
            self.renew()
        self.bench = self.shared_bench.take()
        self.start()

    def test_a_crash_at_the_end_of_a_class_is_an_error(self):
        os.kill(self.bench.process("ovws-twin").pid, signal.SIGTRAP)
        with self.assertRaisesRegex(bench_module.BenchError, "ovws-twin: crashed"):
            self.shared_bench.close()
        self.bench = self.shared_bench.take()

    def test_defaults_cannot_be_changed(self):
        with self.assertRaises(TypeError):
            BenchCase.daemon_config["log"] = {}  # other classes have it, too


class Script(unittest.TestCase):
    """A script of tests: its exit status says whether they ran, and their environment is that of a shell."""

    def status(self, body, **environment):
        code = f"import os, sys, unittest\nsys.path.insert(0, {str(ROOT / 'tests/system')!r})\nfrom case import main\nclass T(unittest.TestCase):\n{body}\nmain()\n"
        return subprocess.run([sys.executable, "-c", code], capture_output=True, env=os.environ | environment).returncode

    def test_a_services_environment_is_forgotten(self):
        given = {"STATE_DIRECTORY": "/x", "NOTIFY_SOCKET": "/x", "OVWS_KEY": "x", "JOURNAL_STREAM": "8:1"}
        body = f" def test_a(self): self.assertEqual({{*{list(given)}}} & os.environ.keys(), set())\n"
        self.assertEqual(self.status(body, **given), 0)

    def test_of_none_of_some_and_of_all_skipped(self):
        skip, run = " def test_{}(self): self.skipTest('no')\n", " def test_{}(self): pass\n"
        parts = " def test_c(self):\n  for k in range(2):\n   with self.subTest(k): self.skipTest('no')\n"
        for body, status in ((run.format("a"), 0), (run.format("a") + skip.format("b"), 0), (skip.format("b"), 77), (parts + run.format("a"), 0),
                             (" def tset_a(self): pass\n", 1), (" def test_a(self): self.fail()\n", 1)):
            self.assertEqual(self.status(body), status, body)


if __name__ == "__main__":
    main()
