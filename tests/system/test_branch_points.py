"""Branch points of the light: frames are refused with the place, and a closed loop holds its correction."""
import struct
import time

from case import BenchCase, ClientError, main, message_since, next_message, wait_for


class BranchPoints(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}, "record": {"directory": "recordings"}}

    def light(self, stream, *points):
        self.twin.call("twin.set", {"branch_points": [{"x": x, "y": y, "charge": charge} for x, y, charge in points]})
        message_since(stream, time.time_ns())

    def frame(self, stream):
        stream.drain()
        return next_message(stream)

    def test_a_frame_is_refused_with_the_place(self):
        stream, events = self.stream("wavefront"), self.stream("event")
        self.take_reference()
        self.settled_frames(stream, 5)
        self.assertEqual(self.frame(stream)["branch_points"], [])
        for x, y, charge in ((0.3, 0.1, 1), (-0.1, -0.25, -1)):
            self.light(stream, (x, y, charge))
            frame = wait_for(lambda: (now := self.frame(stream))["branch_points"] and now, what="a branch point")
            self.assertFalse(frame["valid"])
            at_x, at_y, sign = frame["branch_points"][0]
            self.assertEqual(sign, charge)
            self.assertLess(((at_x - x) ** 2 + (at_y - y) ** 2) ** 0.5, 0.4)
            for _ in range(300):  # no rendering of a smooth wavefront may make it valid
                self.assertFalse(next_message(stream)["valid"])
            wait_for(lambda: (now := self.call("system.status")["sensor"]["invalid"]) and "branch point" in now["reason"], what="the reason")
        told = wait_for(lambda: (event := events.next(1.0)) and "branch_point" in event["data"] and event, what="the event")
        self.assertIn("phase singularity", told["text"])
        self.light(stream)
        wait_for(lambda: (now := self.frame(stream))["valid"] and not now["branch_points"], what="a valid frame")

    def test_a_refused_frame_is_refused_in_a_replay(self):
        stream = self.stream("wavefront")
        for charge in (1, 0):
            self.call("sensor.set", {"tracker": "lg", "charge": charge})
            self.call("camera.set", {"exposure_us": 2000.0 if charge else 500.0})  # bright spots are four times as bright
            self.light(stream)
            self.take_reference()
            # A busy machine may record frames without their images.
            wait_for(lambda: min((report := self.replayed(stream))["refused"], report["valid"]) >= 10, what="a recording with ten images of each kind")

    def replayed(self, stream):
        """Records valid and refused frames; returns the report of their replay."""
        self.light(stream)
        name = f"recording-{time.time_ns()}"
        self.call("record.start", {"name": name})
        self.frames_from_now(stream, 12)
        self.light(stream, (0.3, 0.1, 1))
        for _ in range(10):
            wait_for(lambda: self.frame(stream)["branch_points"], what="a branch point")
        self.call("record.stop")
        return self.replayed_again(name)

    def test_a_reference_is_refused_with_the_place(self):
        stream = self.stream("spots")
        self.take_reference()
        before = self.call("reference.get")
        for tracker in ("fit", "lg"):
            self.call("sensor.set", {"tracker": tracker})
            self.light(stream, (0.3, 0.1, 1))
            for frames in (5, 1):
                error = self.failure("reference.take", {"frames": frames})
                self.assertIn("a branch point (phase singularity) near", error)
                self.assertIn("charge +1", error)
        spots = wait_for(lambda: (now := self.frame(stream))["settled"] and now["tracked"] >= 16 and now, what="the spots")
        rows = list(struct.iter_unpack("<6f", spots["binary"]))
        given = [value for row in rows for value in row[:2]] + [0.01] * len(rows) * 2
        with self.assertRaisesRegex(ClientError, "branch point"):
            self.client.call("reference.give", {}, struct.pack(f"<{len(given)}f", *given))
        self.call("sensor.set", {"tracker": "fit"})
        self.assertEqual(self.call("reference.get"), before)
        self.light(stream)
        self.take_reference()

    def test_a_closed_loop_holds_its_correction(self):
        stream = self.stream("wavefront")
        self.take_reference()
        self.settled_frames(stream, 5)
        self.close_loop()
        wait_for(lambda: self.call("loop.get")["steps"] > 3, what="steps")
        before = self.call("correction.get")
        self.light(stream, (0.3, 0.1, 1))

        def holds():  # the loop may still step for frames from before
            stream.drain()
            steps = self.call("loop.get")["steps"]
            invalid = [not next_message(stream)["valid"] for _ in range(200)]
            return all(invalid) and self.call("loop.get")["steps"] == steps
        wait_for(holds, what="a loop that holds")
        print("\n ", self.call("system.status")["sensor"]["invalid"])
        held = self.call("correction.get")
        self.assertTrue(self.call("loop.get")["closed"])
        moved = {m["j"]: m["waves"] for m in held["modes"]}
        for mode in before["modes"]:
            moved[mode["j"]] = moved.get(mode["j"], 0.0) - mode["waves"]
        print("  largest change of the correction", max(map(abs, moved.values()), default=0.0))
        self.light(stream)
        wait_for(lambda: self.frame(stream)["valid"], what="a valid frame")
        self.assertLess(max(map(abs, moved.values()), default=0.0), 0.05)


if __name__ == "__main__":
    main()
