#!/usr/bin/python3
"""Builds the wheel of the client with setuptools, without a network: make_wheel.py SOURCE FOLDER

SOURCE is the folder with pyproject.toml and the complete package. Wheels of earlier builds in FOLDER are removed.
"""
import contextlib
import io
import os
import shutil
import sys
import tempfile
from pathlib import Path

from setuptools import build_meta


def main():
    source, folder = (Path(argument).resolve() for argument in sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("ovws_client-*.whl"):
        old.unlink()
    os.environ.setdefault("SOURCE_DATE_EPOCH", "1577836800")  # the same files give the same wheel
    with tempfile.TemporaryDirectory() as clean, contextlib.redirect_stdout(io.StringIO()):
        shutil.copytree(source, clean, dirs_exist_ok=True, ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
        os.chdir(clean)
        build_meta.build_wheel(str(folder))
        os.chdir("/")


if __name__ == "__main__":
    main()
