"""A client's own pictures on the SLM (slm.present), and the frames under them (camera.grab)."""
import os
import signal
import subprocess
import sys
import time
import zlib

import numpy as np
import screen
from case import BenchCase, Client, main, wait_for
from ovws_client import Presentation, Refused, grab

ROWS, COLUMNS = 768, 1280
CLOCK_S = 0.1  # the daemon converts between its monotonic clock and UTC
RAW = {"correction": False, "flatness": False, "lut": False}


class PictureCase(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}, "camera": {"frame_rate_hz": 100}, "slm": {"settle_ms": 20}}
    twin_config = {"noise": "pool"}

    def start(self):
        super().start()
        self.random = np.random.default_rng(1)

    def grey(self):
        return self.random.integers(0, 256, (ROWS, COLUMNS), np.uint8)

    def shown_in(self, stamp):
        """CRC-32 of the grey levels that the twin's SLM showed in a frame."""
        sent = {frame["t_ns"]: frame["crc32"] for frame in self.twin.call("twin.get", {"sent_after": stamp["frame_id"] - 1})["sent"]}
        return sent[stamp["t_device_ns"]]

    def ask_for_frames(self, client, **params):
        """Asks for a grab; returns when the daemon has the request, because it answers the next one."""
        for number, (method, given) in enumerate((("camera.grab", params), ("system.status", {}))):
            client._socket.send_json({"jsonrpc": "2.0", "id": number, "method": method, "params": given})
        self.assertEqual(client._socket.recv_json()["id"], 1)

    def published(self):
        return self.call("system.status")["counters"]["frames_published"]

    def shown(self):
        return self.call("system.status")["slm"]["hologram_id"]


class Pictures(PictureCase):
    def test_every_frame_shows_its_own_picture(self):
        before, pictures = self.shown(), int(os.environ.get("OVWS_PICTURES", "40"))
        begun = time.monotonic()
        with Presentation(self.client, **RAW) as slm:
            for k in range(pictures):
                picture = self.grey()
                report = slm.show(picture)
                self.assertGreater(report["hologram_id"], before + k)
                grabbed = slm.grab(1 + k % 2)
                for stamp in grabbed.frames:
                    self.assertEqual((stamp["hologram_id"], stamp["settled"]), (report["hologram_id"], True))
                    self.assertEqual(self.shown_in(stamp), zlib.crc32(picture.tobytes()))
                self.assertEqual(grabbed.images.shape, (1 + k % 2, 512, 512))
            print(f"\n  {pictures} pictures, {pictures / (time.monotonic() - begun):.1f} a second")
            self.assertTrue(self.call("slm.verify")["equal"])
            self.assertEqual(self.call("system.status")["state"], "job_running")
        self.gives_back(before)
        job = self.call("job.get", {"job": report["job"]})
        self.assertEqual((job["kind"], job["state"], job["result"]), ("slm.present", "done", {"pictures": pictures}))

    def gives_back(self, before):
        """The sensor's own hologram is back on the SLM; its number has changed."""
        self.wait_until("running")
        self.assertEqual(self.call("system.status")["slm"]["pattern"], "sensor")
        self.assertGreater(self.shown(), before)
        self.assertTrue(self.call("slm.verify")["equal"])

    def test_the_sensor_returns_when_the_client_is_killed(self):
        """How soon after its lease: tests/bench/service."""
        self.take_reference(10)
        frames, events = self.stream("wavefront"), self.stream("event")
        code = ("import sys, time, numpy as np; from ovws_client import Client, Presentation\n"
                "slm = Presentation(Client(timeout_s=60.0), lease_s=5.0)\n"
                "while True: slm.show(np.random.rand(768, 1280)); print('shown', flush=True)")
        killed = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)})
        self.addCleanup(killed.communicate)
        self.addCleanup(killed.kill)
        self.assertEqual(killed.stdout.readline(), b"shown\n")
        error = self.refused("aberration.set", {"modes": [{"j": 5, "waves": 0.1}]})
        self.assertIn("job", error.reason)
        os.kill(killed.pid, signal.SIGKILL)
        killed_ns = time.time_ns()
        ended = wait_for(lambda: (m := events.next(1.0)) and m["kind"] == "job" and m["data"]["state"] != "running" and m, what="the end of the presentation")
        print(f"\n  the sensor is back {1e-9 * (ended['t_ns'] - killed_ns):.2f} s after a kill with a lease of 5 s")
        self.wait_until("running")
        self.settled_frames(frames, 5, self.shown())

    def test_pictures_pass_through_correction_flatness_and_table(self):
        flat = np.zeros((ROWS, COLUMNS), np.float32)
        self.call("correction.set", {"modes": [{"j": 4, "waves": 0.4}]})
        self.call("slm.show", {"pattern": "grating"})
        grating = self.on_screen()
        self.call("slm.show", {"pattern": "sensor"})
        rows, columns = np.mgrid[:ROWS, :COLUMNS]
        base = 200 * (columns - (COLUMNS - 1) / 2) / COLUMNS + 20 * (rows - (ROWS - 1) / 2) / ROWS
        with Presentation(self.client) as slm:
            slm.show(base, inside_pupil=True)
            # The client's phase has 24 bits, the daemon's own grating 53: single pixels may be one step of the table apart.
            apart = (self.on_screen() - grating).astype(np.int8)
            self.assertLessEqual(np.abs(apart).max(), 1)
            self.assertLess(np.count_nonzero(apart), 0.01 * apart.size)
            slm.show(flat)
            with_correction = self.call("slm.verify")["crc32"]
            slm.show(flat, correction=False)
            self.assertEqual(self.call("slm.verify")["crc32"], zlib.crc32(bytes(ROWS * COLUMNS)))
            self.assertNotEqual(with_correction, self.call("slm.verify")["crc32"])
            quarter = np.full((ROWS, COLUMNS), 0.25)
            slm.show(quarter, correction=False, inside_pupil=True)
            inside = (columns - (COLUMNS - 1) / 2) ** 2 + (rows - (ROWS - 1) / 2) ** 2 <= (768 / 2) ** 2
            self.assertEqual(self.call("slm.verify")["crc32"], zlib.crc32(np.where(inside, 64, 0).astype(np.uint8).tobytes()))

    def on_screen(self):
        self.assertTrue(self.call("slm.verify")["equal"])
        return screen.grab(self.bench.display, 1920, 0, COLUMNS, ROWS)[:, :, 0]

    def test_leases(self):
        def leased(seconds, binary=None, **params):
            """Checks that the lease is of `seconds`, from a moment between request and reply; None: it has ended."""
            asked_s = time.time()
            report = self.client.slm_present(binary, **params)
            answered_s = time.time()
            if seconds is None:
                self.assertIsNone(report["t_lease_ns"])
            else:
                begun_s = 1e-9 * report["t_lease_ns"] - seconds
                self.assertGreater(begun_s, asked_s - CLOCK_S)
                self.assertLess(begun_s, answered_s + CLOCK_S)
            return report

        picture, shape = bytes(ROWS * COLUMNS), [ROWS, COLUMNS]
        first = leased(10.0, picture, shape=shape, dtype="<u1")
        job = first["job"]
        leased(60.0, job=job, lease_s=60)
        again = leased(60.0, picture, job=job, shape=shape, dtype="<u1")
        renewed = leased(60.0, job=job)
        self.assertEqual((renewed["hologram_id"], renewed["t_settled_ns"]), (again["hologram_id"], None))
        leased(None, job=job, lease_s=0)
        self.wait_until("running")

    def test_what_a_presentation_excludes(self):
        with Presentation(self.client, lease_s=60.0) as slm, Client() as other:
            slm.show(self.grey())
            for method, params in (("aberration.set", {"modes": []}), ("sensor.set", {"charge": 0}), ("slm.show", {"pattern": "flat"}),
                                   ("correction.set", {"modes": []}), ("loop.close", {}), ("reference.take", {}), ("lut.run", {})):
                self.assertIn("job", self.refused(method, params).reason, method)
            self.assertIn("a job is running", str(self.refused_by(other, Presentation(other).show, self.grey())))
            # The camera is the client's.
            self.assertEqual(other.call("camera.set", {"exposure_us": 500})["applied"]["exposure_us"], 500)
            wait_for(lambda: slm.grab().frames[0]["exposure_us"] == 500, what="a frame of the new exposure")
            job = slm._job
            self.call("job.cancel", {"job": job})
            self.wait_until("running")
            self.assertIn("leave out job", self.refused("slm.present", {"job": job}).reason)
            self.assertNotEqual(slm.show(self.grey())["job"], job)  # the client begins another
        self.call("aberration.set", {"modes": []})  # at once: the presentation has ended with the block
        self.take_reference(10)
        self.close_loop()
        self.assertIn("loop", str(self.refused_by(self.client, Presentation(self.client).show, self.grey())))

    def refused_by(self, client, call, *args):
        with self.assertRaises(Refused) as caught:
            call(*args)
        return caught.exception

    def test_wrong_pictures(self):
        self.take_reference(10)
        before, frames = self.shown(), self.stream("wavefront")
        good, job = np.zeros((ROWS, COLUMNS), "<f4"), None

        def field(binary, **params):
            return self.refused_by(self.client, self.client.call, "slm.present", {"job": job, **params}, binary).field

        shape = [ROWS, COLUMNS]
        self.assertEqual(field(None), "shape")
        self.assertEqual(field(good.tobytes()), "shape")
        self.assertEqual(field(good.tobytes(), shape=[COLUMNS, ROWS]), "shape")
        self.assertEqual(field(good.tobytes()[:-1], shape=shape), "picture")
        self.assertEqual(field(good.tobytes(), shape=shape, dtype="<u1"), "picture")
        self.assertEqual(field(None, shape=shape), "picture")
        self.assertEqual(field(good.tobytes(), shape=shape, dtype="<f8"), "dtype")
        self.assertEqual(field(good.tobytes(), shape=shape, lease_s=-1), "lease_s")
        self.assertEqual(field(np.full(shape, np.nan, "<f4").tobytes(), shape=shape), "picture")
        for wrong in (np.zeros((ROWS, COLUMNS), int), np.zeros((ROWS, COLUMNS), complex), np.zeros(5)):
            with self.assertRaises(ValueError):
                Presentation(self.client).show(wrong)
        with self.assertRaises(ValueError):
            Presentation(self.client).grab()
        self.assertEqual(self.shown(), before)
        self.assertEqual(self.call("system.status")["state"], "running")  # none of them began a presentation
        self.assertEqual(self.refused_by(self.client, self.client.call, "slm.show", {"pattern": "flat"}, b"x").code, -32602)
        with Presentation(self.client, lease_s=60.0) as slm:
            job = slm.show(good)["job"]
            for bad in (np.nan, np.inf, -1e9):
                good[5, 7] = bad
                error = self.refused_by(self.client, slm.show, good)
                self.assertEqual(error.field, "picture")
                self.assertIn("row 5, column 7", error.reason)
            self.assertEqual(self.shown(), slm.hologram_id)
        self.gives_back(before)
        self.settled_frames(frames, 5, self.shown())

    def test_grabs(self):
        report, pixels = self.client.camera_grab(frames=3, region={"x": 10, "y": 20, "width": 33, "height": 7})
        self.assertEqual((report["shape"], report["dtype"], len(pixels)), ([3, 7, 33], "<u1", 3 * 7 * 33))
        whole = grab(self.client, after_hologram=self.shown(), frames=20)
        self.assertEqual(sorted({stamp["frame_id"] for stamp in whole.frames}), [stamp["frame_id"] for stamp in whole.frames])
        with Client(timeout_s=0.2) as hasty:  # its time-out begins after that of the grab
            mean = grab(hasty, frames=50, average=True)
        self.assertEqual((mean.images.dtype, mean.images.shape, len(mean.frames)), (np.dtype("<f4"), (1, 512, 512), 50))
        self.assertLess(np.abs(mean.images[0] - whole.images.mean(0)).max(), 8.0)
        for params, name in (({"region": {"x": 500, "y": 0, "width": 13, "height": 1}}, "region"), ({"frames": 1000}, "frames"),
                             ({"frames": 0}, "frames"), ({"after_hologram": self.shown() + 1}, "after_hologram"),
                             ({"after_hologram": self.shown() - 1}, "after_hologram"), ({"timeout_s": 0}, "timeout_s")):
            self.assertEqual(self.refused("camera.grab", params).field, name, params)
        self.call("camera.set", {"pixel_format": "Mono12Packed", "exposure_us": 100})
        packed = grab(self.client, after_hologram=self.shown())
        self.assertEqual(packed.images.dtype, np.dtype("<u2"))
        self.assertGreater(int(packed.images.max()), 255)
        self.twin.call("twin.fault", {"kind": "freeze", "seconds": 3600})
        self.assertRegex(self.refused("camera.grab", {"frames": 100, "timeout_s": 0.5}).reason, r"^\D*\d+ of 100 frames")  # some were on their way
        self.twin.call("twin.fault", {"kind": "none"})
        grab(self.client)  # the camera sends frames again
        long = {"frames": 1000, "average": True, "after_hologram": self.shown(), "timeout_s": 60}
        for change, reason in ((("camera.set", {"roi": {"x": 8, "y": 0, "width": 512, "height": 512}}), "the camera's image changed"),
                               (("aberration.set", {"modes": [{"j": 5, "waves": 0.1}]}), "was replaced by hologram")):
            with Client() as other:  # the region or the hologram is replaced meanwhile
                self.ask_for_frames(other, **long)
                published = self.published()
                wait_for(lambda before=published: self.published() > before + 30, what="frames for the grab")
                self.call(*change)
                self.assertIn(reason, other._socket.recv_json()["error"]["message"])

    def test_a_presentation_without_a_display(self):
        with Presentation(self.client, lease_s=60.0) as slm:
            slm.show(self.grey())
            self.xrandr("--off")
            self.wait_until("waiting_for_display")
            self.assertIn("display", str(self.refused_by(self.client, slm.show, self.grey())))
            self.assertIn("display is not in use", str(self.refused_by(self.client, slm.grab)))
        self.xrandr("--mode", f"{COLUMNS}x{ROWS}", "--pos", "1920x0")
        self.gives_back(1)

    def xrandr(self, *arguments):
        subprocess.run(["xrandr", "-display", self.bench.display, "--output", "DUMMY1", *arguments], check=True, capture_output=True)

    def test_a_grab_is_answered_when_the_daemon_stops(self):
        with Client() as other:
            self.ask_for_frames(other, frames=1000, average=True)
            self.bench.stop("ovwsd")
            self.assertIn("the daemon is stopping", other._socket.recv_json()["error"]["message"])


if __name__ == "__main__":
    main()
