"""Paths of the client, its schemas and the program that emits every message."""
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[4]
BUILD = Path(os.environ["OVWS_BUILD"])
PYTHON = BUILD / "python"
sys.path.insert(0, str(PYTHON))

SCHEMAS = {path.stem: json.loads(path.read_text()) for path in sorted((BUILD / "schema").glob("*.json"))}
METHODS = {name: schema for name, schema in SCHEMAS.items() if not name.startswith("stream.")}


def emitted(name):
    """Every message or result of this schema that the encoders produce."""
    emitter = BUILD / "tests" / "emit_messages"
    lines = map(json.loads, subprocess.run([emitter], check=True, capture_output=True, text=True).stdout.splitlines())
    return [line["value"] for line in lines if line["schema"] == name and line.get("part") != "params"]
