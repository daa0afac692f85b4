"""Other processes take CPU and memory: the daemon keeps running and recovers when they end."""
import contextlib
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import time
import unittest

from case import PATIENCE_S, BenchCase, ClientError, main, wait_for
from memory_group import MemoryGroup, NoGroup

# With autogroup scheduling, the nice value of the session counts.
HOG = "import os, pathlib\nos.nice(-10)\ngroup = pathlib.Path('/proc/self/autogroup')\nif group.exists(): group.write_text('-10')\nblock = bytearray({bytes})\nwhile True:\n    for at in range(0, len(block), 4096):\n        block[at] = 1"
HOGS_PER_CORE = 4
HOG_BYTES = 16 << 20
# Blocks a preempted thread for more than a frame period.
REALTIME_HOG = """import os, time
os.sched_setaffinity(0, {{{core}}})
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(90))
while True:
    end = time.monotonic() + 0.012
    while time.monotonic() < end: pass
    time.sleep(0.0006)
"""
STATUS_MESSAGES = 4  # about as many seconds
IN_A_ROW = 100  # frames without a gap
FRAME_PATH = ("acquire", "track", "reconstruct", "publish")
MORE_BYTES = 2 << 20


def schedule(pid, policy, priority=0, name=None):
    """Sets the scheduling of all threads of the process, or of those named `name`."""
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        if name in (None, (task / "comm").read_text().strip()):
            os.sched_setscheduler(int(task.name), policy, os.sched_param(priority))


def may_be_realtime():
    return subprocess.run([sys.executable, "-c", "import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(90))"],
                          stderr=subprocess.DEVNULL, check=False).returncode == 0


class PressureCase(BenchCase):
    # With two workers, each hand-over of a frame may wait for a CPU.
    daemon_config = {"pipeline": {"workers": 2}, "camera": {"frame_rate_hz": 100.0}}

    def missed(self):
        return self.call("system.status")["counters"]["deadline_missed"]

    def frames_in_a_row(self):
        """Waits until settled and valid frames come without a gap."""
        stream, row = self.stream("wavefront"), 0
        end = time.monotonic() + 2 * PATIENCE_S
        while row < IN_A_ROW:
            self.assertLess(time.monotonic(), end, f"only {row} frames in a row")
            frame = self.settled_frames(stream, 1)[0]
            row = row + 1 if frame["gap"] == 0 else 0

    def start_hog(self, code):
        hog = subprocess.Popen([sys.executable, "-c", code], start_new_session=True)
        self.addCleanup(hog.wait)
        self.addCleanup(hog.kill)
        return hog

    def assert_as_before(self):
        self.take_reference(20)
        self.frames_in_a_row()
        self.assertEqual(self.call("system.status")["state"], "running")

    def press(self, start_hogs):
        """Checks that status continues under load, that nothing ends, and that the daemon recovers.

        Prints missed deadlines, whose number depends on the machine; their counting is tested in tests/unit/pipeline."""
        self.client.timeout_s = 2 * PATIENCE_S
        status = self.stream("status")
        self.take_reference(20)
        before = self.missed()
        hogs = start_hogs()
        status.drain()
        pressed = [wait_for(lambda: status.next(1.0), 2 * PATIENCE_S, "status under pressure") for _ in range(STATUS_MESSAGES)]
        for hog in hogs:
            hog.kill()
            hog.wait()
        counts = [message["counters"]["deadline_missed"] for message in pressed]
        print(f"\n  deadlines missed: {before} before, {counts[-1] - before} under pressure")
        self.assertEqual(counts, sorted(counts))
        self.assertTrue(self.bench.process("ovwsd").alive())
        self.wait_until("running")
        self.assert_as_before()


class WithoutRealtime(PressureCase):
    """Without real-time scheduling: normal processes cannot preempt SCHED_FIFO threads."""

    def start_daemon(self):
        super().start_daemon()
        schedule(self.bench.process("ovwsd").pid, os.SCHED_OTHER)

    def assert_as_before(self):
        schedule(self.bench.process("ovwsd").pid, os.SCHED_OTHER)
        super().assert_as_before()

    def start_hogs(self):
        # Give the trackers the lowest priority, so that a short test shows the effect of a long one.
        schedule(self.bench.process("ovwsd").pid, os.SCHED_IDLE, name="track")
        for name in ("ovws-twin", "xorg"):  # keep twin and display running: only the daemon is under load
            schedule(self.bench.process(name).pid, os.SCHED_FIFO, 1)
        hogs = []
        for core in os.sched_getaffinity(0):
            for _ in range(HOGS_PER_CORE):
                hogs.append(self.start_hog(HOG.format(bytes=HOG_BYTES)))
                os.sched_setaffinity(hogs[-1].pid, {core})
        return hogs

    def test_hogs_on_every_core(self):
        self.press(self.start_hogs)


@unittest.skipUnless(may_be_realtime(), "real-time scheduling is not allowed here")
class WithRealtime(PressureCase):
    core = max(os.sched_getaffinity(0))
    daemon_config = PressureCase.daemon_config | {"pipeline": {"workers": 2, "cpus": [core]}}

    def test_a_hog_above_the_frame_path(self):
        """A process with a higher SCHED_FIFO priority on the frame path's CPU."""
        tasks = pathlib.Path(f"/proc/{self.bench.process('ovwsd').pid}/task")
        paths = [task for task in tasks.iterdir() if (task / "comm").read_text().strip() in FRAME_PATH]
        self.assertEqual(len(paths), len(FRAME_PATH) + 1)  # two trackers
        for task in paths:
            self.assertEqual(os.sched_getscheduler(int(task.name)), os.SCHED_FIFO)
            self.assertEqual(os.sched_getaffinity(int(task.name)), {self.core})
        anywhere = [int(task.name) for task in tasks.iterdir() if os.sched_getaffinity(int(task.name)) == os.sched_getaffinity(0)]
        self.assertIn(self.bench.process("ovwsd").pid, anywhere)
        self.press(lambda: [self.start_hog(REALTIME_HOG.format(core=self.core))])


class Memory(PressureCase):
    daemon_config = PressureCase.daemon_config | {"state": {"directory": "state"}}

    def start_daemon(self):
        try:
            self.group = MemoryGroup()
        except NoGroup as why:
            self.group = None
            self.why = str(why)
            return super().start_daemon()
        self.addCleanup(self.group.close)
        self.addCleanup(self.bench.close)
        with self.group.entered():
            super().start_daemon()

    def in_the_group(self):
        """Takes the reference, then limits the cgroup to little more than the present memory."""
        if self.group is None:
            self.skipTest(self.why)
        self.take_reference(20)
        self.fitted_frames(self.stream("wavefront"), 100)  # the search thread has made its model, which takes memory
        usage = self.group.usage()
        self.group.limit(usage + MORE_BYTES)
        print(f"\n  {usage >> 20} MiB, and {MORE_BYTES >> 20} more allowed")

    def test_a_cgroup_without_room(self):
        """Frames continue, because their memory is allocated and locked."""
        self.in_the_group()
        self.settled_frames(self.stream("wavefront"), 200)
        self.frames_in_a_row()
        self.group.lift()
        self.assert_as_before()

    def test_a_daemon_that_the_kernel_ends_for_its_memory(self):
        self.in_the_group()
        before = self.call("reference.get")
        self.client.timeout_s = 1.0
        with contextlib.suppress(ClientError):
            self.call("camera.grab", {"frames": 100})  # of some 25 MiB
        wait_for(lambda: not self.bench.process("ovwsd").alive(), what="its end")
        self.assertEqual(self.bench.stop("ovwsd"), -signal.SIGKILL)
        self.group.lift()
        self.client.close()
        PressureCase.start_daemon(self)
        self.wait_until("running")
        self.assertEqual(self.call("reference.get"), before)
        self.assert_as_before()

    def test_no_more_address_space(self):
        self.take_reference(20)
        pid = self.bench.process("ovwsd").pid
        size = int(re.search(r"VmSize:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text()).group(1)) * 1024
        unlimited = resource.prlimit(pid, resource.RLIMIT_AS)
        resource.prlimit(pid, resource.RLIMIT_AS, (size, unlimited[1]))
        self.settled_frames(self.stream("wavefront"), 200)
        self.frames_in_a_row()
        resource.prlimit(pid, resource.RLIMIT_AS, unlimited)
        self.assert_as_before()


if __name__ == "__main__":
    main()
