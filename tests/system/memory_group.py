"""Memory cgroup (version 1 or 2) that limits the memory of the processes started in it, without swap."""
import contextlib
import os
import pathlib
import time

ROOTS = ((pathlib.Path("/sys/fs/cgroup/memory"), "memory.limit_in_bytes", "memory.memsw.limit_in_bytes", "memory.usage_in_bytes"),
         (pathlib.Path("/sys/fs/cgroup"), "memory.max", None, "memory.current"))


class NoGroup(Exception):
    """The cgroup cannot be created; the text says why."""


class MemoryGroup:
    def __init__(self):
        why = "no memory cgroup is mounted"
        for root, self._limit, self._swap_limit, self._usage in ROOTS:
            self.folder = root / f"ovws-test-{os.getpid()}"
            if not (root / "cgroup.procs").exists():
                continue
            try:
                self.folder.mkdir()
            except OSError as error:
                why = f"no memory cgroup of its own: {error}"
                continue
            if (self.folder / self._limit).exists():
                self._home = next(folder for folder in self._homes(root))
                return
            self.folder.rmdir()
        raise NoGroup(why)

    @staticmethod
    def _homes(root):
        """The cgroup folders of this process."""
        for line in pathlib.Path("/proc/self/cgroup").read_text().splitlines():
            _, controllers, path = line.split(":", 2)
            if "memory" in controllers.split(",") if root.name == "memory" else controllers == "":
                yield root / path.lstrip("/")

    @contextlib.contextmanager
    def entered(self):
        """Context in which started processes join the group permanently; memory counts in the group that allocated it."""
        (self.folder / "cgroup.procs").write_text(str(os.getpid()))
        try:
            yield
        finally:
            (self._home / "cgroup.procs").write_text(str(os.getpid()))

    def usage(self):
        return int((self.folder / self._usage).read_text())

    def limit(self, count):
        """Limits memory to `count` bytes, without swap."""
        (self.folder / self._limit).write_text(str(count))
        if self._swap_limit is None:
            (self.folder / "memory.swap.max").write_text("0")
        elif (self.folder / self._swap_limit).exists():  # limit of memory plus swap
            (self.folder / self._swap_limit).write_text(str(count))

    def lift(self):
        for name in filter(None, (self._swap_limit, self._limit)):
            if (self.folder / name).exists():
                (self.folder / name).write_text("-1" if self._swap_limit else "max")

    def close(self):
        """Removes the group once all its processes have ended."""
        end = time.monotonic() + 60.0
        while True:
            try:
                return self.folder.rmdir()
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.02)
