"""The SLM's output shows the presented hologram, also after jobs that measure the SLM."""
import zlib

from case import main, wait_for
from screen import draw_over, grab
from slm_case import SlmCase


class Cancelled(SlmCase):
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 50}}
    twin_config = {"noise": "pool"}

    def all_of_it(self):
        methods = ("lut.get", "flatness.get", "aberration.get", "sensor.get", "registration.get", "reference.get", "camera.get")
        return [{key: value for key, value in self.call(method).items() if key != "hologram_id"} for method in methods]

    def shown(self):
        return self.call("system.status")["slm"]["hologram_id"]

    def test_leaves_everything_as_it_was(self):
        self.run_job("registration.run", {"frames": 3})
        self.call("aberration.set", {"modes": [{"j": 5, "waves": 0.1}]})
        self.take_reference(10, allow_aberration=True)
        before = self.all_of_it()
        frames = self.stream("wavefront")
        for method, params, pictures in (("slm.settle", {"repetitions": 100}, 3), ("lut.run", {"levels": 256, "frames": 50}, 1),
                                         ("flatness.run", {"frames": 50}, 3)):
            with self.subTest(method):
                first = self.shown()
                job = self.call(method, params)["job"]
                wait_for(lambda: self.shown() >= first + pictures, what="the middle of it")
                self.assertEqual(self.call("job.cancel", {"job": job})["state"], "cancelled")
                self.wait_until("running")
                self.assertEqual(self.all_of_it(), before)
                self.settled_frames(frames, 5, self.call("sensor.get")["hologram_id"])


class ReadBack(SlmCase):
    def test_what_stands_on_the_output_is_what_was_presented(self):
        seen = self.call("slm.verify")
        self.assertTrue(seen["equal"], seen)
        self.assertEqual(seen["crc32"], seen["crc32_shown"])
        shown = grab(self.bench.display, 1920, 0, 1280, 768)[:, :, 0]
        self.assertEqual(seen["crc32"], zlib.crc32(shown.tobytes()))
        events = self.stream("event")
        draw_over(self.bench.display, 2000, 100, 30, 20)  # within the output, without a window
        spoilt = self.call("slm.verify")
        self.assertFalse(spoilt["equal"], spoilt)
        self.assertEqual(spoilt["crc32"], seen["crc32"])
        self.assertNotEqual(spoilt["crc32_shown"], seen["crc32"])
        self.assertGreater(spoilt["differing_pixels"], 500)
        event = wait_for(lambda: (e := events.next(1.0)) and e["kind"] == "slm" and e, what="an event")
        self.assertEqual((event["severity"], event["data"]["differing_pixels"]), ("error", spoilt["differing_pixels"]))
        self.call("aberration.set", {"modes": [{"j": 4, "waves": 0.1}]})
        again = self.call("slm.verify")
        self.assertTrue(again["equal"], again)
        self.assertNotEqual(again["crc32"], seen["crc32"])


if __name__ == "__main__":
    main()
