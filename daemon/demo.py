"""Demonstration: starts a simulated bench, controls the daemon like any client, and prints the measurements.

Run it by daemon/demo, which installs and builds what is missing.
"""
import argparse
import os
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "drivers" / "twin"))

from bench import PATIENCE_S, Bench, BenchError, forget_environment, python_client  # noqa: E402

python_client()
from ovws_client import Client, ClientError, Stream  # noqa: E402

NAMES = {3: "Z(2,-2)", 4: "Z(2,0)", 5: "Z(2,2)", 7: "Z(3,-1)", 8: "Z(3,1)"}
SHOWN_J = tuple(NAMES)
# Charge 0 is 3.9 times as bright as charge 1, and 12 dB are a factor of 4: a quarter keeps both below saturation.
EXPOSURE_US, SHORT_EXPOSURE_US = 2000.0, 500.0
FRAMES = 60
TTY = sys.stdout.isatty()


class Demo:
    def __init__(self, bench, out):
        self.bench = bench
        self.out = out
        self.client = Client(timeout_s=PATIENCE_S)
        self.stream = Stream(["wavefront"])
        self.worst_error = 0.0
        self.frames = 0
        self.saturated = 0
        self.written = []

    # Client calls -------------------------------------------------------------------------------------------------

    def wait_until_running(self):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            status = self.client.call("system.status")
            if status["state"] == "running":
                return status
            time.sleep(0.1)
        raise ClientError(f"the daemon is still {status['state']}: camera {status['camera']['fault']}, SLM {status['slm']['fault']}")

    def take_reference(self, frames=100):
        job = self.client.call("reference.take", {"frames": frames})["job"]
        while True:
            report = self.client.call("job.get", {"job": job})
            if report["state"] != "running":
                break
            self.live(f"  reference: {100 * report['progress']:3.0f} %")
            time.sleep(0.05)
        self.live("")
        if report["state"] != "done":
            raise ClientError(f"the reference failed: {report['error']}")

    def measure(self, **wanted):
        """Returns the time until the first frame, s, and FRAMES settled, valid frames that have these values (e.g. hologram_id). Of the
        tracker fit those count that it has measured from all pixels: until its templates are ready, positions measure the frames."""
        start, first, frames = time.monotonic(), None, []
        while len(frames) < FRAMES:
            if time.monotonic() - start > PATIENCE_S:
                raise ClientError(f"only {len(frames)} settled frames in {PATIENCE_S:.0f} s")
            message = self.stream.next(timeout_s=1.0)
            if message is None or not message["settled"] or not message["valid"]:
                continue
            if any(message[key] != value for key, value in wanted.items()):
                continue
            first = first or time.monotonic() - start
            if message["tracker"] == "fit" and message["sigma"][0] is None:
                continue
            frames.append(message)
            self.live("  " + live_row(message))
        self.live("")
        self.frames += len(frames)
        self.saturated += sum(message["saturated"] > 0.0 for message in frames)
        return first, frames

    def set_camera(self, **settings):
        """Returns what measure() must wait for: the same keys with the values that the camera applied."""
        applied = self.client.call("camera.set", settings)["applied"]
        return {key: applied[key] for key in settings}

    # Output -------------------------------------------------------------------------------------------------------

    def live(self, text):
        if TTY:
            sys.stdout.write("\r\033[K" + text)
            sys.stdout.flush()

    def step(self, what, wanted, first_s, frames):
        mean = {j: statistics.fmean(m["coefficients"][j - 1] for m in frames) for j in frames[0]["j"]}
        spread = max(statistics.pstdev([m["coefficients"][j - 1] for m in frames]) for j in mean)
        error = max(abs(mean[j] - wanted.get(j, 0.0)) for j in mean if j > 2)
        self.worst_error = max(self.worst_error, error)
        latency = statistics.median(m["latency_us"] for m in frames)
        tracked = min(m["tracked"] for m in frames)
        columns = " ".join(f"{mean[j]:+z8.4f}" for j in SHOWN_J)
        answer = "-" if first_s is None else f"{1e3 * first_s:.0f}"
        print(f"{what:<34} {columns}  {error:7.4f}  {spread:7.4f}  {tracked:2d}/{frames[0]['subapertures']}  {latency:7.0f}  {answer:>6}")

    def pictures(self, name):
        self.out.mkdir(parents=True, exist_ok=True)
        prefix = self.out / name
        subprocess.run([self.bench.programs / "ovws", "--timeout", str(PATIENCE_S), "snapshot", "-o", str(prefix)], check=True, stdout=subprocess.DEVNULL)
        self.written += [f"{prefix}-camera.png", f"{prefix}-phase.png"]

    # Sequence -----------------------------------------------------------------------------------------------------

    def aberrate(self, n, m, waves):
        """Returns what measure() must wait for."""
        shown = self.client.call("aberration.set", {"modes": [{"n": n, "m": m, "waves": waves}]})
        return {"hologram_id": shown["hologram_id"]}

    def heading(self, status):
        print(f"camera {status['camera']['info']['model']} at {status['camera']['info']['address']}, "
              f"SLM {status['slm']['info']['output']} {status['slm']['info']['width']} x {status['slm']['info']['height']}, "
              f"{status['sensor']['subapertures']} subapertures, {status['sensor']['modes']} modes\n")
        print(f"coefficients in waves (OSA/ANSI, RMS-normalised), mean of {FRAMES} frames each")
        print("answer: time from the command's reply to the first settled frame; latency: from complete frame to message")
        print(f"{'':<34} " + " ".join(f"{NAMES[j]:>8}" for j in SHOWN_J)
              + "    error   spread  spots  latency  answer\n" + " " * 80 + "(waves)  (waves)            (us)    (ms)")

    def run(self):
        status = self.wait_until_running()
        self.set_camera(exposure_us=EXPOSURE_US)
        self.take_reference()
        self.heading(status)
        self.step("no aberration", {}, None, self.measure()[1])
        self.step("Z(2,-2) = 0.5 wave", {3: 0.5}, *self.measure(**self.aberrate(2, -2, 0.5)))
        self.step("Z(2,0) = 0.3 wave", {4: 0.3}, *self.measure(**self.aberrate(2, 0, 0.3)))
        self.client.call("aberration.clear")
        self.show_bright_spots()
        shown = self.client.call("sensor.set", {"charge": 1, "tracker": "fit"})
        self.step("vortices again, Z(2,0)", {4: 0.3}, *self.measure(hologram_id=shown["hologram_id"]))
        wanted = self.set_camera(gain_db=12.0, exposure_us=SHORT_EXPOSURE_US)
        self.step("gain 12 dB, Z(2,0)", {4: 0.3}, *self.measure(**wanted))
        self.set_camera(gain_db=0.0, exposure_us=EXPOSURE_US)
        self.client.call("aberration.clear")
        lost = self.client.call("system.status")["counters"]["frames_lost"]
        print(f"\novws demo: {self.frames} frames shown, {lost} lost, {self.saturated} saturated, "
              f"largest error {self.worst_error:.4f} wave")

    def show_bright_spots(self):
        self.set_camera(exposure_us=SHORT_EXPOSURE_US)
        self.client.call("sensor.set", {"charge": 0, "tracker": "thresholded"})
        self.take_reference()
        self.step("Shack-Hartmann (charge 0), Z(2,0)", {4: 0.3}, *self.measure(**self.aberrate(2, 0, 0.3)))
        self.set_camera(exposure_us=EXPOSURE_US)

    def draw(self):
        """Writes the images of two of the states again, from the references taken before."""
        self.client.call("sensor.set", {"tracker": "fit"})
        self.measure(**self.aberrate(2, -2, 0.5))
        self.pictures("astigmatism")
        self.set_camera(exposure_us=SHORT_EXPOSURE_US)
        self.client.call("sensor.set", {"charge": 0, "tracker": "thresholded"})
        self.measure(**self.aberrate(2, 0, 0.3))
        self.pictures("shack-hartmann")
        self.client.call("sensor.set", {"charge": 1, "tracker": "fit"})
        self.set_camera(exposure_us=EXPOSURE_US)
        self.client.call("aberration.clear")
        print("\nimages: " + "\n        ".join(self.written))


def live_row(message):
    if not message["valid"]:
        return f"frame {message['frame_id']}  tracked {message['tracked']}/{message['subapertures']}"
    values = " ".join(f"{message['coefficients'][j - 1]:+z.3f}" for j in SHOWN_J)
    return f"frame {message['frame_id']:6d}  {values}  rms {message['rms_waves']:.3f}  {message['latency_us']:.0f} us"


def main():
    parser = argparse.ArgumentParser(prog="daemon/demo", description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help="keep running until Ctrl-C")
    parser.add_argument("--make", action="store_true", help="build programs of the build folder before they are used")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "release", help="build folder")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "demo", help="folder for the images (default: build/demo)")
    arguments = parser.parse_args()
    forget_environment()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells start background jobs with SIGINT ignored
    try:
        with Bench(arguments.build) as bench:
            bench.start_display()
            bench.start_twin({"mirror": {"actuators_across": 9}})
            recordings = arguments.out.resolve() / "recordings"
            bench.start_daemon({"state": {"directory": str(bench.directory / "state")}, "record": {"directory": str(recordings)}})
            demo = Demo(bench, arguments.out.resolve())
            demo.run()
            build(arguments, "ovws")
            demo.draw()
            if arguments.keep:
                build(arguments, "ovws-web")
                print(f"\nlive page: {start_page(bench)}\n"
                      f"running: control tcp://127.0.0.1:7702, streams 7701 and 7703, twin 7790; recordings in {recordings}; Ctrl-C stops it\n"
                      f"to check it: DISPLAY={bench.display} {name_of_ovws(bench)} doctor --config {bench.directory / 'ovwsd.json'}", flush=True)
                wait_for_ctrl_c()
        sys.stdout.flush()
    except KeyboardInterrupt:
        print()
        return 130
    except subprocess.CalledProcessError as error:  # it has said why
        print(f"ovws demo: {error.cmd[0]} ended with status {error.returncode}", file=sys.stderr)
        return 1
    except BrokenPipeError:  # as from head
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (BenchError, ClientError, OSError) as error:
        another = "\nIs another demonstration running? There can be one at a time." if "in use" in str(error) else ""
        print(f"ovws demo: {error}{another}", file=sys.stderr)
        return 1
    return 0


def build(arguments, program):
    if arguments.make:
        if not (arguments.build / "bin" / program).exists():
            print(f"\nbuilding {program}, once: two minutes on two cores", flush=True)
        # On a terminal the build shows how far it is.
        made = subprocess.run(["cmake", "--build", arguments.build, "--target", program], capture_output=not TTY, text=True)
        if made.returncode != 0:
            raise BenchError(f"{program} was not built:\n{made.stdout or ''}{made.stderr or ''}")


def start_page(bench):
    """Starts the live page and returns its address, with control."""
    page = bench.start("ovws-web", [bench.programs / "ovws-web", "--control"])
    page.wait_for_line("ready")
    links = dict(line.split() for line in (bench.directory / "ovws-web.out").read_text().splitlines())
    return links["control"]


def name_of_ovws(bench):
    """The name to type for ovws: its path unless it is installed."""
    return "ovws" if shutil.which("ovws") else bench.programs / "ovws"


def wait_for_ctrl_c():
    try:
        signal.pause()
    except KeyboardInterrupt:
        print()


if __name__ == "__main__":
    sys.exit(main())
