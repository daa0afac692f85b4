"""What the client does with methods and streams together, against a played daemon: which frames count, and which settings are restored."""
import unittest
from dataclasses import replace

import numpy as np
from paths import SCHEMAS

from ovws_client import Client, Image, NoAnswer, Refused, Wavefront

NOW_NS, TRANSFER_NS, EXPOSURE_US = 1_000_000_000, 10_000_000, 2000.0
FIRST_NS = NOW_NS + TRANSFER_NS + int(1e3 * EXPOSURE_US)  # arrival of the first frame that certainly began after the call
EXAMPLE = Wavefront.of(SCHEMAS["stream.wavefront"]["examples"][0])


class Played(Client):
    """A client of a daemon that answers at once and publishes these messages. Calls in `wrong` raise, each once."""

    def __init__(self, *messages, wrong=()):
        self.messages, self.calls, self.wrong = list(messages), [], dict(wrong)

    def call(self, method, params=None):
        if method.endswith(".set"):
            self.calls.append((method, params))
            if method in self.wrong:
                raise self.wrong.pop(method)
        return {"system.status": {"t_ns": NOW_NS}, "config.get": {"camera": {"transfer_ms": 1e-6 * TRANSFER_NS}}, "sensor.get": {"charge": 1, "tracker": "lg"},
                "camera.get": {"settings": {"gain_db": 0.0, "exposure_us": EXPOSURE_US}}}.get(method, {"applied": params})

    def subscribe(self, *kinds, timeout_s=None):
        return self

    def next(self, timeout_s=None):
        return self.messages.pop(0) if self.messages else None

    def __exit__(self, *_):
        pass


def frame(waves=0.0, **values):
    return replace(EXAMPLE, **({"t_arrival_ns": FIRST_NS, "exposure_us": EXPOSURE_US, "coefficients_waves": np.full(len(EXAMPLE.j), waves)} | values))


def image(arrival_ns):
    return Image(seq=0, frame_id=arrival_ns, t_arrival_ns=arrival_ns, hologram_id=1, pixel_format="Mono8", significant_bits=8, pixels=np.zeros((1, 1), np.uint8))


class Frames(unittest.TestCase):
    def test_an_image_whose_exposure_may_have_begun_before_the_call_is_not_taken(self):
        self.assertEqual(Played(image(NOW_NS + TRANSFER_NS), image(FIRST_NS - 1000), image(FIRST_NS)).image().t_arrival_ns, FIRST_NS)
        with self.assertRaises(NoAnswer):
            Played(image(FIRST_NS - 1000)).image(timeout_s=0.1)

    def test_nor_is_such_a_frame_or_one_of_unknown_exposure(self):
        older = [frame(9.0, t_arrival_ns=FIRST_NS - 1000), frame(9.0, exposure_us=None), frame(9.0, exposure_us=EXPOSURE_US + 1.0)]
        mean = Played(*older, frame(0.25), frame(0.0, valid=False), frame(0.75)).wavefront(frames=2)
        self.assertEqual((mean.frames, mean.skipped, mean.waves("defocus")), (2, 1, 0.5))

    def test_frames_of_different_measurements_are_not_averaged(self):
        closed = {"loop": "closed"}
        for before, after in (({}, {"charge": 2}), ({}, {"tracker": "fit"}), ({}, {"j": EXAMPLE.j + 1}), ({}, {"reference_introduced_rms_waves": 0.1}),
                              ({}, {"hologram_id": EXAMPLE.hologram_id + 1}), (closed, {})):
            with self.subTest(before=before, after=after):
                mean = Played(frame(9.0, **before), frame(9.0, valid=False), frame(0.25, **after), frame(0.75, **after)).wavefront(frames=2)
                self.assertEqual((mean.frames, mean.skipped, mean.coefficients_waves[0]), (2, 0, 0.5))
        mean = Played(frame(0.25, **closed), frame(0.75, hologram_id=EXAMPLE.hologram_id + 1, **closed)).wavefront(frames=2)
        self.assertEqual(mean.coefficients_waves[0], 0.5, "the hologram changes at each step of a closed loop")


class Settings(unittest.TestCase):
    def test_they_are_restored_in_reverse_order(self):
        client = Played()
        with client.settings(gain_db=6.0, charge=2) as applied:
            self.assertEqual(applied, {"gain_db": 6.0, "charge": 2})
        self.assertEqual(client.calls, [("camera.set", {"gain_db": 6.0}), ("sensor.set", {"charge": 2}), ("sensor.set", {"charge": 1}), ("camera.set", {"gain_db": 0.0})])

    def test_a_change_without_an_answer_is_restored_too(self):
        client = Played(wrong={"camera.set": NoAnswer("no answer")})
        with self.assertRaises(NoAnswer), client.settings(gain_db=6.0, charge=2):
            self.fail("it was entered")
        self.assertEqual(client.calls, [("camera.set", {"gain_db": 6.0}), ("camera.set", {"gain_db": 0.0})])

    def test_a_key_that_does_not_exist_is_not_restored(self):
        client = Played(wrong={"sensor.set": Refused("sensor.set", {"code": -32602, "message": "nothing: unknown key"})})
        with self.assertRaisesRegex(Refused, "unknown key"), client.settings(nothing=1):
            self.fail("it was entered")
        self.assertEqual(client.calls, [("sensor.set", {"nothing": 1})])

    def test_clamp_goes_to_every_change(self):
        for settings, methods in (({"gain_db": 6.0}, ["camera.set"]), ({"charge": 2}, ["sensor.set"]), ({"gain_db": 6.0, "charge": 2}, ["camera.set", "sensor.set"]), ({}, [])):
            client = Played()
            with client.settings(clamp=True, **settings):
                self.assertEqual([(method, params["clamp"]) for method, params in client.calls], [(method, True) for method in methods])


if __name__ == "__main__":
    unittest.main()
