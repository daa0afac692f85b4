"""The installed units with their sandbox under a real systemd: ready, status, reload, a hanging thread, stop, and the log."""
import contextlib
import json
import os
import pathlib
import pwd
import re
import shutil
import signal
import subprocess
import unittest
import urllib.request

import thread_holder
import user_manager
from case import Client, bench_module, main, wait_for

UNIT, METRICS_UNIT = "ovwsd.service", "ovws-metrics.service"
ROOT = pathlib.Path("/run/ovws-root")  # installed here: a unit with PrivateTmp does not see /tmp
CONFIG = pathlib.Path("/etc/ovws/ovwsd.json")  # in this test's own /etc
COMMON = """
[Service]
StandardError=append:{log}
ExecStart=
"""
DAEMON = COMMON + """
ExecStart={root}/usr/bin/ovwsd --config {config}
ExecStopPost=/bin/sh -c 'echo "the service has ended: $$SERVICE_RESULT" >&2'
Environment=DISPLAY=
TimeoutSec=60
"""
METRICS = COMMON + "ExecStart={root}/usr/bin/ovws metrics\n"
KEY = pathlib.Path("/run/credstore/ovws-metrics.key")


class Systemd(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = bench_module.Bench()
        cls.addClassCleanup(cls.bench.close)
        cls.log_path = cls.bench.directory / "journal.log"
        cls.log_path.touch()
        try:
            user_manager.own_mounts()
            cls.install()
            cls.manager = user_manager.Manager()
            cls.addClassCleanup(cls.manager.close)
            paths = {"root": ROOT, "config": CONFIG, "log": cls.log_path}
            for unit, drop_in in ((UNIT, DAEMON), (METRICS_UNIT, METRICS)):
                (user_manager.UNITS / unit).write_text((ROOT / "usr/lib/systemd/system" / unit).read_text())
                folder = user_manager.UNITS / f"{unit}.d"
                folder.mkdir()
                (folder / "test.conf").write_text(drop_in.format(**paths))
            cls.manager.start()
        except user_manager.NoManager as why:
            raise unittest.SkipTest(str(why)) from why

    @classmethod
    def install(cls):
        done = subprocess.run(["cmake", "--install", os.environ["OVWS_BUILD"], "--prefix", "/usr"], capture_output=True, text=True, timeout=600,
                              env=os.environ | {"DESTDIR": str(ROOT)})
        assert done.returncode == 0, done.stderr
        user_manager.own_users(ROOT / "usr/lib/sysusers.d/ovws.conf")
        CONFIG.parent.mkdir(exist_ok=True)
        CONFIG.write_text("{}")

    def setUp(self):
        self.addCleanup(self.stop)
        started = self.manager.systemctl("start", UNIT)
        self.assertEqual(started.returncode, 0, started.stderr + self.log())

    def stop(self):
        self.manager.systemctl("stop", UNIT)
        self.manager.systemctl("reset-failed", UNIT)

    def log(self):
        return self.log_path.read_text(errors="replace")

    def show(self, name):
        return self.manager.show(UNIT, name)[name]

    def pid(self):
        return int(self.show("MainPID"))

    def test_ready_status_reload_and_stop(self):
        client = Client()
        self.addCleanup(client.close)
        self.assertEqual(client.call("system.status")["state"], "waiting_for_camera", "it answers as soon as it is ready")
        status = wait_for(lambda: (text := self.show("StatusText")).startswith("waiting_for_camera") and text, what="the status line")
        print("\n ", status)
        pid = self.pid()
        CONFIG.write_text('{"camera": {"gain_db": 5.0}}')
        done = self.manager.systemctl("reload", UNIT)
        self.assertEqual(done.returncode, 0, done.stderr)
        wait_for(lambda: "applied camera.gain_db" in self.log(), what="the reload")
        self.assertEqual(client.call("camera.get")["settings"]["gain_db"], 5.0)
        CONFIG.write_text('{"camera": {"gain": 5.0}}')
        self.manager.systemctl("reload", UNIT)
        wait_for(lambda: "not reloaded" in self.log() and "camera.gain" in self.log(), what="the refusal")
        wait_for(lambda: self.show("ActiveState") == "active", what="active again")
        self.assertEqual((self.pid(), self.show("NRestarts")), (pid, "0"))
        CONFIG.write_text("{}")
        self.manager.systemctl("stop", UNIT)
        # By itself: after TimeoutStopSec the manager would have killed it.
        self.assertEqual((self.show("ActiveState"), self.show("Result")), ("inactive", "success"))
        print(re.sub("^", "  ", self.log()[-400:], flags=re.M))

    def test_the_sandbox_is_closed(self):
        process = pathlib.Path("/proc") / str(self.pid())
        status = dict(line.split(":\t", 1) for line in (process / "status").read_text().splitlines())
        user = pwd.getpwnam("ovws").pw_uid
        self.assertEqual(status["Uid"].split(), [str(user)] * 4)
        self.assertEqual((status["NoNewPrivs"], status["Seccomp"]), ("1", "2"))
        for capabilities in ("CapEff", "CapBnd"):
            self.assertEqual(int(status[capabilities], 16), 1 << 13, "CAP_NET_RAW and no other")
        options = {fields[4]: fields[5].split(",") for fields in map(str.split, (process / "mountinfo").read_text().splitlines())}
        self.assertIn("ro", options["/"])
        self.assertTrue(os.listdir("/home"))
        self.assertEqual(os.listdir(process / "root/home"), [], "hidden by ProtectHome")

    def test_it_comes_back_after_a_kill(self):
        pid = self.pid()
        os.kill(pid, signal.SIGKILL)
        wait_for(lambda: self.pid() not in (0, pid) and self.show("ActiveState") == "active", what="the restart")
        self.assertEqual(self.show("NRestarts"), "1")

    def keygen(self, path, *more):
        return subprocess.run([ROOT / "usr/bin/ovws", "keygen", "-o", path, *more], check=True, capture_output=True, text=True).stdout.strip()

    def start_metrics(self):
        self.addCleanup(self.manager.systemctl, "stop", METRICS_UNIT)
        started = self.manager.systemctl("restart", METRICS_UNIT)
        self.assertEqual(started.returncode, 0, started.stderr + self.log())

    def wait_for_metrics(self, up):
        def up_is_scraped():
            with contextlib.suppress(OSError), urllib.request.urlopen("http://127.0.0.1:7705/metrics", timeout=5) as page:
                return f"\novws_up {up}\n" in page.read().decode()
        wait_for(up_is_scraped, what=f"ovws_up {up}")

    def test_the_metrics_take_their_key_from_systemd(self):
        self.start_metrics()  # no key exists yet
        self.wait_for_metrics(1)
        daemon_key, clients = CONFIG.parent / "daemon.json", CONFIG.parent / "clients.json"
        server_key = self.keygen(daemon_key)
        shutil.chown(daemon_key, "ovws", "ovws")
        KEY.parent.mkdir()
        client = {"name": "metrics", "key": self.keygen(KEY, "--server-key", server_key), "role": "read"}
        self.addCleanup(KEY.unlink)
        clients.write_text(json.dumps({"clients": [client]}))
        CONFIG.write_text(json.dumps({"security": {"secret_key": str(daemon_key), "clients": str(clients)}}))
        self.addCleanup(CONFIG.write_text, "{}")
        self.manager.systemctl("restart", UNIT)
        self.wait_for_metrics(0)  # this process started before the key existed
        self.start_metrics()
        self.wait_for_metrics(1)

    def hang(self, name):
        """Holds a thread; checks that the log names it, and that the watchdog, which is notified no more, kills and restarts the service."""
        pid, seen = self.pid(), len(self.log())
        with thread_holder.held(pid, name) as ended:
            wait_for(lambda: f"thread {name} has not run for" in self.log()[seen:], what=f"the log's word on {name}")
            self.assertEqual(self.pid(), pid, "reported before the watchdog acts")
            notified = []  # times of the last notification

            def watched_end():
                now = self.manager.show(UNIT, "MainPID", "WatchdogTimestampMonotonic")
                if int(now["MainPID"]) == pid and now["WatchdogTimestampMonotonic"] not in ("0", *notified):
                    notified.append(now["WatchdogTimestampMonotonic"])
                return ended()
            wait_for(watched_end, what="the watchdog")
        self.assertLessEqual(len(notified), 2, "one may have been on its way")
        wait_for(lambda: "the service has ended: watchdog" in self.log()[seen:], what="the manager's word on why")
        wait_for(lambda: self.pid() not in (0, pid) and self.show("ActiveState") == "active", what="the restart")

    def test_a_hanging_acquire_thread_ends_in_a_restart(self):
        self.hang("acquire")

    @unittest.skipUnless(os.environ.get("OVWS_HANG_ALL"), "takes long: set OVWS_HANG_ALL=1 to hang control and prepare, too, whose turns may take 5 s and 30 s")
    def test_hanging_control_and_prepare_threads_end_in_a_restart(self):
        self.hang("control")
        self.hang("prepare")


if __name__ == "__main__":
    main()
