"""Every pixel format of the camera, through the real link: the same light gives the same spots, also with colour filters."""
import time

import numpy

from case import PATIENCE_S, BenchCase, main, next_message, wait_for
from ovws_client import Image, Spots

FORMATS = ["Mono10", "Mono10p", "Mono10Packed", "Mono12p", "Mono12Packed", "Mono14", "Mono16", "BayerRG10", "BayerGR10p",
           "BayerGB12", "BayerBG12p", "Mono8", "BayerRG8"]
EXACT_PX = 0.01   # formats with sufficient bits
COARSE_PX = 0.02  # 8-bit rounding; a colour camera uses a quarter of its pixels
STILL = {"noise": "none"}


class Formats(BenchCase):
    twin_config = STILL
    daemon_config = {"camera": {"pixel_format": "Mono12", "frame_rate_hz": 20.0}, "stream": {"image_rate_hz": 10.0}}

    def spots(self, stream):
        """The spots of a settled frame exposed from now on, all of which must be found."""
        frame = self.frames_from_now(stream, 1)[0]
        self.assertEqual(frame["tracked"], 19)
        return Spots.of(frame, frame["binary"])

    def picture(self, images, name):
        """An image in this format, of a frame that arrives from now on."""
        now_ns = time.time_ns()
        message = wait_for(lambda: (message := next_message(images))["pixel_format"] == name and message["t_arrival_ns"] > now_ns and message,
                           what=f"an image in {name}")
        return Image.of(message, message["binary"])

    def brightest_near(self, pixels, at):
        x, y = (int(round(float(v))) for v in at)
        return int(pixels[y - 25:y + 26, x - 25:x + 26].max())

    def check(self, names):
        self.take_reference(4)
        spots, images = self.stream("spots"), self.stream("image", endpoint="tcp://127.0.0.1:7703")
        expected = self.spots(spots)
        failures = []
        print("\nformat        worst of 19 spots against Mono12 (px)   brightest spot (DN)")
        for name in names:
            applied = self.call("camera.set", {"pixel_format": name})["applied"]
            self.assertEqual(applied["pixel_format"], name)
            picture = self.picture(images, name)
            found = self.spots(spots)
            worst = float(numpy.abs(found.x_y_px - expected.x_y_px).max())
            brightest = int(found.peak_dn.argmax())
            peak, bits = int(found.peak_dn[brightest]), picture.significant_bits
            print(f"{name:13s} {worst:8.4f} {peak:42d}")
            self.assertEqual(picture.pixels.shape, (512, 512))
            self.assertEqual(picture.pixels.dtype, numpy.dtype("<u1" if bits == 8 else "<u2"))
            self.assertLess(int(picture.pixels.max()), 2**bits)
            self.assertGreater(peak, 2**bits / 4)
            self.assertEqual(peak, self.brightest_near(picture.pixels, found.x_y_px[brightest]))
            if worst > (COARSE_PX if bits == 8 else EXACT_PX):
                failures.append((name, worst))
        self.assertEqual(failures, [])

    def test_every_kind_puts_the_spots_where_twelve_plain_bits_do(self):
        self.check(FORMATS)

    def test_a_colour_camera_is_registered_and_calibrated(self):
        """Also rotated: the first steps with the paper's camera."""
        self.bench.stop("ovws-twin")
        self.wait_until("waiting_for_camera")
        self.bench.start_twin(STILL | {"camera": {"rotation_deg": 20.0}})
        self.wait_until("running")
        self.call("camera.set", {"pixel_format": "BayerRG8", "frame_rate_hz": 60.0})
        self.run_job("registration.run", {})
        self.assertAlmostEqual(self.call("registration.get")["rotation_deg"], 20.0, delta=0.01)
        self.take_reference(10)
        self.run_job("calibration.run", {"modes": list(range(1, 10)), "frames": 5})
        modes = [{"j": 3, "waves": 0.2}, {"j": 7, "waves": -0.1}]
        self.call("aberration.set", {"modes": modes})
        self.assertEqual(self.call("sensor.get")["operator_in_force"], "measured")
        self.modes_when(self.stream("wavefront"), lambda found: all(abs(waves - {3: 0.2, 7: -0.1}.get(j, 0.0)) < 0.01 for j, waves in found.items()),
                        "the modes shown")

    def test_numbers_justified_left_are_known_and_moved(self):
        self.take_reference(4)
        spots, images = self.stream("spots"), self.stream("image", endpoint="tcp://127.0.0.1:7703")
        expected, peak = self.spots(spots), int(self.picture(images, "Mono12").pixels.max())
        self.call("camera.set", {"pixel_format": "Mono8"})
        self.twin.call("twin.set", {"left_justified": True})
        self.call("camera.set", {"pixel_format": "Mono12"})
        wait_for(lambda: self.call("system.status")["counters"].get("frames_left_justified", 0) > 0, what="a frame known as left-justified")
        found = self.spots(spots)
        self.assertLess(float(numpy.abs(found.x_y_px - expected.x_y_px).max()), 0.001)
        self.assertEqual(found.saturated, 0.0)
        self.assertEqual(int(self.picture(images, "Mono12").pixels.max()), peak)

    def test_a_colour_camera_measures_what_is_shown(self):
        """From all pixels that see the laser: 44 modes, each frame and refined."""
        self.call("camera.set", {"pixel_format": "BayerRG12p"})
        self.call("sensor.set", {"mode_count": 44})
        self.take_reference(10)
        self.call("refine.set", {"enabled": True, "electrons_per_dn": 2.5, "rate_hz": 1.0})
        stream, refined = self.stream("wavefront"), self.stream("refined")
        for j, waves in ((3, 0.2), (4, -0.15), (7, 0.1), (25, 0.05)):
            shown = self.call("aberration.set", {"modes": [{"j": j, "waves": waves}]})["hologram_id"]
            self.settled_frames(stream, 1, shown, PATIENCE_S)
            frame = self.fitted_frames(stream, 1, PATIENCE_S)[0]
            refined.drain()
            fitted = wait_for(lambda: self.refined_of(refined, shown), what=f"a refined frame of j = {j}")
            for found in (frame, fitted):
                self.assertEqual(len(found["j"]), 44)
                worst = max(abs(c - (waves if i == j else 0.0)) for i, c in zip(found["j"], found["coefficients"]))
                print(f"\n  {found['schema']}: {waves} wave of j = {j} with an error of {worst:.4f} wave at most")
                self.assertLess(worst, 0.01)

    def refined_of(self, stream, hologram_id):
        message = stream.next(1.0)
        return message if message and message["valid"] and message["hologram_id"] == hologram_id else None


class GreenLaser(Formats):
    """Two of every four pixels see green light."""
    twin_config = STILL | {"optics": {"wavelength_nm": 532.0}}
    daemon_config = Formats.daemon_config | {"optics": {"wavelength_nm": 532.0}}

    def test_every_kind_puts_the_spots_where_twelve_plain_bits_do(self):
        self.check(["BayerRG12", "BayerGR12p", "BayerBG8"])

    test_numbers_justified_left_are_known_and_moved = None
    test_a_colour_camera_is_registered_and_calibrated = None


class SmallSpots(BenchCase):
    """lambda/d of 6.3 pixels: sufficient only for a camera without colour filters."""
    twin_config = STILL | {"optics": {"magnification": 0.5}}
    daemon_config = {"optics": {"magnification": 0.5}}

    def test_a_colour_camera_is_refused_at_once(self):
        error = self.refused("camera.set", {"pixel_format": "BayerRG8"})
        self.assertIn("colour", str(error))
        self.assertEqual(error.field, "pixel_format")
        self.assertEqual(self.call("camera.get")["settings"]["pixel_format"], "Mono8")
        self.assertEqual(self.settled_frames_of_all(), 19)

    def settled_frames_of_all(self):
        self.take_reference(4)
        return self.settled_frames(self.stream("wavefront"), 1)[0]["tracked"]


if __name__ == "__main__":
    main()
