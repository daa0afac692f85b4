"""Sequences of patterns on a DMD: each frame knows its pattern, lost frames or not, and what is refused."""
import time
from itertools import dropwhile
from random import Random

from case import BenchCase, main, merged, message_since, next_message, wait_for
from losses import Account

SLOTS = 8  # at 60 Hz: 480 frames/s
CYCLE_NS = 1e9 / 60.0
MOST_UNSEEN = 4  # cycles without a mark, after which it is searched again
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
        self.images = self.stream("image", endpoint="tcp://127.0.0.1:7703")

    def show(self, patterns=PATTERNS):
        return self.call("aberration.sequence", {"patterns": [modes(one) for one in patterns]})

    def certain(self, stream):
        """Waits for a whole cycle of valid frames."""
        stream.drain()
        seen = set()

        def whole():
            if (message := stream.next(0.5)) and message["valid"] and message["pattern"] is not None:
                seen.add(message["pattern"])
            return len(seen) == len(PATTERNS)
        wait_for(whole, what="a valid frame of every pattern")

    def reconnects(self):
        return self.call("system.status")["counters"]["camera_reconnects"]

    def next(self, stream, frames):
        return [next_message(stream) for _ in range(frames)]

    def pattern_in(self, slot):
        """The pattern of the sequence that slot `slot` shows; None: the mark."""
        return (slot - 1) % len(PATTERNS) if slot else None

    def collect(self, frames, faults=False):
        """Hears this many messages, and at least a quarter of them with a pattern. `faults`: some frames are lost, repeated or out of order."""
        self.late_before = self.call("system.status")["counters"]["frames_late"]
        account, random = Account(self.client, self.twin, self.stream("wavefront")), Random(1)

        def enough():
            if faults:
                self.twin.call("twin.fault", {"kind": random.choice(["drop", "drop", "incomplete", "duplicate", "reorder"]),
                                              "frames": random.randint(1, 3)})
            time.sleep(0.1)
            account.hear()
            return len(account.messages) >= frames and sum(message["pattern"] is not None for message in account.messages) >= frames // 4
        wait_for(enough, 300.0, f"{frames} messages, a quarter of them with a pattern")
        return account

    def known_by_rule(self, account):
        """Each message from the first one with a pattern on, and whether its pattern is certain by the guide's rule, given the slots that the
        twin reports: the mark of its own cycle was seen, and the marks are known. After MOST_UNSEEN cycles without one they are searched again."""
        messages = list(dropwhile(lambda message: message["pattern"] is None, account.messages))
        start_ns = messages[0]["t_device_ns"] - account.sent[messages[0]["t_device_ns"]]["slot"] * CYCLE_NS / SLOTS
        mark, searching, newest = 0, False, []  # cycle of the newest mark; frames since the search began
        for message in messages:
            slot = account.sent[message["t_device_ns"]]["slot"]
            cycle = round((message["t_device_ns"] - start_ns) / CYCLE_NS - slot / SLOTS)
            if searching:
                newest = [*newest, (cycle, slot)][-SLOTS - 1:]
                searching, mark = newest != [(cycle - 1, k) for k in range(SLOTS)] + [(cycle, 0)], cycle
                yield message, False
                continue
            if cycle - mark > MOST_UNSEEN:
                searching, newest = True, []
            elif slot == 0:
                mark = cycle
            yield message, not searching and slot != 0 and mark == cycle

    def check(self, account):
        """Checks that each frame is published or counted, that none has a wrong pattern, by the twin and by what was measured, and that a
        frame whose pattern must be certain has it. Only late frames do not."""
        account.check(self)
        missing = certain = 0
        for message, known in self.known_by_rule(account):
            told = message["pattern"]
            missing += known and told is None
            if told is None:
                self.assertFalse(message["valid"] or message["settled"])
                continue
            certain += 1
            self.assertTrue(known, message)
            self.assertEqual(told, self.pattern_in(account.sent[message["t_device_ns"]]["slot"]), message)
            if message["valid"]:
                for j, waves in zip(message["j"], message["coefficients"]):
                    self.assertAlmostEqual(waves, PATTERNS[told].get(j, 0.0), delta=0.05, msg=f"j = {j} of pattern {told}")
        late = account.counters()["frames_late"] - self.late_before
        print(f"  {certain} of {len(account.messages)} frames have a pattern; {missing} lack one that is certain; {late} were late")
        self.assertLessEqual(missing, late)

    def test_a_frame_never_has_a_wrong_pattern(self):
        self.take_reference(100)
        stream = self.stream("wavefront")
        shown = self.show()
        self.assertEqual([[mode["j"] for mode in one["modes"]] for one in shown["patterns"]], [sorted(one) for one in PATTERNS])
        self.assertTrue(self.call("slm.verify")["equal"])
        self.certain(stream)
        self.check(self.collect(FRAMES))
        account = self.collect(3000, faults=True)
        self.check(account)
        self.assertIn("average", str(self.refused("camera.grab", {"frames": 4, "average": True, "region": CORNER})))
        grabbed = []

        def enough():
            grabbed.extend(self.call("camera.grab", {"frames": 2 * SLOTS, "region": CORNER})["frames"])
            return sum(frame["pattern"] is not None for frame in grabbed) > 2 * SLOTS
        wait_for(enough, what="grabbed frames with a pattern")
        images = self.next(self.images, 5)
        account.hear()
        for frame in grabbed:
            if frame["pattern"] is not None:
                self.assertEqual(frame["pattern"], self.pattern_in(account.sent[frame["t_device_ns"]]["slot"]))
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
        wait_for(lambda: (message := stream.next(0.5)) and message["exposure_us"] == 2300.0, what="a frame of the longer exposure")
        self.assertEqual({(message["pattern"], message["valid"]) for message in self.next(stream, 300)}, {(None, False)})
        self.call("camera.set", {"exposure_us": 1500.0, "frame_rate_hz": 480.0})
        self.certain(stream)
        # A job shows its own holograms; a recording that begins meanwhile ends with the sequence.
        job = self.call("registration.run", {"frames": 100})["job"]  # three seconds: this process may stand still meanwhile
        wait_for(lambda: self.call("aberration.get")["patterns"] == [], what="the job's hologram")
        self.call("record.start", recording)
        self.job_ended(job)
        self.assertEqual(len(self.call("aberration.get")["patterns"]), len(PATTERNS))
        ended = wait_for(lambda: (now := self.call("record.get"))["state"] == "ended" and now, what="the recording's end")
        self.assertIn("sequence", ended["reason"])
        self.certain(stream)
        for change in ({"roi": {"x": 8, "y": 8, "width": 496, "height": 496}}, {"roi": {"x": 0, "y": 0, "width": 512, "height": 512}}):
            self.call("camera.set", change)
        self.certain(stream)
        self.call("correction.set", modes({3: 0.02}))
        self.call("correction.clear")
        self.certain(stream)
        before = self.reconnects()
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 0.5})
        wait_for(lambda: self.reconnects() > before, what="the camera again")
        self.certain(stream)
        self.check(self.collect(1000))

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
        wait_for(valid, what="a valid frame")
        for method in ("loop.close", "loop.identify", "reference.take", "calibration.run", "record.start", "camera.auto_exposure"):
            self.assertIn("aberration.clear", str(self.refused(method)))
        self.twin.call("twin.set", {"peak_electrons": 0.0})
        message_since(stream, time.time_ns())
        wait_for(lambda: all(message["pattern"] is None for message in self.next(stream, 2 * SLOTS)), what="two cycles without light")
        self.assertFalse(any(message["valid"] for message in self.next(stream, 200)))
        wait_for(lambda: (why := self.call("system.status")["sensor"]["invalid"]) and "pattern" in why["reason"], what="the reason")
        self.twin.call("twin.set", {"peak_electrons": 60000})
        wait_for(valid, what="a valid frame after the light")
        hologram_id = self.call("aberration.set", modes({4: 0.1}))["hologram_id"]
        message = self.settled_frames(stream, 1, hologram_id)[0]
        self.assertIsNone(message["pattern"])
        self.assertAlmostEqual(message["coefficients"][message["j"].index(4)], 0.1, delta=0.02)
        self.assertEqual(self.call("aberration.get")["patterns"], [])
        self.show()
        cleared = self.run_ovws("setup", "-y", "clear")
        self.assertEqual(cleared.returncode, 0, cleared.stdout + cleared.stderr)
        now = self.call("aberration.get")
        self.assertEqual((now["modes"], now["patterns"]), ([], []))


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
        wait_for(lambda: said in (self.call("system.status")["camera"]["fault"] or ""), what="the camera's fault")
        self.assertEqual(self.call("system.status")["counters"]["frames_published"], 0)


if __name__ == "__main__":
    main()
