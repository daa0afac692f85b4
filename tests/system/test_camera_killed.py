"""A camera that dies: detected and reported, no frame while it is away, and used again with its settings after it returns.

    OVWS_ABSENCE_S=60   a longer absence

How soon it is detected and used again is measured by tests/bench/camera_return.
"""
import os
import signal
import time

from case import BenchCase, clock_offset_ns, main, next_message, wait_for

CAMERA = {"gain_db": 3.0, "exposure_us": 1500.0, "frame_rate_hz": 80.0, "pixel_format": "Mono12",
          "roi": {"x": 8, "y": 16, "width": 488, "height": 480}}
PERIOD_S = 1.0 / CAMERA["frame_rate_hz"]
SILENCE_S = max(3.0 * PERIOD_S, 1e-6 * CAMERA["exposure_us"] + 2.0)  # then a camera counts as lost
LONG_ABSENCE_S = float(os.environ.get("OVWS_ABSENCE_S", "4"))  # after it has counted as lost; Aravis, too, has given it up then


class CameraKilled(BenchCase):
    daemon_config = {"camera": CAMERA, "stream": {"image_rate_hz": 0}}

    def setUp(self):
        super().setUp()
        self.take_reference(20)
        self.heard = self.stream("wavefront", "event")  # one subscription: in the order in which they were published

    def next(self):
        return next_message(self.heard)

    def kill(self):
        """Returns a late frame of the camera: a new stream begins with lower numbers."""
        self.heard.drain()
        last = wait_for(lambda: (m := self.next())["topic"] == "wavefront" and m["frame_id"] > 100 and m, what="100 frames")
        self.offset_ns = clock_offset_ns()
        os.kill(self.bench.process("ovws-twin").pid, signal.SIGKILL)
        self.bench.stop("ovws-twin")
        return last

    def seconds_between(self, killed_ns, now_ns):
        stepped_ns = clock_offset_ns() - self.offset_ns
        return 1e-9 * (now_ns - killed_ns - stepped_ns)

    def wait_for_fault(self, last):
        """Waits for the event of the camera's loss; returns the last frame before it."""
        while (message := self.next())["topic"] != "event" or (message["kind"], message["severity"]) != ("camera", "error"):
            last = message if message["topic"] == "wavefront" else last
        if "control of the camera was lost" not in message["text"]:  # which a refused packet may show first
            self.assertIn("frames", message["text"])
            self.assertGreaterEqual(self.seconds_between(last["t_arrival_ns"], message["t_ns"]), SILENCE_S)
        camera = self.call("system.status")["camera"]
        self.assertFalse(camera["connected"])
        self.assertTrue(camera["fault"])
        return last

    def ask(self, absent):
        """Checks that requests are answered without a camera; once its absence is known, camera requests are refused."""
        for method, params in (("system.status", {}), ("camera.get", {}), ("aberration.set", {"modes": []})):
            self.call(method, params)
        if absent:
            self.assertIn("camera", str(self.refused("camera.set", {"gain_db": 1.0})))

    def stay_away(self, seconds):
        """Checks that requests are answered and that no frame is published meanwhile."""
        end = time.monotonic() + seconds
        while True:
            self.ask(absent=True)
            message = self.heard.next(0.2)
            self.assertTrue(message is None or message["topic"] != "wavefront", message)
            if message is None and time.monotonic() >= end:
                return

    def come_back(self, last):
        """Starts the camera again; checks that the frames that were missed are counted, until one is valid."""
        self.start_twin()
        frame, restarts = last, 0
        while restarts == 0 or not frame["valid"]:
            if (message := self.next())["topic"] != "wavefront":
                continue
            last, frame = frame, message
            if frame["frame_id"] > last["frame_id"]:
                self.assertEqual(frame["frame_id"], last["frame_id"] + 1 + frame["gap"])
                continue
            restarts += 1  # the numbers of a new stream
            away = self.seconds_between(last["t_arrival_ns"], frame["t_arrival_ns"]) / PERIOD_S
            print(f"\n  {frame['gap']} of {away:.0f} frames missing")
            self.assertAlmostEqual(frame["gap"] + 1, away, delta=1.0)
        self.assertEqual(restarts, 1)

    def check_settings(self):
        """Checks the settings in the camera's registers and in the daemon."""
        registers = self.twin.call("twin.get")["camera"]
        settings = self.call("camera.get")["settings"]
        for key, value in CAMERA.items():
            for reported in (registers[key], settings[key]):
                if isinstance(value, float):
                    self.assertAlmostEqual(reported, value, delta=0.01 * value, msg=key)
                else:
                    self.assertEqual(reported, value, key)

    def test_killed_and_back(self):
        for absence in ("shorter than its detection", "until its detection", f"{LONG_ABSENCE_S} s longer"):
            with self.subTest(absence):
                reconnects = self.call("system.status")["counters"]["camera_reconnects"]
                last = self.kill()
                self.ask(absent=False)
                if absence != "shorter than its detection":
                    last = self.wait_for_fault(last)
                    self.stay_away(0.0 if absence == "until its detection" else LONG_ABSENCE_S)
                self.come_back(last)
                wait_for(lambda: self.call("system.status")["camera"]["connected"], what="a connected camera")
                self.assertEqual(self.call("system.status")["counters"]["camera_reconnects"], reconnects + 1)
                self.check_settings()


if __name__ == "__main__":
    main()
