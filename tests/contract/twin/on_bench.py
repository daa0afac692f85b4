#!/usr/bin/env python3
"""on_bench.py BUILD [--twin JSON] COMMAND [ARGUMENT]…: runs the command with a bench (X server and
twin, with these keys of its configuration) in its own network namespace, with DISPLAY set, and
returns the command's exit status."""

import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "drivers" / "twin"))
import bench  # noqa: E402

build, *command = sys.argv[1:]
twin = {}
if command[0] == "--twin":
    twin, command = json.loads(command[1]), command[2:]
bench.own_network()
with bench.Bench(build=build) as b:
    b.start_display()
    b.start_twin(twin)
    status = subprocess.run(command, env=os.environ | {"DISPLAY": b.display}).returncode
    if b.process("ovws-twin").stop() != 0 or status != 0:
        print(b.log("ovws-twin"), file=sys.stderr)
        status = status or 1
sys.exit(status)
