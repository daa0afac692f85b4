"""The daemon maps the bench's wavefront error finely, compared with the twin's hidden surface and with flatness.run."""
import base64
import math
import time

import numpy

from case import main, wait_for
from slm_case import SlmCase


class Random64:
    """The generator std::mt19937_64 of the C++ standard, by which the twin makes its surface."""
    def __init__(self, seed):
        self.words = [seed]
        for k in range(1, 312):
            before = self.words[-1]
            self.words.append((6364136223846793005 * (before ^ (before >> 62)) + k) % 2 ** 64)
        self.at = 312

    def uniform(self):
        if self.at == 312:
            for k in range(312):
                x = (self.words[k] & (2 ** 64 - 2 ** 31)) | (self.words[(k + 1) % 312] & (2 ** 31 - 1))
                self.words[k] = self.words[(k + 156) % 312] ^ (x >> 1) ^ (0xB5026F5AA96619E9 if x & 1 else 0)
            self.at = 0
        x = self.words[self.at]
        self.at += 1
        x ^= (x >> 29) & 0x5555555555555555
        x ^= (x << 17) & 0x71D67FFFEDA60000
        x ^= (x << 37) & 0xFFF7EEE000000000
        x ^= x >> 43
        return (x >> 11) * 2.0 ** -53


def surface(slm, width, height, x, y):
    """The twin's flatness error (README of the twin) at SLM pixels, waves."""
    uniform = Random64(slm["flatness_seed"]).uniform
    waves = numpy.zeros_like(x)
    for _ in range(8):
        direction, start = 2 * math.pi * uniform(), uniform()
        cycles = (0.5 + (slm["flatness_cycles"] - 0.5) * uniform()) / height
        waves += numpy.cos(2 * math.pi * (cycles * (math.cos(direction) * x + math.sin(direction) * y) + start))
    return slm["flatness_rms_waves"] * math.sqrt(2 / 8) * waves


def picture(sent):
    waves = numpy.frombuffer(base64.b64decode(sent["base64"]), "<f4").reshape(sent["cells"], sent["cells"])
    return waves.astype(float)


class Map(SlmCase):
    """A surface finer than any mode, a turned and mirrored camera of 8 bits, fresh noise in each frame."""
    small = True
    width, height, pupil = 640, 384, 384.0
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 100}}
    twin_config = {"camera": {"rotation_deg": 90.0, "mirror": "x"}, "noise": "fresh",
                   "slm": {"flatness_rms_waves": 0.15, "flatness_cycles": 9.0, "flatness_seed": 3},
                   "light": {"shape": "gaussian", "diameter_px": 600.0}}

    def error(self, waves):
        """RMS of a map minus the hidden surface, and of the surface, without piston and tilts."""
        cells = waves.shape[0]
        line = ((2 * numpy.arange(cells) + 1) / cells - 1) * self.pupil / 2
        x, y = numpy.meshgrid(line, line)
        truth = surface(self.twin_config["slm"], self.width, self.height, x + (self.width - 1) / 2, y + (self.height - 1) / 2)
        inside = numpy.hypot(x, y) < self.pupil / 2
        plane = numpy.stack([numpy.ones(inside.sum()), x[inside], y[inside]], axis=1)

        def rms(values):
            return float(numpy.std(values - plane @ numpy.linalg.lstsq(plane, values, rcond=None)[0]))
        return rms((waves - truth)[inside]), rms(truth[inside])

    def test_finds_the_surface_and_applies_it(self):
        self.assertIn("registration.run first", self.failure("map.run"))
        self.run_job("registration.run", {"frames": 3}, 60.0)
        shown = self.call("sensor.get")["hologram_id"]
        begin = time.monotonic()
        first = self.run_job("map.run", {"frames": 5}, 120.0)["result"]
        took = time.monotonic() - begin
        self.assertNotEqual(self.call("sensor.get")["hologram_id"], 0, shown)
        error, truth = self.error(picture(first["map"]))
        print(f"\n  map: surface of {truth:.4f} waves RMS, error {error:.4f}, expected {first['standard_error_waves']:.4f}, misfit "
              f"{first['misfit']:.3f}, {first['resolution_px']:.1f} px resolved with cells of {first['cell_px']:.2f} px, "
              f"exposure {first['exposure_us']:.0f} us, {took:.1f} s, of which {first['seconds']:.1f} s retrieval")
        self.assertGreater(truth, 0.1)
        self.assertLess(error, 0.02)
        self.assertEqual(first["flatness_rms_waves"], 0.0)
        begin = time.monotonic()
        modes = self.run_job("flatness.run", {"frames": 2}, 120.0)["result"]
        took = time.monotonic() - begin
        second = self.run_job("map.run", {"frames": 5, "apply": True}, 120.0)["result"]
        by_modes, _ = self.error(picture(second["flatness"]))
        again, _ = self.error(picture(second["map"]))
        after = self.judge()["wavefront"]["rms_waves"]
        print(f"  flatness.run: error {by_modes:.4f} in {took:.1f} s; the map beside it {again:.4f}, both differ by "
              f"{second['difference_rms_waves']:.4f}; left after apply {after:.4f}")
        self.assertLess(again, 0.02)
        self.assertLess(again, 0.5 * by_modes)
        self.assertAlmostEqual(second["difference_rms_waves"], by_modes, delta=0.02)
        self.assertLess(after, 0.025)
        self.assertTrue(second["applied"])
        found = self.call("flatness.get")
        self.assertNotEqual(found["t_taken_ns"], modes["t_taken_ns"])
        self.restart()
        self.assertEqual(self.call("flatness.get"), found)
        self.assertLess(self.judge()["wavefront"]["rms_waves"], 0.025)

    def test_refuses_what_it_cannot_do(self):
        self.run_job("registration.run", {"frames": 3}, 60.0)
        for params, field in (({"patterns": 3}, "patterns"), ({"cells": 300}, "cells"), ({"frames": 0}, "frames"), ({"apply": 1}, "apply")):
            self.assertIn(field, self.refused("map.run", params).message)
        self.assertIn("256 cells requires 648 x 648 pixels", self.failure("map.run", {"cells": 256}))
        job = self.call("map.run", {"frames": 100})["job"]
        self.call("job.cancel", {"job": job})
        wait_for(lambda: self.call("job.get", {"job": job})["state"] == "cancelled", 10.0, "the job's end")
        self.take_reference(10)
        self.twin.call("twin.set", {"peak_electrons": 2})
        self.assertRegex(self.failure("map.run", {"frames": 1}), "increase the exposure|no wavefront explains")
        self.twin.call("twin.set", {"peak_electrons": 6000})
        self.call("correction.set", {"modes": [{"j": 3, "waves": 0.01}]})
        self.assertIn("correction.clear", self.failure("map.run"))


if __name__ == "__main__":
    main()
