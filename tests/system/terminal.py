"""Terminal emulator: runs a program in its own pseudo-terminal and holds the screen that it draws."""
import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import termios
import threading

import pyte
from case import PROGRAM_PATIENCE_S, wait_for


class Terminal:
    """Reads continuously, like a terminal. `raw` holds all bytes received. Standard output may lead elsewhere."""

    def __init__(self, command, columns=80, lines=24, stdout=None, **environment):
        self.master, self.slave = pty.openpty()
        self._screen = pyte.Screen(columns, lines)
        self._stream = pyte.ByteStream(self._screen)
        self._lock = threading.Lock()
        self.raw = b""
        self.resize(columns, lines)
        self.modes_before = self.modes()
        env = {k: v for k, v in os.environ.items() if k not in ("LC_ALL", "LANG", "NO_COLOR")}
        self.process = subprocess.Popen(
            [str(part) for part in command], stdin=self.slave, stdout=self.slave if stdout is None else stdout, stderr=self.slave, start_new_session=True,
            env=env | {"TERM": "linux", "LC_ALL": "C.UTF-8"} | environment, preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
        self._end = threading.Event()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self):
        while not self._end.is_set():
            if not select.select([self.master], [], [], 0.05)[0]:
                continue
            try:
                data = os.read(self.master, 65536)
            except OSError:
                return
            with self._lock:
                self.raw += data
                self._stream.feed(data)

    def resize(self, columns, lines):
        with self._lock:
            self._screen.resize(lines, columns)
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))

    def rows(self):
        with self._lock:
            return list(self._screen.display)

    def text(self):
        return "\n".join(self.rows())

    def colours(self):
        """The foreground colours on the screen."""
        with self._lock:
            return {cell.fg for row in self._screen.buffer.values() for cell in row.values()}

    def press(self, keys):
        os.write(self.master, keys.encode())

    def wait(self):
        """Waits for the program's end, and until all that it wrote is in `raw`. Returns its exit status."""
        status = self.process.wait(PROGRAM_PATIENCE_S)
        os.write(self.slave, b"\0")  # arrives after that, and is not shown
        wait_for(lambda: self.raw.endswith(b"\0"), what="the terminal's last output")
        return status

    def modes(self):
        """The four flag words of termios."""
        return termios.tcgetattr(self.slave)[:4]

    def close(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self._end.set()
        self._reader.join()
        os.close(self.slave)
        os.close(self.master)
