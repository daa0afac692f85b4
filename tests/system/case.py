"""Base of the system tests: a bench in its own network namespace, and a client."""
import ctypes
import json
import os
import subprocess
import sys
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "drivers" / "twin"))

import bench as bench_module  # noqa: E402

bench_module.python_client()
from ovws_client import Client, ClientError, Stream  # noqa: E402

__all__ = ["bench_module", "BenchCase", "Client", "ClientError", "Stream", "ROOT", "main", "merged", "own_mounts", "wait_for"]


def own_mounts():
    """Moves this process into its own mount namespace: its mounts are private and disappear with it."""
    clone_newns = 0x00020000
    if ctypes.CDLL(None, use_errno=True).unshare(clone_newns) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    subprocess.run(["mount", "--make-rprivate", "/"], check=True)


def wait_for(condition, timeout_s=10.0, what="the condition"):
    """Polls condition() and returns its first true value; fails after `timeout_s`. A condition that waits by itself, such as
    for a message, is asked again at once."""
    end, in_time = time.monotonic() + timeout_s, True
    while in_time:
        begun = time.monotonic()
        in_time = begun < end  # asked once more if this process stood still meanwhile
        value = condition()
        if value:
            return value
        time.sleep(max(0.0, begun + 0.02 - time.monotonic()))
    raise AssertionError(f"{what} did not come true within {timeout_s} s")


def merged(config, changes):
    """Recursively merges the sections of `changes` into a configuration."""
    return config | {key: merged(config[key], value) if isinstance(value, dict) and isinstance(config.get(key), dict) else value
                     for key, value in changes.items()}


# An SLM of half the size with a lens of half the focal length: the camera image is the same, and holograms and propagation
# take a quarter of the time.
SMALL_SIZE = (640, 384)
SMALL_DAEMON = {"slm": {"width": 640, "height": 384}, "optics": {"focal_length_mm": 100.0},
                "sensor": {"pupil_diameter_px": 384.0, "spacing": 0.5}}
SMALL_TWIN = SMALL_DAEMON | {"light": {"diameter_px": 600.0}}


class BenchCase(unittest.TestCase):
    """A complete bench: display, twin, daemon. `twin_config` and `daemon_config` are keys that differ from the defaults.

    The twin repeats a pool of noisy frames while nothing changes, because fresh noise in every frame takes half a core.
    Tests that depend on fresh noise set {"noise": "fresh"}."""

    twin_config = {}
    daemon_config = {}
    small = False  # use SMALL_SIZE instead of 1280 x 768

    def setUp(self):
        self.bench = bench_module.Bench()
        self.addCleanup(self.bench.close)
        self.addCleanup(self.report_failure)
        self.start()

    def report_failure(self):
        """If the test has failed: prints the failure, the machine's load, the ends of the bench's logs and the daemon's status."""
        result = self._outcome.result
        failures = [text for test, text in result.errors + result.failures if self is getattr(test, "test_case", test)]
        if not failures:
            return
        print(f"\n--- {self.id()} failed; load {os.getloadavg()}", *failures, sep="\n")
        for log in sorted(self.bench.directory.glob("*.log")):
            print(f"--- end of {log.name}", *log.read_text(errors="replace").splitlines()[-20:], sep="\n")
        try:
            with Client() as client:
                print("--- system.status", json.dumps(client.call("system.status")), sep="\n", flush=True)
        except Exception as error:  # the daemon may be what has failed
            print("--- no status:", error, flush=True)

    def start(self):
        self.start_display()
        self.start_twin()
        self.start_daemon()
        self.wait_until("running")

    def start_display(self, number=None):
        return self.bench.start_display(number, **({"slm_size": SMALL_SIZE} if self.small else {}))

    def start_twin(self, **more):
        config = merged(SMALL_TWIN if self.small else {}, {"noise": "pool"} | self.twin_config)
        return self.bench.start_twin(merged(config, more))

    def start_daemon(self, **more):
        config = merged(SMALL_DAEMON if self.small else {}, self.daemon_config)
        self.bench.start_daemon(merged(config, more))
        self.client = Client()
        self.addCleanup(self.client.close)

    def call(self, method, params=None):
        return self.client.call(method, params)

    def stream(self, *topics, endpoint="tcp://127.0.0.1:7701"):
        stream = Stream(topics, endpoint)
        self.addCleanup(stream.close)
        if "event" in topics:
            self.subscribed(stream, topics)
        return stream

    @staticmethod
    def subscribed(stream, topics):
        """Waits until the daemon knows the subscriptions: events are sent once, the status every second."""
        stream._socket.subscribe("status")
        wait_for(lambda: (message := stream.next(1.0)) and message["topic"] == "status", what="the subscription")
        if "status" not in topics:
            stream._socket.unsubscribe("status")

    def wait_until(self, state, timeout_s=20.0):
        return wait_for(lambda: (status := self.call("system.status"))["state"] == state and status, timeout_s, f"state {state}")

    def run_job(self, method, params, timeout_s=30.0):
        job = self.call(method, params)["job"]
        ended = wait_for(lambda: (report := self.call("job.get", {"job": job}))["state"] != "running" and report, timeout_s, method)
        self.assertEqual(ended["state"], "done", ended)
        return ended

    def recorded_frames(self, count, timeout_s=20.0):
        """Waits until the recording has at least `count` frames; record.get reports them four times a second."""
        return wait_for(lambda: (report := self.call("record.get"))["frames"] >= count and report, timeout_s, f"a recording of {count} frames")

    def take_reference(self, frames=50, **params):
        return self.run_job("reference.take", {"frames": frames} | params)

    def fitted_frames(self, stream, count, timeout_s=20.0):
        """The next `count` settled and valid messages in a row that templates measured."""
        frames, end = [], time.monotonic() + timeout_s
        while len(frames) < count:
            self.assertLess(time.monotonic(), end, f"only {len(frames)} of {count} frames were measured by templates in {timeout_s} s")
            frame = self.settled_frames(stream, 1)[0]
            frames = [*frames, frame] if frame["sigma"][0] is not None else []
        return frames

    def settled_frames(self, stream, count, hologram_id=None, timeout_s=10.0):
        """The next `count` settled and valid messages, of hologram `hologram_id` if it is given."""
        frames = []
        end = time.monotonic() + timeout_s
        while len(frames) < count:
            self.assertLess(time.monotonic(), end, f"only {len(frames)} of {count} settled frames in {timeout_s} s")
            message = stream.next(0.5)
            if message is None or not message["settled"] or not message["valid"]:
                continue
            if hologram_id is None or message["hologram_id"] == hologram_id:
                frames.append(message)
        return frames

    def refused(self, method, params=None):
        """Calls a method that must fail; returns the error."""
        with self.assertRaises(ClientError) as caught:
            self.call(method, params)
        self.assertIsNotNone(caught.exception.code, caught.exception)
        return caught.exception


def main():
    bench_module.own_network()
    unittest.main(verbosity=2)
