"""A fixed lenslet array on the twin: no display, and the spots of the real camera's images are where the truth says."""
import time
import unittest

import numpy

from case import bench_module, Client, Stream, main, wait_for
from ovws_client import Image

TWIN = {"modulator": "fixed", "noise": "pool",
        "camera": {"sensor_width": 1280, "sensor_height": 1024, "rotation_deg": 3.0},
        "optics": {"focal_length_mm": 5.2, "camera_pitch_um": 5.3, "centre_px": [143.2, 144.6]},
        "array": {"columns": 9, "rows": 9, "shape": "circle", "beam_diameter_mm": 1.38},
        "sensor": {"charge": 0}, "light": {"peak_electrons": 1500}, "mirror": {"actuators_across": 9}}
LAMBDA_F_UM2 = 632e-3 * 5.2e3
CALLS = 200


def centroid(image, at, reach=6):
    x0, y0 = (round(v) - reach for v in at)
    box = image[y0:y0 + 2 * reach + 1, x0:x0 + 2 * reach + 1].astype(float)
    light = numpy.clip(box - 0.4 * box.max(), 0.0, None)
    y, x = numpy.mgrid[:box.shape[0], :box.shape[1]]
    return x0 + (x * light).sum() / light.sum(), y0 + (y * light).sum() / light.sum()


class FixedArray(unittest.TestCase):
    def setUp(self):
        self.bench = bench_module.Bench()
        self.addCleanup(self.bench.close)
        self.bench.start_twin(TWIN)
        self.bench.start_daemon({"camera": {"frame_rate_hz": 200}, "stream": {"image_rate_hz": 50}})
        self.twin = Client("tcp://127.0.0.1:7790")
        self.addCleanup(self.twin.close)
        self.images = Stream(["image"], "tcp://127.0.0.1:7703")
        self.addCleanup(self.images.close)

    def image(self):
        """An image of a frame that the twin began after this call: the second that it sent after it."""
        sent = max((frame["frame_id"] for frame in self.twin.call("twin.get")["sent"]), default=0)
        later = set()

        def begun_later():
            message = self.images.next(1.0)
            later.update({message["frame_id"]} if message and message["frame_id"] > sent else ())
            return len(later) > 1 and message
        message = wait_for(begun_later, what="an image")
        return Image.of(message, message["binary"]).pixels.astype(float)

    def offsets(self):
        image = self.image()
        spots = [(spot["x"], spot["y"]) for spot in self.twin.call("twin.get")["spots"]]
        return numpy.array(spots), numpy.array([centroid(image, spot) for spot in spots]) - spots

    def test_spots_are_behind_the_lenslets_and_follow_the_light(self):
        truth = self.twin.call("twin.get")
        self.assertFalse(truth["display"]["shown"])
        spots, offsets = self.offsets()
        self.assertEqual(len(spots), 69)  # lenslets within 4.6 pitches of the centre
        print("\nflat: largest distance from the truth", abs(offsets).max(), "px")
        self.assertLess(abs(offsets).max(), 0.35)
        self.twin.call("twin.set", {"aberration": [{"j": 4, "waves": 0.5}, {"j": 2, "waves": 0.5}]})
        moved, offsets = self.offsets()
        print("defocus and tilt: largest", abs(offsets).max(), "px, the spots moved by up to", abs(moved - spots).max())
        self.assertGreater(abs(moved - spots).max(), 2.0)
        self.assertLess(numpy.sqrt((offsets**2).mean()), 0.3)
        error = self.refused("twin.get", {"judge": "sensor"})
        self.assertIn("fixed array", error)

    def refused(self, method, params):
        try:
            self.twin.call(method, params)
        except Exception as error:  # the client's own class
            return f"{error}"
        raise AssertionError("was not refused")

    def test_the_mirror_moves_the_spots(self):
        mirror = self.twin.call("twin.get")["mirror"]
        positions = numpy.array(mirror["positions"])
        self.assertEqual(positions.shape, (69, 2))
        # A tilt by the mirror: 0.4 wave per pupil radius along x of the array.
        tilt = (0.4 * positions[:, 0]).tolist()
        _, before = self.offsets()
        self.assertEqual(self.twin.call("twin.mirror", {"waves": tilt})["actuators"], 69)
        _, after = self.offsets()
        moved = numpy.median(after - before, axis=0)
        radius_um = 9 * 150.0 / 2
        # Gaussian influences add up to a somewhat larger wavefront than the commands.
        gain = sum(mirror["coupling"] ** (k * k) for k in range(-4, 5)) ** 2
        wanted = gain * 0.4 / radius_um * LAMBDA_F_UM2 / 5.3
        print("\ntilt by the mirror moves the spots by", moved, "px; expected", wanted)
        self.assertLess(abs(moved[0] / wanted - 1.0), 0.2)
        took_s = []
        for k in range(CALLS):
            commands, begun_s = [w * (-1) ** k for w in tilt], time.monotonic()
            self.twin.call("twin.mirror", {"waves": commands})
            took_s.append(time.monotonic() - begun_s)
        print(f"twin.mirror: {1e3 * sum(took_s) / CALLS:.2f} ms per call")
        self.assertEqual(self.twin.call("twin.get")["mirror"]["waves"], commands)
        self.assertLess(min(took_s), 0.05)  # some 0.1 ms on an idle machine
        self.assertIn("69", self.refused("twin.mirror", {"waves": [0.0]}))


if __name__ == "__main__":
    main()
