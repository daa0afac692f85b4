"""The SLM's output shows exactly the grey levels that `ovws hologram` writes."""
import json
import subprocess

import numpy
from case import PROGRAM_PATIENCE_S, BenchCase, main, wait_for
from PIL import Image
from screen import grab

SLM = (1920, 0, 1280, 768)  # DUMMY1 in the bench's X server


class Hologram(BenchCase):
    def start(self):
        self.bench.start_display()
        self.bench.start_twin()

    def expected(self, config, *arguments):
        path = self.bench.directory / "expected.png"
        subprocess.run([self.bench.programs / "ovws", "hologram", "--config", config, "-o", path, *arguments], check=True, stdout=subprocess.DEVNULL,
                       timeout=PROGRAM_PATIENCE_S)
        with Image.open(path) as image:
            return numpy.asarray(image)

    def assert_shown(self, expected):
        shown = grab(self.bench.display, *SLM)
        for channel in range(3):
            self.assertEqual(int((shown[:, :, channel] != expected).sum()), 0, "pixels differ")

    def check(self, config):
        self.daemon_config = config
        self.start_daemon()
        self.wait_until("running")
        path = self.bench.directory / "ovwsd.json"
        wait_for(lambda: self.call("system.status")["slm"]["hologram_id"], what="a hologram")
        self.assert_shown(self.expected(path))
        self.call("aberration.set", {"modes": [{"n": 2, "m": -2, "waves": 0.5}, {"n": 4, "m": 0, "waves": 0.1}], "norm": "unit"})
        aberrated = self.expected(path, "--modes", "2,-2:0.5;4,0:0.1", "--norm", "unit")
        self.assert_shown(aberrated)
        self.call("sensor.set", {"charge": -2, "subapertures_across": 7, "spacing": 0.28})
        changed = self.bench.directory / "changed.json"
        changed.write_text(json.dumps(config | {"sensor": {"charge": -2, "subapertures_across": 7, "spacing": 0.28}}))
        self.assert_shown(self.expected(changed, "--modes", "2,-2:0.5;4,0:0.1", "--norm", "unit"))

    def test_default(self):
        self.check({})

    def test_with_lut_and_flatness(self):
        lut = self.bench.directory / "lut.txt"
        lut.write_text("# a gamma of 1.4 over 7/8 of the range\n" + "\n".join(str(round(224 * (i / 255) ** 1.4)) for i in range(256)))
        flatness = self.bench.directory / "flatness.png"
        y, x = numpy.mgrid[0:768, 0:1280]
        waves = 0.3 * numpy.hypot((x - 700) / 640, (y - 300) / 384) ** 2
        Image.fromarray((waves * 65536).astype(numpy.uint32).clip(0, 65535).astype(numpy.uint16)).save(flatness)
        self.check({"slm": {"lut": str(lut), "flatness": str(flatness)}})


if __name__ == "__main__":
    main()
