"""Starts a simulated bench on this machine, and stops exactly what it started.

A bench is an X server with two virtual outputs (DUMMY0 for the desktop, DUMMY1 for the SLM), the
digital twin `ovws-twin`, which reads DUMMY1 and answers as a camera, and optionally the daemon
`ovwsd`. Standard library only.

    import bench
    with bench.Bench() as b:
        b.start_display()
        b.start_twin({"detector": {"read_noise_e": 20}})
        b.start_daemon({"camera": {"frame_rate_hz": 200}})
        ...                     # b.display, b.programs, b.directory, b.log("ovws-twin")

The camera's port (UDP 3956) is fixed by GigE Vision, so one machine, or one network namespace,
holds one bench; `own_network()` moves the calling process into a namespace of its own.
"""

import ctypes
import functools
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parent.parent
PATIENCE_S = 60.0  # limit of each wait for a program's start or end
STOPS = {signal.SIGTERM, signal.SIGKILL, signal.SIGINT, signal.SIGHUP}  # other signals end a program that crashes
X_LOCK, X_SOCKET = "/tmp/.X{}-lock", "/tmp/.X11-unix/X{}"


class BenchError(Exception):
    """A program did not start or ended by itself; the text says which one, and ends with its log."""


def find_programs(build=None):
    """The folder with ovwsd, ovws and ovws-twin: in `build`, else in $OVWS_BUILD, else in the
    folder of build/* whose ovws-twin is the newest."""
    build = build or os.environ.get("OVWS_BUILD")
    folders = [pathlib.Path(build)] if build else sorted((SOURCE / "build").glob("*"))
    twins = [f / "bin" / "ovws-twin" for f in folders if (f / "bin" / "ovws-twin").exists()]
    if not twins:
        raise BenchError(f"no bin/ovws-twin in {build or SOURCE / 'build'}: build the project first")
    return max(twins, key=lambda twin: twin.stat().st_mtime).resolve().parent


def python_client():
    """Makes `import ovws_client` find the package of the build in use, which contains generated code."""
    sys.path.insert(0, str(find_programs().parent / "python"))


def forget_environment():
    """Removes what would change the bench's programs and clients: keys of a daemon, and what a service manager gives its services."""
    for name in ("OVWS_KEY", "OVWS_SERVER_KEY", "STATE_DIRECTORY", "RUNTIME_DIRECTORY", "CACHE_DIRECTORY", "LOGS_DIRECTORY",
                 "CONFIGURATION_DIRECTORY", "CREDENTIALS_DIRECTORY", "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID", "LISTEN_FDS",
                 "LISTEN_PID", "LISTEN_FDNAMES", "JOURNAL_STREAM"):
        os.environ.pop(name, None)


def own_network():
    """Moves this process and its future children into an empty network namespace. Without root rights it first enters a user
    namespace in which it has them, if the system allows this."""
    clone_newnet, clone_newuser = 0x40000000, 0x10000000
    libc = ctypes.CDLL(None, use_errno=True)
    user, group = os.geteuid(), os.getegid()
    if libc.unshare(clone_newnet) != 0:
        if libc.unshare(clone_newnet | clone_newuser) != 0:
            raise BenchError(f"cannot create a network namespace: {os.strerror(ctypes.get_errno())}")
        for name, text in (("setgroups", "deny"), ("uid_map", f"0 {user} 1"), ("gid_map", f"0 {group} 1")):
            pathlib.Path("/proc/self", name).write_text(text)
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)


def _end_with_parent():
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGTERM)


def free_displays():
    """Display numbers that seem free. Xorg's own search (-displayfd) is not used: it only sees its
    network namespace, and takes over the socket file of a server in another one. Every process
    searches from another number, so that none takes the number of a server that another process
    starts again."""
    for number in range(100 + os.getpid() % 800, 1000):
        if not any(os.path.exists(path.format(number)) for path in (X_LOCK, X_SOCKET)):
            yield number


def _serves_display(pid, number):
    """Whether the X server with this process id holds the display and answers a client."""
    try:
        if int(pathlib.Path(X_LOCK.format(number)).read_text()) != pid:
            return False
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
            client.settimeout(2.0)
            client.connect(X_SOCKET.format(number))
            client.sendall(b"l\0\x0b\0\0\0\0\0\0\0\0\0")  # little-endian, protocol 11.0
            return client.recv(1) == b"\x01"
    except (OSError, ValueError):
        return False


def _xorg_config(width, height):
    """Returns the text of xorg-bench.conf with an SLM of this size (pixels) at 60 Hz."""
    text = (HERE / "xorg-bench.conf").read_text()
    if (width, height) == (1280, 768):
        return text
    columns, lines = width + 384, height + 30
    mode = (f'Modeline "{width}x{height}" {60e-6 * columns * lines:.2f} '
            f"{width} {width + 64} {width + 192} {columns} {height} {height + 3} {height + 13} {lines}")
    start = text.index('Modeline "1280x768"')
    return (text[:start] + mode + text[text.index("\n", start):]).replace("1280x768", f"{width}x{height}")


class Process:
    """One program of the bench with its log files."""

    def __init__(self, name, command, directory, env=None, pass_fds=()):
        self.name = name
        self._is_killed = False
        self.log_path = pathlib.Path(directory) / f"{name}.log"
        self._out_path = pathlib.Path(directory) / f"{name}.out"
        # A session of its own, so that Ctrl-C at the terminal stops the bench in order.
        with open(self._out_path, "wb") as out, open(self.log_path, "wb") as log:
            self.popen = subprocess.Popen(
                [str(part) for part in command], stdin=subprocess.DEVNULL, stdout=out, stderr=log,
                env=env, pass_fds=pass_fds, cwd=directory, start_new_session=True,
                preexec_fn=_end_with_parent)

    @property
    def pid(self):
        return self.popen.pid

    def alive(self):
        return self.popen.poll() is None

    def failure(self, what):
        """A BenchError with what went wrong, or that the program ended before, and the end of the log."""
        return self._error(what if self.alive() else f"ended with status {self.popen.returncode}")

    def crash(self):
        """A BenchError if this ended program has crashed, or None."""
        number = -self.popen.returncode
        if self._is_killed:
            return self._error("did not end within its time and was killed")
        return self._error(f"crashed ({signal.strsignal(number)})") if number > 0 and number not in STOPS else None

    def _error(self, what):
        tail = self.log_path.read_text(errors="replace").splitlines()[-15:]
        return BenchError("\n  ".join([f"{self.name}: {what}"] + tail))

    def wait_for_line(self, start, timeout=PATIENCE_S):
        """Waits for the first line on standard output that begins with `start`, and returns it."""
        deadline = time.monotonic() + timeout
        while True:
            alive = self.alive()
            for line in self._out_path.read_text(errors="replace").splitlines(keepends=True):
                if line.startswith(start) and line.endswith("\n"):
                    return line.rstrip()
            if not alive or time.monotonic() > deadline:
                raise self.failure(f"no line '{start} …' within {timeout} s")
            time.sleep(0.02)

    def stop(self):
        """Sends SIGTERM, and SIGKILL after PATIENCE_S. Returns the exit status."""
        if self.alive():
            self.popen.terminate()
            try:
                self.popen.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                self._is_killed = True
                self.popen.kill()
                self.popen.wait()
        return self.popen.returncode


class Bench:
    """A bench with a working folder, which is removed at the end unless `directory` is given."""

    def __init__(self, build=None, directory=None):
        self._build = build
        self._own_directory = directory is None
        self.directory = pathlib.Path(directory or tempfile.mkdtemp(prefix="ovws-bench-"))
        self.directory.mkdir(parents=True, exist_ok=True)
        self.display = None
        self._crashes = []
        self._processes = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @functools.cached_property
    def programs(self):
        """The folder with the built programs."""
        return find_programs(self._build)

    def log(self, name):
        """Standard error of a program."""
        return (self.directory / f"{name}.log").read_text(errors="replace")

    def process(self, name):
        """The running program of that name, or None."""
        return next((p for p in self._processes if p.name == name), None)

    def start(self, name, command, **more):
        process = Process(name, command, self.directory, **more)
        self._processes.append(process)
        return process

    def stop(self, name):
        """Stops one program of the bench, for tests of the consequences. Returns its exit status."""
        return self._end(self.process(name))

    def _end(self, process):
        """Stops a program and notes whether it crashed; returns its exit status."""
        self._processes.remove(process)
        status = process.stop()
        if crash := process.crash():
            self._crashes.append(crash)
        return status

    def check(self):
        """Raises a BenchError if programs of the bench that have been stopped had crashed."""
        crashes, self._crashes = self._crashes, []
        if crashes:
            raise BenchError("\n".join(map(str, crashes)))

    def start_display(self, number=None, timeout=PATIENCE_S, slm_size=(1280, 768)):
        """Starts an X server with the outputs DUMMY0 (1920 x 1080) and DUMMY1 (the SLM, `slm_size`
        pixels), on a free display number unless one is given. Sets `display`."""
        # Not the wrapper /usr/bin/Xorg: it may refuse users who are not at the console.
        xorg = next(filter(os.path.exists, ("/usr/lib/xorg/Xorg", "/usr/libexec/Xorg")), "Xorg")
        self._write("xorg-bench.conf", _xorg_config(*slm_size))
        for display in [number] if number is not None else free_displays():
            server = self.start("xorg", [
                xorg, f":{display}", "-config", self.directory / "xorg-bench.conf",
                "-logfile", self.directory / "xorg-details.log",
                "-noreset", "-nolisten", "tcp", "-novtswitch", "-sharevts", "-s", "0", "-dpms"])
            deadline = time.monotonic() + timeout
            while server.alive() and time.monotonic() < deadline:
                if _serves_display(server.pid, display):
                    self.display = f":{display}"
                    return self.display
                time.sleep(0.05)
            error = server.failure("no X server")
            taken = "already active" in server.log_path.read_text(errors="replace")
            self.stop("xorg")
            if not taken or number is not None:
                raise error
        raise BenchError("every X display number is taken")

    def start_twin(self, config=None, arguments=(), timeout=PATIENCE_S):
        """Starts the twin with these keys of its configuration. Returns when its camera and control
        socket answer."""
        path = self._write("twin.json", config or {})
        twin = self.start("ovws-twin",
                          [self.programs / "ovws-twin", "--config", path, *arguments],
                          env=self._environment())
        twin.wait_for_line("ready", timeout)
        return twin

    def start_daemon(self, config=None, timeout=PATIENCE_S):
        """Starts the daemon with these keys of its configuration. Returns when it has reported
        readiness by sd_notify; this function stands in for the service manager."""
        path = self._write("ovwsd.json", config or {})
        notify_path = self.directory / "notify"
        notify_path.unlink(missing_ok=True)
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify:
            notify.bind(str(notify_path))
            env = self._environment() | {"NOTIFY_SOCKET": str(notify_path)}
            daemon = self.start("ovwsd", [self.programs / "ovwsd", "--config", path], env=env)
            deadline = time.monotonic() + timeout
            notify.settimeout(0.1)
            while time.monotonic() < deadline and daemon.alive():
                try:
                    if b"READY=1" in notify.recv(4096).split(b"\n"):
                        return daemon
                except TimeoutError:
                    pass
        raise daemon.failure(f"not ready in {timeout} s")

    def keep_only(self, *names):
        """Stops all programs but these, in reverse order, and removes all files but theirs."""
        for process in reversed(self._processes[:]):
            if process.name not in names:
                self._end(process)
        for path in self.directory.iterdir():
            if not path.name.startswith((*names, "twin.json")):
                shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()

    def close(self):
        """Stops all programs of this bench in reverse order, and removes its own folder. Raises a BenchError if a program has
        crashed."""
        while self._processes:
            self._end(self._processes[-1])
        if self._own_directory:
            shutil.rmtree(self.directory, ignore_errors=True)
        self.check()

    def _environment(self):
        # Without an X server of the bench, its programs must not find the user's display.
        env = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        return env | ({"DISPLAY": self.display} if self.display else {})

    def _write(self, name, config):
        path = self.directory / name
        path.write_text(config if isinstance(config, str) else json.dumps(config, indent=2))
        return path
