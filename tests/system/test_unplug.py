"""A camera that was unplugged comes back by itself, and the frames that it did not send are counted."""
import time

from case import BenchCase, Client, main, wait_for


class Unplug(BenchCase):
    def test_frames_missing_over_a_reconnection_are_counted(self):
        twin = Client("tcp://127.0.0.1:7790")
        self.addCleanup(twin.close)
        stream = self.stream("wavefront")
        first = stream.next(5.0)
        twin.call("twin.fault", {"kind": "unplug", "seconds": 2.0})
        frames, last = 1, first
        while last["t_arrival_ns"] < first["t_arrival_ns"] + 6_000_000_000:
            last = stream.next(10.0)
            frames += 1 + last["gap"]
        due = 1 + 100.0 * 1e-9 * (last["t_arrival_ns"] - first["t_arrival_ns"])
        reconnects = self.call("system.status")["counters"]["camera_reconnects"]
        print(f"\n  {frames} frames sent or counted as missing, {due:.0f} due, {reconnects} reconnections")
        self.assertGreaterEqual(reconnects, 1)
        self.assertLess(abs(frames - due), 0.1 * due)

    def test_frames_come_again_however_shortly_the_camera_was_unplugged(self):
        twin = Client("tcp://127.0.0.1:7790")
        self.addCleanup(twin.close)
        stream = self.stream("wavefront")
        for seconds in (0.1, 0.3, 0.6, 2.0):
            with self.subTest(seconds=seconds):
                before = stream.next(10.0)
                twin.call("twin.fault", {"kind": "incomplete", "seconds": 9})  # the camera's properties change as it goes
                time.sleep(0.1)
                begun = time.monotonic()
                twin.call("twin.fault", {"kind": "unplug", "seconds": seconds})
                wait_for(lambda: stream.next(10.0)["t_arrival_ns"] > before["t_arrival_ns"] + (seconds + 0.05) * 1e9, 30.0, "frames")
                print(f"\n  {seconds} s: frames again after {time.monotonic() - begun:.1f} s")
                self.assertTrue(twin.call("twin.get")["camera"]["plugged"])


if __name__ == "__main__":
    main()
