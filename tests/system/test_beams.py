"""Several light sources on one camera: each is measured by its own plan, against its own reference."""
import json
import subprocess
import time

import numpy as np
from case import PATIENCE_S, PROGRAM_PATIENCE_S, BenchCase, main, wait_for

from ovws_client import Subscription, Wavefront  # noqa: E402  (case finds it)

OFFSETS = {"b": [3.0, 418.0], "c": [-2.0, 852.0]}  # where the sources are
CONFIGURED = [{"name": "b", "offset_px": [0.0, 424.0]}, {"name": "c", "offset_px": [0.0, 848.0]}]
HIDDEN = {"": {3: 0.05, 4: -0.03}, "b": {4: 0.08, 5: 0.04}, "c": {7: 0.04, 3: -0.06}}
TOPICS = {"wavefront": "", "wavefront.b": "b", "wavefront.c": "c"}


class Beams(BenchCase):
    twin_config = {"camera": {"sensor_width": 512, "sensor_height": 1344},
                   "sources": [{"offset_px": OFFSETS["b"]}, {"offset_px": OFFSETS["c"], "power": 0.7}]}
    daemon_config = {"camera": {"roi": {"x": 0, "y": 0, "width": 512, "height": 1344}},
                     "optics": {"centre_px": [255.5, 255.5]}, "beams": CONFIGURED, "stream": {"image_rate_hz": 0}, "state": {"directory": "state"},
                     "record": {"directory": "recordings"}}

    def setUp(self):
        super().setUp()
        self.changed_ns = 0
        self.peak_electrons = self.twin.call("twin.get")["peak_electrons"]

    def light(self, hidden, power=None):
        """Gives each source its aberration; `power`: of b and c."""
        power = power or {"b": 1.0, "c": 0.7}
        modes = {name: [{"j": j, "waves": waves} for j, waves in hidden.get(name, {}).items()] for name in ("", "b", "c")}
        self.twin.call("twin.set", {"aberration": modes[""], "sources": [
            {"offset_px": OFFSETS[name], "power": power[name], "aberration": modes[name]} for name in ("b", "c")]})
        self.changed_ns = time.time_ns()

    def place_b(self, b_px):
        self.twin.call("twin.set", {"sources": [{"offset_px": [3.0, b_px]}, {"offset_px": OFFSETS["c"], "power": 0.7}]})
        self.changed_ns = time.time_ns()

    def newest(self, stream):
        """The newest message of every source, of one settled frame exposed after the last change: one that arrived late is not settled."""
        stream.drain()
        frames, end = {}, time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            message = stream.next(0.5)
            if message is None or message["topic"] not in TOPICS or not message["settled"] or message["t_device_ns"] <= self.changed_ns:
                continue
            frame = frames.setdefault(message["frame_id"], {})
            frame[TOPICS[message["topic"]]] = message
            if len(frame) == 3:
                return frame
        self.fail("no complete frame came")

    def all_valid(self, stream):
        return wait_for(lambda: (now := self.newest(stream)) and all(m["valid"] for m in now.values()) and now, what="three valid sources")

    def validity(self, stream):
        """Whether each source is valid in a settled frame: frames that come late are not settled."""
        frame = self.newest(stream)
        return [frame[name]["valid"] for name in ("", "b", "c")]

    def assert_modes(self, message, hidden, within=0.012):
        for j, waves in zip(message["j"], message["coefficients"]):
            if j > 2:
                self.assertAlmostEqual(waves, hidden.get(j, 0.0), delta=within, msg=f"{message['topic']} j = {j}")

    def test_each_source_is_measured_against_its_own_reference(self):
        stream = self.stream("wavefront")
        states = self.call("system.status")["sensor"]["beams"]
        self.assertEqual([(one["name"], one["referenced"]) for one in states], [("b", False), ("c", False)])
        self.take_reference()
        self.light(HIDDEN)
        frame = self.all_valid(stream)
        for name, hidden in HIDDEN.items():
            self.assert_modes(frame[name], hidden)
        states = wait_for(lambda: (now := self.call("system.status")["sensor"]["beams"])[1]["referenced"] and now)
        for one in states:
            for found, true in zip(one["offset_px"], OFFSETS[one["name"]]):
                self.assertAlmostEqual(found, true, delta=0.3)
        # A new reference of one source is that of no other.
        self.take_reference(beam="b")
        self.changed_ns = time.time_ns()
        frame = self.all_valid(stream)
        self.assert_modes(frame["b"], {})
        for name in ("", "c"):
            self.assert_modes(frame[name], HIDDEN[name])
        with Subscription(Wavefront.of_beam("c"), timeout_s=PATIENCE_S) as typed:
            message = wait_for(lambda: (frame := next(typed)).valid and frame, what="a valid frame of c")
            self.assertAlmostEqual(message.waves(7), HIDDEN["c"][7], delta=0.012)
        self.assertEqual(self.refused("reference.take", {"frames": 5, "beam": "d"}).field, "beam")

    def test_the_lost_spots_of_each_source_are_reported(self):
        """The camera's region ends just before the last spot of the middle row of c."""
        cut = 512 - max(x for x, _ in self.model_px()) + 1.0
        self.bench.stop("ovwsd")
        self.start_daemon(beams=[CONFIGURED[0], {"name": "c", "offset_px": [cut, 848.0]}])
        self.wait_until("running")
        self.twin.call("twin.set", {"sources": [{"offset_px": OFFSETS["b"]}, {"offset_px": [cut, 852.0], "power": 0.7}]})
        events = self.stream("event")
        self.assertEqual(self.take_reference()["result"]["lost_spots"], [])  # of the main source
        told = wait_for(lambda: (event := events.next(1.0)) and event["topic"] == "event" and "lost_spots" in (event["data"] or {}) and event, what="the event")
        self.assertEqual((told["data"]["beam"], told["data"]["lost_spots"]), ("c", [11]))
        self.assertIn("of the source c", told["text"])
        self.assertEqual(self.take_reference(beam="c")["result"]["lost_spots"], [11])
        self.assertEqual(self.take_reference(beam="b")["result"]["lost_spots"], [])

    def model_px(self):
        """Where the spots of the main source lie."""
        return self.call("reference.set", {"source": "model"})["positions_px"]

    def test_given_positions_are_the_reference_of_the_main_source_alone(self):
        self.call("sensor.set", {"tracker": "lg"})
        self.take_reference()
        reference = self.call("reference.get")
        given = np.array([reference["positions_px"], reference["standard_error_px"]], "<f4")
        self.client.call("reference.give", {"frames": 50}, given.tobytes())
        self.assertEqual([one["referenced"] for one in self.call("system.status")["sensor"]["beams"]], [True, True])
        self.light(HIDDEN)
        frame = self.all_valid(self.stream("wavefront"))
        for name, hidden in HIDDEN.items():
            self.assert_modes(frame[name], hidden)

    def test_the_command_line_uses_the_main_source(self):
        """A subscription to `spots` brings those of all sources: the message of c is the last of each frame."""
        self.bench.stop("ovwsd")
        self.start_daemon(stream={"image_rate_hz": 10})
        self.wait_until("running")
        stream = self.stream("wavefront")
        self.take_reference()
        self.light({}, {"b": 1.0, "c": 0.0})
        wait_for(lambda: not self.newest(stream)["c"]["valid"], what="c to be dark")
        shown = self.run_ovws("--json", "snapshot", "-o", self.bench.directory / "snap")
        self.assertTrue(json.loads(shown.stdout)["valid"], shown.stderr)

    def test_a_lattice_whose_sources_overlap_is_refused(self):
        refused = self.refused("lattice.prepare", {"lattices": [{"name": "fine"}, {"name": "wide", "sensor": {"spacing": 0.35}}]})
        self.assertEqual(refused.data["field"], "lattices[1].sensor")
        self.assertIn("overlap", str(refused))
        self.assertEqual(self.refused("sensor.set", {"spacing": 0.35}).data["field"], "beams[0].offset_px")

    def test_sources_that_drift_together_are_not_valid(self):
        stream, events = self.stream("wavefront"), self.stream("event")
        self.take_reference()
        self.all_valid(stream)
        for b_px, valid in ((380.0, True), (356.0, False), (350.0, False), (338.0, False), (418.0, True)):
            self.place_b(b_px)
            expected = [valid, valid, True]
            wait_for(lambda: self.validity(stream) == expected, what=f"validity at {b_px} px")
            for _ in range(5):
                self.assertEqual(self.validity(stream), expected, b_px)
            if b_px == 350.0:
                sensor = wait_for(lambda: (now := self.call("system.status")["sensor"])["invalid"] and now["beams"][0]["reason"] and now, what="the reasons")
                self.assertIn("too close to those of the source b", sensor["invalid"]["reason"])
                self.assertIn("too close to those of the main source", sensor["beams"][0]["reason"])
                self.assertIsNone(sensor["beams"][1]["reason"])
                told = wait_for(lambda: (event := events.next(1.0)) and event["kind"] == "spots" and "beam" not in event["data"] and event, what="the event")
                self.assertIn("too close to those of the source b", told["text"])

    def test_a_replay_knows_the_other_sources(self):
        """Those too close to the main one, and those among which it searches for its spots."""
        stream = self.stream("wavefront")
        for tracker in ("lg", "fit"):
            self.call("sensor.set", {"tracker": tracker})
            self.take_reference()
            # A busy machine may record frames without their images.
            wait_for(lambda: self.replayed(stream)["refused"] >= 10, what=f"a recording with ten images of refused frames of {tracker}")

    def replayed(self, stream):
        """Records frames of sources that come too close and are dark; returns the report of their replay."""
        self.all_valid(stream)
        name = f"recording-{time.time_ns()}"
        self.call("record.start", {"name": name})
        for b_px in (418.0, 356.0, 418.0):
            self.place_b(b_px)
            for _ in range(10):
                wait_for(lambda: self.validity(stream) == [b_px == 418.0] * 2 + [True], what=f"validity at {b_px} px")
        before = self.call("system.status")["counters"]["acquisitions"]
        self.twin.call("twin.set", {"peak_electrons": 1.0})  # all are dark
        wait_for(lambda: self.call("system.status")["counters"]["acquisitions"] > before + 6, what="searches")
        self.twin.call("twin.set", {"peak_electrons": self.peak_electrons})
        self.all_valid(stream)
        self.call("record.stop")
        report = self.replayed_again(name)
        print("\n ", report)
        return report

    def test_a_dark_source_disturbs_no_other(self):
        stream, events = self.stream("wavefront"), self.stream("event")
        self.take_reference()
        self.all_valid(stream)
        self.light({}, {"b": 0.0, "c": 0.7})
        wait_for(lambda: not self.newest(stream)["b"]["valid"], what="b to be dark")
        for _ in range(20):
            frame = self.newest(stream)
            self.assertEqual([frame[name]["valid"] for name in ("", "b", "c")], [True, False, True])
            self.assertEqual(frame["b"]["coefficients"][0], None)
        told = wait_for(lambda: (event := events.next(1.0)) and event["data"].get("beam") == "b" and event, what="the event")
        self.assertFalse(told["data"]["valid"])
        beams = wait_for(lambda: (now := self.call("system.status")["sensor"]["beams"])[0]["reason"] and now, what="the reason")
        self.assertIn("spots are found", beams[0]["reason"])
        self.assertIsNone(beams[1]["reason"])
        self.light({})
        self.all_valid(stream)

    def test_references_of_all_sources_survive_a_restart(self):
        stream = self.stream("wavefront")
        self.take_reference()
        self.light(HIDDEN)
        self.all_valid(stream)
        self.bench.stop("ovwsd")
        self.start_daemon()
        frame = self.all_valid(self.stream("wavefront"))
        for name, hidden in HIDDEN.items():
            self.assert_modes(frame[name], hidden)


class Overlapping(BenchCase):
    def start(self):
        pass

    def refusal(self, beams):
        config = self.bench.directory / "overlap.json"
        config.write_text(json.dumps({"camera": {"roi": {"x": 0, "y": 0, "width": 512, "height": 1024}},
                                      "optics": {"centre_px": [255.5, 255.5]}, "beams": beams}))
        checked = subprocess.run([self.bench.programs / "ovwsd", "--config", config], capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S)
        self.assertNotEqual(checked.returncode, 0)
        return checked.stderr + checked.stdout

    def test_sources_that_overlap_are_refused(self):
        text = self.refusal([{"name": "b", "offset_px": [0, 420]}, {"name": "c", "offset_px": [100, 500]}])
        self.assertIn("beams[1].offset_px", text)
        self.assertIn("overlap those of the source b", text)
        text = self.refusal([{"name": "b", "offset_px": [0, 200]}])
        self.assertIn("overlap those of the main source", text)
        text = self.refusal([{"name": "b", "offset_px": [0, 760]}])
        self.assertIn("outside the camera's region", text)
        self.assertIn("beams[0].name", self.refusal([{"name": "main", "offset_px": [0, 420]}]))


if __name__ == "__main__":
    main()
