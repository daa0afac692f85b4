"""The operator from displacements to modes: requested, computed at once, and more accurate."""
import statistics
import time

from case import TWIN, BenchCase, Client, main, next_message, wait_for
from losses import Account

# The error is not noise: it grows with the square of the mode, because the matrix is linear.
SHOWN = [(3, 0.04), (7, -0.04), (12, 0.04)]
LARGEST_ERROR = 0.04  # of the mode that is shown
FRAMES = 50


class Operator(BenchCase):
    daemon_config = {"tracking": {"tracker": "lg", "operator": "diffractive"}}

    def in_use(self):
        sensor = self.call("system.status")["sensor"]
        return sensor["operator"], sensor["operator_in_force"], sensor["operator_reason"]

    def error(self, j, waves):
        """Measurement error with one mode shown: root sum square over all modes, waves."""
        fast = self.stream("wavefront")
        hologram_id = self.call("aberration.set", {"modes": [{"j": j, "waves": waves}]})["hologram_id"]
        frames = self.settled_frames(fast, FRAMES, hologram_id)
        found = dict(zip(frames[0]["j"], map(statistics.fmean, zip(*(frame["coefficients"] for frame in frames)))))
        return sum((value - (waves if k == j else 0.0)) ** 2 for k, value in found.items()) ** 0.5

    def errors(self, name):
        errors = {j: self.error(j, waves) for j, waves in SHOWN}
        print(f"\n  {name}: error of all modes at 0.04 wave " + ", ".join(f"{error:.5f} (j = {j})" for j, error in errors.items()))
        self.call("aberration.clear")
        return errors

    def test_it_is_made_beside_the_measurement_and_reads_small_modes_better(self):
        self.assertEqual(self.in_use(), ("diffractive", "diffractive", None))  # the configuration's
        events = self.stream("event")
        twin = Client(TWIN)
        self.addCleanup(twin.close)
        account = Account(self.client, twin, self.stream("wavefront"))
        self.take_reference()
        events.drain()
        diffractive = self.errors("diffractive")
        applied = self.call("sensor.set", {"operator": "slopes"})["applied"]
        self.assertEqual((applied["operator"], self.in_use()), ("slopes", ("slopes", "slopes", None)))
        self.assertTrue(self.call("system.status")["sensor"]["referenced"])  # both operators use the same reference
        slopes = self.errors("slopes")
        account.hear()
        for j, waves in SHOWN:
            error = diffractive[j]
            self.assertLess(error, LARGEST_ERROR * abs(waves))
            self.assertLess(error, slopes[j])
        self.assertLess(sum(diffractive.values()), 0.5 * sum(slopes.values()))
        self.assertEqual(self.call("sensor.set", {"operator": "diffractive"})["applied"]["operator"], "diffractive")
        self.assertEqual(self.in_use(), ("diffractive", "diffractive", None))
        for other in ({"subapertures_across": 4}, {"subapertures_across": 5, "tracker": "lg"}):
            started = time.monotonic()
            self.call("sensor.set", other)
            print(f"  {other}: {time.monotonic() - started:.2f} s")
            self.assertEqual(self.in_use(), ("diffractive", "diffractive", None))
        self.assertEqual(self.call("sensor.get")["operator_in_force"], "diffractive")
        job, said, data = self.take_reference()["job"], [], {}  # its last event comes after all others
        while (data.get("job"), data.get("state")) != (job, "done"):
            event = next_message(events)
            data = event["data"] or {}
            if event["kind"] == "sensor" and "operator" in data:
                said.append(data["operator"])
        self.assertEqual(said, ["slopes", "diffractive"])
        account.check(self)

    def test_an_unknown_operator_is_refused_and_the_rest_saved(self):
        before = self.call("sensor.get")
        self.assertEqual(self.refused("sensor.set", {"operator": "slope", "charge": 0}).data["field"], "operator")
        self.assertEqual(self.call("sensor.get")["charge"], before["charge"])
        self.assertEqual(self.call("config.get")["tracking"]["operator"], "diffractive")
        # A region without spots: the reason is reported, and the slopes stay active.
        self.call("camera.set", {"roi": {"x": 0, "y": 0, "width": 64, "height": 64}})
        reason = wait_for(lambda: (now := self.in_use())[1] == "slopes" and "finds only" in (now[2] or "") and now[2])
        print(f"\n  without spots: {reason}")


if __name__ == "__main__":
    main()
