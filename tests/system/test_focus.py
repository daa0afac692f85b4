"""The daemon measures the aberrations of the whole pupil from the shapes and places of its spots, compared with what the twin hides."""
import math
import time

import numpy
from case import main, message_since, next_message, wait_for
from slm_case import SlmCase

DEFOCUS, OBLIQUE, VERTICAL_COMA = 4, 3, 7


def shift_by_rays(defocus_waves, optics, slm, diameter_px):
    """How far the camera, in the focal plane, is behind the focus of a light with defocus: rays from an SLM in the front focal
    plane of a lens, mm."""
    wavelength, focal = optics["wavelength_nm"] * 1e-6, optics["focal_length_mm"]
    radius = 0.5 * diameter_px * slm["pitch_um"] * 1e-3
    heights = numpy.linspace(-radius, radius, 9)[1:]
    heights = heights[heights != 0.0]
    # Zernike defocus: sqrt(3) (2 (r / radius)^2 - 1) waves; rays are perpendicular to the surface of equal phase.
    angles = wavelength * defocus_waves * math.sqrt(3.0) * 4.0 * heights / radius ** 2
    at_lens = heights + focal * angles
    behind = angles - at_lens / focal
    crossings = -at_lens / behind  # distance from the lens to the axis
    assert numpy.ptp(crossings) < 1e-9 * focal
    return focal - crossings.mean()


class Focus(SlmCase):
    small = True
    twin_config = {"camera": {"rotation_deg": 90.0, "mirror": "x"}}
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 200}}

    def set_twin(self, **settings):
        """Returns when no frame from before is in transit."""
        self.twin.call("twin.set", settings)
        message_since(self.stream("wavefront"), time.time_ns())

    def hide(self, **modes):
        self.set_twin(aberration=[{"j": int(j[1:]), "waves": waves} for j, waves in modes.items()])

    def measure(self, **hidden):
        self.hide(**hidden)
        found = self.run_job("focus.run", {"frames": 2})["result"]
        modes = {mode["j"]: mode for mode in found["modes"]}
        errors = {j: modes[j]["waves"] - hidden.get(f"j{j}", 0.0) for j in range(3, 9)}
        print(f"\n  hidden {hidden}: defocus {found['defocus_waves']:+.4f} +- {found['defocus_standard_error_waves']:.4f}, largest error "
              f"{max(map(abs, errors.values())):.4f}, camera {found['camera_shift_mm']:+.3f} mm, exposure {found['exposure_us']:.0f} us")
        self.assertLess(abs(errors[DEFOCUS]), 0.005)
        self.assertLess(max(map(abs, errors.values())), 0.02)
        self.assertEqual(found["defocus_waves"], modes[DEFOCUS]["waves"])
        config = self.call("config.get")
        expected = shift_by_rays(hidden.get("j4", 0.0), config["optics"], config["slm"], found["pupil_diameter_px"])
        self.assertAlmostEqual(found["camera_shift_mm"], expected, delta=0.0165)  # 0.005 wave
        return found

    def test_finds_defocus_beside_astigmatism_and_coma(self):
        self.assertIn("registration.run first", self.failure("focus.run"))
        self.run_job("registration.run", {"frames": 3})
        before = self.call("camera.get")["settings"], self.call("system.status")["slm"]["pattern"]
        self.measure(j4=-1.0, j3=0.1, j7=0.1)
        self.measure(j4=0.05)
        self.measure(j4=0.3, j5=-0.1, j8=-0.1)
        self.assertEqual((self.call("camera.get")["settings"], self.call("system.status")["slm"]["pattern"]), before)
        self.check_verb()
        self.check_flatness()
        self.check_cancelled()
        self.check_refused()

    def check_verb(self):
        self.hide(j4=-0.5)
        said = self.run_ovws("focus", "frames=2")
        print("\n ", said.stdout)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertRegex(said.stdout, r"^the camera is 1\.6\d\d mm behind the focus: move it towards the lens by 1\.6\d\d mm\ndefocus -0\.\d+ wave RMS ")
        self.assertNotIn("flatness", said.stdout)

    def check_flatness(self):
        """What the flatness compensates is not in the result, and is named beside it."""
        self.run_job("flatness.run", {"frames": 2})
        found = self.run_job("focus.run", {"frames": 2})["result"]
        print("\n  after flatness.run: defocus", found["defocus_waves"], "beside", found["flatness_defocus_waves"])
        self.assertLess(abs(found["defocus_waves"]), 0.01)
        self.assertAlmostEqual(found["defocus_waves"] + found["flatness_defocus_waves"], -0.5, delta=0.005)
        self.call("flatness.clear")

    def check_cancelled(self):
        """An introduced aberration is not measured, and returns."""
        self.call("aberration.set", {"modes": [{"j": 5, "waves": 0.2}]})
        self.call("camera.set", {"frame_rate_hz": 40})  # it goes on for seconds
        job = self.call("focus.run", {"frames": 100})["job"]
        wait_for(lambda: self.call("job.get", {"job": job})["progress"] > 0.1, what="frames")
        self.call("job.cancel", {"job": job})
        self.wait_until("running")
        self.call("camera.set", {"frame_rate_hz": 200})
        self.assertEqual(self.call("job.get", {"job": job})["state"], "cancelled")
        self.measure(j4=-0.5)
        self.assertEqual([(mode["j"], mode["waves"]) for mode in self.call("aberration.get")["modes"]], [(5, 0.2)])
        self.call("aberration.clear")

    def check_refused(self):
        self.call("correction.set", {"modes": [{"j": 3, "waves": 0.01}]})
        self.assertIn("correction.clear", self.failure("focus.run"))
        self.call("correction.clear")
        self.set_twin(peak_electrons=1.0)
        self.assertRegex(self.failure("focus.run", {"frames": 1}), "only .* spots are found: check the exposure")
        self.set_twin(peak_electrons=6000.0)
        self.call("sensor.set", {"tracker": "lg", "mode_count": 3})  # which does not matter here
        frames = self.stream("wavefront")
        wait_for(lambda: (frame := next_message(frames))["tracked"] == frame["subapertures"], what="the spots")
        self.measure(j4=0.1)


if __name__ == "__main__":
    main()
