"""The wheel of the Python client, installed by pip into an own environment without a network, runs the notebooks on a bench."""
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from case import PROGRAM_PATIENCE_S, ROOT, BenchCase, bench_module, main

BUILD = bench_module.find_programs().parent
NOTEBOOKS = ROOT / "proto" / "python" / "notebooks"


def checked(command, **more):
    done = subprocess.run(command, capture_output=True, text=True, **more)
    assert done.returncode == 0, f"{command}\n{done.stdout[-3000:]}{done.stderr[-3000:]}"
    return done


class Notebooks(BenchCase):
    daemon_config = {"record": {"directory": "recordings"}}
    twin_config = {"noise": "pool"}

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.python = Path(folder.name, "bin", "python")
        # Debian's numpy, pyzmq and h5py stay visible; pip is Debian's, too.
        checked([sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", folder.name], timeout=PROGRAM_PATIENCE_S)
        (wheel,) = (BUILD / "wheel").glob("*.whl")
        checked([cls.python, "-m", "pip", "install", "--no-index", "--no-deps", wheel], timeout=PROGRAM_PATIENCE_S, env=os.environ | {"HOME": folder.name})
        cls.site = next(Path(folder.name, "lib").glob("python3*/site-packages/ovws_client"))

    def run_notebook(self, name):
        """Runs a notebook; returns what its cells showed, and its values by name."""
        env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"MPLBACKEND": "Agg"}
        done = checked([self.python, Path(__file__).with_name("run_notebook.py"), NOTEBOOKS / name], timeout=PROGRAM_PATIENCE_S, env=env, cwd=self.bench.directory)
        self.assertIn("100 %", done.stderr, "the progress of a job")
        *shown, values = done.stdout.splitlines()
        return "\n".join(shown), json.loads(values)

    def test_first_light(self):
        where = checked([self.python, "-c", "import ovws_client; print(ovws_client.__file__)"], timeout=PROGRAM_PATIENCE_S, cwd="/").stdout
        self.assertEqual(where.strip(), str(self.site / "__init__.py"), "the installed one")
        shown, values = self.run_notebook("first_light.ipynb")
        self.assertIn("the daemon is running", shown)
        self.assertEqual(shown.count("<figure>"), 4, "two images and two maps")
        self.assertIn("horizontal coma", shown)
        self.assertAlmostEqual(values["coma"]["8"] - values["flat"]["8"], 0.2, delta=0.005)
        self.assertEqual(self.call("aberration.get")["modes"], [])
        self.assertEqual(self.call("camera.get")["settings"]["exposure_us"], 2000.0)

    def test_calibration(self):
        shown, values = self.run_notebook("calibration.ipynb")
        self.assertIn("<td", shown)
        for found in (values["before"], values["after"]):
            for waves in found.values():
                self.assertAlmostEqual(waves, 0.1, delta=0.01)
        self.assertIsNotNone(self.call("calibration.get")["t_taken_ns"])

    def test_loop(self):
        shown, values = self.run_notebook("loop.ipynb")
        self.assertAlmostEqual(values["before"]["3"], 0.3, delta=0.01)
        self.assertLess(max(abs(waves) for waves in values["residual"].values()), 0.005)
        self.assertAlmostEqual(values["correction"]["oblique astigmatism"], 0.3, delta=0.01)
        self.assertAlmostEqual(values["correction"]["defocus"], -0.15, delta=0.01)

    def test_recording(self):
        shown, values = self.run_notebook("recording.ipynb")
        self.assertIn("GB an hour", shown)
        self.assertAlmostEqual(values["step"], 0.1, delta=0.005)
        self.assertTrue(Path(values["file"]).exists())

    def test_live(self):
        shown, values = self.run_notebook("live.ipynb")
        self.assertEqual(len(re.findall(r"<p>Frame \d+: ", shown)), 5, "a wavefront and its 4 updates")
        maps = shown.count("waves RMS without tilts")  # on a busy machine a frame may be late: then it has no map
        self.assertEqual(shown.count("<figure>"), 21 + maps, "an image and its 20 updates, and the maps")
        self.assertEqual(values["valid"], values["settled"])
        self.assertGreater(values["settled"], 0)
        self.assertGreater(values["duration_s"], 0.5, "100 frames, and those that a busy machine has lost, at 100 Hz")


if __name__ == "__main__":
    main()
