"""The daemon measures the flatness of its SLM, compared with the twin's truth."""
import math

from case import main, wait_for
from slm_case import SlmCase


class Flatness(SlmCase):
    """Surface errors finer than the sensor's modes, with a rotated and mirrored camera."""
    small = True
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 100}}
    twin_config = {"camera": {"rotation_deg": 90.0, "mirror": "x"},
                   "slm": {"flatness_rms_waves": 0.3, "flatness_cycles": 2.5}}

    def measure(self):
        """Runs flatness.run on the current hologram; returns the truth and the result."""
        before = self.judge()
        found = self.run_job("flatness.run", {"frames": 2})["result"]
        after = self.judge()
        errors = {mode["j"]: mode["waves"] - before["flatness_modes"][mode["j"]] for mode in found["modes"]
                  if mode["j"] < 19}
        rms = math.sqrt(sum(error ** 2 for error in errors.values()))
        truth = math.sqrt(sum(before["flatness_modes"][j] ** 2 for j in errors))
        print(f"\n  flatness {truth:.4f} waves RMS in {len(errors)} modes: error {rms:.4f} RMS, largest {max(map(abs, errors.values())):.4f}, "
              f"{found['iterations']} scans, the last {found['residual_rms_waves']:.4f} from the one before; the light "
              f"{before['wavefront'].get('rms_waves')} -> {after['wavefront'].get('rms_waves')}")
        print("   ", {j: round(error, 4) for j, error in errors.items()})
        self.assertEqual(len(errors), 16)
        self.assertLess(max(map(abs, errors.values())), 0.005)
        self.assertLess(after["wavefront"]["rms_waves"], 0.01)
        self.assertGreater(truth, 0.1)
        return found

    def test_is_measured_kept_and_cleared(self):
        self.assertIn("registration.run first", self.failure("flatness.run"))
        self.run_job("registration.run", {"frames": 3})
        found = self.measure()
        self.assertEqual(self.call("flatness.get"), found)
        self.restart()
        self.assertEqual(self.call("flatness.get"), found)
        self.check_another_camera(found)
        self.call("correction.set", {"modes": [{"j": 3, "waves": 0.01}]})
        self.assertIn("correction.clear", self.failure("flatness.run"))
        self.take_reference(10)
        self.close_loop()
        self.assertEqual(self.refused("flatness.run").code, -32000)
        self.call("loop.open")
        self.assertFalse(self.call("flatness.clear")["measured"])
        self.call("correction.clear")
        self.twin.call("twin.set", {"geometry": {"rotation_deg": 200.0}})
        self.assertIn("registration.run", self.failure("flatness.run"))

    def check_another_camera(self, found):
        """Another camera means other optics: results measured with the previous one are not used until it returns."""
        events = self.stream("event")
        self.renew_twin(camera={"serial": "TWIN0002"})
        event = wait_for(lambda: (e := events.next(1.0)) and e["kind"] == "slm" and "camera.serial was" in e["text"] and e, what="an event")
        self.assertEqual((event["severity"], event["data"]["used"]), ("warning", False))
        wait_for(lambda: not self.call("flatness.get")["measured"], what="another camera's")
        self.assertTrue((self.bench.directory / "state" / "flatness.slm.json").exists())
        self.restart()
        wait_for(lambda: not self.call("flatness.get")["measured"], what="another camera's")
        self.renew_twin()
        self.restart()
        self.assertEqual(self.call("flatness.get"), found)
        self.assertTrue(self.call("registration.get")["registered"])


if __name__ == "__main__":
    main()
