"""Installation of the client by pip from a copy of its folder, without a network; the installed package works, with its types."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

from paths import PYTHON, ROOT


class Package(unittest.TestCase):
    def test_pip_installs_it(self):
        with tempfile.TemporaryDirectory() as folder:
            source, target = Path(folder, "source"), Path(folder, "target")
            shutil.copytree(PYTHON, source, ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
            options = ["--no-index", "--no-deps", "--no-build-isolation", "--target", target]
            command = [sys.executable, "-m", "pip", "install", *options, source]
            done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=os.environ | {"HOME": folder})
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            installed = {path.name for path in (target / "ovws_client").iterdir()}
            self.assertLessEqual({path.name for path in (PYTHON / "ovws_client").iterdir()} - {"__pycache__"}, installed)
            self.assertIn("py.typed", installed)
            words = "import ovws_client; print(ovws_client.__file__); ovws_client.Client().close()"
            printed = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, cwd=folder, timeout=60,
                                     env=os.environ | {"PYTHONPATH": str(target)})
            self.assertEqual(printed.stdout.strip(), str(target / "ovws_client" / "__init__.py"), printed.stderr)

    def test_its_version_is_the_projects(self):
        version = tomllib.loads((PYTHON / "pyproject.toml").read_text())["project"]["version"]
        self.assertEqual([version], re.findall(r"project\(ovws VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()))


if __name__ == "__main__":
    unittest.main()
