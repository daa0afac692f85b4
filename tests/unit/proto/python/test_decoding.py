"""Decoding of messages made by the daemon's encoders, detection of losses, and refusal of malformed messages."""
import copy
import dataclasses
import json
import pickle
import unittest

from paths import SCHEMAS, emitted

import numpy as np
import zmq

import ovws_client
from ovws_client import Lost, NotUnderstood
from ovws_client.subscription import Decoder, Losses

KINDS = {kind.topic: kind for kind in (ovws_client.Wavefront, ovws_client.Spots, ovws_client.Corrector, ovws_client.Refined, ovws_client.Status, ovws_client.Event,
                                       ovws_client.Image, ovws_client.Phase)}
# Constants of the schema, and fields with another name in the client.
CONSTANT = {"schema", "unit", "basis", "orientation", "columns", "column_units", "shape", "dtype"}
RENAMED = {"coefficients": "coefficients_waves", "sigma": "sigma_waves"}
BINARY = {"spots": {"x_y_px", "ref_x_y_px", "peak_dn", "quality"}, "corrector": {"commands"}, "image": {"pixels"}, "phase": {"waves"}}


def example(topic):
    return SCHEMAS[f"stream.{topic}"]["examples"][0]


def binary_of(body):
    if "dtype" not in body:
        return None
    return np.arange(np.prod(body["shape"]), dtype=body["dtype"]).tobytes()


def frames_of(topic, body):
    binary = binary_of(body)
    return [zmq.Frame(topic.encode()), zmq.Frame(json.dumps(body).encode())] + ([zmq.Frame(binary)] if binary else [])


class Messages(unittest.TestCase):
    def test_every_topic_and_every_key_has_its_place(self):
        self.assertEqual({f"stream.{topic}" for topic in KINDS}, {name for name in SCHEMAS if name.startswith("stream.")})
        for topic, kind in KINDS.items():
            keys = {RENAMED.get(key, key) for key in SCHEMAS[f"stream.{topic}"]["properties"]} - CONSTANT
            names = {field.name for field in dataclasses.fields(kind)} - {"lost_messages"} - BINARY.get(topic, set())
            self.assertEqual(names, keys, topic)

    def test_what_the_encoders_make_is_understood(self):
        for topic, kind in KINDS.items():
            bodies = emitted(f"stream.{topic}") + [example(topic)]
            self.assertGreaterEqual(len(bodies), 2)
            for body in bodies:
                message = kind.of(body, binary_of(body))
                for key in body.keys() - CONSTANT:
                    value = getattr(message, RENAMED.get(key, key))
                    if isinstance(value, np.ndarray):
                        value = [None if np.isnan(each) else each for each in value.tolist()]
                    self.assertEqual(value, body[key], f"{topic}.{key}")

    def test_messages_and_their_loss_cross_to_another_process_whole(self):
        kinds = [*KINDS.values(), ovws_client.Wavefront.of_beam("b"), ovws_client.Spots.of_beam("b")]
        for kind in kinds:
            topic = kind.topic.partition(".")[0]
            message = kind.of(example(topic), binary_of(example(topic)), 2)
            for copied in (lambda value: pickle.loads(pickle.dumps(value)), copy.copy, copy.deepcopy):
                self.assertIs(copied(kind), kind)
                other, loss = copied(message), copied(Lost(message, 3))
                self.assertIs(type(other), kind)
                self.assertIs(type(loss.message), kind)
                self.assertEqual((loss.messages, loss.frames, str(loss)), (2, 3, str(Lost(message, 3))))
                for field in dataclasses.fields(kind):
                    np.testing.assert_equal(getattr(other, field.name), getattr(message, field.name))
                    np.testing.assert_equal(getattr(loss.message, field.name), getattr(message, field.name))

    def test_not_valid_is_nan_and_none(self):
        frame = next(frame for body in emitted("stream.wavefront") if not (frame := KINDS["wavefront"].of(body)).valid)
        self.assertTrue(np.isnan(frame.coefficients_waves).all() and len(frame.coefficients_waves) == len(frame.j))
        self.assertIsNone(frame.rms_waves)
        self.assertTrue(np.isnan(frame.phase_waves(8)).all())

    def test_pictures_lie_where_they_came(self):
        for dtype in ("<u1", "<u2"):
            body = example("image") | {"shape": [3, 5], "dtype": dtype}
            binary = memoryview(bytearray(binary_of(body)))
            pixels = KINDS["image"].of(body, binary).pixels
            self.assertEqual((pixels.shape, pixels.dtype), ((3, 5), np.dtype(dtype)))
            np.testing.assert_array_equal(pixels, np.arange(15).reshape(3, 5))
            binary[0] = 77
            self.assertEqual(pixels[0, 0], 77, "not a copy")

    def test_the_columns_of_spots(self):
        body = example("spots") | {"shape": [2, 6]}
        table = np.array([[10, 20, 9, 18, 200, 0.5], [np.nan] * 6], "<f4")
        spots = KINDS["spots"].of(body, table.tobytes())
        np.testing.assert_array_equal(spots.x_y_px, [[10, 20], [np.nan] * 2])
        np.testing.assert_array_equal(spots.displacements_px, [[1, 2], [np.nan] * 2])
        np.testing.assert_array_equal(spots.peak_dn, [200, np.nan])
        np.testing.assert_array_equal(spots.quality, np.array([0.5, np.nan], "f4"))

    def test_commands_come_with_valid_frames_only(self):
        body = example("corrector") | {"shape": [3]}
        corrector = KINDS["corrector"].of(body, np.array([1, -2, 0.5], "<f4").tobytes())
        np.testing.assert_array_equal(corrector.commands, np.array([1, -2, 0.5], "f4"))
        self.assertEqual(len(KINDS["corrector"].of(body | {"shape": [0], "valid": False}).commands), 0)

    def test_another_form_is_not_taken_for_this_one(self):
        def refused(topic, words, binary=None, **changes):
            body = {key: value for key, value in (example(topic) | changes).items() if value != "missing"}
            with self.assertRaisesRegex(NotUnderstood, words):
                KINDS[topic].of(body, binary)

        refused("wavefront", "ovws.wavefront/2", schema="ovws.wavefront/2")
        refused("wavefront", "ovws.spots/1", schema="ovws.spots/1")
        refused("wavefront", "coefficients", coefficients="missing")
        refused("wavefront", "gap", gap="missing")
        refused("image", "binary part")
        refused("image", "reshape", binary=b"123")
        refused("image", "<f8", binary=b"12345678", dtype="<f8", shape=[1, 1])
        refused("spots", "columns", binary=bytes(7 * 6 * 4), column_units=["mm"] * 6)
        KINDS["event"].of(example("event") | {"added_later": 1})  # fields may be added


class Loss(unittest.TestCase):
    def test_holes_are_counted_by_topic(self):
        losses = Losses()
        heard = [("wavefront", 7), ("wavefront", 8), ("status", 3), ("wavefront", 11), ("status", 4)]
        self.assertEqual([losses.before(*message) for message in heard], [0, 0, 0, 2, 0])
        self.assertEqual(losses.before("wavefront", 4), 4, "a daemon started anew")
        self.assertEqual(losses.before("wavefront", 5), 0)
        self.assertEqual(losses.messages, 6)

    def feed(self, decoder, seqs, topic="wavefront", **changes):
        for seq in seqs:
            yield decoder.decode(frames_of(topic, example(topic) | {"seq": seq} | changes))

    def test_reported(self):
        decoder = Decoder([KINDS["wavefront"], KINDS["image"]], "report")
        self.assertEqual([m.lost_messages for m in self.feed(decoder, (5, 6, 9, 10))], [0, 0, 2, 0])
        self.assertEqual([m.lost_messages for m in self.feed(decoder, (0, 2), "image", shape=[4, 4])], [0, 1])
        self.assertEqual(decoder.losses.messages, 3)

    def test_raised_with_the_message_and_goes_on(self):
        decoder = Decoder([KINDS["wavefront"]], "raise")
        self.assertEqual([m.seq for m in self.feed(decoder, (5, 6))], [5, 6])
        with self.assertRaises(Lost) as caught:
            list(self.feed(decoder, (9,)))
        self.assertEqual((caught.exception.messages, caught.exception.frames, caught.exception.message.seq), (2, 0, 9))
        with self.assertRaises(Lost) as caught:
            list(self.feed(decoder, (10,), gap=3))
        self.assertEqual((caught.exception.messages, caught.exception.frames), (0, 3))
        self.assertIn("3 frames", str(caught.exception))
        self.assertEqual([m.seq for m in self.feed(decoder, (11,))], [11])

    def test_a_topic_that_only_begins_alike(self):
        decoder = Decoder([KINDS["wavefront"]], "raise")
        self.assertIsNone(decoder.decode(frames_of("wavefronts", {"seq": 1})))

    def test_nothing_to_subscribe_to(self):
        with self.assertRaises(ValueError):
            Decoder([], "report")


if __name__ == "__main__":
    unittest.main()
