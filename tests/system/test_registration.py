"""Registration of a rotated, mirrored, magnified and shifted camera; measurements are then correct."""
import math
import time

from case import BenchCase, main, message_since, wait_for

MODES = (3, 4, 5, 7, 12)
WAVES = 0.2
SCALE_PX = 964.15  # per cycle: focal length x wavelength / (SLM pitch x camera pitch)


class Registration(BenchCase):
    small = True
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 50}}

    def place_camera(self, **geometry):
        self.twin.call("twin.set", {"geometry": geometry})

    def coefficients(self, mode_j, waves):
        hologram = self.call("aberration.set", {"modes": [{"j": mode_j, "waves": waves}]})["hologram_id"]
        frames = self.settled_frames(self.wavefronts, 10, hologram)
        self.assertEqual({frame["tracked"] for frame in frames}, {19})
        columns = zip(*(frame["coefficients"] for frame in frames))
        return dict(zip(frames[0]["j"], (sum(column) / len(frames) for column in columns)))

    def check(self, rotation_deg, mirror, magnification, centre_px):
        self.place_camera(rotation_deg=rotation_deg, mirror=mirror, magnification=magnification, centre_px=centre_px)
        found = self.run_job("registration.run", {})["result"]
        print(f"\n  {rotation_deg} degrees, mirror {mirror}, {magnification}, base {centre_px}: "
              f"{found['rotation_deg']:.3f} degrees, {found['mirrored']}, scale {found['scale_px_per_cycle']:.2f}, "
              f"base {found['base_px']}, left {found['residual_px']:.3f} px of {found['sights']} sights")
        self.assertEqual(found["mirrored"], mirror != "none")
        self.assertAlmostEqual(found["scale_px_per_cycle"], SCALE_PX * magnification, delta=1.5)
        for axis in (0, 1):
            self.assertAlmostEqual(found["base_px"][axis], centre_px[axis], delta=0.5)
        if mirror == "none":
            self.assertLess(abs(math.remainder(found["rotation_deg"] - rotation_deg, 360.0)), 0.1)
        self.assertEqual(self.call("registration.get"), found)
        self.take_reference(20)
        self.wavefronts = self.stream("wavefront")
        for j in MODES:
            modes = self.coefficients(j, WAVES)
            others = max(abs(value) for k, value in modes.items() if k != j)
            print(f"    mode {j}: {modes[j]:.4f} of {WAVES}, others up to {others:.4f}")
            self.assertAlmostEqual(modes[j], WAVES, delta=0.05 * WAVES + 0.003)
            self.assertLess(others, 0.02)
        self.call("aberration.clear")
        self.check_all_pixels()

    def check_all_pixels(self):
        """The tracker `fit` and the refinement know the camera's geometry, too."""
        self.call("sensor.set", {"tracker": "fit"})
        self.take_reference(50)
        modes = {j: 0.05 for j in MODES}

        def worst(frame):
            return max(abs(value - modes.get(j, 0.0)) for j, value in zip(frame["j"], frame["coefficients"]))
        hologram = self.call("aberration.set", {"modes": [{"j": j, "waves": waves} for j, waves in modes.items()]})["hologram_id"]
        self.settled_frames(self.wavefronts, 1, hologram)
        # Templates of the wavefront before may measure the first ones.
        fitted = wait_for(lambda: (frame := self.fitted_frames(self.wavefronts, 1)[0]) and worst(frame) < 0.005 and frame, what="templates about this wavefront")
        self.call("refine.set", {"enabled": True, "electrons_per_dn": 10000 / 255, "read_noise_e": 5.0, "black_level_dn": 2.0})
        stream = self.stream("refined")
        refined = wait_for(lambda: (found := stream.next(1.0)) and found["hologram_id"] == hologram and found["valid"] and found)
        self.call("refine.set", {"enabled": False})
        for name, frame in (("fit", fitted), ("refined", refined)):
            print(f"    {name}: errors up to {worst(frame):.4f} wave")
            self.assertLess(worst(frame), 0.005)
        self.call("aberration.clear")
        self.call("sensor.set", {"tracker": "lg"})

    def check_again(self):
        """The same map, found again, leaves in use what was measured with it."""
        known, reference = self.call("registration.get"), self.call("reference.get")["t_taken_ns"]
        events = self.stream("event")
        again = self.run_job("registration.run", {})["result"]
        for key in ("base_px", "px_per_cycle"):
            self.assertEqual(again[key], known[key])
        self.assertNotEqual(again["t_taken_ns"], known["t_taken_ns"])
        event = wait_for(lambda: (event := events.next(0.5)) and event["kind"] == "registration" and event, what="the event")
        self.assertTrue(event["data"]["confirmed"])
        self.assertEqual(self.call("reference.get")["t_taken_ns"], reference)
        self.frames_from_now(self.wavefronts, 10)  # valid ones

    def test_a_camera_of_another_angle_parity_and_scale(self):
        for case in ((33.0, "none", 1.0, [275.5, 245.5]), (20.0, "y", 0.95, [240.0, 260.0])):
            with self.subTest(case=case):
                self.check(*case)
        self.check_again()
        # Another grating moves the base spot, and the map with it.
        self.call("sensor.set", {"grooves": [205, 15]})
        self.take_reference(20)
        self.assertEqual({frame["tracked"] for frame in self.frames_from_now(self.wavefronts, 10)}, {19})
        before = self.call("registration.get")
        self.twin.call("twin.set", {"peak_electrons": 3e8})
        self.assertIn("saturated", self.failure("registration.run"))
        self.twin.call("twin.set", {"peak_electrons": 6000})
        job = self.call("registration.run", {"frames": 40})["job"]  # goes on for seconds
        wait_for(lambda: self.call("job.get", {"job": job})["progress"] > 0.2, what="the first images")
        self.place_camera(magnification=1.05)
        ended = self.job_ended(job)
        self.assertEqual(ended["state"], "failed", ended)
        self.assertIn("does not move", ended["error"]["message"])
        self.assertEqual(self.call("registration.get"), before)
        self.call("registration.clear")
        self.assertFalse(self.call("registration.get")["registered"])
        self.place_camera(rotation_deg=0.0, mirror="none", magnification=1.0, centre_px=[255.5, 255.5])
        message_since(self.wavefronts, time.time_ns())
        self.take_reference(20)  # frames are of the sensor's hologram again
        self.assertEqual({frame["tracked"] for frame in self.frames_from_now(self.wavefronts, 10)}, {19})


if __name__ == "__main__":
    main()
