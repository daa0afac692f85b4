"""The interaction matrix measured on the bench gives correct modes for any orientation of the camera.

    OVWS_CALIBRATION=full   one camera per geometric fault, every mode for each; default: one camera with all faults
    OVWS_AMPLITUDE=0.1      amplitude of the pokes, waves; default: the daemon's
    OVWS_TRACKER=fit    tracker of both tests that measure modes
"""
import os
import time

from case import BenchCase, main, message_since, wait_for

FULL = os.environ.get("OVWS_CALIBRATION") == "full"
ALL = tuple(range(3, 15))
WAVES = 0.2
MIDDLE = [255.5, 255.5]
CAMERAS = (  # degrees, mirror, magnification, base spot
    (3.0, "none", 1.0, MIDDLE),
    (33.0, "none", 1.0, MIDDLE),
    (90.0, "none", 1.0, MIDDLE),
    (0.0, "x", 1.0, MIDDLE),
    (0.0, "none", 1.05, MIDDLE),
    (0.0, "none", 1.0, [275.5, 255.5])) if FULL else (
    (33.0, "x", 1.05, [275.5, 255.5]),)


class CalibrationCase(BenchCase):
    small = True
    daemon_config = {"stream": {"image_rate_hz": 0}, "state": {"directory": "state"}, "tracking": {"tracker": "lg"}}

    def calibrate(self, **params):
        found = self.run_job("calibration.run", params)["result"]
        self.assertEqual(self.call("calibration.get"), found)
        self.assertTrue(found["in_force"])
        factors = [mode["factor"] for mode in found["modes"]]
        noise = [mode["standard_error_px_per_wave"] / mode["signal_px_per_wave"] for mode in found["modes"]]
        print(f"    {len(factors)} modes, condition {found['condition_number']:.2f}, "
              f"factors {min(factors):.3f} to {max(factors):.3f}, correlation from "
              f"{min(mode['correlation'] for mode in found['modes']):.4f}, noise up to {max(noise):.4f} of the signal, "
              f"drift {found['drift_px']:.3f} px of {found['drift_noise_px']:.3f}, {found['disagreement']}")
        return found

    def in_use(self):
        sensor = self.call("system.status")["sensor"]
        return sensor["operator"], sensor["operator_in_force"], sensor["operator_reason"]

    def means(self, hologram_id):
        """Mean coefficients of frames with this hologram."""
        stream = self.stream("wavefront")
        frames = self.settled_frames(stream, 10, hologram_id)
        stream.close()
        return self.mean_modes(frames)

    def is_right(self, j, modes):
        others = max(abs(value) for k, value in modes.items() if k != j)
        print(f"    mode {j}: {modes[j]:.4f} of {WAVES}, others up to {others:.4f}")
        return abs(modes[j] - WAVES) <= 0.02 * WAVES + 0.003 and others < 0.02

    def wait_for_hidden(self, j):
        """Waits until ten frames in a row measure a mode that has just been hidden in the light; with `fit`, frames that templates measured:
        at first those of the wavefront before."""
        stream = self.stream("wavefront")
        message_since(stream, time.time_ns())
        next_frames = self.fitted_frames if self.call("sensor.get")["tracker"] == "fit" else self.settled_frames
        wait_for(lambda: self.is_right(j, self.mean_modes(next_frames(stream, 10))), what=f"mode {j}")
        stream.close()


class Reading(CalibrationCase):
    def amplitude(self):
        return {"amplitude_waves": float(os.environ["OVWS_AMPLITUDE"])} if "OVWS_AMPLITUDE" in os.environ else {}

    def use_tracker(self, usual):
        tracker = os.environ.get("OVWS_TRACKER", usual)
        print(f"\n  tracker {tracker}")
        self.call("sensor.set", {"tracker": tracker})

    def read_with(self, rotation_deg, mirror, magnification, centre_px):
        print(f"\n  {rotation_deg} degrees, mirror {mirror}, {magnification}, base {centre_px}")
        self.twin.call("twin.set", {"geometry": {"rotation_deg": rotation_deg, "mirror": mirror, "magnification": magnification,
                                                 "centre_px": centre_px}})
        self.run_job("registration.run", {})
        self.take_reference(20)
        found = self.calibrate(frames=10, **self.amplitude())
        self.assertEqual(([mode["j"] for mode in found["modes"]], found["dropped"], found["lost_spots"]), (list(range(1, 19)), [], []))
        self.assertEqual((found["disagreement"], found["disagreement_reason"]), ("none", None))
        for j in ALL:
            with self.subTest(mode=j):
                modes = self.means(self.call("aberration.set", {"modes": [{"j": j, "waves": WAVES}]})["hologram_id"])
                self.assertTrue(self.is_right(j, modes), modes)
        self.call("aberration.clear")

    def test_what_the_slm_shows_is_read_wherever_the_camera_stands(self):
        self.use_tracker("lg")
        for case in CAMERAS:
            with self.subTest(case=case):
                self.read_with(*case)

    def test_what_is_hidden_in_the_light_is_read(self):
        self.use_tracker("fit")
        self.take_reference(50)
        self.calibrate(**self.amplitude())
        for j in ALL if FULL else (3, 7, 12, 14):
            with self.subTest(mode=j):
                self.twin.call("twin.set", {"aberration": [{"j": j, "waves": WAVES}]})
                self.wait_for_hidden(j)


class Rules(CalibrationCase):
    """What makes a calibration stale, and what is refused, with few modes and frames."""

    def quick(self, **params):
        return self.calibrate(frames=3, modes=[1, 2, 3, 4, 5], **params)

    def expect_fallback(self, field):
        requested, active, reason = self.in_use()
        self.assertEqual((requested, active), ("measured", "slopes"))
        self.assertRegex(reason, f"is not used: .*{field}.*: run calibration.run")
        self.assertEqual(self.call("calibration.get")["calibrated"], False)
        status = self.run_ovws("status")
        self.assertIn(f"operator_reason: {reason}\n", status.stdout)

    def test_it_is_used_with_what_it_was_measured_with_only(self):
        refused = self.refused("sensor.set", {"operator": "measured"})
        self.assertEqual((refused.code, refused.data["field"]), (-32000, "operator"))
        self.assertIn("there is no calibration", refused.data["reason"])
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.05}]})
        first = self.quick()
        self.assertEqual(self.in_use(), ("measured", "measured", None))
        self.assertEqual(self.call("aberration.get")["modes"][0]["waves"], 0.05)  # unchanged
        self.assertEqual(self.call("sensor.get")["modes_j"], [1, 2, 3, 4, 5])
        origin = first["origin"]
        self.assertEqual((origin["aberration"], origin["camera"]["serial"], origin["settings"]["gain_db"], origin["slm"]["width"],
                          origin["roi"]["width"], origin["registration"]), ([{"j": 3, "waves": 0.05}], "TWIN0001", 0.0, 640, 512, None))
        for change, back, field in (({"charge": 2}, {"charge": 1}, "charge"), ({"subapertures_across": 4}, {"subapertures_across": 5}, "subapertures_across")):
            self.call("sensor.set", change)
            self.expect_fallback(field)
            refused = self.refused("sensor.set", {"operator": "measured"})
            self.assertIn(field, refused.data["reason"])
            self.call("sensor.set", back)
            self.assertEqual(self.call("calibration.get"), first)
            self.assertEqual(self.in_use(), ("measured", "measured", None))
        self.call("camera.set", {"roi": {"x": 16}})
        self.expect_fallback("roi")
        self.call("camera.set", {"roi": {"x": 0}})
        self.assertEqual(self.in_use()[1], "measured")
        # Each key makes it stale.
        self.call("sensor.set", {"tracker": "fit"})
        self.expect_fallback("tracker")
        second = self.quick()
        self.assertNotEqual(second["t_taken_ns"], first["t_taken_ns"])
        self.call("sensor.set", {"tracker": "lg"})
        self.assertEqual(self.call("calibration.get"), first)
        self.call("sensor.set", {"operator": "slopes"})
        self.assertEqual(self.in_use(), ("slopes", "slopes", None))
        self.assertEqual(self.call("calibration.get"), first | {"in_force": False})
        self.call("sensor.set", {"operator": "measured"})
        self.assertEqual(self.in_use(), ("measured", "measured", None))
        # Measuring the same map again is the same registration; another magnification is a different one.
        self.run_job("registration.run", {"frames": 3})
        self.assertEqual(self.in_use(), ("measured", "measured", None))
        self.twin.call("twin.set", {"geometry": {"magnification": 1.05}})
        self.run_job("registration.run", {"frames": 3})
        self.expect_fallback("registration")
        self.call("registration.clear")
        self.twin.call("twin.set", {"geometry": {"magnification": 1.0}})
        # Loaded again after a restart, which starts with the configuration's values.
        self.bench.stop("ovwsd")
        self.client.close()
        self.start_daemon(tracking={"operator": "measured"})
        self.wait_until("running")
        self.assertEqual(self.call("calibration.get"), first)
        self.assertEqual(self.in_use(), ("measured", "measured", None))
        self.assertFalse(self.call("calibration.clear")["calibrated"])
        self.assertEqual(self.in_use()[:2], ("measured", "slopes"))

    def test_what_cannot_be_is_refused(self):
        self.assertEqual(self.refused("calibration.run", {"amplitude_waves": 0.3}).data["field"], "amplitude_waves")
        self.assertEqual(self.refused("calibration.run", {"modes": [3, 3]}).data["field"], "modes")
        self.call("slm.show", {"pattern": "grating"})
        self.assertIn("does not show the sensor", self.refused("calibration.run").data["reason"])
        self.call("slm.show", {"pattern": "sensor"})
        job = self.call("calibration.run", {"modes": [3, 40]})["job"]
        ended = self.job_ended(job)
        self.assertEqual((ended["state"], ended["error"]["data"]["field"]), ("failed", "modes"))
        self.assertIn("j = 1 to 18", ended["error"]["data"]["reason"])
        self.wait_until("running")
        job = self.call("calibration.run", {"frames": 1000})["job"]  # does not end by itself meanwhile
        for method in ("calibration.run", "registration.run", "calibration.clear", "reference.take"):
            self.assertIn("job", self.refused(method).data["reason"])
        self.call("job.cancel", {"job": job})
        self.wait_until("running")
        self.assertEqual((self.call("calibration.get")["calibrated"], self.in_use()), (False, ("slopes", "slopes", None)))
        # Detects spots that move during the calibration.
        job = self.call("calibration.run", {"modes": [3, 5], "frames": 100})["job"]  # goes on for seconds
        wait_for(lambda: self.call("job.get", {"job": job})["progress"] > 0.0, what="the first picture")
        self.twin.call("twin.set", {"geometry": {"centre_px": [258.5, 255.5]}})
        ended = self.job_ended(job)
        self.assertEqual(ended["state"], "failed", ended)
        self.assertRegex(ended["error"]["data"]["reason"], "the spots have moved by [0-9.]+ px")
        self.twin.call("twin.fault", {"kind": "unplug", "seconds": 60})
        self.wait_until("waiting_for_camera")
        self.assertEqual(self.refused("calibration.run").code, -32001)


if __name__ == "__main__":
    main()
