"""The daemon as a service: notifications, log and exit. The test plays the service manager."""
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import unittest

from case import PATIENCE_S, BenchCase, Client, ClientError, bench_module, main, wait_for

# With the libraries of Debian 12 the service locks 106 MiB of them whole, and 141 MiB in all; a display driver may add its own.
MAX_LOCKED_WHOLE_MIB, MAX_LOCKED_MIB = 130, 180


class Service(unittest.TestCase):
    def setUp(self):
        self.bench = bench_module.Bench()
        self.addCleanup(self.bench.close)

    def start(self, config="{}", **environment):
        path = self.bench.directory / "notify"
        self.notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.notify.close)
        self.notify.bind(str(path))
        self.config = self.bench.directory / "ovwsd.json"
        self.config.write_text(config)
        env = {k: v for k, v in os.environ.items() if k != "DISPLAY"} | {"NOTIFY_SOCKET": str(path)} | environment
        self.daemon = subprocess.Popen([self.bench.programs / "ovwsd", "--config", self.config], env=env, cwd="/", stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.daemon.stderr.close)
        self.addCleanup(self.daemon.kill)

    def messages(self, until):
        """The lines of the notifications, from now until until(lines) is true."""
        lines = []
        self.notify.settimeout(PATIENCE_S)
        while not until(lines):
            lines += self.notify.recv(65536).decode().splitlines()
        return lines

    def exit_status(self):
        """Waits for the terminating daemon. Its notifications are refused meanwhile: it would wait for room in a queue that nobody reads."""
        self.notify.close()
        return self.daemon.wait(PATIENCE_S)

    @staticmethod
    def has_looked_for_cameras(lines):
        """Whether the camera's thread waits: a daemon that is stopped while Aravis looks for cameras does not await its end."""
        return any(line.startswith("STATUS=") and "not opened yet" not in line for line in lines)

    def test_ready_status_watchdog_and_an_orderly_end(self):
        """How soon it ends, and how regularly it notifies the watchdog, is printed by tests/bench/service."""
        self.start(WATCHDOG_USEC="600000")  # notified three times in this interval
        lines = self.messages(lambda lines: "READY=1" in lines and lines.count("WATCHDOG=1") >= 6 and self.has_looked_for_cameras(lines))
        self.assertEqual(lines.count("READY=1"), 1)
        status = [line for line in lines if line.startswith("STATUS=")]
        print("\n ", status[-1])
        self.assertTrue(any("waiting_for_camera" in line for line in status))
        if os.access("/dev/cpu_dma_latency", os.W_OK):
            held = subprocess.run(["ls", "-l", f"/proc/{self.daemon.pid}/fd"], capture_output=True, text=True).stdout
            self.assertIn("/dev/cpu_dma_latency", held, "held while it runs")
        self.daemon.send_signal(signal.SIGTERM)
        self.assertEqual(self.messages(lambda lines: "STOPPING=1" in lines).count("READY=1"), 0)
        self.assertEqual(self.exit_status(), 0)

    def test_log_for_the_journal_carries_priorities(self):
        self.start(JOURNAL_STREAM="1:1")
        lines = self.messages(lambda lines: "READY=1" in lines and self.has_looked_for_cameras(lines))
        self.assertNotIn("WATCHDOG=1", lines)  # no manager asks for it
        self.daemon.terminate()
        self.exit_status()
        lines = self.daemon.stderr.read().splitlines()
        self.assertTrue(lines)
        for line in lines:
            self.assertRegex(line, re.compile(r"^<[2-7]>\S"))

    def test_relative_paths_start_from_the_folder_of_the_configuration(self):
        """In the check, at the start and at a reload; the daemon and the check run in "/", as services do."""
        folder = self.bench.directory
        (folder / "lut.txt").write_text(" ".join(map(str, range(256))))
        (folder / "mask.csv").write_text(("0.25 " * 16 + "\n") * 16)
        values = {"slm": {"lut": "lut.txt"}, "sensor": {"mask": {"file": "mask.csv"}}, "state": {"directory": "state"},
                  "control": {"endpoint": "ipc://control"}, "camera": {"driver": "replay", "id": "run.h5"}}
        self.start(json.dumps(values))
        self.messages(lambda lines: "READY=1" in lines)
        self.notify.close()  # as in exit_status
        checked = subprocess.run([self.bench.programs / "ovwsd", "--config", self.config, "--check-config"], capture_output=True, text=True, cwd="/")
        self.assertEqual(checked.returncode, 0, checked.stderr)
        client = Client(f"ipc://{folder}/control")
        self.addCleanup(client.close)
        used = client.call("config.get")
        for config in (json.loads(checked.stdout), used):
            self.assertEqual((config["slm"]["lut"], config["sensor"]["mask"]["file"], config["state"]["directory"], config["camera"]["id"]),
                             (f"{folder}/lut.txt", f"{folder}/mask.csv", f"{folder}/state", f"{folder}/run.h5"))
        with self.assertRaisesRegex(ClientError, "id: must be the absolute path"):
            client.call("camera.select", {"id": "other.h5", "wait": True})
        self.assertTrue((folder / "state").is_dir())
        self.config.write_text(json.dumps(values | {"slm": {"lut": "lut.txt", "settle_ms": 22.5}}))
        self.daemon.send_signal(signal.SIGHUP)
        wait_for(lambda: client.call("config.get")["slm"]["settle_ms"] == 22.5, what="the reload")

    def test_a_reload_that_is_asked_for_while_it_reads_its_file_does_not_end_it(self):
        os.mkfifo(pipe := self.bench.directory / "slow.json")
        starting = subprocess.Popen([self.bench.programs / "ovwsd", "--config", pipe], stderr=subprocess.PIPE, text=True)
        with pipe.open("w") as config:  # waits until it is read
            starting.send_signal(signal.SIGHUP)
            config.write("{]")
        self.assertIn("not JSON", starting.communicate(timeout=PATIENCE_S)[1])
        self.assertEqual(starting.returncode, 1)


class LockedMemory(BenchCase):
    def locked_mib(self):
        """Locked memory: what is locked whole, used or not, and all that is resident. VmLck counts what is only locked once used, too."""
        whole_kib = resident_kib = size_kib = rss_kib = 0
        for line in pathlib.Path(f"/proc/{self.bench.process('ovwsd').pid}/smaps").read_text().splitlines():
            name, *fields = line.split()
            if name == "Size:":
                size_kib = int(fields[0])
            elif name == "Rss:":
                rss_kib = int(fields[0])
            elif name == "VmFlags:" and "lo" in fields:
                resident_kib += rss_kib
                if "lf" not in fields and "rd" in fields:  # neither locked on fault, as it is used, nor a mere reservation of addresses
                    whole_kib += size_kib
        return whole_kib / 1024, resident_kib / 1024

    def test_what_is_mapped_after_the_start_is_locked_as_it_is_used(self):
        """Most of a thread's stack and of what the display's driver loads is never used."""
        if "memory is not locked" in self.bench.log("ovwsd"):
            self.skipTest("memory cannot be locked here")
        self.take_reference()
        self.fitted_frames(self.stream("wavefront"), 20)
        whole_mib, resident_mib = self.locked_mib()
        print(f"\n  {whole_mib:.0f} MiB are locked whole, {resident_mib:.0f} MiB are locked and resident")
        self.assertGreater(whole_mib, 20.0, "the program and its own libraries")
        self.assertLess(whole_mib, MAX_LOCKED_WHOLE_MIB)
        self.assertLess(resident_mib, MAX_LOCKED_MIB)


if __name__ == "__main__":
    main()
