"""The instrument measures its own SLM: look-up table and flatness, against the truth of the twin."""
import math

from case import BenchCase, Client, main, wait_for
from screen import draw_over

TWO_PI = 2.0 * math.pi


class SlmCase(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}}

    def start_daemon(self):
        if "state" not in self.daemon_config:
            self.daemon_config = self.daemon_config | {"state": {"directory": str(self.bench.directory / "state")}}
        super().start_daemon()

    def start(self):
        super().start()
        self.twin = Client("tcp://127.0.0.1:7790")
        self.addCleanup(self.twin.close)

    def judge(self, pattern="sensor"):
        return self.twin.call("twin.get", {"judge": pattern})

    def failure(self, method, params=None):
        """What a job of this method, which must fail, says."""
        job = self.call(method, params)["job"]
        ended = wait_for(lambda: (report := self.call("job.get", {"job": job}))["state"] != "running" and report, 60.0)
        self.assertEqual(ended["state"], "failed", ended)
        return ended["error"]["message"]

    def restart(self):
        self.bench.stop("ovwsd")
        self.start_daemon()
        self.wait_until("running")


def lut_error_rad(grey_levels, truth_waves):
    """How far the phases shown are from those wanted, RMS over what is in reach, free of piston."""
    wanted = [k / 256 for k in range(256) if k / 256 <= truth_waves[255]]
    off = [math.remainder(truth_waves[grey] - phase, 1.0) for grey, phase in zip(grey_levels, wanted)]
    mean = sum(off) / len(off)
    return TWO_PI * math.sqrt(sum((x - mean) ** 2 for x in off) / len(off))


class LookUpTable(SlmCase):
    def measure(self, depth_waves):
        truth = self.judge()
        before, path = self.call("lut.get"), truth["lut_waves"]
        first_order = truth["wavefront"].get("first_order", math.nan)
        self.assertEqual((before["source"], before["measured"]), ("linear", False))
        found = self.run_job("lut.run", {"levels": 17, "frames": 2}, 60.0)["result"]
        self.assertEqual(self.call("lut.get"), found)
        after = self.judge()["wavefront"]["first_order"]
        curve = math.sqrt(sum((p - TWO_PI * w) ** 2 for p, w in zip(found["phase_rad"], path)) / 256)
        error = lut_error_rad(found["grey_levels"], path)
        print(f"\n  depth {depth_waves} waves, found {found['depth_rad'] / TWO_PI:.4f}: response {curve:.4f} rad, LUT "
              f"{lut_error_rad(before['grey_levels'], path):.3f} -> {error:.4f} rad RMS, first order {first_order:.4f} -> {after:.4f}, "
              f"noise {found['noise_rad']:.4f} rad")
        self.assertLess(error, 0.05)
        self.assertLess(curve, 0.05)
        self.assertAlmostEqual(found["depth_rad"], TWO_PI * path[255], delta=0.05)
        self.assertEqual(found["reaches_2pi"], depth_waves >= 1.0)
        self.assertEqual(found["reason"] is None, depth_waves >= 1.0)
        return found, first_order, after


class ShallowSlm(LookUpTable):
    twin_config = {"noise": "pool", "slm": {"gamma": 1.4, "depth_waves": 0.9}}

    def check_clear_that_fails(self, found):
        """Neither in force nor on the disk does anything change."""
        kept = self.bench.directory / "state" / "lut.slm.json"
        aside = kept.with_suffix(".aside")
        kept.rename(aside)
        (kept / "x").mkdir(parents=True)  # what nobody can remove as a file
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
        self.bench.start_display(display)
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
        self.twin.call("twin.set", {"peak_electrons": 600000})
        self.assertIn("saturated", self.failure("lut.run"))
        self.assertFalse(self.call("lut.get")["measured"])


class DeepSlm(LookUpTable):
    twin_config = {"noise": "pool", "slm": {"gamma": 1.4, "depth_waves": 1.2}}

    def test_is_cut_to_two_pi(self):
        _, before, after = self.measure(1.2)
        self.assertGreater(after, 0.98)


class Flatness(SlmCase):
    """A surface as the glass of an SLM bends: what is finer than the sensor's modes it cannot tell from them."""
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 50}}
    twin_config = {"noise": "pool", "camera": {"rotation_deg": 90.0, "mirror": "x"},
                   "slm": {"flatness_rms_waves": 0.6, "flatness_cycles": 1.0}}

    def test_is_measured_kept_and_cleared(self):
        self.assertIn("registration.run first", self.failure("flatness.run"))
        self.run_job("registration.run", {"frames": 3}, 60.0)
        before = self.judge()
        found = self.run_job("flatness.run", {"frames": 20}, 60.0)["result"]
        self.assertEqual(self.call("flatness.get"), found)
        after = self.judge()
        errors = {mode["j"]: mode["waves"] - before["flatness_modes"][mode["j"]] for mode in found["modes"]
                  if mode["j"] < len(before["flatness_modes"])}
        rms = math.sqrt(sum(error ** 2 for error in errors.values()))
        truth = math.sqrt(sum(before["flatness_modes"][j] ** 2 for j in errors))
        print(f"\n  flatness {truth:.4f} waves RMS in {len(errors)} modes: error {rms:.4f} RMS, largest {max(map(abs, errors.values())):.4f}, "
              f"{found['iterations']} looks, {found['residual_rms_waves']:.4f} left; the light {before['wavefront'].get('rms_waves')} -> "
              f"{after['wavefront'].get('rms_waves')}")
        print("   ", {j: round(error, 4) for j, error in errors.items()})
        self.assertLess(after["wavefront"]["rms_waves"], 0.03)
        self.assertGreater(truth, 0.1)
        self.assertLess(max(map(abs, errors.values())), 0.02)
        self.restart()
        self.assertEqual(self.call("flatness.get"), found)
        self.call("correction.set", {"modes": [{"j": 3, "waves": 0.01}]})
        self.assertIn("correction.clear", self.failure("flatness.run"))
        self.take_reference(10)
        self.call("loop.close")
        self.assertEqual(self.refused("flatness.run").code, -32000)
        self.call("loop.open")
        self.assertFalse(self.call("flatness.clear")["measured"])
        self.call("correction.clear")
        self.twin.call("twin.set", {"geometry": {"rotation_deg": 92.0}})
        self.assertIn("registration.run", self.failure("flatness.run"))


class Cancelled(SlmCase):
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 50}}
    twin_config = {"noise": "pool"}

    def all_of_it(self):
        methods = ("lut.get", "flatness.get", "aberration.get", "sensor.get", "registration.get", "reference.get", "camera.get")
        return [{key: value for key, value in self.call(method).items() if key != "hologram_id"} for method in methods]

    def shown(self):
        return self.call("system.status")["slm"]["hologram_id"]

    def test_leaves_everything_as_it_was(self):
        self.run_job("registration.run", {"frames": 3}, 60.0)
        self.call("aberration.set", {"modes": [{"j": 5, "waves": 0.1}]})
        self.take_reference(10)
        before = self.all_of_it()
        frames = self.stream("wavefront")
        for method, params, pictures in (("slm.settle", {"repetitions": 100}, 3), ("lut.run", {"levels": 256, "frames": 50}, 1),
                                         ("flatness.run", {"frames": 1000}, 1)):
            with self.subTest(method):
                first = self.shown()
                job = self.call(method, params)["job"]
                wait_for(lambda: self.shown() >= first + pictures, 30.0, "the middle of it")
                self.assertEqual(self.call("job.cancel", {"job": job})["state"], "cancelled")
                self.wait_until("running")
                self.assertEqual(self.all_of_it(), before)
                self.settled_frames(frames, 5, self.call("sensor.get")["hologram_id"])


class Settling(SlmCase):
    daemon_config = {"stream": {"image_rate_hz": 0}, "slm": {"settle_ms": 100}}
    twin_config = {"noise": "pool", "slm": {"settle_ms": 10}}

    def check(self, truth_ms):
        found = self.run_job("slm.settle", {"repetitions": 8}, 60.0)["result"]
        print(f"\n  settles in {truth_ms} ms: p50 {found['p50_ms']:.1f}, max {found['max_ms']:.1f}, not before {found['least_ms']:.1f}, "
              f"resolution {found['resolution_ms']:.1f} ms, proposed {found['proposed_settle_ms']} ms")
        # The first exposure that stands begins after the truth, and the one before it began before; 5 ms for stamps that all came late.
        self.assertGreater(found["p50_ms"], truth_ms - 5.0)
        self.assertLess(found["p50_ms"], truth_ms + found["resolution_ms"] + 5.0)
        self.assertLess(found["resolution_ms"], 20.0)  # two frames
        self.assertGreaterEqual(found["proposed_settle_ms"], truth_ms)
        self.assertEqual(found["configured_settle_ms"], 100.0)

    def test_is_what_the_camera_sees(self):
        self.check(10.0)
        self.bench.stop("ovws-twin")
        self.bench.start_twin({"noise": "pool", "slm": {"settle_ms": 60}})
        self.wait_until("running")
        self.check(60.0)


class ReadBack(SlmCase):
    def test_what_stands_on_the_output_is_what_was_presented(self):
        seen = self.call("slm.verify")
        self.assertTrue(seen["equal"], seen)
        self.assertEqual(seen["crc32"], seen["crc32_shown"])
        events = self.stream("event")
        draw_over(self.bench.display, 2000, 100, 30, 20)  # of the output, without a window of its own
        spoilt = self.call("slm.verify")
        self.assertFalse(spoilt["equal"], spoilt)
        self.assertEqual(spoilt["crc32"], seen["crc32"])
        self.assertNotEqual(spoilt["crc32_shown"], seen["crc32"])
        self.assertGreater(spoilt["differing_pixels"], 500)
        event = wait_for(lambda: (e := events.next(1.0)) and e["kind"] == "slm" and e, what="an event")
        self.assertEqual((event["severity"], event["data"]["differing_pixels"]), ("error", spoilt["differing_pixels"]))
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]})
        again = self.call("slm.verify")
        self.assertTrue(again["equal"], again)
        self.assertNotEqual(again["crc32"], seen["crc32"])


if __name__ == "__main__":
    main()
