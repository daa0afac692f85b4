"""slmsuite's own calibrations on the twin through the bridge. It is not in Debian: without it (pip install slmsuite, or OVWS_SLMSUITE, the
folder of an unpacked release) this test is skipped."""
import os
import sys
import unittest
import warnings

import numpy as np
from case import BenchCase, main

sys.path.extend(filter(None, [os.environ.get("OVWS_SLMSUITE")]))
try:
    import matplotlib
    matplotlib.use("Agg")
    from ovws_bridges.slmsuite import Bench, flatness_phase
    from slmsuite.hardware.cameraslms import FourierSLM
    MISSING = ""
except ImportError as error:
    MISSING = f"slmsuite cannot be imported: {error}"

# The camera sees the zeroth order in its middle, and the base spot 301 pixels to its right.
CENTRE = [813.0, 562.0]
SUPERPIXEL = 96
PUPIL = 768


@unittest.skipIf(MISSING, MISSING)
class SlmSuite(BenchCase):
    twin_config = {"optics": {"centre_px": CENTRE}, "slm": {"flatness_rms_waves": 0.2}, "light": {"peak_electrons": 3000}}
    daemon_config = {"camera": {"roi": {"x": 0, "y": 0, "width": 1024, "height": 1024}, "frame_rate_hz": 50},
                     "optics": {"centre_px": CENTRE}, "slm": {"settle_ms": 20}, "stream": {"image_rate_hz": 0}}

    def test_its_wavefront_calibration_agrees_with_flatness_run(self):
        warnings.simplefilter("ignore")  # of slmsuite
        self.call("camera.set", {"exposure_us": 1500})
        self.run_job("registration.run", {"frames": 3})
        ours = self.run_job("flatness.run", {"frames": 3})["result"]
        self.assertGreater(ours["rms_waves"], 0.15)
        before = self.call("camera.get")["settings"]
        with Bench() as bench:
            flat = flatness_phase(bench.client) / (2 * np.pi)
            system = FourierSLM(bench.cam, bench.slm)
            bench.cam.set_exposure(4e-5)
            fourier = system.fourier_calibrate(array_shape=8, array_pitch=40, autoexposure=True)
            scale = 200e3 / 3.45  # focal length / camera pixel
            print(f"\n  Fourier calibration: {np.diag(fourier['M'])} px per unit, {scale:.0f} expected")
            np.testing.assert_allclose(fourier["M"], scale * np.eye(2), atol=2e-3 * scale)
            np.testing.assert_allclose(system.kxyslm_to_ijcam([0, 0]).ravel(), np.subtract(CENTRE, [301.3, 50.2]), atol=2.0)
            bench.cam.set_exposure(1e-3)
            aside = (1280 - PUPIL) // 2 // SUPERPIXEL
            system.wavefront_calibrate_superpixel(calibration_points=np.reshape(CENTRE, (2, 1)), superpixel_size=SUPERPIXEL,
                                                  exclude_superpixels=(aside, 0), plot=-1)
            theirs = system.wavefront_calibration_superpixel_process()["phase"] / (2 * np.pi)
            bench.cam.set_exposure(1e-6 * before["exposure_us"])
        rms = rms_apart(theirs, flat)
        print(f"  slmsuite and flatness.run differ by {rms:.4f} wave RMS; the error is {ours['rms_waves']:.3f}")
        self.assertLess(rms, 0.03)
        self.wait_until("running")
        self.assertEqual(self.call("camera.get")["settings"], before)

    def test_images_belong_to_the_phase_and_the_window_is_cut_out(self):
        with warnings.catch_warnings(record=True) as warned:
            bench = Bench(lease_s=30.0)
        self.assertFalse([w for w in warned if "zeroth order" in str(w.message)])
        with bench:
            rows, columns = bench.slm.shape
            x = np.arange(columns) * np.ones((rows, 1))
            places = []
            for cycles in (200, 260):
                bench.slm.set_phase(2 * np.pi * cycles / columns * x)
                image = bench.cam.get_image()
                places.append(np.unravel_index(np.argmax(image), image.shape)[1])
            self.assertAlmostEqual(places[1] - places[0], 60 / columns * 200e3 * 0.632 / (19 * 3.45), delta=2)
            bench.cam.set_woi((10, 64, 20, 32))
            self.assertEqual(bench.cam.get_image().shape, (32, 64))
            self.assertEqual(bench.cam.get_image(averaging=3).shape, (32, 64))
        self.wait_until("running")
        self.call("camera.set", {"roi": {"x": 0, "y": 0, "width": 400, "height": 512}})
        with self.assertWarnsRegex(UserWarning, r"zeroth order is at \(512, 512\), outside"), Bench():
            pass


def rms_apart(a_waves, b_waves):
    """RMS difference of two wavefronts over the pupil, in waves, without piston and tilts, which depend on the reference and its blaze."""
    rows, columns = a_waves.shape
    y, x = np.mgrid[:rows, :columns]
    x, y = (x - (columns - 1) / 2) / (PUPIL / 2), (y - (rows - 1) / 2) / (PUPIL / 2)
    inside = np.hypot(x, y) <= 1
    apart = (a_waves - b_waves)[inside]
    apart = apart - np.angle(np.mean(np.exp(2j * np.pi * apart))) / (2 * np.pi)
    plane = np.stack([np.ones(apart.size), x[inside], y[inside]], axis=1)
    for _ in range(3):
        apart = apart - np.round(apart)
        apart = apart - plane @ np.linalg.lstsq(plane, apart, rcond=None)[0]
    return np.sqrt(np.mean(apart**2))


if __name__ == "__main__":
    main()
