"""A bench that plays: the real daemon against a twin whose hidden wavefront is known. For the programs of this folder.

Needs root: the bench uses its own network namespace.
"""
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "drivers" / "twin"))

import bench as bench_module  # noqa: E402

bench_module.python_client()
from ovws_client import Client, Stream  # noqa: E402

SENSOR_MODES, LOOP_MODES = range(3, 19), range(3, 15)


def rms(modes):
    return sum(waves * waves for waves in modes.values()) ** 0.5


def draw(rng, modes_j, low, high):
    """Random modes of low to high wave RMS together: {j: waves}."""
    modes = {j: rng.gauss(0.0, 1.0) for j in modes_j}
    scale = rng.uniform(low, high) / rms(modes)
    return {j: scale * waves for j, waves in modes.items()}


def wait_for(condition, timeout_s=30.0):
    end = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > end:
            raise SystemExit(f"the bench was not ready within {timeout_s:.0f} s")
        time.sleep(0.05)


class Play:
    """Starts the display, the twin and the daemon of `bench`; `sensor` are the params of sensor.set."""

    def __init__(self, bench, sensor, twin_config=None, daemon_config=None):
        slm = (daemon_config or {}).get("slm", {})
        bench.start_display(slm_size=(slm.get("width", 1280), slm.get("height", 768)))
        bench.start_twin(twin_config or {})
        bench.start_daemon({"stream": {"image_rate_hz": 0}, **(daemon_config or {})})
        self.client, self.twin = Client(), Client("tcp://127.0.0.1:7790")
        wait_for(lambda: self.client.call("system.status")["state"] == "running")
        self.client.call("sensor.set", sensor)
        self.stream = Stream(("wavefront",), "tcp://127.0.0.1:7701")

    def run_job(self, method, params, timeout_s=120.0):
        """Waits for the job's end and returns its report."""
        job = self.client.call(method, params)["job"]
        wait_for(lambda: self.client.call("job.get", {"job": job})["state"] != "running", timeout_s)
        return self.client.call("job.get", {"job": job})

    def hide(self, modes):
        """Replaces the hidden wavefront; returns the UTC time in ns, after which frames show it."""
        self.twin.call("twin.set", {"aberration": [{"j": j, "waves": waves} for j, waves in modes.items()]})
        return time.time_ns()

    def frames(self, seconds, since_ns):
        """Settled frames of the next seconds, each with its age since `since_ns`, in seconds."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            frame = self.stream.next(left)
            if frame is not None and frame["settled"] and frame["t_device_ns"] > since_ns:
                yield 1e-9 * (frame["t_device_ns"] - since_ns), frame

    @staticmethod
    def error(frame, modes):
        return rms({j: value - modes.get(j, 0.0) for j, value in zip(frame["j"], frame["coefficients"])})

    def left_waves(self, hidden):
        """What the correction leaves of a hidden wavefront, wave RMS over the sensor's modes."""
        left = dict(hidden)
        for mode in self.client.call("correction.get")["modes"]:
            left[mode["j"]] = left.get(mode["j"], 0.0) - mode["waves"]
        return rms({j: waves for j, waves in left.items() if j in SENSOR_MODES})
