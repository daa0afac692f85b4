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

from case import ROOT, Client, main


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
                              capture_output=True, text=True, timeout=120, env=os.environ | {key: value})

    def test_it_shows_the_aberrations_and_leaves_nothing(self):
        with tempfile.TemporaryDirectory() as out:
            done = self.run_demo("--out", out)
            print("\n" + done.stdout + done.stderr)
            self.assertEqual(done.returncode, 0)
            self.assertEqual(sorted(re.findall(rf"{out}/(\S+)", done.stdout)), sorted(os.listdir(out)), "every picture is listed")
            for picture in ("astigmatism-camera.png", "astigmatism-phase.png", "shack-hartmann-camera.png"):
                self.assertGreater((pathlib.Path(out) / picture).stat().st_size, 5000)
        summary = next(line for line in done.stdout.splitlines() if line.startswith("ovws demo:"))
        counts = re.fullmatch(r"ovws demo: (\d+) frames shown, (\d+) lost, 0 saturated, largest error (0\.0\d+) wave", summary)
        self.assertTrue(counts, summary)
        shown, lost, error = map(float, counts.groups())
        self.assertLessEqual(lost, 0.1 * shown)  # a busy machine loses packets
        self.assertLess(error, 0.02)
        self.assertEqual(processes_of(self.marker), [])

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
            while "running: " not in (line := demo.stdout.readline()):
                self.assertTrue(line, "the demo ended by itself")
            program = re.search(r"DISPLAY=\S+ (\S+) doctor", demo.stdout.readline())[1]
            self.assertTrue(shutil.which(program), "a command that can be typed")
            for port in (7702, 7790):
                with self.subTest(port):
                    client = Client(f"tcp://127.0.0.1:{port}")
                    self.addCleanup(client.close)
                    self.assertTrue(client.call("system.status" if port == 7702 else "twin.get"))
            for port in (7701, 7703):
                with socket.create_connection(("127.0.0.1", port), timeout=2.0):
                    pass
            demo.send_signal(signal.SIGINT)
            self.assertEqual(demo.wait(20.0), 0)
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
