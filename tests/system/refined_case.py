"""Base of the tests of refined frames."""
import time

import jsonschema
from case import PATIENCE_S, BenchCase

# The twin's camera: 10000 electrons are the full scale of 255 DN.
CAMERA = {"electrons_per_dn": 10000 / 255, "read_noise_e": 5.0, "black_level_dn": 2.0}
SHOWN = {3: 0.3, 8: 0.2}  # Z(2,-2) and Z(3,1)
MODES = [{"n": 2, "m": -2, "waves": 0.3}, {"n": 3, "m": 1, "waves": 0.2}]
FITS = 3


def errors(message):
    return [value - SHOWN.get(j, 0.0) for j, value in zip(message["j"], message["coefficients"])]


def root_sum_square(values):
    return sum(v * v for v in values) ** 0.5


class RefinedCase(BenchCase):
    daemon_config = {"state": {"directory": "state"}}

    def setUp(self):
        super().setUp()
        self.schema = self.call("system.describe")["streams"]["refined"]
        self.refined = self.stream("refined")

    def enable(self, **more):
        return self.call("refine.set", {"enabled": True, **CAMERA, **more})["applied"]

    def next_refined(self, wanted=lambda message: True):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            message = self.refined.next(1.0)
            if message is None:
                continue
            self.assertEqual(message.pop("topic"), "refined")
            jsonschema.Draft202012Validator(self.schema).validate(message)
            if wanted(message):
                return message
        self.fail(f"no such refined frame in {PATIENCE_S} s; {self.call('system.status')['refine']}")

    def of_hologram(self, hologram_id, count=1):
        found = [self.next_refined(lambda m: m["hologram_id"] == hologram_id) for _ in range(count)]
        for message in found:
            self.assertTrue(message["valid"], message)
        return found
