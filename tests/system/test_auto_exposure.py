"""camera.auto_exposure finds the exposure of the twin's camera, whatever the light is, or says what is wrong."""
import json
import time

from case import BenchCase, main, message_since, wait_for

CLOSE = 0.05  # of the target, as documented
TARGET = 0.7
ZEROTH_PX = 16  # the zeroth order is at the left edge of this bench's image, brighter than the spots


class AutoExposure(BenchCase):
    small = True
    twin_config = {"noise": "fresh"}

    def setUp(self):
        super().setUp()
        self.frames = self.stream("wavefront")
        self.usual = self.twin.call("twin.get")["peak_electrons"]

    def light(self, factor):
        self.twin.call("twin.set", {"peak_electrons": factor * self.usual})
        message_since(self.frames, time.time_ns())

    def found(self, **params):
        result = self.run_job("camera.auto_exposure", params)["result"]
        pixels = self.client.image().pixels[:, ZEROTH_PX:]
        top = float(pixels.max()) / self.full_scale()
        print(f"\n  {result['exposure_us']:.1f} us, {result['gain_db']} dB in {result['looks']} looks: {result['brightest']:.3f} of full scale, single brightest pixel {top:.3f}")
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], result["exposure_us"])
        target = params.get("target", TARGET)
        self.assertLess(abs(result["brightest"] / target - 1.0), CLOSE)
        # The single brightest pixel of one frame has noise, and spots are unequally bright.
        self.assertGreater(top, 0.95 * target)
        self.assertLess(top, 1.25 * target)
        self.assertLess(result["saturated_pixels"], 10)  # of the zeroth order
        self.assertLessEqual(result["looks"], 8)
        return result

    def full_scale(self):
        return {"Mono8": 255, "Mono12": 4095, "BayerRG12p": 4095}[self.call("camera.get")["settings"]["pixel_format"]]

    def not_found(self, **params):
        """Runs a search that must fail and leave the settings as they were; returns the message of its error."""
        before = self.call("camera.get")["settings"]
        message = self.failure("camera.auto_exposure", params)
        self.assertEqual(self.call("camera.get")["settings"], before)
        print(f"\n  {message}")
        return message

    def test_from_every_light(self):
        self.light(100.0)  # as an exposure that is 100 times too long
        self.found()
        self.light(1.0)
        self.call("camera.set", {"exposure_us": 20.0})  # about 100 times too short
        self.found()
        self.call("camera.set", {"pixel_format": "Mono12"})
        self.found(target=0.5)
        self.light(0.02)
        self.call("slm.show", {"pattern": "grating"})  # all light in one spot
        self.found()
        self.light(1.0)
        self.call("slm.show", {"pattern": "sensor"})
        self.call("camera.set", {"pixel_format": "BayerRG12p", "exposure_us": 2000.0})
        self.found()
        self.call("camera.set", {"pixel_format": "Mono8", "gain_db": 20.0})
        self.light(100.0)
        self.assertLess(self.found()["gain_db"], 20.0)

    def test_what_is_wrong_is_said(self):
        self.light(0.0)
        self.assertIn("laser is on", self.not_found())
        self.light(1.0)
        self.assertIn("max_exposure_us", self.not_found(max_exposure_us=100.0))
        self.light(10000.0)
        self.assertIn("neutral-density", self.not_found())
        self.light(1.0)
        self.check_cancelled()
        self.check_verb()

    def check_cancelled(self):
        rate = self.call("camera.get")["settings"]["frame_rate_hz"]
        self.call("camera.set", {"frame_rate_hz": 2.0, "exposure_us": 20.0})  # each look takes some seconds
        before = self.call("camera.get")["settings"]
        job = self.call("camera.auto_exposure")["job"]
        wait_for(lambda: self.call("camera.get")["settings"] != before, what="a changed exposure")
        self.assertEqual(self.call("job.cancel", {"job": job})["state"], "cancelled")
        self.assertEqual(self.call("camera.get")["settings"], before)
        self.call("camera.set", {"frame_rate_hz": rate})

    def check_verb(self):
        said = self.run_ovws("exposure", "auto")
        print("\n ", said.stdout)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertRegex(said.stdout, r"^exposure [\d.]+ ms, gain 0 dB: most spots reach up to \d\d % of full scale, \d+ pixels\s+are\s+saturated\n$")
        self.assertIn("brightest", json.loads(self.run_ovws("--json", "exposure", "auto").stdout))
        self.light(0.0)
        said = self.run_ovws("exposure", "auto")
        self.assertEqual(said.returncode, 1)
        self.assertIn("no light reaches the camera", said.stderr)


if __name__ == "__main__":
    main()
