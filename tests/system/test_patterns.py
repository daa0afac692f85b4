"""Sequences of patterns on a DMD: each frame knows its pattern, lost frames or not, and what is refused."""
import time
from random import Random

from case import BenchCase, Client, main, merged, wait_for

SLOTS = 8  # at 60 Hz: 480 frames/s
PATTERNS = [{}, {1: 0.4, 4: 0.15}, {2: -0.4}, {3: 0.2}, {4: -0.15, 5: 0.1}]  # waves; slots 6 and 7 show 0 and 1 again
FRAMES = 10_000
CORNER = {"x": 0, "y": 0, "width": 8, "height": 8}


def modes(of):
    return {"modes": [{"j": j, "waves": waves} for j, waves in of.items()]}


class Patterns(BenchCase):
    twin_config = {"modulator": "dmd", "dmd": {"slots": SLOTS}, "light": {"peak_electrons": 60000}}
    daemon_config = {"modulator": "dmd", "dmd": {"slots": SLOTS}, "slm": {"settle_ms": 60.0}, "tracking": {"tracker": "lg"},
                     "camera": {"trigger": "Line0", "frame_rate_hz": 480.0, "exposure_us": 1500.0}, "stream": {"image_rate_hz": 5}, "record": {"directory": "recordings"},
                     "state": {"directory": "state"}}

    def setUp(self):
        super().setUp()
        self.twin = Client("tcp://127.0.0.1:7790")
        self.addCleanup(self.twin.close)
        self.images = self.stream("image", endpoint="tcp://127.0.0.1:7703")

    def show(self, patterns=PATTERNS):
        return self.call("aberration.sequence", {"patterns": [modes(one) for one in patterns]})

    def certain(self, stream):
        """Waits for a whole cycle of valid frames."""
        stream.drain()
        seen = set()
        end = time.monotonic() + 20.0
        while len(seen) < len(PATTERNS):
            self.assertLess(time.monotonic(), end, f"certain and valid in 20 s: {seen}")
            message = stream.next(0.5)
            if message is not None and message["valid"] and message["pattern"] is not None:
                seen.add(message["pattern"])

    def next(self, stream, frames):
        return [wait_for(lambda: stream.next(1.0), 10.0, "a frame") for _ in range(frames)]

    def pattern_in(self, slot):
        """The pattern of the sequence that slot `slot` shows; None: the mark."""
        return (slot - 1) % len(PATTERNS) if slot else None

    def ask(self, slots, newest):
        """Adds the twin's frames after number `newest` to `slots`; returns the newest number."""
        while sent := self.twin.call("twin.get", {"sent_after": newest} if newest else {})["sent"]:
            slots.update((one["t_ns"], one["slot"]) for one in sent)
            if newest is None:
                return sent[-1]["frame_id"]
            newest = sent[-1]["frame_id"]
        return newest

    def collect(self, stream, frames, faults=False):
        """The next messages, and the slot that each frame's light came from, by its timestamp. `faults`: some frames are lost, repeated or
        out of order."""
        heard, slots, newest = [], {}, None
        random = Random(1)
        end = time.monotonic() + 120.0
        while len(heard) < frames:
            self.assertLess(time.monotonic(), end, f"{len(heard)} frames in 120 s")
            message = stream.next(0.5)
            if message is not None:
                heard.append(message)
            if faults and len(heard) % 40 == 0:
                self.twin.call("twin.fault", {"kind": random.choice(["drop", "drop", "incomplete", "duplicate", "reorder"]),
                                              "frames": random.randint(1, 3)})
            if newest is None or len(heard) % 400 == 0 or len(heard) == frames:
                newest = self.ask(slots, newest)
        self.newest = newest
        return heard, slots

    def check(self, heard, slots):
        """That no frame has a wrong pattern, by the twin and by what was measured. The fraction of certain frames with light."""
        compared = lit = certain = 0
        for message in heard:
            slot = slots.get(message["t_device_ns"])
            if slot is None:
                continue  # sent before the first question
            compared += 1
            lit += slot != 0
            told = message["pattern"]
            if told is None:
                self.assertFalse(message["valid"] or message["settled"])
                continue
            certain += 1
            self.assertEqual(told, self.pattern_in(slot), message)
            if message["valid"]:
                for j, waves in zip(message["j"], message["coefficients"]):
                    self.assertAlmostEqual(waves, PATTERNS[told].get(j, 0.0), delta=0.05, msg=f"j = {j} of pattern {told}")
        valid = sum(message["valid"] for message in heard)
        print(f"\n  {len(heard)} frames, {compared} compared: {certain / max(lit, 1):.3f} of those with light are certain; "
              f"{valid} valid; gaps {sum(message['gap'] for message in heard)}")
        self.assertGreater(compared, 0.9 * len(heard))
        return certain / lit

    def test_a_frame_never_has_a_wrong_pattern(self):
        self.take_reference(100)
        stream = self.stream("wavefront")
        shown = self.show()
        self.assertEqual([[mode["j"] for mode in one["modes"]] for one in shown["patterns"]], [sorted(one) for one in PATTERNS])
        self.assertTrue(self.call("slm.verify")["equal"])
        self.certain(stream)
        stream.drain()
        self.assertGreater(self.check(*self.collect(stream, FRAMES)), 0.5)  # a busy machine loses some
        stream.drain()
        self.assertGreater(self.check(*self.collect(stream, 3000, faults=True)), 0.3)
        self.assertIn("average", str(self.refused("camera.grab", {"frames": 4, "average": True, "region": CORNER})))
        grabbed = [frame for _ in range(4) for frame in self.call("camera.grab", {"frames": 2 * SLOTS, "region": CORNER})["frames"]]
        images = [wait_for(lambda: self.images.next(0.5), 5.0, "an image") for _ in range(5)]
        slots = {sent["t_ns"]: sent["slot"] for sent in self.twin.call("twin.get", {"sent_after": self.newest})["sent"]}
        self.assertGreater(sum(frame["pattern"] is not None for frame in grabbed), 2 * SLOTS)
        for frame in grabbed:
            if frame["pattern"] is not None:
                self.assertEqual(frame["pattern"], self.pattern_in(slots[frame["t_device_ns"]]))
            self.assertEqual(frame["settled"], frame["pattern"] is not None)
        self.assertTrue(all(image["pattern"] in (None, *range(len(PATTERNS))) for image in images))

    def test_the_sequence_through_changes_jobs_and_faults(self):
        self.take_reference(100)
        stream = self.stream("wavefront")
        self.show()
        self.certain(stream)
        recording = {"name": "sequence"}
        # An exposure of more than a slot shows two patterns: no frame is certain.
        self.call("camera.set", {"exposure_us": 2300.0, "frame_rate_hz": 400.0})
        wait_for(lambda: (message := stream.next(0.5)) and message["exposure_us"] == 2300.0, 10.0, "a frame of the longer exposure")
        self.assertEqual({(message["pattern"], message["valid"]) for message in self.next(stream, 300)}, {(None, False)})
        self.call("camera.set", {"exposure_us": 1500.0, "frame_rate_hz": 480.0})
        self.certain(stream)
        # A job shows its own holograms; a recording that begins meanwhile ends with the sequence.
        job = self.call("registration.run", {"frames": 40})["job"]
        wait_for(lambda: self.call("aberration.get")["patterns"] == [], 10.0, "the job's hologram")
        self.call("record.start", recording)
        wait_for(lambda: self.call("job.get", {"job": job})["state"] != "running", 60.0, "the job's end")
        self.assertEqual(len(self.call("aberration.get")["patterns"]), len(PATTERNS))
        ended = wait_for(lambda: (now := self.call("record.get"))["state"] == "ended" and now, 10.0, "the recording's end")
        self.assertIn("sequence", ended["reason"])
        self.certain(stream)
        for change in ({"roi": {"x": 8, "y": 8, "width": 496, "height": 496}}, {"roi": {"x": 0, "y": 0, "width": 512, "height": 512}}):
            self.call("camera.set", change)
        self.certain(stream)
        self.call("correction.set", modes({3: 0.02}))
        self.call("correction.clear")
        self.certain(stream)
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 0.5})
        wait_for(lambda: not self.call("system.status")["camera"]["connected"], 20.0, "a lost camera")
        wait_for(lambda: self.call("system.status")["camera"]["connected"], 30.0, "the camera again")
        self.certain(stream)
        self.check(*self.collect(stream, 1000))

    def test_light_that_fails_and_what_is_refused(self):
        self.take_reference(100)
        stream = self.stream("wavefront")
        for method, params, word in (("aberration.sequence", {"patterns": [modes({})] * SLOTS}, "at most 7"),
                                     ("aberration.sequence", {"patterns": []}, "patterns"),
                                     ("aberration.sequence", {"patterns": [{"modes": [{"j": 4, "waves": 1e9}]}]}, "waves"),
                                     ("aberration.sequence", {"patterns": [modes({}), modes({200: 90.0})]}, "patterns[1].modes")):
            with self.subTest(params=str(params)[:60]):
                self.assertIn(word, str(self.refused(method, params)))
                self.assertEqual(self.call("aberration.get")["patterns"], [])
        self.call("slm.set", {"settle_ms": 20.0})
        self.assertEqual(self.refused("aberration.sequence", {"patterns": [modes({})]}).data["field"], "slm.settle_ms")
        self.call("slm.set", {"settle_ms": 60.0})
        self.call("camera.set", {"exposure_us": 2090.0, "frame_rate_hz": 470.0})
        self.assertIn("longer than a pattern", str(self.refused("aberration.sequence", {"patterns": [modes({})]})))
        self.call("camera.set", {"exposure_us": 1500.0, "frame_rate_hz": 480.0})
        self.show()
        valid = lambda: (message := stream.next(0.5)) and message["valid"] and message["pattern"] is not None  # noqa: E731
        wait_for(valid, 10.0, "a valid frame")
        for method in ("loop.close", "loop.identify", "reference.take", "calibration.run", "record.start", "camera.auto_exposure"):
            self.assertIn("aberration.clear", str(self.refused(method)))
        self.twin.call("twin.set", {"peak_electrons": 0.0})
        stream.drain()
        wait_for(lambda: all(message["pattern"] is None for message in self.next(stream, 2 * SLOTS)), 10.0, "two cycles without light")
        for _ in range(200):
            self.assertFalse(stream.next(1.0)["valid"])
        why = wait_for(lambda: self.call("system.status")["sensor"]["invalid"], what="the reason")
        self.assertIn("pattern", why["reason"])
        self.twin.call("twin.set", {"peak_electrons": 60000})
        wait_for(valid, 10.0, "a valid frame after the light")
        self.call("aberration.set", modes({4: 0.1}))
        stream.drain()
        message = wait_for(lambda: (m := stream.next(0.5)) and m["valid"] and m["settled"] and m, 10.0, "a frame of one hologram")
        self.assertIsNone(message["pattern"])
        self.assertAlmostEqual(message["coefficients"][message["j"].index(4)], 0.1, delta=0.02)
        self.assertEqual(self.call("aberration.get")["patterns"], [])


class FreeCamera(BenchCase):
    twin_config = {"modulator": "dmd", "dmd": {"slots": SLOTS}, "light": {"peak_electrons": 60000}}
    daemon_config = {"modulator": "dmd", "dmd": {"slots": SLOTS}}

    def test_a_camera_without_a_trigger_takes_no_sequence(self):
        self.assertEqual(self.refused("aberration.sequence", {"patterns": [modes({})]}).data["field"], "camera.trigger")


class WrongTrigger(BenchCase):
    twin_config = FreeCamera.twin_config
    daemon_config = merged(FreeCamera.daemon_config, {"camera": {"trigger": "Line7"}})

    def start(self):
        self.start_display()
        self.start_twin()
        self.start_daemon()

    def test_a_trigger_that_the_camera_does_not_have_is_a_fault(self):
        said = '"Line7" is no TriggerSource of this camera, which has Line0'
        wait_for(lambda: said in (self.call("system.status")["camera"]["fault"] or ""), 20.0, "the camera's fault")
        self.assertEqual(self.call("system.status")["counters"]["frames_published"], 0)


if __name__ == "__main__":
    main()
