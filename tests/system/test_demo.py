"""The demonstration ends by itself, shows the promised results, and leaves no processes or files behind."""
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

from case import PROGRAM_PATIENCE_S, ROOT, TWIN, Client, Stream, main
from losses import COUNTERS, Account

MEASUREMENTS, FRAMES = 6, 60  # lines of the table, and frames of each
SUMMARY = re.compile(r"ovws demo: (\d+) frames shown, (\d+) lost, 0 saturated, largest error (0\.0\d+) wave")


def processes_of(marker):
    """Ids of processes whose environment holds the marker: all descendants of a demo run."""
    found = []
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if marker.encode() in (entry / "environ").read_bytes() and int(entry.name) != os.getpid():
                found.append((int(entry.name), (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()))
        except OSError:
            pass
    return found


class Demo(unittest.TestCase):
    def run_demo(self, *arguments):
        self.marker = f"OVWS_DEMO_TEST={os.getpid()}"
        key, value = self.marker.split("=")
        return subprocess.run([sys.executable, ROOT / "daemon" / "demo.py", "--build", os.environ["OVWS_BUILD"], *arguments],
                              capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, env=os.environ | {key: value})

    def test_it_shows_the_aberrations_and_leaves_nothing(self):
        with tempfile.TemporaryDirectory() as out:
            done = self.run_demo("--out", out)
            print("\n" + done.stdout + done.stderr)
            self.assertEqual(done.returncode, 0)
            self.assertEqual(sorted(re.findall(rf"{out}/(\S+)", done.stdout)), sorted(os.listdir(out)), "every picture is listed")
            for picture in ("astigmatism-camera.png", "astigmatism-phase.png", "shack-hartmann-camera.png"):
                self.assertGreater((pathlib.Path(out) / picture).stat().st_size, 5000)
        summary = next(line for line in done.stdout.splitlines() if line.startswith("ovws demo:"))
        self.check_summary(summary)
        self.assertEqual(processes_of(self.marker), [])

    def check_summary(self, line):
        """Checks the counts and the error in the demonstration's summary; returns the number of lost frames in it."""
        self.assertRegex(line, SUMMARY)
        shown, lost, error = SUMMARY.fullmatch(line.rstrip()).groups()
        self.assertEqual(int(shown), MEASUREMENTS * FRAMES)
        self.assertLess(float(error), 0.02)
        return int(lost)

    def account(self):
        daemon, twin, stream = Client(), Client(TWIN), Stream(["wavefront"])
        for one in (daemon, twin, stream):
            self.addCleanup(one.close)
        return Account(daemon, twin, stream)

    def follow(self, demo):
        """Reads what the demonstration prints until it stays up; checks that each frame is published or counted as lost, and that the summary
        has the daemon's count."""
        account = None
        while "running: " not in (line := demo.stdout.readline()):
            self.assertTrue(line, "the demo ended by itself")
            if line.startswith("camera "):
                account = self.account()
            elif account:
                account.hear()
            if line.startswith("ovws demo:"):
                said, counters = self.check_summary(line), account.counters()
        account.check(self)
        # The demonstration asked for the count after the frames of 12 dB, and before this test did.
        first = next(k for k, message in enumerate(account.messages) if message["gain_db"] == 12.0)
        others = sum(counters[name] for name in COUNTERS if name != "frames_lost")
        self.assertGreaterEqual(said, sum(message["gap"] for message in account.messages[1:first + 1]) - others)
        self.assertLessEqual(said, counters["frames_lost"])

    def test_keep_stays_up_until_ctrl_c(self):
        marker = f"OVWS_DEMO_TEST=keep{os.getpid()}"
        key, value = marker.split("=")
        out = tempfile.TemporaryDirectory()
        self.addCleanup(out.cleanup)
        # Ignore SIGINT, as a shell does for background jobs.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.SIG_IGN))
        demo = subprocess.Popen([sys.executable, "-u", ROOT / "daemon" / "demo.py", "--build", os.environ["OVWS_BUILD"], "--keep", "--out", out.name],
                                stdout=subprocess.PIPE, text=True, env=os.environ | {key: value})
        with demo:
            self.follow(demo)
            program = re.search(r"DISPLAY=\S+ (\S+) doctor", demo.stdout.readline())[1]
            self.assertTrue(shutil.which(program), "a command that can be typed")
            for port in (7702, 7790):
                with self.subTest(port):
                    client = Client(f"tcp://127.0.0.1:{port}")
                    self.addCleanup(client.close)
                    self.assertTrue(client.call("system.status" if port == 7702 else "twin.get"))
                    if port == 7702:
                        self.assertEqual(client.call("system.status")["sensor"]["tracker"], "fit", "the default")
            for port in (7701, 7703):
                with socket.create_connection(("127.0.0.1", port), timeout=PROGRAM_PATIENCE_S):
                    pass
            demo.send_signal(signal.SIGINT)
            self.assertEqual(demo.wait(PROGRAM_PATIENCE_S), 0)
        self.assertEqual(processes_of(marker), [])

    def test_a_taken_port_is_said(self):
        for port in (7702, 7790):
            with self.subTest(port), socket.socket() as taken:
                taken.bind(("127.0.0.1", port))
                taken.listen()
                with tempfile.TemporaryDirectory() as folder:
                    done = self.run_demo("--out", f"{folder}/demo")
                    self.assertEqual(os.listdir(folder), [], "no folder without pictures")
                print("\n" + done.stderr)
                self.assertEqual(done.returncode, 1)
                self.assertIn(str(port), done.stderr)
                self.assertEqual(processes_of(self.marker), [])


if __name__ == "__main__":
    main()
