"""A bench with bridges: processes of ovws_bridges, and what they may use."""
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

from case import ROOT, BenchCase, bench_module

PYTHON = bench_module.find_programs().parent / "python"
RUN = ROOT / "tests" / "bench" / "bridges"


def has(package):
    """Whether a package can be imported that is not in Debian."""
    return importlib.util.find_spec(package) is not None


def environment():
    """For processes that import ovws_bridges; PV Access stays on this machine."""
    path = os.pathsep.join(filter(None, (str(PYTHON), os.environ.get("PYTHONPATH"))))
    return os.environ | {"PYTHONPATH": path, "EPICS_PVA_ADDR_LIST": "127.0.0.1", "EPICS_PVA_AUTO_ADDR_LIST": "NO", "EPICS_PVAS_INTF_ADDR_LIST": "127.0.0.1"}


class BridgeCase(BenchCase):
    small = True
    daemon_config = {"state": {"directory": "state"}, "camera": {"frame_rate_hz": 50.0}}  # the reference survives a restart

    def start(self):
        super().start()
        self.take_reference(20)

    def start_bridge(self, module, *arguments, ready, name=None):
        """Starts python3 -m ovws_bridges.MODULE; returns when it has printed a line that begins with `ready`."""
        process = self.bench.start(name or module, [sys.executable, "-m", f"ovws_bridges.{module}", *arguments], env=environment())
        process.wait_for_line(ready)
        return process

    def restart_daemon(self):
        self.start_daemon()
        self.wait_until("running")

    @staticmethod
    def established(which, *options):
        """Established TCP connections that `which` selects: each line of ss."""
        listed = subprocess.run(["ss", "-Htn", *options, "state", "established", which], capture_output=True, text=True, check=True)
        return listed.stdout.splitlines()

    def connections(self, pid):
        """The client's ports of a process's connections to the daemon's control and stream ports."""
        lines = self.established("( dport = :7701 or dport = :7702 )", "-p")
        return {line.split()[2].rpartition(":")[2] for line in lines if f"pid={pid}," in line}

    def daemon_has(self, ports):
        """Whether the daemon still has one of these connections."""
        return any(line.split()[3].rpartition(":")[2] in ports for line in self.established("( sport = :7701 or sport = :7702 )"))

    def schema(self, name):
        """A schema of system.describe."""
        described = self.call("system.describe")
        return described["streams"][name] if name in described["streams"] else described["methods"][name]["params"]


def reports(text):
    """The JSON objects among printed lines."""
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


__all__ = ["BridgeCase", "Path", "RUN", "environment", "has", "reports"]
