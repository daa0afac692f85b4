"""Refined frames beside the fast estimate: labelled with their frame, refused with a reason, and in uneven light."""
import signal
import statistics

from case import main, wait_for
from refined_case import CAMERA, FITS, MODES, PATIENCE_S, RefinedCase, errors, root_sum_square


class Refined(RefinedCase):
    def test_each_frame_is_published_as_what_it_was(self):
        self.enable(rate_hz=5.0)
        first = self.next_refined()
        self.assertEqual((first["against"], first["charge"], first["valid"]), ("model", 1, True), first)
        self.take_reference()
        self.next_refined(lambda m: m["against"] == "reference" and m["valid"])
        # A change during a fit: its result still has the old hologram and charge. Without a reference
        # every fit takes some tenths of a second.
        self.call("reference.clear")
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

    def test_it_is_right_to_what_it_says(self):
        """How many frames a second are refined, and the latency of the fast stream beside it, are printed by tests/bench/refined_rate."""
        self.call("sensor.set", {"tracker": "lg"})  # a fast estimate without templates, which fit all pixels, too
        self.take_reference()
        fast = self.stream("wavefront")
        self.assertEqual(self.enable(rate_hz=5.0)["pixel_format"], "Mono8")
        hologram_id = self.call("aberration.set", {"modes": MODES})["hologram_id"]
        tracked = self.settled_frames(fast, 50, hologram_id)
        # Mean over the frames for each j: the bias of the fast estimate, without its noise.
        fast_errors = [statistics.fmean(error) for error in zip(*map(errors, tracked))]
        found = self.of_hologram(hologram_id, FITS)
        after = self.call("system.status")
        for message in found:
            worst = max(map(abs, errors(message)))
            print(f"\n  frame {message['frame_id']}: worst mode {worst:.4f}, all {root_sum_square(errors(message)):.4f} wave, largest sigma"
                  f" {max(message['sigma']):.5f}, chi2 {message['chi2_per_pixel']:.2f}, {message['iterations']} iterations")
            self.assertEqual(message["against"], "reference")
            self.assertLess(worst, 0.01)
            self.assertLess(root_sum_square(errors(message)), root_sum_square(fast_errors))
            self.assertTrue(all(0.0 < sigma < 0.01 for sigma in message["sigma"]))
        print(f"  fast estimate: worst mode {max(map(abs, fast_errors)):.4f}, all {root_sum_square(fast_errors):.4f} wave\n  status:", after["refine"])
        published = [message["t_publish_ns"] for message in (*tracked, *iter(lambda: fast.next(0.0), None))]
        during = [sum(0 < message["t_publish_ns"] - at < 1e6 * message["duration_ms"] for at in published) for message in found]
        print(f"  frames published during each fit: {during}")
        self.assertGreater(max(during), 0)  # the frame path does not wait for a fit
        self.assertGreaterEqual(after["refine"]["done"], FITS)
        self.assertEqual(after["refine"]["refused"], 0)
        text = self.run_ovws("watch", "refined", "-n", "1").stdout
        self.assertIn("oblique astigmatism", text)

    def test_what_cannot_be_is_refused_with_its_field(self):
        before = self.call("refine.get")
        self.assertFalse(before["enabled"])
        for params, field, words in (({"enabled": True}, "electrons_per_dn", "set the number of electrons"),
                                     ({"enabled": 1}, "enabled", "true or false"),
                                     ({"rate_hz": 2.0, "enabled": None}, "enabled", "true or false"),
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
        said = self.call("system.status")["refine"]
        self.assertEqual((said["state"], said["reason"]), ("off", None))
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

    def test_it_is_configured_saved_and_ends_in_the_middle_of_a_fit(self):
        self.enable(rate_hz=20.0)
        self.call("config.save")
        self.assertEqual(self.call("config.get")["refine"]["electrons_per_dn"], CAMERA["electrons_per_dn"])
        wait_for(lambda: self.call("system.status")["refine"]["state"] == "refining", PATIENCE_S)
        daemon = self.bench.process("ovwsd")
        daemon.popen.send_signal(signal.SIGTERM)
        self.assertEqual(daemon.popen.wait(PATIENCE_S), 0)  # how soon: tests/bench/service
        print("  log:", self.bench.log("ovwsd").splitlines()[-1])


class UnevenLight(RefinedCase):
    """A Gaussian beam: the outermost subapertures get about three quarters of the light of the innermost."""

    twin_config = {"light": {"shape": "gaussian", "diameter_px": 1700}}

    def test_fitted_amplitudes_explain_it(self):
        hologram_id = self.call("aberration.set", {"modes": MODES})["hologram_id"]
        self.enable(rate_hz=5.0)
        # The first may have started before the change.
        found = [self.next_refined(lambda m: m["hologram_id"] == hologram_id and m["valid"]) for _ in range(1 + FITS)][1:]
        chi2 = statistics.fmean(message["chi2_per_pixel"] for message in found)
        error = root_sum_square([statistics.fmean(each) for each in zip(*map(errors, found))])
        print(f"\n  chi2 per pixel {chi2:.2f}, all errors {error:.4f} wave, largest sigma {max(found[0]['sigma']):.5f},"
              f" {found[0]['iterations']} iterations, {found[0]['duration_ms']:.0f} ms")
        print("  status:", self.call("system.status")["refine"])
        self.assertLess(chi2, 2.0)
        self.assertLess(error, 0.003)
        self.call("config.save")
        self.assertTrue(self.call("config.get")["refine"]["enabled"])


if __name__ == "__main__":
    main()
