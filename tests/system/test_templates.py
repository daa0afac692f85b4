"""Templates from the reference: better fits and correct modes on a bench that differs from the model; missing ones are reported."""
import statistics
import struct

from case import BenchCase, Client, main, wait_for

HIDDEN = [{"n": 2, "m": -2, "waves": 0.4}, {"n": 3, "m": 3, "waves": 0.15}]
SHOWN = [(3, 0.1), (4, 0.08), (7, 0.05), (9, -0.08)]  # Z(2,-2), Z(2,0), Z(3,-1), Z(3,3): j and waves
FRAMES = 50


class Templates(BenchCase):
    twin_config = {"aberration": HIDDEN}
    daemon_config = {"state": {"directory": "state"}, "tracking": {"tracker": "matched"}}

    def qualities(self, count=FRAMES):
        """Median quality of each spot; 0 for lost spots."""
        spots = self.stream("spots")
        rows = []
        for message in self.settled_frames(spots, count):
            table = list(struct.iter_unpack("<6f", message["binary"]))
            rows.append([row[5] for row in table])
        return [statistics.median(column) for column in zip(*rows)]

    def in_use(self):
        sensor = self.call("system.status")["sensor"]
        return sensor["template"], sensor["own_templates"], sensor["template_reason"]

    def read(self, j, waves):
        """Mean of each measured mode while one mode is shown."""
        fast = self.stream("wavefront")
        hologram_id = self.call("aberration.set", {"modes": [{"j": j, "waves": waves}]})["hologram_id"]
        frames = self.settled_frames(fast, FRAMES, hologram_id)
        latency = statistics.median(frame["latency_us"] for frame in frames)
        return dict(zip(frames[0]["j"], map(statistics.fmean, zip(*(frame["coefficients"] for frame in frames))))), latency

    def readings(self, name):
        for j, waves in SHOWN:
            found, latency_us = self.read(j, waves)
            others = max(abs(value) for k, value in found.items() if k != j)
            print(f"  {name}: {waves:+.3f} of j = {j} reads {found[j]:+.4f} ({100 * (found[j] / waves - 1):+.1f} %), others at most {others:.4f}, latency {latency_us:.0f} us")
            yield waves, found[j], others
        self.call("aberration.clear")

    def test_they_fit_better_and_read_modes_within_the_bound(self):
        self.assertEqual(self.call("sensor.get")["template"], "model")
        self.take_reference()
        self.assertEqual(self.in_use(), ("model", 0, None))
        model = self.qualities()
        print()
        list(self.readings("model"))
        self.call("sensor.set", {"template": "reference"})
        asked, own, reason = self.in_use()
        self.assertEqual((asked, own), ("reference", 0))
        self.assertIn("take one", reason)
        self.take_reference()
        self.assertEqual(self.in_use(), ("reference", 19, None))
        reference = self.qualities()
        print(f"  quality: model {min(model):.4f} to {max(model):.4f}, mean {statistics.fmean(model):.4f};"
              f" reference {min(reference):.4f} to {max(reference):.4f}, mean {statistics.fmean(reference):.4f}")
        self.assertGreater(statistics.fmean(reference), statistics.fmean(model))
        self.assertGreater(min(reference), min(model))
        for waves, found, others in self.readings("reference"):
            self.assertLess(abs(found - waves), 0.05 * abs(waves) + 0.005)
            self.assertLess(others, 0.01)
        # References are stored per template kind.
        self.call("sensor.set", {"template": "model"})
        self.assertEqual(self.in_use(), ("model", 0, None))
        self.assertTrue(self.call("system.status")["sensor"]["referenced"])
        self.call("sensor.set", {"template": "reference"})
        self.assertEqual(self.in_use(), ("reference", 19, None))

    def test_what_is_in_use_is_said_and_a_set_is_all_or_nothing(self):
        before = self.call("sensor.get")
        for params, field in (({"template": "reference", "charge": 99}, "charge"), ({"template": "own"}, "template"),
                              ({"tracker": "lg_contour", "template": "reference"}, "tracker")):
            self.assertEqual(self.refused("sensor.set", params).data["field"], field)
            self.assertEqual(self.call("sensor.get"), before)
        applied = self.call("sensor.set", {"template": "reference", "tracker": "lg"})["applied"]
        self.assertEqual((applied["template"], applied["tracker"]), ("reference", "lg"))
        self.assertIn("only the tracker matched", self.in_use()[2])
        self.call("sensor.set", {"tracker": "matched"})
        self.take_reference(1)  # may or may not contain an image
        _, own, reason = self.in_use()
        print(f"\n  a reference of one frame: {own} templates, {reason}")
        self.assertTrue((own == 19) == (reason is None) and (own == 19 or "no mean image" in reason))
        # A spot that is saturated in the reference uses the model's template, which is reported.
        twin = Client("tcp://127.0.0.1:7790")
        self.addCleanup(twin.close)
        twin.call("twin.set", {"noise": "none"})
        twin.call("twin.set", {"peak_electrons": 3000})  # no spot saturates
        wait_for(lambda: self.stream("spots").next(5.0)["saturated"] == 0.0, what="spots that are not saturated")
        peaks = sorted(row[4] for row in struct.iter_unpack("<6f", self.stream("spots").next(5.0)["binary"]))
        exposure_us = self.call("camera.get")["settings"]["exposure_us"] * 255.0 / (peaks[-1] * peaks[-2]) ** 0.5
        self.call("camera.set", {"exposure_us": exposure_us})  # only the brightest spot saturates
        wait_for(lambda: 0.0 < self.stream("spots").next(5.0)["saturated"] < 0.1, what="one saturated spot")
        self.call("reference.clear")
        self.take_reference(20)
        _, own, reason = self.in_use()
        print(f"  overexposed: {own} templates, {reason}")
        self.assertLess(own, 19)
        self.assertIn("saturated", reason)
        self.assertLess(len(reason), 200)
        self.call("config.save")
        self.assertEqual(self.call("config.get")["tracking"]["template"], "reference")


if __name__ == "__main__":
    main()
