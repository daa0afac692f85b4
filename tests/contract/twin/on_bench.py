#!/usr/bin/env python3
"""on_bench.py BUILD COMMAND [ARGUMENT]…: runs the command with a bench (X server and twin) in its
own network namespace, with DISPLAY set, and returns the command's exit status."""

import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "drivers" / "twin"))
import bench  # noqa: E402

bench.own_network()
with bench.Bench(build=sys.argv[1]) as b:
    b.start_display()
    b.start_twin()
    status = subprocess.run(sys.argv[2:], env=os.environ | {"DISPLAY": b.display}).returncode
    if b.process("ovws-twin").stop() != 0 or status != 0:
        print(b.log("ovws-twin"), file=sys.stderr)
        status = status or 1
sys.exit(status)
