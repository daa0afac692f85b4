"""The tracker `matched` and its templates of older versions: accepted, and measured by `fit` with two estimates."""
import statistics

from case import BenchCase, main

HIDDEN = [{"n": 2, "m": -2, "waves": 0.4}, {"n": 3, "m": 3, "waves": 0.15}]
SHOWN = [(3, 0.1), (4, 0.08), (7, 0.05), (9, -0.08)]  # Z(2,-2), Z(2,0), Z(3,-1), Z(3,3): j and waves
FRAMES = 50


class Templates(BenchCase):
    twin_config = {"aberration": HIDDEN}
    daemon_config = {"state": {"directory": "state"}, "tracking": {"tracker": "matched", "template": "reference"}}

    def read(self, j, waves):
        """Mean of each measured mode while one mode is shown."""
        fast = self.stream("wavefront")
        hologram_id = self.call("aberration.set", {"modes": [{"j": j, "waves": waves}]})["hologram_id"]
        frames = self.settled_frames(fast, FRAMES, hologram_id)
        self.assertEqual({frame["tracker"] for frame in frames}, {"fit"})
        return dict(zip(frames[0]["j"], map(statistics.fmean, zip(*(frame["coefficients"] for frame in frames)))))

    def test_the_former_tracker_measures_by_fit(self):
        sensor = self.call("sensor.get")
        self.assertEqual((sensor["tracker"], sensor["estimates"], sensor["template"], sensor["own_templates"]), ("fit", 2, "reference", 0))
        self.assertIn("no effect", sensor["template_reason"])
        self.take_reference()
        print()
        for j, waves in SHOWN:
            found = self.read(j, waves)
            others = max(abs(value) for k, value in found.items() if k != j)
            print(f"  {waves:+.3f} of j = {j} reads {found[j]:+.4f} ({100 * (found[j] / waves - 1):+.1f} %), others at most {others:.4f}")
            self.assertLess(abs(found[j] - waves), 0.05 * abs(waves) + 0.005)
            self.assertLess(others, 0.01)
        self.call("aberration.clear")
        applied = self.call("sensor.set", {"tracker": "matched", "template": "model", "estimates": 4})["applied"]
        self.assertEqual((applied["tracker"], applied["estimates"], applied["template"]), ("fit", 4, "model"))
        self.assertIsNone(self.call("sensor.get")["template_reason"])
        self.call("config.save")
        self.assertEqual(self.call("config.get")["tracking"]["tracker"], "fit")


if __name__ == "__main__":
    main()
