"""The wall clock steps, both ways, while frames flow: only wall-clock time stamps change, and the Python client finds the frames that it waits for.

Only the daemon sees the step, through an LD_PRELOAD library (stepped_clock.cpp).
"""
import mmap
import struct
import time
from unittest import mock

from case import PATIENCE_S, BenchCase, Client, main, next_message, wait_for

from ovws_bridges.bluesky import WavefrontSensor
from ovws_client import Client as PlainClient
from ovws_client.corrector import mean_spots

HOUR_NS, FAR_NS = 3_600_000_000_000, 60_000_000_000
STEP_NS = 20_000_000_000


class Clock(BenchCase):
    daemon_config = {"camera": {"frame_rate_hz": 50.0}, "stream": {"image_rate_hz": 2.0}}

    def start_daemon(self):
        shared = self.bench.directory / "clock"
        shared.write_bytes(bytes(16))
        with open(shared, "r+b") as file:
            self.clock = mmap.mmap(file.fileno(), 16)
        with self.preload("stepped_clock", OVWS_CLOCK_STEP=str(shared)):
            super().start_daemon()

    def step(self, ns):
        self.clock[:8] = struct.pack("q", ns)

    def wall_waits(self):
        return struct.unpack("q", self.clock[8:])[0]

    def assert_steps(self, stream, from_ns, to_ns):
        restarts = self.call("system.status")["counters"]["camera_reconnects"]
        self.step(from_ns)
        stream.drain()
        frames = [next_message(stream) for _ in range(50)]
        self.step(to_ns)
        after, follows = [], []
        while sum(follows) < 60:
            after.append(next_message(stream))
            follows.append(abs(after[-1]["t_publish_ns"] - time.time_ns() - to_ns) < FAR_NS)
            self.assertLess(len(follows), 500, "stamps do not follow the step")
        self.assertEqual(follows, sorted(follows), "all stamps but those of frames already on their way")
        ids = [frame["seq"] for frame in frames + after]
        self.assertEqual(ids, list(range(ids[0], ids[0] + len(ids))), "none is missing in the stream")
        # Latency stays that of the machine, far below the step.
        stages = wait_for(lambda: (now := self.call("system.status")["latency"]) and now["published"]["count"] and now["arrived"]["count"] and now, what="latencies")
        latency = stages["published"]
        self.assertTrue(0.0 < latency["max_us"] < 1e-3 * FAR_NS, latency)
        self.assertLess(stages["arrived"]["max_us"], 1e-3 * FAR_NS, "the camera's clock is held against one that does not step")
        modes = [{"n": 2, "m": 0, "waves": 0.05 if to_ns > from_ns else 0.0}]
        hologram = self.call("aberration.set", {"modes": modes})["hologram_id"]
        self.settled_frames(stream, 5, hologram)
        print(f"\n  step of {(to_ns - from_ns) / 1e9:+.0f} s: published at most {latency['max_us'] / 1e3:.1f} ms late")
        self.take_reference(20, allow_aberration=True)
        status = self.call("system.status")
        self.assertEqual((status["state"], status["counters"]["camera_reconnects"]), ("running", restarts))
        self.assertLess(status["uptime_s"], 600.0)

    def test_an_hour_forth_and_back(self):
        self.take_reference(20)
        stream = self.stream("wavefront")
        self.assert_steps(stream, 0, HOUR_NS)
        self.assert_steps(stream, HOUR_NS, 0)
        self.assert_steps(stream, 0, -HOUR_NS)
        self.assertEqual(self.wall_waits(), 0, "nothing waits for a time of the wall clock")
        self.assertNotRegex(self.bench.log("ovwsd"), r"has not run for \d{4}")  # seconds: a busy machine may hold up a thread for some

    def test_the_camera_of_the_twin_goes_on_when_the_clock_steps_back(self):
        with self.preload("stepped_clock", OVWS_CLOCK_STEP=str(self.bench.directory / "clock")):
            self.renew_twin()
        stream = self.stream("wavefront")
        restarts = self.call("system.status")["counters"]["camera_reconnects"]
        before = next_message(stream)
        self.step(-FAR_NS)
        after = wait_for(lambda: (message := next_message(stream))["t_device_ns"] < before["t_device_ns"] and message, what="a frame after the step")
        self.assertLess(after["frame_id"] - before["frame_id"], 500)
        self.assertEqual(self.call("system.status")["counters"]["camera_reconnects"], restarts)

    def test_the_client_waits_for_frames_across_a_step(self):
        def steps(call):
            """Steps back after each answer, and further back the next time: frames appear to be older than what was asked before them."""
            def stepping(*request):
                result = call(*request)
                self.step(self.stepped - STEP_NS)
                self.stepped -= STEP_NS
                return result
            return stepping

        self.take_reference(20)
        self.stepped = 0
        call_binary = mock.patch.object(PlainClient, "call_binary", steps(PlainClient.call_binary))  # of all methods
        call_binary.start()
        self.addCleanup(call_binary.stop)
        with Client() as client:
            self.assertEqual(client.wavefront(frames=3).frames, 3)
            self.assertEqual(client.image().pixels.ndim, 2)
            self.assertEqual(mean_spots(client, 3)[0].size, 2 * client.sensor_get()["subapertures"])
        sensor = WavefrontSensor("ovws", timeout_s=PATIENCE_S / 2)
        self.addCleanup(sensor.close)
        sensor.exposure_us.set(1500.0).wait(PATIENCE_S)
        sensor.trigger().wait(PATIENCE_S)
        self.assertLess(self.stepped, -10 * STEP_NS)


if __name__ == "__main__":
    main()
