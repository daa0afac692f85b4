"""What the client does with methods and streams together, against a played daemon: which frames count, and which settings are restored."""
import asyncio
import itertools
import math
import unittest
from dataclasses import replace
from unittest import mock

import numpy as np
from paths import SCHEMAS

from ovws_client import Client, Image, NoAnswer, Refused, Spots, Wavefront
from ovws_client.async_bench import AsyncBench
from ovws_client.corrector import mean_spots

EXPOSURE_US = 2000.0
FIRST = 1041  # number of the first frame whose exposure began after the call
STEP_NS = 20_000_000_000  # of the wall clock
EXAMPLE = Wavefront.of(SCHEMAS["stream.wavefront"]["examples"][0])
SPOTS = Spots.of(SCHEMAS["stream.spots"]["examples"][0], bytes(7 * 6 * 4))


class Played(Client):
    """A client of a daemon that answers at once and publishes these messages. Calls in `wrong` raise, each once. Grabs give the frames
    `grabbed`, (number, arrival), the last of them again."""

    def __init__(self, *messages, wrong=(), grabbed=None):
        self.messages, self.calls, self.wrong, self.subscribed = list(messages), [], dict(wrong), False
        self.grabbed = list(grabbed or [(FIRST, next((m.t_arrival_ns for m in messages if m.frame_id == FIRST), 0))])

    def call(self, method, params=None):
        if method.endswith(".set"):
            self.calls.append((method, params))
            if method in self.wrong:
                raise self.wrong.pop(method)
        return {"sensor.get": {"charge": 1, "tracker": "lg"},
                "camera.get": {"settings": {"gain_db": 0.0, "exposure_us": EXPOSURE_US}}}.get(method, {"applied": params})

    def call_binary(self, method, params=None, binary=None):
        assert self.subscribed, "a frame could come between the grab and the subscription"
        if method in self.wrong:
            raise self.wrong.pop(method)
        frame_id, arrival_ns = self.grabbed.pop(0) if len(self.grabbed) > 1 else self.grabbed[0]
        return {"camera.grab": {"frames": [{"frame_id": frame_id, "t_arrival_ns": arrival_ns}]}}[method], b"\0"

    def subscribe(self, *kinds, timeout_s=None):
        self.subscribed = True
        return self

    def next(self, timeout_s=None):
        return self.messages.pop(0) if self.messages else None

    def __exit__(self, *_):
        pass


class AsyncPlayed(AsyncBench):
    """The same for asyncio."""

    def __init__(self, played):
        self.played = played

    async def call_binary(self, *request):
        return self.played.call_binary(*request)

    async def subscribe(self, *kinds):
        self.played.subscribe(*kinds)
        return self

    async def next(self, timeout_s):
        return self.played.next(timeout_s)

    async def __aenter__(self):
        return self

    async def __aexit__(self, *_):
        pass


def frame(waves=0.0, **values):
    return replace(EXAMPLE, **({"frame_id": FIRST, "exposure_us": EXPOSURE_US, "coefficients_waves": np.full(len(EXAMPLE.j), waves)} | values))


def image(frame_id, arrival_ns=0):
    return Image(seq=0, frame_id=frame_id, t_arrival_ns=arrival_ns, hologram_id=1, pixel_format="Mono8", significant_bits=8, pixels=np.zeros((1, 1), np.uint8))


class Frames(unittest.TestCase):
    def test_an_image_whose_exposure_began_before_the_call_is_not_taken(self):
        self.assertEqual(Played(image(FIRST - 2), image(FIRST - 1), image(FIRST + 3)).image().frame_id, FIRST + 3)
        with self.assertRaises(NoAnswer):
            Played(image(FIRST - 1)).image(timeout_s=0.1)

    def test_nor_is_such_a_frame_or_one_of_unknown_exposure(self):
        older = [frame(9.0, frame_id=FIRST - 1), frame(9.0, exposure_us=None)]
        mean = Played(*older, frame(0.25), frame(0.0, valid=False), frame(0.75)).wavefront(frames=2)
        self.assertEqual((mean.frames, mean.skipped, mean.waves("defocus")), (2, 1, 0.5))

    def test_a_step_of_the_wall_clock_orders_nothing(self):
        for step_ns in (-STEP_NS, STEP_NS):
            arrivals = [EXAMPLE.t_arrival_ns + step_ns * (k > 1) for k in range(3)]
            frames = [frame(waves, frame_id=FIRST - 1 + k, t_arrival_ns=arrivals[k]) for k, waves in enumerate((9.0, 0.25, 0.75))]
            self.assertEqual(Played(*frames).wavefront(frames=2).coefficients_waves[0], 0.5, step_ns)
            images = [image(FIRST - 2 + k, arrivals[k]) for k in range(3)]
            self.assertEqual(Played(*images).image().frame_id, FIRST, step_ns)
            spots = [replace(SPOTS, frame_id=FIRST - 1 + k, t_arrival_ns=arrivals[k], exposure_us=EXPOSURE_US, settled=True,
                             x_y_px=np.full_like(SPOTS.x_y_px, k)) for k in range(3)]
            self.assertEqual(mean_spots(Played(*spots), 2)[0][0], 1.5, step_ns)

    def test_the_frames_of_a_camera_that_counts_from_the_beginning_are_later(self):
        frames = [frame(9.0, frame_id=FIRST - 1), frame(0.0), frame(0.25, frame_id=1), frame(0.5, frame_id=2)]
        self.assertEqual(Played(*frames).wavefront(frames=3).coefficients_waves[0], 0.25)

    def assert_first(self, expected, frames, grabbed):
        """That the first of these frames, (number, arrival), that counts is this one, for every call and both kinds of client."""
        kinds = {Image: [image(*each) for each in frames],
                 Wavefront: [frame(k, frame_id=each[0], t_arrival_ns=each[1]) for k, each in enumerate(frames)],
                 Spots: [replace(SPOTS, frame_id=each[0], t_arrival_ns=each[1], exposure_us=EXPOSURE_US, settled=True,
                                 x_y_px=np.full_like(SPOTS.x_y_px, k)) for k, each in enumerate(frames)]}
        k = [each[0] for each in frames].index(expected)
        self.assertEqual(Played(*kinds[Image], grabbed=grabbed).image().frame_id, expected)
        self.assertEqual(Played(*kinds[Wavefront], grabbed=grabbed).wavefront(frames=1).coefficients_waves[0], k)
        self.assertEqual(mean_spots(Played(*kinds[Spots], grabbed=grabbed), 2)[0][0], k + 0.5)
        for act, messages in ((AsyncPlayed.image, kinds[Image]), (lambda client: client.wavefront(frames=1), kinds[Wavefront])):
            client = AsyncPlayed(Played(*messages, grabbed=grabbed))
            found = asyncio.run(act(client))
            self.assertEqual(found.frame_id if isinstance(found, Image) else frames[int(found.coefficients_waves[0])][0], expected)

    def test_frames_of_before_a_restart_of_the_numbers_are_not_later(self):
        stream = [(5000, 100), (5001, 101), (1, 201), (2, 202), (3, 203), (4, 204), (5, 205)]
        self.assert_first(3, stream, [(3, 203), (6, 206)])
        self.assert_first(3, stream[:2] + stream[4:], [(3, 203), (6, 206)])
        self.assert_first(4, stream[:2] + stream[5:], [(3, 203), (6, 206)])

    def test_frames_after_a_restart_that_the_stream_does_not_show_are_later(self):
        self.assert_first(1, [(1, 201), (2, 202), (3, 203)], [(5002, 102), (4, 204)])
        self.assert_first(1, [(4999, 99), (1, 201), (2, 202)], [(5002, 102), (4, 204)])

    def test_a_step_of_the_wall_clock_is_no_restart(self):
        for step_ns, stepped in itertools.product((-STEP_NS, STEP_NS), (FIRST, FIRST + 1)):
            stamps = [(number, number + step_ns * (number >= stepped)) for number in range(FIRST - 2, FIRST + 5)]
            for left_out in ((), (2,), (2, 3)):  # with and without the frame that was grabbed
                stream = [stamp for k, stamp in enumerate(stamps) if k not in left_out]
                self.assert_first(FIRST + len(left_out), stream, [stamps[2], stamps[-1]])

    def test_a_camera_that_sends_nothing_is_no_answer_with_the_reason(self):
        silent = Refused("camera.grab", {"code": -32001, "message": "0 of 1", "data": {"field": "", "reason": "0 of 1 frames came within 3 s"}})
        for act in (lambda client: client.image(timeout_s=3.0), lambda client: client.wavefront(timeout_s=3.0), lambda client: mean_spots(client, 2, 3.0)):
            with self.assertRaisesRegex(NoAnswer, "^(no image|0 of 50 valid frames|0 of 2 settled frames) within 3.0 s: 0 of 1 frames came"):
                act(Played(wrong={"camera.grab": silent}))

    def test_grabs_that_others_use_are_waited_for(self):
        busy = Refused("camera.grab", {"code": -32000, "message": "too many grabs", "data": {"field": "", "reason": "too many grabs wait"}})
        acts = ((lambda client, timeout_s: client.image(timeout_s), image(FIRST)), (lambda client, timeout_s: client.wavefront(1, timeout_s), frame()),
                (lambda client, timeout_s: asyncio.run(AsyncPlayed(client).wavefront(1, timeout_s)), frame()))
        for act, message in acts:
            self.assertIsNotNone(act(Played(message, wrong={"camera.grab": busy}), 20.0))
            client = Played(message)
            client.call_binary = mock.Mock(side_effect=busy)
            with self.assertRaisesRegex(NoAnswer, "within 0.1 s: too many grabs wait"):
                act(client, 0.1)

    def test_numbers_of_numpy_are_numbers_and_wrong_ones_are_refused_by_name(self):
        for frames in (np.int64(2), np.float32(2.0), 2.0, np.array(2)):
            self.assertEqual(Played(frame(0.25), frame(0.75)).wavefront(frames=frames, timeout_s=np.float32(3.0)).frames, 2)
        for frames in (4.5, np.float64(4.5), 0, -1, math.nan, math.inf, "4", None):
            for act in (lambda client: client.wavefront(frames=frames), lambda client: mean_spots(client, frames)):
                with self.assertRaisesRegex(ValueError, "^frames: must be a whole number of at least 1, not "):
                    act(Played(frame()))
        for timeout_s in (-1, math.nan, "4", None):
            for act in (lambda client: client.wavefront(timeout_s=timeout_s), lambda client: client.image(timeout_s)):
                with self.assertRaisesRegex(ValueError, "^timeout_s: must be a number of at least 0, not "):
                    act(Played(frame()))

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
