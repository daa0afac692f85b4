#!/usr/bin/env python3
"""twin_life_test.py BUILD: start of the twin, loss of its display, and its end."""

import pathlib
import signal
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "drivers" / "twin"))
import bench  # noqa: E402

BUILD = sys.argv.pop(1)


class TwinLife(unittest.TestCase):
    def setUp(self):
        self.bench = bench.Bench(build=BUILD)
        self.addCleanup(self.bench.close)

    def wait_for_log(self, text, times=1, timeout=bench.PATIENCE_S):
        deadline = time.monotonic() + timeout
        while self.bench.log("ovws-twin").count(text) < times:
            self.assertLess(time.monotonic(), deadline, f"no '{text}' in the log:\n"
                            + self.bench.log("ovws-twin"))
            time.sleep(0.02)

    def refused(self, *arguments):
        """Error output of a second twin that is started with these arguments."""
        second = self.bench.start("second", [self.bench.programs / "ovws-twin", *arguments])
        self.assertEqual(second.popen.wait(bench.PATIENCE_S), 1)
        self.bench.stop("second")
        return self.bench.log("second")

    def test_starts_without_a_display_and_finds_it_when_it_comes(self):
        number = next(bench.free_displays())
        self.bench.start_twin(arguments=["--display", f":{number}"])
        self.wait_for_log(f"no X server answers at display ':{number}'")
        self.bench.start_display(number)
        self.wait_for_log("reading DUMMY1")

    def test_survives_the_death_of_the_display_and_reads_the_next_one(self):
        self.bench.start_display()
        number = int(self.bench.display[1:])
        self.bench.start_twin()
        for round_number in (1, 2):
            self.wait_for_log("reading DUMMY1", times=round_number)
            self.bench.process("xorg").popen.send_signal(signal.SIGKILL)
            self.bench.stop("xorg")
            self.wait_for_log("the X server ended or changed its screens", times=round_number)
            self.bench.start_display(number)
        self.wait_for_log("reading DUMMY1", times=3)
        self.assertTrue(self.bench.process("ovws-twin").alive())

    def test_says_which_outputs_there_are_when_its_own_is_not(self):
        self.bench.start_display()
        self.bench.start_twin({"slm": {"display": "HDMI-7"}})
        self.wait_for_log("no output HDMI-7 is on; there are: DUMMY0, DUMMY1")

    def test_refuses_an_output_of_another_size(self):
        self.bench.start_display()
        self.bench.start_twin({"slm": {"display": "DUMMY0"}})
        self.wait_for_log("DUMMY0 shows 1920 x 1080, the SLM has 1280 x 768 pixels")

    def test_says_which_port_is_taken(self):
        self.bench.start_twin()
        self.assertIn("tcp://127.0.0.1:7790 is in use", self.refused())
        self.assertIn("UDP 127.0.0.1:3956 is taken",
                      self.refused("--control", "tcp://127.0.0.1:7791"))

    def test_says_what_is_wrong_with_its_configuration(self):
        path = self.bench.directory / "wrong.json"
        for text, said in (('{"detector": {"read_nois_e": 3}}', 'did you mean "read_noise_e"'),
                           ('{"light": {"peak_electrons": -1}}', "light.peak_electrons"),
                           ('{"sensor": {"pupil_diameter_px": 900}}', "sensor.pupil_diameter_px"),
                           ('{"aberration": [{"n": 2, "m": 1, "waves": 1}]}', "aberration[0]"),
                           ('{"camera": {"address": "here"}}', "not an IPv4 address"),
                           ("{", "wrong.json")):
            path.write_text(text)
            self.assertIn(said, self.refused("--config", path))

    def test_ends_with_status_0(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            self.bench.start_display()
            twin = self.bench.start_twin()
            twin.popen.send_signal(number)
            self.assertEqual(twin.popen.wait(bench.PATIENCE_S), 0)
            self.bench.stop("ovws-twin")
            self.bench.stop("xorg")

    def test_ends_though_the_x_server_hangs(self):
        self.bench.start_display()
        server = self.bench.process("xorg")
        server.popen.send_signal(signal.SIGSTOP)
        self.addCleanup(server.popen.send_signal, signal.SIGCONT)
        twin = self.bench.start_twin()
        twin.popen.terminate()
        self.assertEqual(twin.popen.wait(bench.PATIENCE_S), 0)


if __name__ == "__main__":
    bench.own_network()
    unittest.main(verbosity=2)
