"""What notebooks show: HTML that is well-formed, with images that other programs decode; and the mean of wavefronts."""
import base64
import io
import re
import unittest
import xml.etree.ElementTree as etree

import numpy as np
from PIL import Image as Picture
from paths import SCHEMAS

from ovws_client import Image, MeanWavefront, Wavefront, display


def parsed(text):
    """The HTML as a tree; it is well-formed XML, too."""
    return etree.fromstring(f"<div>{text}</div>")


def picture(text):
    return Picture.open(io.BytesIO(base64.b64decode(re.search(r"base64,([^\"]+)", text)[1])))


def frame(waves, valid=True):
    body = SCHEMAS["stream.wavefront"]["examples"][0]
    count = len(waves)
    return Wavefront.of(body | {"j": list(range(1, count + 1)), "coefficients": list(waves) if valid else [None] * count, "sigma": [0.001] * count, "valid": valid,
                                "rms_waves": 0.5 if valid else None})


class Display(unittest.TestCase):
    def test_png_of_grey_levels_and_colours(self):
        for pixels in (np.arange(35, dtype=np.uint8).reshape(5, 7), np.arange(105, dtype=np.uint8).reshape(5, 7, 3)):
            np.testing.assert_array_equal(np.asarray(Picture.open(io.BytesIO(display.png(pixels)))), pixels)

    def test_a_camera_image(self):
        pixels = np.array([[0, 4095, 16], [32, 4095, 2048]], np.uint16)
        image = Image(seq=0, frame_id=7, t_arrival_ns=0, hologram_id=1, pixel_format="Mono12", significant_bits=12, pixels=pixels)
        text = image._repr_html_()
        np.testing.assert_array_equal(np.asarray(picture(text)), pixels >> 4)
        self.assertIn("frame 7: 3 x 2 Mono12, brightest pixel 4095 of 4095 DN, 2 saturated", parsed(text).find(".//figcaption").text)

    def test_a_wavefront(self):
        text = frame([0.0, 0.0, 0.1, -0.25])._repr_html_()
        rows = [[cell.text or "" for cell in row] for row in parsed(text).iter("tr")]
        self.assertEqual(rows[0], ["mode", "waves", "standard error"])
        self.assertEqual(rows[4], ["defocus", "-0.2500", "0.0010"])
        colours = np.asarray(picture(text)).astype(int)
        self.assertEqual(colours.shape, (128, 128, 3))
        self.assertEqual(colours[0, 0].tolist(), [255, 255, 255], "nothing outside the pupil")
        self.assertEqual(display.signed(np.array([[np.nan, 0.0]]), 1.0).tolist(), [[[255, 255, 255], [247, 247, 247]]])
        lost = frame([0.0, 0.0, 0.1, -0.25], valid=False)._repr_html_()
        self.assertIn("not valid", lost)
        self.assertNotIn("base64", lost)
        self.assertEqual(frame([0.0, 0.0, 0.1, -0.25]).waves("defocus"), -0.25)

    def test_text_is_escaped(self):
        self.assertEqual(parsed(display.table(["<b>"], [["a & b"]])).find(".//th").text, "<b>")

    def test_the_mean_and_its_standard_error(self):
        rng = np.random.default_rng(3)
        waves = np.array([0.3, 0.0, 0.1, -0.2]) + rng.normal(0.0, 0.01, (100, 4))
        mean = MeanWavefront.of([frame(row) for row in waves], skipped=2)
        np.testing.assert_allclose(mean.coefficients_waves, waves.mean(axis=0))
        np.testing.assert_allclose(mean.standard_error_waves, waves.std(axis=0, ddof=1) / 10.0)
        self.assertAlmostEqual(mean.rms_waves, np.hypot(*waves.mean(axis=0)[2:]), msg="without tilts")
        self.assertEqual((mean.frames, mean.skipped, mean.names[3], mean.waves((2, 0))), (100, 2, "defocus", mean.coefficients_waves[3]))
        self.assertIn("Mean of 100 frames", mean._repr_html_())
        self.assertTrue(np.isnan(MeanWavefront.of([frame(waves[0])]).standard_error_waves).all())


if __name__ == "__main__":
    unittest.main()
