"""The daemon maps the bench's wavefront error finely, compared with the twin's hidden surface and with flatness.run."""
import base64
import math
import re

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


class MapCase(SlmCase):
    """A turned and mirrored camera of 8 bits, fresh noise in each frame."""
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

    def measure(self, params):
        """Runs map.run; returns its result and the map's error."""
        found = self.run_job("map.run", params)["result"]
        error, truth = self.error(picture(found["map"]))
        print(f"\n  map: surface of {truth:.4f} waves RMS, error {error:.4f}, noise {found['standard_error_waves']:.4f}, misfit "
              f"{found['misfit']:.3f}, {found['resolution_px']:.1f} px resolved with cells of {found['cell_px']:.2f} px, "
              f"{2 * found['patterns'] * found['frames']} frames of {found['exposure_us']:.0f} us, {found['seconds']:.1f} s of retrieval")
        self.assertGreater(truth, 0.1)
        self.assertLess(error, 0.01)
        self.assertLess(found["standard_error_waves"], error)
        return found, error


class Fine(MapCase):
    """A surface finer than any mode."""
    twin_config = MapCase.twin_config | {"slm": {"flatness_rms_waves": 0.15, "flatness_cycles": 9.0, "flatness_seed": 3}}

    def test_finds_the_surface_and_applies_it(self):
        self.assertIn("registration.run first", self.failure("map.run"))
        self.run_job("registration.run", {"frames": 3})
        before = self.judge()["wavefront"]["rms_waves"]
        found, _ = self.measure({"frames": 3, "apply": True})
        after = self.judge()["wavefront"]["rms_waves"]
        print(f"  the light {before:.4f} -> {after:.4f}")
        self.assertLess(after, 0.015)
        self.assertTrue(found["applied"])
        self.assertEqual(found["flatness_rms_waves"], 0.0)
        # Half a period of the finest wave is 21 px.
        self.assertLess(found["resolution_px"], 21.0)
        flatness = self.call("flatness.get")
        self.assertEqual(flatness["t_taken_ns"], found["t_taken_ns"])
        self.restart()
        self.assertEqual(self.call("flatness.get"), flatness)
        self.assertAlmostEqual(self.judge()["wavefront"]["rms_waves"], after, delta=0.001)
        again, _ = self.measure({"frames": 3})
        self.assertLess(again["difference_rms_waves"], 0.01)

    def test_refuses_what_it_cannot_do(self):
        self.run_job("registration.run", {"frames": 3})
        for params, field in (({"patterns": 3}, "patterns"), ({"cells": 300}, "cells"), ({"frames": 0}, "frames"), ({"apply": 1}, "apply")):
            self.assertIn(field, str(self.refused("map.run", params)))
        self.assertIn("256 cells requires 720 x 720 pixels", self.failure("map.run", {"cells": 256}))
        job = self.call("map.run", {"frames": 100})["job"]
        self.call("job.cancel", {"job": job})
        wait_for(lambda: self.call("job.get", {"job": job})["state"] == "cancelled", what="the job's end")
        self.take_reference(10)
        self.twin.call("twin.set", {"peak_electrons": 2})
        self.assertRegex(self.failure("map.run", {"frames": 1}), "increase the exposure|no wavefront explains")
        self.twin.call("twin.set", {"peak_electrons": 6000})
        self.twin.call("twin.set", {"branch_points": [{"x": 0.5, "y": -0.2, "charge": 1}]})
        error = self.failure("map.run")
        self.assertIn("branch point (phase singularity) near", error)
        x, y = map(float, re.search(r"near x (\S+), y (\S+) pupil", error).groups())
        self.assertLess(math.hypot(x - 0.5, y + 0.2), 0.1, error)
        self.twin.call("twin.set", {"branch_points": []})
        job = self.call("map.run", {"frames": 60})["job"]  # takes images for seconds
        wait_for(lambda: self.call("job.get", {"job": job})["progress"] > 0.15, what="half of the first images")
        at = self.twin.call("twin.get")["geometry"]["centre_px"]
        self.twin.call("twin.set", {"geometry": {"centre_px": [at[0] + 3.0, at[1]]}})
        ended = self.job_ended(job)
        self.assertIn("the image moved by", ended["error"]["message"])
        self.twin.call("twin.set", {"geometry": {"centre_px": at}})
        self.call("correction.set", {"modes": [{"j": 3, "waves": 0.01}]})
        self.assertIn("correction.clear", self.failure("map.run"))


class Colour(MapCase):
    """A colour camera, whose filters pass the laser in every second pixel of every second row."""
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 100, "pixel_format": "BayerRG8"}}

    def test_is_refused(self):
        self.run_job("registration.run", {"frames": 3})
        self.assertIn("use a monochrome camera", self.failure("map.run"))


class Smooth(MapCase):
    """A surface as flatness.run finds it."""
    twin_config = MapCase.twin_config | {"slm": {"flatness_rms_waves": 0.2, "flatness_cycles": 2.5, "flatness_seed": 3}}

    def test_agrees_with_flatness_run(self):
        self.run_job("registration.run", {"frames": 3})
        self.run_job("flatness.run", {"frames": 2})
        found, error = self.measure({"frames": 3})
        by_modes, _ = self.error(picture(found["flatness"]))
        print(f"  flatness.run: error {by_modes:.4f}; both differ by {found['difference_rms_waves']:.4f}")
        self.assertLess(by_modes, 0.02)
        self.assertAlmostEqual(found["difference_rms_waves"], math.hypot(by_modes, error), delta=0.01)


if __name__ == "__main__":
    main()
