"""Base of the system tests: a bench in its own network namespace, and a client."""
import ctypes
import functools
import json
import os
import subprocess
import sys
import time
import unittest
from pathlib import Path
from types import MappingProxyType
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "drivers" / "twin"))

import bench as bench_module  # noqa: E402

bench_module.python_client()
import ovws_client  # noqa: E402
from ovws_client import ClientError, Stream  # noqa: E402

PATIENCE_S = 2 * bench_module.PATIENCE_S  # limit of each wait for an event; a wait returns as soon as the event comes
PROGRAM_PATIENCE_S = 300.0  # limit of each wait for the end of a program or a job


class Client(ovws_client.Client):
    """A client whose time-out allows for a loaded machine."""

    def __init__(self, endpoint=ovws_client.wire.CONTROL, timeout_s=PATIENCE_S, *keys, **more):
        super().__init__(endpoint, timeout_s, *keys, **more)


def own_mounts():
    """Moves this process into its own mount namespace: its mounts are private and disappear with it."""
    clone_newns = 0x00020000
    if ctypes.CDLL(None, use_errno=True).unshare(clone_newns) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    subprocess.run(["mount", "--make-rprivate", "/"], check=True)


def wait_for(condition, timeout_s=PATIENCE_S, what="the condition"):
    """Polls condition(), at most every 20 ms, and returns its first true value; fails after `timeout_s`."""
    end, in_time = time.monotonic() + timeout_s, True
    while in_time:
        begun = time.monotonic()
        in_time = begun < end  # asked once more if this process stood still meanwhile
        value = condition()
        if value:
            return value
        time.sleep(max(0.0, begun + 0.02 - time.monotonic()))
    raise AssertionError(f"{what} did not come true within {timeout_s} s")


def next_message(stream):
    return wait_for(lambda: stream.next(1.0), what="a message")


def message_since(stream, at_ns):
    """The next message of an image that was exposed after `at_ns`: those that have arrived or are in transit are skipped."""
    stream.drain()
    return wait_for(lambda: (message := next_message(stream))["t_device_ns"] > at_ns and message, what="an image exposed after the change")


def clock_offset_ns():
    """Wall clock less monotonic clock: as much as it grows between two times, the difference of their wall times is too large."""
    return time.time_ns() - time.monotonic_ns()


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


TWIN = "tcp://127.0.0.1:7790"
TWIN_SETTINGS = ("aberration", "norm", "shades", "branch_points", "sources", "peak_electrons", "geometry", "turbulence",
                 "scintillation", "quantum_efficiency", "prnu", "shot_noise", "dark_current_e_per_s", "read_noise_e", "full_well_e",
                 "black_level_dn", "bits", "left_justified", "noise")


def twin_settings(report):
    """What twin.set takes of a report of twin.get."""
    settings = {key: report[key] for key in TWIN_SETTINGS}
    if settings["turbulence"]:
        settings["turbulence"] = {key: value for key, value in settings["turbulence"].items() if key not in ("t_ns", "modes")}
    return settings


class SharedBench:
    """The display and the twin that the tests of a class share. A test may change or stop them: then the twin is restored, or the
    next test gets new ones."""

    def __init__(self):
        self._bench = None
        self._twin = None  # (process, its configuration, what twin.get reported at its start)
        self._display = None  # what it reported then

    def take(self):
        """A bench with at most a display and a twin."""
        self._bench = self._bench or bench_module.Bench()
        return self._bench

    def twin_of(self, config):
        """The running twin if it has this configuration, else a new one."""
        running = self._bench.process("ovws-twin")
        if self._twin and running is self._twin[0] and config == self._twin[1]:
            return running
        if running:
            self._bench.stop("ovws-twin")
        started = self._bench.start_twin(config)
        with Client(TWIN) as twin:
            self._twin = started, config, twin.call("twin.get")
        self._display = self._display_report()
        return started

    def give_back(self):
        """Stops what the test has started besides display and twin, and empties the folder. Raises a BenchError if a program has
        crashed."""
        try:
            self._bench.keep_only("xorg", "ovws-twin")
            restored = self._restored()
        except (ClientError, OSError, subprocess.SubprocessError):
            restored = False
        if restored:
            self._bench.check()
        else:
            self.close()

    def _restored(self):
        """Restores the twin. Returns whether display and twin are those of the start, and the display unchanged."""
        if not self._twin or self._bench.process("ovws-twin") is not self._twin[0] or not self._twin[0].alive():
            return False
        if not self._bench.process("xorg") or self._display_report() != self._display:
            return False
        before = self._twin[2]
        with Client(TWIN) as twin:
            twin.call("twin.fault", {"kind": "none"})
            twin.call("twin.set", twin_settings(before))
            if before["mirror"]:
                twin.call("twin.mirror", {"waves": before["mirror"]["waves"]})
        return True

    def _display_report(self):
        """Outputs and screen saver of the X server."""
        if not self._bench.display:
            return None
        outputs, saver = (subprocess.run([*command, "-display", self._bench.display], check=True, capture_output=True, timeout=PATIENCE_S, text=True).stdout
                          for command in (["xrandr"], ["xset", "q"]))
        return [line for line in outputs.splitlines() if "connected" in line], saver

    def close(self):
        bench, self._bench, self._twin = self._bench, None, None
        if bench:
            bench.close()


class BenchCase(unittest.TestCase):
    """A complete bench: display, twin, daemon. `twin_config` and `daemon_config` are keys that differ from the defaults.

    The twin repeats a pool of noisy frames while nothing changes, because fresh noise in every frame takes half a core.
    Tests that depend on fresh noise set {"noise": "fresh"}.

    The tests of a class share display and twin, which are put back as they were (SharedBench); each has a daemon of its own, with
    empty folders."""

    twin_config = MappingProxyType({})
    daemon_config = MappingProxyType({})
    small = False  # use SMALL_SIZE instead of 1280 x 768

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.shared_bench = SharedBench()
        cls.addClassCleanup(cls.shared_bench.close)

    def setUp(self):
        environment = dict(os.environ)
        self.addCleanup(lambda: (os.environ.clear(), os.environ.update(environment)))
        self.bench = self.shared_bench.take()
        self.addCleanup(self.shared_bench.give_back)
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
        if number is None and self.bench.process("xorg"):
            return self.bench.display
        return self.bench.start_display(number, **({"slm_size": SMALL_SIZE} if self.small else {}))

    def start_twin(self, **more):
        config = merged(SMALL_TWIN if self.small else {}, {"noise": "pool"} | self.twin_config)
        return self.shared_bench.twin_of(merged(config, more))

    def renew_twin(self, **more):
        """Starts the twin again, and returns when the daemon has its camera."""
        before = self.call("system.status")["counters"]["camera_reconnects"]
        self.bench.stop("ovws-twin")
        self.start_twin(**more)
        wait_for(lambda: self.call("system.status")["counters"]["camera_reconnects"] > before, what="the new camera")
        self.wait_until("running")

    def start_daemon(self, **more):
        config = merged(SMALL_DAEMON if self.small else {}, self.daemon_config)
        self.bench.start_daemon(merged(config, more))
        self.client = Client()
        self.addCleanup(self.client.close)

    @functools.cached_property
    def twin(self):
        """A client of the twin."""
        client = Client(TWIN)
        self.addCleanup(client.close)
        return client

    def preload(self, name, **seen):
        """A context: programs that start in it preload the library of `name`.cpp, and see these variables."""
        library = self.bench.directory / f"{name}.so"
        if not library.exists():
            subprocess.run(["g++", "-std=c++20", "-O2", "-shared", "-fPIC", "-o", library, Path(__file__).with_name(f"{name}.cpp"), "-ldl"], check=True)
        return mock.patch.dict(os.environ, seen | {"LD_PRELOAD": str(library)})

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

    def wait_until(self, state, timeout_s=PATIENCE_S):
        return wait_for(lambda: (status := self.call("system.status"))["state"] == state and status, timeout_s, f"state {state}")

    def job_ended(self, job):
        """Waits for a job's end; returns its report."""
        return wait_for(lambda: (report := self.call("job.get", {"job": job}))["state"] != "running" and report, PROGRAM_PATIENCE_S, "the job's end")

    def run_job(self, method, params):
        ended = self.job_ended(self.call(method, params)["job"])
        self.assertEqual(ended["state"], "done", ended)
        return ended

    def failure(self, method, params=None):
        """Runs a job that must fail; returns the message of its error."""
        ended = self.job_ended(self.call(method, params)["job"])
        self.assertEqual(ended["state"], "failed", ended)
        return ended["error"]["message"]

    def recorded_frames(self, count, timeout_s=PATIENCE_S):
        """Waits until the recording has at least `count` frames; record.get reports them four times a second."""
        return wait_for(lambda: (report := self.call("record.get"))["frames"] >= count and report, timeout_s, f"a recording of {count} frames")

    def replayed_again(self, name):
        """Replays the recording that has ended as `name` in the folder `recordings`: checks that each frame that has its image measures as it
        did, bit for bit. Returns the report, with `refused`: how many of these frames were settled, referenced and not valid."""
        from ovws_client.recording import Recording
        path = self.bench.directory / "recordings" / f"{name}.h5"
        done = self.run_ovws("--json", "replay", path)
        report = json.loads(done.stdout.splitlines()[-1])
        self.assertEqual((done.returncode, report["same"], report["first_difference"]), (0, report["replayed"], None), report)
        with Recording(path) as run:
            rows = run.frames[run.frames["picture"] >= 0]
        self.assertEqual((report["replayed"], report["valid"]), (len(rows), (rows["valid"] == 1).sum()), report)
        return report | {"refused": int(((rows["valid"] == 0) & (rows["settled"] == 1)).sum())}

    def take_reference(self, frames=50, **params):
        return self.run_job("reference.take", {"frames": frames} | params)

    def ovws_command(self, *words):
        """The command line of `ovws` with these words, which waits for a busy machine's daemon unless they say how long."""
        return [self.bench.programs / "ovws", *([] if "--timeout" in words else ["--timeout", str(PATIENCE_S)]), *map(str, words)]

    def run_ovws(self, *words, **more):
        return subprocess.run(self.ovws_command(*words), capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, **more)

    def close_loop(self, **params):
        """Closes the loop with a patience of PATIENCE_S, so that a busy machine cannot open it. It does not open at its limit or for a
        growing residual within that time, either."""
        return self.call("loop.close", {"patience_s": PATIENCE_S} | params)

    def fitted_frames(self, stream, count, timeout_s=PATIENCE_S):
        """The next `count` settled and valid messages in a row that templates measured."""
        frames, end = [], time.monotonic() + timeout_s
        while len(frames) < count:
            self.assertLess(time.monotonic(), end, f"only {len(frames)} of {count} frames were measured by templates in {timeout_s} s")
            frame = self.settled_frames(stream, 1)[0]
            frames = [*frames, frame] if frame["sigma"][0] is not None else []
        return frames

    def settled_frames(self, stream, count, hologram_id=None, timeout_s=PATIENCE_S):
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

    def frames_from_now(self, stream, count):
        """The next `count` settled and valid messages of images exposed from now on."""
        message_since(stream, time.time_ns())
        return self.settled_frames(stream, count)

    @staticmethod
    def mean_modes(frames):
        """Mean coefficient of each mode, by its number j."""
        return dict(zip(frames[0]["j"], (sum(column) / len(frames) for column in zip(*(frame["coefficients"] for frame in frames)))))

    def modes_when(self, stream, are_right, what):
        """Waits for mean coefficients that `are_right`. With `fit`, templates of the wavefront before measure the first frames of another."""
        def means():
            modes = self.mean_modes(self.frames_from_now(stream, 20))
            print("\n ", what, {j: round(waves, 4) for j, waves in modes.items()})
            return are_right(modes) and modes
        return wait_for(means, what=what)

    def refused(self, method, params=None):
        """Calls a method that must fail; returns the error."""
        with self.assertRaises(ClientError) as caught:
            self.call(method, params)
        self.assertIsNotNone(caught.exception.code, caught.exception)
        return caught.exception


def main():
    """Runs the tests of the calling script. Exits with 77, which ctest shows as skipped, if all of them were skipped, and with 1 if there
    are none."""
    bench_module.forget_environment()
    bench_module.own_network()
    result = unittest.main(verbosity=2, exit=False).result
    # Classes are not among testsRun, and parts of tests (subTest) are not tests.
    skipped = sum(isinstance(test, unittest.TestCase) and not hasattr(test, "test_case") for test, _ in result.skipped)
    if not result.testsRun and not result.skipped:
        print("no test ran", flush=True)
        sys.exit(1)
    sys.exit(1 if not result.wasSuccessful() else 77 if result.skipped and result.testsRun == skipped else 0)
