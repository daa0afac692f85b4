"""A real systemd user manager in its own namespaces: it sees no unit and no socket of the machine.

Root only. The mounts are private to this process; two cgroups are made for the manager and removed with their processes.
"""
import contextlib
import ctypes
import os
import pathlib
import socket
import stat
import subprocess
import time

CGROUPS = pathlib.Path("/sys/fs/cgroup")
RUNTIME = pathlib.Path("/run/ovws-manager")  # not in /run/user, which ProtectHome hides
UNITS = pathlib.Path("/run/ovws-units")
TARGETS = ("basic", "default", "exit", "shutdown", "sysinit", "multi-user")


class NoManager(Exception):
    """The manager cannot run here; the text says why."""


def own_mounts():
    """Moves this process into its own mount namespace, with an empty /run."""
    clone_newns, ms_rec_private, ms_rec_shared = 0x00020000, 0x4000 | 0x40000, 0x4000 | 0x100000
    libc = ctypes.CDLL(None, use_errno=True)

    def must(result, what):
        if result != 0:
            raise NoManager(f"{what}: {os.strerror(ctypes.get_errno())}")

    must(libc.unshare(clone_newns), "no mount namespace")
    must(libc.mount(b"none", b"/", None, ms_rec_private, None), "mounts cannot be made private")
    # Share mounts between this process and the manager: a service's credentials are a mount made by its child.
    must(libc.mount(b"none", b"/", None, ms_rec_shared, None), "mounts cannot be shared with the manager")
    must(libc.mount(b"tmpfs", b"/run", b"tmpfs", 0, None), "no /run of its own")
    must(libc.mount(b"tmpfs", b"/home", b"tmpfs", 0, None), "no /home of its own")
    pathlib.Path("/home", "user").mkdir()
    pathlib.Path("/run/systemd/system").mkdir(parents=True)
    RUNTIME.mkdir(parents=True)
    UNITS.mkdir()
    make_inaccessible_nodes()


def make_inaccessible_nodes():
    """The nodes that a system manager makes at boot and mounts over the paths that a service must not see."""
    folder = pathlib.Path("/run/systemd/inaccessible")
    (folder / "dir").mkdir(parents=True, mode=0)
    (folder / "reg").touch(mode=0)
    os.mkfifo(folder / "fifo", 0)
    with socket.socket(socket.AF_UNIX) as node:
        node.bind(str(folder / "sock"))
    for name, kind in (("chr", stat.S_IFCHR), ("blk", stat.S_IFBLK)):
        try:
            os.mknod(folder / name, kind, os.makedev(0, 0))
        except OSError as error:
            raise NoManager(f"no device nodes: {error}") from error


def own_users(definition):
    """Gives this process its own copy of /etc, with the users of a sysusers.d file."""
    for command in (["cp", "-a", "/etc", "/run/etc"], ["mount", "--bind", "/run/etc", "/etc"], ["systemd-sysusers", definition]):
        ran = subprocess.run(command, capture_output=True, text=True)
        if ran.returncode != 0:
            raise NoManager(f"{command[0]}: {ran.stderr.strip()}")


class Manager:
    """One `systemd --user`, whose units are the files in UNITS."""

    def __init__(self):
        self._cgroups = []
        for hierarchy in self._hierarchies():
            folder = hierarchy / f"ovws-test-{os.getpid()}"
            try:
                folder.mkdir()
            except OSError as error:
                raise NoManager(f"no cgroup of its own: {error}") from error
            self._cgroups.append(folder)
        for target in TARGETS:
            (UNITS / f"{target}.target").write_text(f"[Unit]\nDescription={target}\n")
        self.environment = {"PATH": os.environ["PATH"], "HOME": "/run", "XDG_RUNTIME_DIR": str(RUNTIME), "SYSTEMD_UNIT_PATH": str(UNITS)}

    @staticmethod
    def _hierarchies():
        """The mounted cgroup hierarchies in which systemd counts its processes: the only one of version 2, or those beside version 1."""
        if (CGROUPS / "cgroup.controllers").is_file():
            return [CGROUPS]
        found = [CGROUPS / name for name in ("systemd", "unified") if (CGROUPS / name).is_dir()]
        if not found:
            raise NoManager(f"neither cgroup v2 ({CGROUPS}/cgroup.controllers) nor systemd's v1 hierarchy ({CGROUPS}/systemd) is mounted")
        return found

    def start(self):
        self.popen = subprocess.Popen(["/usr/lib/systemd/systemd", "--user"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                      stderr=subprocess.DEVNULL, env=self.environment, preexec_fn=self._enter)
        end = time.monotonic() + 120.0
        while self.popen.poll() is None and time.monotonic() < end:
            if self.systemctl("list-units").returncode == 0:
                (RUNTIME / "systemd/notify").chmod(0o777)  # as the system manager's: for services of other users
                return
            time.sleep(0.1)
        raise NoManager("systemd --user does not answer: " + self.systemctl("list-units").stderr.strip())

    def _enter(self):
        for folder in self._cgroups:
            (folder / "cgroup.procs").write_text(str(os.getpid()))

    def systemctl(self, *arguments, timeout=120.0):
        return subprocess.run(["systemctl", "--user", "--no-pager", "--full", *arguments], env=self.environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=timeout)

    def show(self, unit, *properties):
        """The unit's properties as a dictionary of strings."""
        shown = self.systemctl("show", unit, "--property=" + ",".join(properties)).stdout
        return dict(line.split("=", 1) for line in shown.splitlines() if "=" in line)

    def close(self):
        """Ends the manager and every process in its cgroups, which are its own."""
        if hasattr(self, "popen") and self.popen.poll() is None:
            self.popen.kill()
            self.popen.wait()
        for folder in self._cgroups:
            for procs in folder.rglob("cgroup.procs"):
                for pid in procs.read_text().split():
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(int(pid), 9)
            end = time.monotonic() + 5.0
            for part in sorted([folder, *(p for p in folder.rglob("*") if p.is_dir())], reverse=True):
                while time.monotonic() < end:
                    try:
                        part.rmdir()
                        break
                    except OSError:
                        time.sleep(0.02)
