"""A bench whose state directory is on its own small disk."""
import contextlib
import subprocess
import time
from itertools import pairwise

from case import BenchCase, own_mounts, wait_for
from losses import Account

# One job for each kind of stored result, in order of dependency: method, params, and the method that reports whether it is stored.
RUNS = (("registration.run", {"frames": 2}, None),
        ("lut.run", {"levels": 17, "frames": 2}, "lut.get"),
        ("reference.take", {"frames": 10}, "reference.get"),
        ("calibration.run", {"frames": 2, "modes": [1, 2, 3]}, "calibration.get"))
ITEMS = ("registration.get", "lut.get", "reference.get", "calibration.get")


class DiskCase(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "state"}, "stream": {"image_rate_hz": 0}, "tracking": {"tracker": "lg"}}

    def start(self):
        self.state = self.bench.directory / "state"
        self.state.mkdir()
        own_mounts()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "none", self.state], check=True)
        self.addCleanup(subprocess.run, ["umount", "-l", self.state], check=True)
        super().start()

    def restart(self):
        self.bench.stop("ovwsd")
        self.client.close()
        self.start_daemon()
        self.wait_until("running")
        return self.bench.log("ovwsd")

    def known(self):
        """The results of all get methods, without `in_force`, which depends on the configuration."""
        return {method: {key: value for key, value in self.call(method).items() if key != "in_force"} for method in ITEMS}

    def files(self):
        """The contents of all stored files, including those set aside as outdated."""
        found = {}
        for path in self.state.iterdir():
            if path.name != "filler" and path.suffix != ".ovws-tmp":  # the daemon tries to write again and again
                found[path.name.removesuffix(".outdated")] = path.read_bytes()
        return found

    @contextlib.contextmanager
    def flowing(self):
        """Checks that frames are published meanwhile without a pause, and that each one that a busy machine loses is counted."""
        stream = self.stream("wavefront")
        account = self.account = Account(self.client, self.twin, stream)
        yield
        end = time.time_ns()
        wait_for(lambda: account.hear() or account.messages[-1]["t_publish_ns"] > end, what="a frame after the end")
        account.check(self)
        stream.close()
        for last, message in pairwise(account.messages):
            self.assertLess(message["t_arrival_ns"] - last["t_arrival_ns"], 5e9)

    def assert_nothing_is_kept(self, why):
        """Checks that jobs work in memory and report that their results are not stored, and why."""
        events = self.stream("event")
        for method, params, get in RUNS:
            with self.subTest(method):
                events.drain()
                self.run_job(method, params)
                self.account.hear()
                event = wait_for(lambda: (e := events.next(1.0)) and "will not survive a restart" in e["text"] and e, what=f"the event of {method}")
                self.assertEqual(event["severity"], "error")
                self.assertRegex(event["text"], why)
                store = self.call("system.status")["store"]
                self.assertEqual(store["directory"], str(self.bench.directory / "state"))
                self.assertRegex(store["reason"], why)
                if get:
                    self.assertIsNone(self.call(get)["sha256"])
        self.call("camera.set", {"exposure_us": 1900.0})
        refused = self.refused("config.save")
        self.assertEqual((refused.code, refused.data["field"]), (-32001, "path"))
        self.assertRegex(refused.data["reason"], why)
        self.call("camera.set", {"exposure_us": 2000.0})

    def check(self, break_it, mend_it, why, sets_aside):
        """`sets_aside`: outdated files can be renamed, so that a restart does not load them."""
        for method, params, _ in RUNS:
            self.run_job(method, params)
        self.call("config.save")
        before, files = self.known(), self.files()
        break_it()
        with self.flowing():
            self.assert_nothing_is_kept(why)
        self.assertEqual(self.files(), files)
        log = self.restart()
        self.assertRegex(log, "new measurements and settings are lost at a restart; those saved before are used: " + why)
        if sets_aside:
            self.assertEqual({item.get("sha256") for item in self.known().values()}, {None})
            self.assertFalse(self.call("registration.get")["registered"])
        else:
            self.assertEqual(self.known(), before)
        with self.flowing():
            self.assert_nothing_is_kept(why)
        self.assertEqual(self.files(), files)
        mend_it()
        with self.flowing():
            for method, params, _ in RUNS:
                self.run_job(method, params)
                self.account.hear()
            self.call("config.save")
        wait_for(lambda: self.call("system.status")["store"]["reason"] is None, what="the end of the reason")
        after = self.known()
        self.assertNotIn(None, [item.get("sha256", "") for item in after.values()])
        self.restart()
        self.assertEqual(self.known(), after)
        return before
