"""Wrong input of every kind: one reply with a clear error each time, and no partial changes."""
import json

from case import PATIENCE_S, BenchCase, Client, main

PARSE, REQUEST, METHOD, PARAMS = -32700, -32600, -32601, -32602


class WrongInput(BenchCase):
    def setUp(self):
        super().setUp()
        self.take_reference(20)
        self.before = self.everything()

    def everything(self):
        return {m: self.call(m) for m in ("camera.get", "sensor.get", "aberration.get", "reference.get", "config.get")}

    def tearDown(self):
        """After each test the daemon's state must be unchanged, and it must still measure."""
        self.assertEqual(self.everything(), self.before)
        self.settled_frames(self.stream("wavefront"), 5)

    def assert_refused(self, method, params, code, field, *words):
        error = self.refused(method, params)
        print(f"\n  {method} {json.dumps(params)[:70]}\n    -> {error.code} {error.data.get('field')}: {error.data.get('reason')}")
        self.assertEqual(error.code, code)
        self.assertEqual(error.data.get("field"), field)
        for word in words:
            self.assertIn(str(word), str(error) + json.dumps(error.data))

    def raw(self, data):
        client = Client(timeout_s=PATIENCE_S)
        self.addCleanup(client.close)
        return client.exchange(data)

    def test_names_that_are_not_known(self):
        self.assert_refused("camera.set", {"gian_db": 3.0}, PARAMS, "gian_db", "gain_db")
        self.assert_refused("sensor.set", {"charge": 1, "gird": "square"}, PARAMS, "gird", "grid")
        self.assert_refused("aberation.set", {"modes": []}, METHOD, "method", "aberration.set")
        self.assert_refused("camera.set", {"roi": {"x": 0, "y": 0, "widht": 256, "height": 256}}, PARAMS, "roi.widht", "width")

    def test_types(self):
        self.assert_refused("camera.set", {"gain_db": "loud"}, PARAMS, "gain_db", "number")
        self.assert_refused("sensor.set", {"charge": 0.5}, PARAMS, "charge")
        self.assert_refused("aberration.set", {"modes": {"j": 3}}, PARAMS, "modes", "array")
        self.assert_refused("reference.take", {"frames": None}, PARAMS, "frames")
        self.assert_refused("camera.set", [1, 2], PARAMS, "params")

    def test_values(self):
        self.assert_refused("camera.set", {"gain_db": 90.0}, PARAMS, "gain_db", 48)
        self.assert_refused("camera.set", {"exposure_us": -1.0}, PARAMS, "exposure_us")
        self.assert_refused("camera.set", {"gain_db": 3.0, "exposure_us": 1e9}, PARAMS, "exposure_us")
        self.assert_refused("camera.set", {"pixel_format": "Mono17"}, PARAMS, "pixel_format", "Mono16")
        self.assert_refused("camera.set", {"roi": {"x": 4000, "y": 0, "width": 512, "height": 512}}, PARAMS, "roi.x")
        self.assert_refused("camera.set", {"roi": {"x": 0, "y": 0, "width": 60000, "height": 512}}, PARAMS, "roi.width")
        self.assert_refused("sensor.set", {"pupil_diameter_px": 5000.0}, PARAMS, "pupil_diameter_px")
        self.assert_refused("sensor.set", {"grooves": [900.0, 20.0]}, PARAMS, "grooves")
        self.assert_refused("sensor.set", {"subapertures_across": 9}, PARAMS, "spacing", "sensor.subapertures_across to 6")
        self.assert_refused("sensor.set", {"charge": 7}, PARAMS, "spacing", "sensor.spacing to 0.42")
        self.assert_refused("aberration.set", {"modes": [{"n": 2, "m": 1, "waves": 0.1}]}, PARAMS, "modes[0].n")
        self.assert_refused("aberration.set", {"modes": [{"n": 2, "m": -2, "waves": 200.0}]}, PARAMS, "modes", "too steep")
        self.assert_refused("job.get", {"job": 4711}, PARAMS, "job", 4711)

    def test_clamp_brings_numbers_into_range(self):
        applied = self.call("camera.set", {"gain_db": 90.0, "clamp": True})["applied"]
        self.assertEqual(applied["gain_db"], 48.0)
        self.call("camera.set", {"gain_db": 0.0})

    def test_bytes_that_are_no_request(self):
        for name, data, code in (("garbage", b"\x00\xffgarbage", PARSE),
                                 ("1 MiB of garbage", bytes(range(256)) * 4096, REQUEST),
                                 ("wrong UTF-8", b'{"jsonrpc":"2.0","id":1,"method":"\xc3\x28"}', PARSE),
                                 ("half of a request", b'{"jsonrpc":"2.0","id":1,', PARSE),
                                 ("empty", b"", PARSE),
                                 ("a number", b"42", REQUEST),
                                 ("an empty batch", b"[]", REQUEST),
                                 ("no method", b'{"jsonrpc":"2.0","id":1}', REQUEST),
                                 ("very deep", b"[" * 30000 + b"]" * 30000, PARSE),
                                 ("NaN", b'{"jsonrpc":"2.0","id":1,"method":"camera.set","params":{"gain_db":NaN}}', PARSE)):
            with self.subTest(name):
                error = self.raw(data)["error"]
                print(f"\n  {name}\n    -> {error['code']} {error['message']}: {error.get('data')}")
                self.assertIn(error["code"], (code, PARSE, REQUEST))
                self.assertTrue(error["message"])

    def test_one_bad_member_fails_alone(self):
        replies = self.raw(json.dumps([
            {"jsonrpc": "2.0", "id": 1, "method": "sensor.get"},
            {"jsonrpc": "2.0", "id": 2, "method": "camera.set", "params": {"gain_db": "loud"}},
            {"jsonrpc": "2.0", "method": "system.status"},
            17,
            {"jsonrpc": "2.0", "id": "three", "method": "aberration.get"}]).encode())
        by_id = {reply["id"]: reply for reply in replies}
        self.assertEqual(len(replies), 4)  # the notification has none
        self.assertIn("result", by_id[1])
        self.assertEqual(by_id[2]["error"]["code"], PARAMS)
        self.assertEqual(by_id[None]["error"]["code"], REQUEST)
        self.assertIn("result", by_id["three"])


if __name__ == "__main__":
    main()
