"""A camera that dies or hangs: detected soon, reported, and used again soon after it returns."""
import os
import signal
import statistics
import time

from case import BenchCase, Client, main, wait_for

CAMERA = {"gain_db": 3.0, "exposure_us": 1500.0, "frame_rate_hz": 80.0, "pixel_format": "Mono12",
          "roi": {"x": 8, "y": 16, "width": 488, "height": 480}}
PERIOD_S = 1.0 / CAMERA["frame_rate_hz"]
ANSWER_S, LONGEST_ANSWER_S = 0.5, 2.0  # of half of the answers; of each, because a busy machine delays some
PATIENCE_S = max(3.0 * PERIOD_S, 1e-6 * CAMERA["exposure_us"] + 2.0)
ABSENT_S = [0.3, 4.0, 10.0] + ([60.0] if os.environ.get("OVWS_LONG_ABSENCE") else [])


class CameraKilled(BenchCase):
    daemon_config = {"camera": CAMERA, "stream": {"image_rate_hz": 0}}

    def setUp(self):
        super().setUp()
        self.take_reference(20)
        self.wavefront, self.events = self.stream("wavefront"), self.stream("event")
        self.settled_frames(self.wavefront, 5)
        self.answers_s = []

    def assert_answered(self):
        self.assertLess(statistics.median(self.answers_s), ANSWER_S)
        self.assertLess(max(self.answers_s), LONGEST_ANSWER_S)

    def wait_for_fault(self, since):
        """Seconds until the camera counts as gone by its event; checks status and frames too."""
        event = wait_for(lambda: (m := self.events.next(1.0)) and m["kind"] == "camera" and m["severity"] == "error" and m, 10.0, "the event")
        seconds = time.monotonic() - since
        self.assertIn("frames", event["text"])
        camera = self.call("system.status")["camera"]
        self.assertFalse(camera["connected"])
        self.assertTrue(camera["fault"])
        self.wavefront.drain()
        return seconds

    def assert_settings_are_back(self):
        """Checks the settings in the camera's registers and in the daemon."""
        twin = Client("tcp://127.0.0.1:7790")
        self.addCleanup(twin.close)
        registers = twin.call("twin.get")["camera"]
        settings = self.call("camera.get")["settings"]
        for key, value in CAMERA.items():
            for reported in (registers[key], settings[key]):
                if isinstance(value, float):
                    self.assertAlmostEqual(reported, value, delta=0.01 * value, msg=key)
                else:
                    self.assertEqual(reported, value, key)

    def come_back(self):
        """Restarts the camera; returns the seconds until valid coefficients, and the first frame."""
        self.start_twin()
        ready = time.monotonic()
        self.gaps = 0
        while True:
            self.assertLess(time.monotonic(), ready + 30.0, "no valid frame")
            frame = self.wavefront.next(1.0)
            self.gaps += frame["gap"] if frame else 0
            if frame and frame["valid"]:
                break
        return time.monotonic() - ready, frame

    def ask(self, absent):
        """Checks that requests are answered without a camera; once its absence is known, camera requests are refused at once."""
        for method, params in (("system.status", {}), ("camera.get", {}), ("aberration.set", {"modes": []})):
            asked = time.monotonic()
            self.call(method, params)
            self.answers_s.append(time.monotonic() - asked)
        if absent:
            asked = time.monotonic()
            self.assertIn("camera", str(self.refused("camera.set", {"gain_db": 1.0})))
            self.answers_s.append(time.monotonic() - asked)
        self.assert_answered()

    def last_frame(self):
        frame = self.wavefront.next(2.0)
        while (newer := self.wavefront.next(0.0)) is not None:
            frame = newer
        return frame

    def test_killed_and_back(self):
        for absent_s in ABSENT_S:
            with self.subTest(absent_s=absent_s):
                reconnects = self.call("system.status")["counters"]["camera_reconnects"]
                self.events.drain()
                self.wavefront.drain()
                before = self.last_frame()
                twin = self.bench.process("ovws-twin")
                os.kill(twin.pid, signal.SIGKILL)
                killed = time.monotonic()
                self.bench.stop("ovws-twin")
                self.wavefront.drain()
                seen_s = None
                if absent_s > 1.5 * PATIENCE_S:
                    seen_s = self.wait_for_fault(killed)
                    self.assertLess(seen_s, PATIENCE_S + 2.0)
                    self.assertIsNone(self.wavefront.next(0.2))
                while time.monotonic() < killed + absent_s:
                    self.ask(seen_s is not None)
                    time.sleep(0.1)
                back_s, first = self.come_back()
                gap = self.gaps
                away = 1e-9 * (first["t_arrival_ns"] - before["t_arrival_ns"]) / PERIOD_S
                seen = f"seen after {seen_s:.2f} s" if seen_s else "not to be seen yet"
                print(f"\n  away {absent_s} s: {seen}, valid {back_s:.2f} s after it answered, "
                      f"{gap} of {away:.0f} frames missing, slowest answer {max(self.answers_s):.3f} s")
                self.assertLess(back_s, max(0.0, PATIENCE_S - absent_s) + 5.0)
                self.assertLess(abs(gap - away), 0.1 * away + 20)
                wait_for(lambda: self.call("system.status")["counters"]["camera_reconnects"] == reconnects + 1, 5.0, "a reconnect, counted")
                self.assert_settings_are_back()


if __name__ == "__main__":
    main()
