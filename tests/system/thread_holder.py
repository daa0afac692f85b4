"""Stops one thread of a process with ptrace, like a debugger; the program needs no support for it."""
import contextlib
import ctypes
import os
import pathlib

PTRACE_DETACH, PTRACE_SEIZE, PTRACE_INTERRUPT = 17, 0x4206, 0x4207
WALL = 0x40000000  # __WALL: wait for threads too


def thread_id(pid, name):
    """The id of the thread with this name."""
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        if (task / "comm").read_text().strip() == name:
            return int(task.name)
    raise LookupError(f"process {pid} has no thread {name}")


def _ptrace(request, tid):
    libc = ctypes.CDLL(None, use_errno=True)
    libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    libc.ptrace.restype = ctypes.c_long
    if libc.ptrace(request, tid, None, None) != 0:
        raise OSError(ctypes.get_errno(), f"ptrace {request:#x} of thread {tid}")


@contextlib.contextmanager
def held(pid, name):
    """Context in which the thread is stopped; yields a function that returns whether the thread has ended.
    Poll it while waiting for the process: a traced thread is reaped only when its tracer waits for it."""
    tid = thread_id(pid, name)
    _ptrace(PTRACE_SEIZE, tid)
    _ptrace(PTRACE_INTERRUPT, tid)
    os.waitpid(tid, WALL)
    gone = []

    def ended():
        if not gone:
            with contextlib.suppress(ChildProcessError):
                waited, status = os.waitpid(tid, WALL | os.WNOHANG)
                if waited and not os.WIFSTOPPED(status):
                    gone.append(status)
        return bool(gone)

    try:
        yield ended
    finally:
        if not ended():
            _ptrace(PTRACE_DETACH, tid)
