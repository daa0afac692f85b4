"""The daemon measures the look-up table of its SLM, compared with the twin's truth."""
import math

from case import main, wait_for
from slm_case import SlmCase

TWO_PI = 2.0 * math.pi


def lut_error_rad(grey_levels, truth_waves):
    """RMS error of the phases shown, over the reachable range, without piston, rad."""
    falls = truth_waves[255] < 0.0
    wanted = [k / 256 for k in range(256) if (1.0 - k / 256 if falls and k > 0 else k / 256) <= abs(truth_waves[255])]
    off = [math.remainder(truth_waves[grey_levels[round(256 * phase)]] - phase, 1.0) for phase in wanted]
    mean = sum(off) / len(off)
    return TWO_PI * math.sqrt(sum((x - mean) ** 2 for x in off) / len(off))


class LookUpTable(SlmCase):
    small = True

    def measure(self, depth_waves):
        truth = self.judge()
        before, path = self.call("lut.get"), truth["lut_waves"]
        first_order = truth["wavefront"].get("first_order", math.nan)
        self.assertEqual((before["source"], before["measured"]), ("linear", False))
        found = self.run_job("lut.run", {"levels": 17, "frames": 2})["result"]
        self.assertEqual(self.call("lut.get"), found)
        after = wait_for(lambda: self.judge()["wavefront"].get("first_order"), what="a twin that sees the sensor's hologram again")
        curve = math.sqrt(sum((p - TWO_PI * w) ** 2 for p, w in zip(found["phase_rad"], path)) / 256)
        error = lut_error_rad(found["grey_levels"], path)
        print(f"\n  depth {depth_waves} waves, found {found['depth_rad'] / TWO_PI:.4f}: response {curve:.4f} rad, LUT "
              f"{lut_error_rad(before['grey_levels'], path):.3f} -> {error:.4f} rad RMS, first order {first_order:.4f} -> {after:.4f}, "
              f"noise {found['noise_rad']:.4f} rad")
        self.assertLess(error, 0.05)
        self.assertLess(curve, 0.05)
        self.assertAlmostEqual(found["depth_rad"], abs(TWO_PI * path[255]), delta=0.05)
        self.assertEqual(found["falls"], depth_waves < 0.0)
        self.assertEqual(found["reaches_2pi"], abs(depth_waves) >= 1.0)
        self.assertEqual(found["reason"] is None, abs(depth_waves) >= 1.0)
        return found, first_order, after


class ShallowSlm(LookUpTable):
    twin_config = {"slm": {"gamma": 1.4, "depth_waves": 0.9}}

    def check_clear_that_fails(self, found):
        """Checks that a failed lut.clear changes neither the active table nor the stored file."""
        kept = self.bench.directory / "state" / "lut.slm.json"
        aside = kept.with_suffix(".aside")
        kept.rename(aside)
        (kept / "x").mkdir(parents=True)  # a folder cannot be removed as a file
        self.refused("lut.clear")
        self.assertEqual(self.call("lut.get"), found)
        self.assertTrue(self.call("reference.get")["taken"])
        (kept / "x").rmdir()
        kept.rmdir()
        aside.rename(kept)
        display = int(self.bench.display[1:])
        self.bench.stop("xorg")
        self.wait_until("waiting_for_display")
        self.refused("lut.clear")
        self.assertEqual(self.call("lut.get"), found)
        self.start_display(display)
        self.restart()
        self.assertEqual(self.call("lut.get"), found)

    def test_is_measured_kept_and_cleared(self):
        self.take_reference(10)
        linear = self.call("reference.get")
        found, before, after = self.measure(0.9)
        self.assertGreater(after, before + 0.05)
        self.assertFalse(self.call("reference.get")["taken"], "it belongs to the LUT of before")
        self.take_reference(10)
        self.restart()
        self.assertEqual(self.call("lut.get"), found)
        self.assertTrue(self.call("reference.get")["taken"], "it belongs to the LUT that is in force again")
        self.assertIsNotNone(found["sha256"])
        self.check_clear_that_fails(found)
        cleared = self.call("lut.clear")
        self.assertEqual((cleared["source"], cleared["grey_levels"]), ("linear", list(range(256))))
        self.assertEqual(self.call("reference.get"), linear, "it belongs to the LUT that is in force again")
        self.check_exposure()

    def check_exposure(self):
        """The job finds an exposure of its own, and restores the camera's."""
        before = self.call("camera.get")["settings"]
        for light, wanted in ((600_000, 0.9), (60, 0.9)):  # 100 times as bright, and as dim, as usual
            self.twin.call("twin.set", {"peak_electrons": light})
            self.assertLess(abs(self.run_job("lut.run", {})["result"]["depth_rad"] / (2.0 * math.pi * wanted) - 1.0), 0.02)
            self.assertEqual(self.call("camera.get")["settings"], before)
            self.call("lut.clear")
        self.twin.call("twin.set", {"peak_electrons": 6e8})
        self.assertIn("saturated", self.failure("lut.run"))
        self.assertFalse(self.call("lut.get")["measured"])
        self.assertEqual(self.call("camera.get")["settings"], before)


if __name__ == "__main__":
    main()
