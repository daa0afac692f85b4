"""Missing camera, display or port, and wrong configuration: the daemon reports them, and recovers when they appear."""
import json
import os
import signal
import socket
import subprocess
import time
import unittest

from case import PATIENCE_S, PROGRAM_PATIENCE_S, BenchCase, bench_module, main, next_message, wait_for


class Absent(BenchCase):
    def start(self):
        pass

    def test_camera_comes_later(self):
        self.bench.start_display()
        self.start_daemon()
        status = self.wait_until("waiting_for_camera")
        self.assertFalse(status["camera"]["connected"])
        self.assertTrue(status["camera"]["fault"])
        print("\n  camera absent:", status["camera"]["fault"])
        self.assertIn("camera", str(self.refused("camera.set", {"gain_db": 1.0})))
        self.assertIn("camera", str(self.refused("reference.take", {"frames": 5})))
        self.bench.start_twin()
        self.wait_until("running")
        self.take_reference(20)
        self.settled_frames(self.stream("wavefront"), 10)

    def test_display_comes_later(self):
        display = next(bench_module.free_displays())
        self.bench.display = f":{display}"
        self.bench.start_twin()
        self.start_daemon()
        status = self.wait_until("waiting_for_display")
        print("\n  display absent:", status["slm"]["fault"])
        self.assertTrue(status["slm"]["fault"])
        self.assertIn("display", str(self.refused("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})))
        self.assertEqual(self.call("aberration.get")["modes"], [])
        frame = self.stream("wavefront").next(PATIENCE_S)
        self.assertFalse(frame["valid"] or frame["settled"])
        self.assertEqual(set(frame["coefficients"]), {None})
        self.bench.start_display(display)
        self.wait_until("running")
        self.take_reference(20)
        self.settled_frames(self.stream("wavefront"), 10)

    def test_wrong_output_name_lists_those_there(self):
        self.bench.start_display()
        self.bench.start_twin()
        self.daemon_config = {"slm": {"display": "HDMI-7"}}
        self.start_daemon()
        fault = self.wait_until("waiting_for_display")["slm"]["fault"]
        print("\n  wrong output:", fault)
        self.assertIn("HDMI-7", fault)
        self.assertIn("DUMMY1", fault)

    def test_primary_output_is_refused(self):
        self.bench.start_display()
        self.bench.start_twin()
        self.daemon_config = {"slm": {"display": "DUMMY0", "width": 1920, "height": 1080}}
        self.start_daemon()
        status = self.wait_until("fault")
        print("\n  primary output:", status["fault"])
        self.assertIn("allow_primary", status["slm"]["fault"])
        wait_for(lambda: self.call("system.status")["camera"]["connected"], what="the camera")
        self.assertEqual(self.call("camera.set", {"gain_db": 3.0})["applied"]["gain_db"], 3.0)
        self.refused("aberration.clear")

    def test_settings_that_the_camera_refuses(self):
        self.bench.start_display()
        self.bench.start_twin()
        self.daemon_config = {"camera": {"gain_db": 99.0}}
        self.start_daemon()
        status = self.wait_until("fault")
        print("\n  refused by the camera:", status["fault"])
        self.assertIn("camera.gain_db", status["camera"]["fault"])
        wait_for(lambda: self.call("system.status")["slm"]["connected"], what="the display")
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})
        self.assertIn("98", str(self.refused("camera.set", {"gain_db": 98.0})))
        events = self.stream("event")
        self.assertEqual(self.call("camera.set", {"gain_db": 3.0})["applied"]["gain_db"], 3.0)
        self.wait_until("running")
        states = []
        wait_for(lambda: states.extend(e["data"]["state"] for e in [next_message(events)] if e["kind"] == "state") or "running" in states,
                 what="the event of the state")
        self.assertEqual(states, ["running"])  # the camera is there: nothing waits for it

    def hang_display(self):
        """Runs a bench and stops its X server; returns the server's number."""
        self.bench.start_display()
        self.bench.start_twin()
        self.start_daemon()
        self.wait_until("running")
        server = self.bench.process("xorg").pid
        os.kill(server, signal.SIGSTOP)
        self.addCleanup(os.kill, server, signal.SIGCONT)
        self.assertIn("display", str(self.refused("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})))
        return server

    def test_a_display_that_hangs_is_reported_and_ends_nothing(self):
        server = self.hang_display()
        slm = wait_for(lambda: (slm := self.call("system.status")["slm"])["fault"] and slm, what="the fault")
        print("\n  display frozen:", slm["fault"])
        self.call("camera.set", {"roi": {"x": 8}})  # the displayed hologram is now for another region
        self.refused("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})
        os.kill(server, signal.SIGCONT)
        wait_for(lambda: not self.call("system.status")["slm"]["fault"], what="the end of the fault")
        self.take_reference(20)
        self.settled_frames(self.stream("wavefront"), 10)
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})

    def test_a_display_that_hangs_does_not_keep_the_daemon_from_ending(self):
        self.hang_display()
        asked = time.monotonic()
        self.assertEqual(self.bench.stop("ovwsd"), 0)  # it was not killed
        print(f"\n  ended {time.monotonic() - asked:.2f} s after SIGTERM with a frozen display")


class Refusals(unittest.TestCase):
    """The daemon exits at once with status 1 and an error message."""

    def run_daemon(self, config, *arguments):
        from bench import Bench
        with Bench() as bench:
            path = bench.directory / "ovwsd.json"
            path.write_text(config if isinstance(config, str) else json.dumps(config))
            done = subprocess.run([bench.programs / "ovwsd", "--config", path, *arguments], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        print("\n ", done.stderr.strip())
        return done

    def test_configuration_with_a_typo(self):
        for config, words in (({"camera": {"exposre_us": 5}}, ["camera.exposre_us", "exposure_us"]),
                              ({"camera": {"exposure_us": "long"}}, ["camera.exposure_us", "number"]),
                              ({"sensor": {"charge": 99}}, ["sensor.charge", "8"]),
                              ({"slm": {"lut": "/nowhere.txt"}}, ["slm.lut", "/nowhere.txt"]),
                              ({"sensor": {"pupil_diameter_px": 4000}}, ["sensor.pupil_diameter_px"]),
                              ('{"camera": ', ["ovwsd.json"])):
            with self.subTest(config):
                done = self.run_daemon(config)
                self.assertEqual(done.returncode, 1)
                for word in words:
                    self.assertIn(word, done.stderr)

    def test_check_config_says_what_is_wrong_and_ends(self):
        self.assertEqual(self.run_daemon("{}", "--check-config").returncode, 0)
        for config in ({"camera": {"gian_db": 1}}, {"slm": {"flatness": "/nowhere.png"}}, {"sensor": {"subapertures_across": 1}},
                       {"camera": {"driver": "webcam"}}):
            self.assertEqual(self.run_daemon(config, "--check-config").returncode, 1, config)

    def test_check_config_names_values_with_which_the_spots_can_be_seen(self):
        for config, words in (({"slm": {"width": 3840, "height": 2160, "pitch_um": 3.74}}, ["sensor.spacing", "sensor.subapertures_across to 3"]),
                              ({"slm": {"width": 1920, "height": 1080, "pitch_um": 8}, "optics": {"focal_length_mm": 1000}},
                               ["camera.roi", "spots fall outside", "optics.focal_length_mm to 140"])):
            with self.subTest(config):
                done = self.run_daemon(config, "--check-config")
                self.assertEqual(done.returncode, 1)
                for word in words:
                    self.assertIn(word, done.stderr)

    def test_port_in_use(self):
        for key, port in (("control", 7702), ("stream", 7701), ("stream", 7703)):
            with self.subTest(port), socket.socket() as taken:
                taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                taken.bind(("127.0.0.1", port))
                taken.listen()
                done = self.run_daemon("{}")
                self.assertEqual(done.returncode, 1)
                self.assertIn(str(port), done.stderr)
                self.assertIn("in use", done.stderr)


if __name__ == "__main__":
    main()
