"""Refined frames beside the fast estimate: correct, labelled with their frame, and without slowing the frame path."""
import signal
import statistics
import subprocess
import time

import jsonschema
from case import BenchCase, main, wait_for

# The twin's camera: 10000 electrons are the full scale of 255 DN.
CAMERA = {"electrons_per_dn": 10000 / 255, "read_noise_e": 5.0, "black_level_dn": 2.0}
SHOWN = {3: 0.3, 8: 0.2}  # Z(2,-2) and Z(3,1)
MODES = [{"n": 2, "m": -2, "waves": 0.3}, {"n": 3, "m": 1, "waves": 0.2}]
FITS = 3
PATIENCE_S = 60.0


def errors(message):
    return [value - SHOWN.get(j, 0.0) for j, value in zip(message["j"], message["coefficients"])]


def root_sum_square(values):
    return sum(v * v for v in values) ** 0.5


class RefinedCase(BenchCase):
    daemon_config = {"state": {"directory": "state"}}

    def setUp(self):
        super().setUp()
        self.schema = self.call("system.describe")["streams"]["refined"]
        self.refined = self.stream("refined")

    def enable(self, **more):
        return self.call("refine.set", {"enabled": True, **CAMERA, **more})["applied"]

    def next_refined(self, wanted=lambda message: True):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            message = self.refined.next(1.0)
            if message is None:
                continue
            self.assertEqual(message.pop("topic"), "refined")
            jsonschema.Draft202012Validator(self.schema).validate(message)
            if wanted(message):
                return message
        self.fail(f"no such refined frame in {PATIENCE_S} s; {self.call('system.status')['refine']}")

    def of_hologram(self, hologram_id, count=1):
        found = [self.next_refined(lambda m: m["hologram_id"] == hologram_id) for _ in range(count)]
        for message in found:
            self.assertTrue(message["valid"], message)
        return found


class Refined(RefinedCase):
    def latency_us(self, stream, seconds):
        """Median and 99th percentile of the latency from arrival to message; checks that no frame was lost."""
        stream.drain()
        end, heard = time.monotonic() + seconds, []
        while time.monotonic() < end:
            message = stream.next(1.0)
            self.assertIsNotNone(message, "the fast stream stopped")
            self.assertEqual(message["gap"], 0)
            heard.append(message["latency_us"])
        heard.sort()
        return statistics.median(heard), heard[int(0.99 * (len(heard) - 1))]

    def test_it_is_right_to_what_it_says_and_slows_nothing(self):
        self.take_reference()
        fast = self.stream("wavefront")
        without = self.latency_us(fast, 4.0)
        before = self.call("system.status")["counters"]
        applied = self.enable(rate_hz=5.0)
        self.assertEqual(applied["pixel_format"], "Mono8")
        hologram_id = self.call("aberration.set", {"modes": MODES})["hologram_id"]
        tracked = self.settled_frames(fast, 50, hologram_id)
        # Mean over the frames for each j: the bias of the fast estimate, without its noise.
        fast_errors = [statistics.fmean(error) for error in zip(*map(errors, tracked))]
        found = self.of_hologram(hologram_id, FITS)
        with_it = self.latency_us(fast, 4.0)
        after = self.call("system.status")
        for message in found:
            worst = max(map(abs, errors(message)))
            print(f"\n  frame {message['frame_id']}: worst mode {worst:.4f}, all {root_sum_square(errors(message)):.4f} wave, largest sigma"
                  f" {max(message['sigma']):.5f}, chi2 {message['chi2_per_pixel']:.2f}, {message['iterations']} iterations,"
                  f" {message['duration_ms']:.0f} ms, {1e-9 * (message['t_publish_ns'] - message['t_arrival_ns']):.2f} s after the frame")
            self.assertEqual(message["against"], "reference")
            self.assertLess(worst, 0.01)
            self.assertLess(root_sum_square(errors(message)), root_sum_square(fast_errors))
            self.assertTrue(all(0.0 < sigma < 0.01 for sigma in message["sigma"]))
        print(f"  fast estimate: worst mode {max(map(abs, fast_errors)):.4f}, all {root_sum_square(fast_errors):.4f} wave")
        print(f"  fast stream's latency: p50 {without[0]:.0f}, p99 {without[1]:.0f} us without, p50 {with_it[0]:.0f}, p99 {with_it[1]:.0f} us with it")
        print("  status:", after["refine"])
        for counter in ("frames_lost", "frames_incomplete", "frames_dropped", "messages_dropped"):
            self.assertEqual(after["counters"][counter], before[counter], counter)
        self.assertGreaterEqual(after["refine"]["done"], FITS)
        self.assertEqual(after["refine"]["refused"], 0)
        text = subprocess.run([self.bench.programs / "ovws", "watch", "refined", "-n", "1"], capture_output=True, text=True, timeout=PATIENCE_S).stdout
        self.assertIn("oblique astigmatism", text)

    def test_each_frame_is_published_as_what_it_was(self):
        self.enable(rate_hz=5.0)
        first = self.next_refined()
        self.assertEqual((first["against"], first["charge"], first["valid"]), ("model", 1, True), first)
        self.take_reference()
        self.next_refined(lambda m: m["against"] == "reference" and m["valid"])
        # A change during a fit: its result still has the old hologram and charge.
        wait_for(lambda: self.call("system.status")["refine"]["state"] == "refining")
        hologram_id = self.call("sensor.set", {"charge": 0, "tracker": "thresholded"})["hologram_id"]
        self.call("camera.set", {"exposure_us": 500.0})
        seen = []
        self.next_refined(lambda m: seen.append((m["hologram_id"], m["charge"], m["against"])) or m["exposure_us"] == 500.0 and m["valid"])
        print("\n  hologram, charge, against:", sorted(set(seen)))
        self.assertTrue(all((charge == 0) == (number >= hologram_id) for number, charge, _ in seen), seen)
        self.assertEqual(seen[-1], (hologram_id, 0, "model"))
        # Gain, format and exposure: the conversion to electrons follows.
        peak_e = self.of_hologram(hologram_id)[0]["peak_e"]
        self.call("camera.set", {"gain_db": 3.0, "pixel_format": "Mono12", "exposure_us": 300.0})
        self.assertAlmostEqual(self.call("refine.get")["electrons_per_dn"], 10000 / 255 / 16)
        message = self.next_refined(lambda m: m["gain_db"] == 3.0)
        print(f"  {peak_e:.0f} electrons at 0 dB and 500 us, {message['peak_e']:.0f} at 3 dB and 300 us; chi2 {message['chi2_per_pixel']:.2f}")
        self.assertTrue(message["valid"], message)
        self.assertAlmostEqual(message["peak_e"] / peak_e, 0.6, delta=0.06)

    def test_what_cannot_be_is_refused_with_its_field(self):
        before = self.call("refine.get")
        self.assertFalse(before["enabled"])
        for params, field, words in (({"enabled": True}, "electrons_per_dn", "set the number of electrons"),
                                     ({"enabled": 1}, "enabled", "true or false"),
                                     ({"rate_hz": 2.0, "spot_amplitudes": None}, "spot_amplitudes", "true or false"),
                                     ({"rate_hz": 0}, "rate_hz", "0.001"),
                                     ({"electrons_per_dn": -1}, "electrons_per_dn", "1000000"),
                                     ({"rate_hz": 2.0, "saturation_dn": 300}, "saturation_dn", "255"),
                                     ({"black_level_dn": 255}, "black_level_dn", "below"),
                                     ({"read_noise": 3}, "read_noise", "read_noise_e")):
            error = self.refused("refine.set", params)
            print(f"\n  {params} -> {error.data['field']}: {error.data['reason']}")
            self.assertEqual(error.data["field"], field)
            self.assertIn(words, str(error))
            self.assertEqual(self.call("refine.get"), before)
        self.call("refine.set", {"black_level_dn": 2.0})
        error = self.refused("refine.set", {"saturation_dn": 1})  # the error names the given value, not the active one
        self.assertEqual(error.data["field"], "saturation_dn")
        self.assertIn("above black_level_dn, which is 2", error.data["reason"])
        self.call("refine.set", {"black_level_dn": 0.0})
        self.assertEqual(self.call("system.status")["refine"]["state"], "off")
        # Less noise configured than present: the fit is published, but not valid.
        self.call("camera.set", {"pixel_format": "Mono12"})
        self.enable(electrons_per_dn=100.0, black_level_dn=32.0)
        doubted = self.next_refined()
        print("\n ", doubted["reason"])
        self.assertFalse(doubted["valid"])
        self.assertEqual(set(doubted["coefficients"]), {None})
        self.assertGreater(doubted["chi2_per_pixel"], 3.0)
        status = self.call("system.status")["refine"]
        self.assertEqual(status["done"], 0)
        self.assertGreaterEqual(status["refused"], 1)
        self.call("slm.show", {"pattern": "flat"})
        wait_for(lambda: "no settled and valid frame" in str(self.call("system.status")["refine"]["reason"]), PATIENCE_S)

    def test_it_is_configured_saved_and_ends_in_time(self):
        self.enable(rate_hz=20.0)
        self.call("config.save")
        self.assertEqual(self.call("config.get")["refine"]["electrons_per_dn"], CAMERA["electrons_per_dn"])
        wait_for(lambda: self.call("system.status")["refine"]["state"] == "refining", PATIENCE_S)
        daemon = self.bench.process("ovwsd")
        asked = time.monotonic()
        daemon.popen.send_signal(signal.SIGTERM)
        self.assertEqual(daemon.popen.wait(10.0), 0)
        took_s = time.monotonic() - asked
        print(f"\n  ended {took_s:.2f} s after SIGTERM, in the middle of a fit")
        self.assertLess(took_s, 3.0)
        print("  log:", self.bench.log("ovwsd").splitlines()[-1])


class UnevenLight(RefinedCase):
    """A Gaussian beam: the outermost subapertures get about three quarters of the light of the innermost."""

    twin_config = {"light": {"shape": "gaussian", "diameter_px": 1700}}

    def test_fitted_amplitudes_explain_it(self):
        hologram_id = self.call("aberration.set", {"modes": MODES})["hologram_id"]
        chi2, error = {}, {}
        for fitted in (False, True):
            self.assertEqual(self.enable(rate_hz=5.0, spot_amplitudes=fitted)["spot_amplitudes"], fitted)
            # The first may have started before the change. Not every fit of amplitudes converges.
            found = [self.next_refined(lambda m: m["hologram_id"] == hologram_id and m["valid"]) for _ in range(1 + FITS)][1:]
            chi2[fitted] = statistics.fmean(message["chi2_per_pixel"] for message in found)
            error[fitted] = root_sum_square([statistics.fmean(each) for each in zip(*map(errors, found))])
            print(f"\n  spot_amplitudes {fitted}: chi2 per pixel {chi2[fitted]:.2f}, all errors {error[fitted]:.4f} wave,"
                  f" largest sigma {max(found[0]['sigma']):.5f}, {found[0]['iterations']} iterations, {found[0]['duration_ms']:.0f} ms")
        print("  status:", self.call("system.status")["refine"])
        self.assertLess(chi2[True], 0.7 * chi2[False])
        self.assertLess(error[True], 0.003)
        self.call("config.save")
        self.assertTrue(self.call("config.get")["refine"]["spot_amplitudes"])


if __name__ == "__main__":
    main()
