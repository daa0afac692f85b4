"""The Python client on a complete bench: its README, its examples, every kind of message, and its numbers against the daemon's."""
import asyncio
import itertools
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
import time

from case import PATIENCE_S, PROGRAM_PATIENCE_S, ROOT, BenchCase, Client, bench_module, main, wait_for

import numpy as np

import ovws_client
from ovws_bridges.bluesky import WavefrontSensor
from ovws_client import AsyncClient, AsyncSubscription, NoAnswer, Refused, Subscription

PYTHON = bench_module.find_programs().parent / "python"
SOURCE = ROOT / "proto" / "python"
README = (SOURCE / "README.md").read_text()
KINDS = (ovws_client.Event, ovws_client.Status, ovws_client.Wavefront, ovws_client.Spots, ovws_client.Image, ovws_client.Phase)
PYPLOT = """
def said(name):
    return lambda *a, **k: print("pyplot", name)
cla, bar, xlabel, ylabel, pause = map(said, ("cla", "bar", "xlabel", "ylabel", "pause"))
"""

NAPARI = """
class Layer:
    def reset_contrast_limits(self): print("redrawn")
class Viewer:
    def __init__(self, title): self.layers = {}
    def add_image(self, data, name, **_):
        print("layer", name, data.shape)
        self.layers[name] = Layer()
def run(): print("window")
"""
NAPARI_THREADING = """
def thread_worker(function, connect):
    return lambda *a: [connect["yielded"](value) for value in function(*a)]
"""


def blocks(language):
    return [textwrap.dedent(block) for block in re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)]


class Scripts(BenchCase):
    """Examples as separate programs, as a user runs them."""

    daemon_config = {"record": {"directory": "recordings"}}
    twin_config = {"mirror": {"actuators_across": 9}}

    def run_here(self, command, path=PYTHON, **more):
        print("\n  $", shlex.join(map(str, command))[:120])
        env = os.environ | {"PYTHONPATH": str(path), "HOME": str(self.bench.directory), "MPLBACKEND": "Agg"}
        done = subprocess.run(command, capture_output=True, text=True, timeout=PROGRAM_PATIENCE_S, env=env, **more)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        print(textwrap.indent(done.stdout[-400:], "    "))
        return done.stdout

    def example(self, name, *arguments, **more):
        return self.run_here([sys.executable, SOURCE / "examples" / name, *arguments], **more)

    def test_five_lines(self):
        five, *_ = blocks("python")
        self.assertEqual(len(five.splitlines()), 5)
        command, env = [sys.executable, "-u", "-c", five], os.environ | {"PYTHONPATH": str(PYTHON)}
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=env)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)  # it would run forever
        # On a busy machine the first frames may be late, and not valid.
        self.assertTrue(any(re.match(r"\d+ True \[", line) for line in itertools.islice(process.stdout, 20_000)))

    def test_the_other_blocks(self):
        self.take_reference(20)
        _, *others = blocks("python")
        self.assertGreaterEqual(len(others), 3)
        for block in others:
            self.assertTrue(self.run_here([sys.executable, "-c", block]))

    def test_the_commands(self):
        self.take_reference(20)
        folder = self.bench.directory / "clone"
        unwanted = shutil.ignore_patterns("build", "*.egg-info", "__pycache__")
        shutil.copytree(PYTHON, folder / "build" / "release" / "python", ignore=unwanted)
        shutil.copytree(PYTHON.parent / "wheel", folder / "build" / "release" / "wheel")
        shutil.copytree(SOURCE / "examples", folder / "proto" / "python" / "examples")
        (folder / "bin").mkdir()
        (folder / "bin" / "python3").symlink_to(sys.executable)
        commands = "set -e\n" + f'PATH="{folder}/bin:$PATH"\n' + "".join(blocks("sh"))
        self.assertIn("pip install", commands)
        self.assertEqual(commands.count("python3 proto/python/examples/"), len(list((SOURCE / "examples").glob("*.py"))))
        self.assertRegex(self.run_here(["sh", "-c", commands], path=PYTHON, cwd=folder), r"(?m)^running$")

    def test_the_links(self):
        for link in re.findall(r"\]\(([^)#:]+)\)", README):
            self.assertTrue((SOURCE / link).exists(), link)

    def show(self, modes):
        """Introduces an aberration; returns when templates measure it."""
        self.settled_frames(stream := self.stream("wavefront"), 1, self.call("aberration.set", {"modes": modes})["hologram_id"])
        self.fitted_frames(stream, 5)

    def test_live_plot(self):
        self.take_reference(20)
        self.show([{"j": 4, "waves": 0.2}])
        shown = re.findall(r"j =   4 +\+0\.(\d+) (#*)", self.example("live_plot.py", "100", path=self.matplotlib("raise ImportError")))
        self.assertEqual(shown[-1][1], "########", shown)
        self.assertEqual(self.example("live_plot.py", "2", path=self.matplotlib(PYPLOT)).count("pyplot bar"), 2)

    def matplotlib(self, pyplot):
        """A folder with a fake matplotlib, used whether the real one is installed or not."""
        package = self.bench.directory / "played" / "matplotlib"
        package.mkdir(parents=True, exist_ok=True)
        (package / "__init__.py").touch()
        (package / "pyplot.py").write_text(pyplot)
        return f"{package.parent}:{PYTHON}"

    def test_napari_view(self):
        """All but the window of napari, which Debian does not have."""
        package = self.bench.directory / "played" / "napari"
        (package / "qt").mkdir(parents=True)
        (package / "__init__.py").write_text(NAPARI)
        (package / "qt" / "__init__.py").touch()
        (package / "qt" / "threading.py").write_text(NAPARI_THREADING)
        shown = self.example("napari_view.py", "10", path=f"{package.parent}:{PYTHON}")
        self.assertEqual(sorted(re.findall(r"layer (.*)", shown)), ["camera, DN (512, 512)", "wavefront, waves (128, 128)"])
        self.assertEqual((shown.count("redrawn"), shown.splitlines()[-1]), (8, "window"))
        (package / "__init__.py").write_text("raise ImportError")
        self.assertEqual(sorted(self.example("napari_view.py", "10", path=f"{package.parent}:{PYTHON}").splitlines()),
                         ["camera, DN: 512 x 512", "wavefront, waves: 128 x 128"])

    def test_gain_sweep(self):
        self.take_reference(100)
        self.fitted_frames(self.stream("wavefront"), 50)  # the first ones are measured by positions, with more noise
        before = self.call("camera.get")["settings"]
        printed = re.findall(r"([\d.]+) dB, +([\d.]+) us: ([\d.]+) milliwaves", self.example("gain_sweep.py"))
        self.assertEqual([(float(gain_db), float(exposure_us)) for gain_db, exposure_us, _ in printed], [(0, 2000), (6, 1002), (12, 502)])
        scatter = [float(milliwaves) for *_, milliwaves in printed]
        self.assertEqual(scatter, sorted(scatter), "less light, more noise")
        self.assertGreater(scatter[2], 1.3 * scatter[0])
        self.assertEqual(self.call("camera.get")["settings"], before)

    def test_own_loop(self):
        self.take_reference(100)
        self.twin.call("twin.set", {"aberration": [{"j": 3, "waves": 0.3}, {"j": 7, "waves": -0.1}]})
        self.modes_when(self.stream("wavefront"), lambda modes: abs(modes[3] - 0.3) < 0.01, "the light's aberration")
        residual_waves = [float(value) for value in re.findall(r"residual ([\d.]+) waves", self.example("own_loop.py"))]
        self.assertAlmostEqual(residual_waves[0], 0.316, delta=0.03)
        self.assertLess(residual_waves[-1], 0.005)
        corrected = {mode["j"]: mode["waves"] for mode in self.call("correction.get")["modes"]}
        self.assertAlmostEqual(corrected[3], 0.3, delta=0.01)

    def test_own_basis(self):
        self.take_reference(100)
        self.show([{"j": 4, "waves": 0.2}, {"j": 3, "waves": 0.1}])
        printed = re.findall(r"x\^(\d) y\^(\d): ([-+.\d]+) waves", self.example("own_basis.py"))
        waves = {(int(a), int(b)): float(value) for a, b, value in printed}
        # 0.2 sqrt(3) (2 x^2 + 2 y^2 - 1) + 0.1 sqrt(6) 2 x y
        for power, value in {(2, 0): 0.693, (0, 2): 0.693, (1, 1): 0.490, (1, 0): 0.0, (0, 1): 0.0}.items():
            self.assertAlmostEqual(waves[power], value, delta=0.03)


class Numbers(BenchCase):
    def for_a_while(self, stream):
        end = time.monotonic() + PATIENCE_S
        for message in stream:
            self.assertLess(time.monotonic(), end, "what was waited for did not come")
            yield message

    def test_every_kind_of_message(self):
        self.take_reference(20)
        found = {}
        with Subscription(*KINDS, timeout_s=PATIENCE_S) as stream:
            for message in self.for_a_while(stream):
                if type(message) not in found and isinstance(message, ovws_client.Status):
                    self.client.reference_take(frames=5)  # causes events; a client that got a status has also subscribed to events
                found.setdefault(type(message), message)
                if set(found) == set(KINDS):
                    break
        self.assertIn(found[ovws_client.Status].state, ("running", "job_running"))
        spots, image = found[ovws_client.Spots], found[ovws_client.Image]
        self.assertLess(np.abs(spots.x_y_px[9] - 255.5).max(), 2.0, "the base subaperture is the tenth of 19")
        self.assertEqual((image.pixels.shape, image.pixels.dtype, image.pixels.flags.owndata), ((512, 512), np.uint8, False))
        self.wait_until("running")
        self.client.camera_set(pixel_format="Mono12")
        with Subscription(ovws_client.Image, timeout_s=PATIENCE_S) as stream:
            deep = next(image for image in stream if image.pixel_format == "Mono12")
        self.assertEqual((deep.pixels.dtype, deep.significant_bits), (np.uint16, 12))
        self.assertLess(deep.pixels.max(), 1 << 12)
        self.assertGreater(deep.pixels.max(), image.pixels.max(), "four bits more")

    def test_the_map_of_the_coefficients_is_the_daemons(self):
        self.take_reference(20)
        self.client.aberration_set([{"n": 3, "m": 1, "waves": 0.2}, {"n": 2, "m": -2, "waves": 0.3}])
        frames = {}
        with Subscription(ovws_client.Wavefront, ovws_client.Phase, timeout_s=PATIENCE_S) as stream:
            for message in self.for_a_while(stream):
                if isinstance(message, ovws_client.Wavefront):
                    frames[message.frame_id] = message
                elif message.valid and message.frame_id in frames and abs(np.nanstd(message.waves) - 0.36) < 0.02:
                    break
        mine = frames[message.frame_id].phase_waves(message.waves.shape[0])
        np.testing.assert_array_equal(np.isnan(mine), np.isnan(message.waves))
        self.assertLess(np.nanmax(np.abs(mine - message.waves)), 1e-5)
        self.assertAlmostEqual(float(np.nanstd(mine)), 0.36, delta=0.02)

    def test_the_lattice_is_the_daemons(self):
        for settings in ({}, {"grid": "square", "subapertures_across": 6}, {"grid": "hexagonal", "subapertures_across": 7}):
            with self.subTest(**settings):
                self.client.sensor_set(**settings)
                self.compare_lattice(1e-9)
        self.client.sensor_set(subapertures_across=5)
        self.twin.call("twin.set", {"geometry": {"rotation_deg": 20.0, "mirror": "x"}})
        frames = self.stream("wavefront")
        for _ in range(100):  # by then the camera's usual delay is known, on a busy machine, too
            frames.next(PATIENCE_S)
        self.run_job("registration.run", {"frames": 2})
        self.assertTrue(self.client.registration_get()["mirrored"])
        self.compare_lattice(1e-6)

    def compare_lattice(self, delta_px):
        positions_px = np.array(self.client.reference_set("model")["positions_px"])
        config = self.client.config_get()
        centres, matrix_px = ovws_client.subaperture_centres(config), ovws_client.px_per_slope(config, self.client.registration_get())
        self.assertEqual(centres.shape, positions_px.shape)
        # The lattice's own gratings are slopes too: s V grooves over the SLM's width and height.
        radius_px, slm = 0.5 * config["sensor"]["pupil_diameter_px"], config["slm"]
        slopes = centres * radius_px**2 * config["sensor"]["spacing"] / [slm["width"], slm["height"]]
        base = np.argmin(np.hypot(*centres.T))
        self.assertLess(np.abs(slopes @ matrix_px.T - (positions_px - positions_px[base])).max(), delta_px)

    def test_asyncio(self):
        async def both():
            async with AsyncClient(timeout_s=PATIENCE_S) as client, AsyncSubscription(ovws_client.Wavefront, timeout_s=PATIENCE_S) as stream:
                await client.wait_for_job(await client.reference_take(frames=20))
                status, sensor, frame = await asyncio.gather(client.system_status(), client.sensor_get(), anext(stream))
                with self.assertRaises(Refused) as caught:
                    await client.sensor_set(tracker="lgg")
                return status["state"], len(sensor["modes_j"]) == len(frame.j), (caught.exception.field, caught.exception.nearest)

        self.assertEqual(asyncio.run(both()), ("running", True, ("tracker", "lg")))


class AtTheBench(BenchCase):
    """What the client does with methods and streams together."""

    twin_config = {"noise": "pool"}

    def test_settings_are_restored_also_after_an_error(self):
        before = self.client.camera_get()["settings"], self.client.sensor_get()
        with self.client.settings(gain_db=6, exposure_us=900.0, tracker="lg") as applied:
            self.assertEqual((applied["gain_db"], applied["exposure_us"], applied["tracker"]), (6.0, 900.0, "lg"))
            self.assertEqual(self.client.camera_get()["settings"]["gain_db"], 6.0)
        for wrong in ({"gain_db": 3, "tracker": "lgg"}, {"gain_db": 1000}, {"nothing": 1}):
            with self.assertRaises(Refused) as caught, self.client.settings(**wrong):
                self.fail("it was entered")
            self.assertIn(caught.exception.field, wrong)
        with self.assertRaises(KeyError), self.client.settings(gain_db=3):
            raise KeyError("in the block")
        self.assertEqual(self.client.camera_get()["settings"], before[0])
        self.assertEqual(self.client.sensor_get()["tracker"], before[1]["tracker"])

    def test_an_image_and_a_wavefront_are_of_what_was_set_before(self):
        self.take_reference(50)
        bright = self.client.image().pixels.mean()
        with self.client.settings(exposure_us=500.0):
            self.assertLess(self.client.image().pixels.mean(), 0.5 * bright)
        for waves in (0.1, -0.1):
            self.client.aberration_set({"defocus": waves})
            mean = self.client.wavefront(frames=20)
            self.assertEqual((mean.frames, mean.hologram_id), (20, self.client.aberration_get()["hologram_id"]))
            # On a busy machine positions measure all of these frames, until templates are rendered.
            self.assertAlmostEqual(mean.waves("defocus"), waves, delta=0.005)
            self.assertTrue(0.0 < mean.standard_error_waves[3] < 0.005, mean.standard_error_waves)

    def test_with_await_it_is_the_same(self):
        self.take_reference(50)

        async def seen():
            async with AsyncClient(timeout_s=PATIENCE_S) as client:
                before = (await client.camera_get())["settings"]
                bright = (await client.image()).pixels.mean()
                with self.assertRaises(Refused):
                    async with client.settings(exposure_us=500.0, gain_db=1000):
                        self.fail("it was entered")
                async with client.settings(exposure_us=500.0):
                    dim = (await client.image()).pixels.mean()
                await client.aberration_set({"defocus": 0.1})
                mean = await client.wavefront(frames=20)
                with self.assertRaisesRegex(NoAnswer, "of 1000 valid frames within 0.5 s"):
                    await client.wavefront(frames=1000, timeout_s=0.5)
                return before == (await client.camera_get())["settings"], dim / bright, mean

        restored, ratio, mean = asyncio.run(seen())
        self.assertTrue(restored)
        self.assertLess(ratio, 0.5)
        self.assertEqual(mean.frames, 20)
        self.assertAlmostEqual(mean.waves("defocus"), 0.1, delta=0.005)

    def test_without_a_reference_it_says_how_many_were_not_valid(self):
        with self.assertRaisesRegex(NoAnswer, r"0 of 20 valid frames within 5.0 s, and \d+ that were not valid; is there a reference\?"):
            self.client.wavefront(frames=20, timeout_s=5.0)


class Keys(BenchCase):
    def start(self):
        folder = self.bench.directory
        self.public = {name: subprocess.run([self.bench.programs / "ovws", "keygen", "-o", folder / f"{name}.json"], check=True,
                                            capture_output=True, text=True).stdout.strip() for name in ("daemon", "analysis")}
        clients = [{"name": "analysis", "key": self.public["analysis"], "role": "read"}]
        (folder / "clients.json").write_text(json.dumps({"clients": clients}))
        self.bench.start_daemon({"security": {"secret_key": str(folder / "daemon.json"), "clients": str(folder / "clients.json")}})
        self.keys = {"key": folder / "analysis.json", "server_key": self.public["daemon"]}

    def test_with_keys_and_without(self):
        async def same(timeout_s, **keys):
            subscription = AsyncSubscription(ovws_client.Status, timeout_s=timeout_s, **keys)
            async with AsyncClient(timeout_s=timeout_s, **keys) as client, subscription as stream:
                return (await client.system_status())["state"] == (await anext(stream)).state

        with Client(timeout_s=PATIENCE_S, **self.keys) as client, Subscription(ovws_client.Status, timeout_s=PATIENCE_S, **self.keys) as stream:
            # The state may change from one to the other: the daemon has just been started.
            wait_for(lambda: client.system_status()["state"] == next(stream).state, what="the same state")
            with client.subscribe(ovws_client.Status, timeout_s=PATIENCE_S) as again:
                wait_for(lambda: next(again).state == client.system_status()["state"], what="the same state")
            with self.assertRaises(Refused) as caught:
                client.camera_set(gain_db=1.0)
            self.assertEqual((caught.exception.code, caught.exception.field), (-32003, "method"))
        sensor = WavefrontSensor(**self.keys)
        self.addCleanup(sensor.close)
        sensor.stage()
        self.assertEqual(sensor.gain_db.set(1.0).exception(PATIENCE_S).code, -32003)
        wait_for(lambda: asyncio.run(same(PATIENCE_S, **self.keys)), what="the same state")
        with Client(timeout_s=1.0) as client, self.assertRaisesRegex(NoAnswer, "does it require a key"):
            client.system_status()
        with Subscription(ovws_client.Status, timeout_s=2.5) as stream, self.assertRaisesRegex(NoAnswer, "does it require a key"):
            next(stream)
        wrong = self.keys | {"server_key": self.public["analysis"]}
        with self.assertRaisesRegex(NoAnswer, "the server key correct"):
            asyncio.run(same(1.0, **wrong))


if __name__ == "__main__":
    main()
