"""A blocked or slow disk blocks nothing else: frames continue, requests are answered, and all data are written afterwards.

Only the daemon sees such a disk, through an LD_PRELOAD library (slow_disk.cpp).
"""
import json
import os
import threading
import time

import h5py
from case import PATIENCE_S, BenchCase, Client, main, wait_for
from losses import Account

STANDS_S = float(os.environ.get("OVWS_DISK_STANDS_S", "7"))  # longer than the watchdog allows a thread
MIB = 1 << 20


class SlowDisk(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "slow-disk"}, "stream": {"image_rate_hz": 0}}

    def start_daemon(self):
        self.speed_file = self.bench.directory / "speed"
        self.folder = self.bench.directory / "slow-disk"
        self.folder.mkdir(exist_ok=True)
        with self.preload("slow_disk", OVWS_SLOW_FOLDER="slow-disk", OVWS_SLOW_DISK=str(self.speed_file)):
            super().start_daemon()

    def speed(self, bytes_per_s):
        """Sets the disk's speed. 0: blocked; None: real speed."""
        if bytes_per_s is None:
            return self.speed_file.unlink()
        new = self.speed_file.with_suffix(".new")
        new.write_text(str(bytes_per_s))
        return new.rename(self.speed_file)

    def in_background(self, method, params=None):
        """Calls a method with a separate client in a thread; returns a list that receives the reply."""
        replies = []

        def ask():
            client = Client(timeout_s=STANDS_S + 2 * PATIENCE_S)
            replies.append(client.call(method, params))
            client.close()

        threading.Thread(target=ask, daemon=True).start()
        return replies

    def ended_by_sigterm(self):
        """Terminates the daemon; returns its exit status and how long it took."""
        began = time.monotonic()
        self.bench.process("ovwsd").popen.terminate()
        return self.bench.process("ovwsd").popen.wait(PATIENCE_S), time.monotonic() - began


class Standing(SlowDisk):
    def test_it_holds_up_nobody_and_all_is_written_afterwards(self):
        self.take_reference(10)
        before = self.call("reference.get")
        self.assertIsNotNone(before["sha256"])
        frames, events = self.stream("wavefront"), self.stream("event")
        account = Account(self.client, self.twin, self.stream("wavefront"))
        self.call("camera.set", {"exposure_us": 1900.0})
        self.speed(0)
        began = time.monotonic()
        job = self.call("reference.take", {"frames": 10})["job"]
        wait_for(lambda: self.call("reference.get")["t_taken_ns"] != before["t_taken_ns"], what="the new reference")
        self.wait_until("running")
        saved = self.in_background("config.save")
        slowest_s, hologram, reason, hung = 0.0, 0, "", set()
        while not reason or "disk" not in hung or time.monotonic() - began < STANDS_S:
            self.assertLess(time.monotonic() - began, STANDS_S + PATIENCE_S, (reason, hung))
            asked = time.monotonic()
            status = self.call("system.status")
            hologram = self.call("aberration.set", {"modes": [{"j": 5, "waves": 0.02 * (hologram % 2)}]})["hologram_id"]
            slowest_s = max(slowest_s, time.monotonic() - asked)
            reason = status["store"]["reason"] or reason
            self.assertEqual(status["state"], "running")
            self.settled_frames(frames, 1, hologram)
            account.hear()
            hung |= {event["text"].split()[1] for event in iter(lambda: events.next(0.0), None) if event["kind"] == "thread"}
        self.assertEqual((saved, self.call("job.get", {"job": job})["state"], self.call("reference.get")["sha256"]), ([], "running", None))
        self.assertRegex(reason, "the disk has not answered for [0-9]+ s: check it; items waiting to be written: 1$")
        self.speed(None)
        ended = self.job_ended(job)
        self.assertEqual(ended["state"], "done")
        wait_for(lambda: saved, what="the reply to config.save")
        after = self.call("reference.get")
        self.assertIsNotNone(after["sha256"])
        wait_for(lambda: self.call("system.status")["store"]["reason"] is None, what="the end of the reason")
        account.check(self)
        self.assertEqual(hung - {"acquire"}, {"disk"}, "a busy machine may hold up the acquire thread for 2 s")
        overlay = json.loads((self.bench.directory / saved[0]["path"]).read_text())
        self.assertEqual(overlay["saved"]["camera.exposure_us"], {"value": 1900.0, "instead_of": 2000.0})
        self.bench.stop("ovwsd")
        self.client.close()
        self.start_daemon()
        self.wait_until("running")
        self.assertEqual(self.call("reference.get")["sha256"], after["sha256"])
        print(f"\n  the disk stood still for {STANDS_S:.0f} s: two calls took at most {slowest_s:.2f} s")

    def test_a_job_is_cancelled_and_all_that_needs_no_disk_is_answered(self):
        self.run_job("reference.take", {"frames": 10})
        job = self.call("calibration.run", {"frames": 50})["job"]
        wait_for(lambda: self.call("job.get", {"job": job})["progress"] > 0.0, what="the first poke")
        self.speed(0)
        self.assertEqual(self.call("job.cancel", {"job": job})["state"], "cancelled")
        self.call("aberration.set", {"modes": [{"j": 3, "waves": 0.1}]})  # the sensor is free
        asks = [name for name in self.call("system.describe")["methods"] if name.endswith((".get", ".list", ".model", ".outputs", ".verify"))]
        for method in sorted(set(asks) - {"job.get", "record.list"}):  # which needs params, and the disk
            self.call(method)
        job = self.call("lattice.prepare", {"lattices": [{"name": "same"}], "frames": 10, "find_exposure": False})["job"]
        wait_for(lambda: self.call("system.status")["state"] == "running", what="the procedure's end; its job waits for the disk")
        self.assertEqual(self.call("job.cancel", {"job": job})["state"], "cancelled")

    def test_the_daemon_ends_without_it(self):
        self.speed(0)
        self.call("reference.take", {"frames": 10})
        wait_for(lambda: self.call("system.status")["sensor"]["referenced"], what="the reference")
        status, took_s = self.ended_by_sigterm()
        print(f"\n  ended {took_s:.2f} s after SIGTERM, with an item that no disk took")
        self.assertEqual(status, 1, self.bench.log("ovwsd"))
        self.assertIn("state: items that were not written and are lost: 1: the disk has not answered", self.bench.log("ovwsd"))


class Recording(SlowDisk):
    def record(self, name):
        """Records while the disk stands still, until the backlog keeps a slow one busy for seconds."""
        self.call("record.start", {"name": name, "pictures_every": 1})
        wait_for(lambda: self.call("record.get")["frames"] > 0, what="the first frame")
        self.speed(0)
        frames = self.stream("wavefront")
        for _ in range(60):
            self.assertIsNotNone(frames.next(PATIENCE_S))

    def test_its_end_is_written_when_the_daemon_stops(self):
        self.record("slow")
        last = self.call("record.get")
        self.speed(8 * MIB)
        status, took_s = self.ended_by_sigterm()
        with h5py.File(self.folder / "recordings" / "slow.h5", "r") as file:
            frames, dropped, left_out = file["frames"].shape[0], file["frames"]["dropped_before"].sum(), file["summary"][0]["frames_dropped"]
        print(f"\n  {last['frames']} frames at SIGTERM, {frames} in the file {took_s:.2f} s later, {left_out} left out")
        self.assertEqual((status, left_out), (0, dropped), "a busy machine may drop some before, but none at the end")
        self.assertGreater(frames + dropped, last["frames"] + 10)

    def test_a_disk_that_stands_still_ends_it_and_the_exit_status_says_so(self):
        self.record("lost")
        status, took_s = self.ended_by_sigterm()
        print(f"\n  ended {took_s:.2f} s after SIGTERM, with a disk that takes nothing")
        self.assertEqual(status, 1)
        self.assertRegex(self.bench.log("ovwsd"), "record: the disk has not answered for 10 s: the end of .*lost.h5 is lost")


if __name__ == "__main__":
    main()
