"""Others want the processors and the memory: what is late is counted and told, nothing ends, and afterwards all is as before."""
import os
import pathlib
import re
import resource
import subprocess
import sys
import time

from case import BenchCase, main, wait_for

# Where the system shares by session first, its nice value is what counts.
HOG = "import os, pathlib\nos.nice(-10)\ngroup = pathlib.Path('/proc/self/autogroup')\nif group.exists(): group.write_text('-10')\nblock = bytearray({bytes})\nwhile True:\n    for at in range(0, len(block), 4096):\n        block[at] = 1"
HOGS_PER_CORE = 4
HOG_BYTES = 16 << 20


def schedule(pid, policy, priority=0, name=None):
    """All threads of the process, or those of that name."""
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        if name in (None, (task / "comm").read_text().strip()):
            os.sched_setscheduler(int(task.name), policy, os.sched_param(priority))


class Pressure(BenchCase):
    # Threads that hand a frame on wait for a processor at each step.
    daemon_config = {"pipeline": {"workers": 2}, "camera": {"frame_rate_hz": 100.0}}

    def start_daemon(self):
        super().start_daemon()
        # Without real time, as on a desk: against SCHED_FIFO no hog of normal scheduling has a chance. The trackers have the least
        # claim to a processor, so that a short test sees what a long one would.
        pid = self.bench.process("ovwsd").pid
        schedule(pid, os.SCHED_OTHER)
        schedule(pid, os.SCHED_IDLE, name="track")

    def missed(self):
        return self.call("system.status")["counters"]["deadline_missed"]

    def published_hz(self):
        return self.call("system.status")["rates"]["published_hz"]

    def start_hogs(self):
        hogs = []
        for core in os.sched_getaffinity(0):
            for _ in range(HOGS_PER_CORE):
                hog = subprocess.Popen([sys.executable, "-c", HOG.format(bytes=HOG_BYTES)], start_new_session=True)
                self.addCleanup(hog.wait)
                self.addCleanup(hog.kill)
                os.sched_setaffinity(hog.pid, {core})
                hogs.append(hog)
        return hogs

    def assert_as_before(self):
        wait_for(lambda: self.published_hz() > 80.0, 20.0, "the old rate")
        self.take_reference(20)
        self.assertEqual(self.call("system.status")["state"], "running")

    def test_hogs_on_every_core(self):
        self.client.timeout_s = 20.0
        status = self.stream("status")
        self.take_reference(20)
        before = self.missed()
        for name in ("ovws-twin", "xorg"):  # the bench goes on: only the daemon is pressed
            schedule(self.bench.process(name).pid, os.SCHED_FIFO, 1)
        hogs = self.start_hogs()
        told = wait_for(lambda: (message := status.next(1.0)) and message["counters"]["deadline_missed"] > before and message, 40.0,
                        "a deadline missed, and told")
        time.sleep(3.0)
        during = self.missed()
        for hog in hogs:
            hog.kill()
            hog.wait()
        print(f"\n  deadlines missed: {before} before, {told['counters']['deadline_missed']} told first, {during} in all")
        self.assertTrue(self.bench.process("ovwsd").alive())
        self.wait_until("running", 30.0)
        self.assert_as_before()

    def test_no_more_memory_while_frames_flow(self):
        self.take_reference(20)
        pid = self.bench.process("ovwsd").pid
        size = int(re.search(r"VmSize:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text()).group(1)) * 1024
        unlimited = resource.prlimit(pid, resource.RLIMIT_AS)
        resource.prlimit(pid, resource.RLIMIT_AS, (size, unlimited[1]))
        stream = self.stream("wavefront")
        self.settled_frames(stream, 200, timeout_s=20.0)
        self.assertGreater(self.published_hz(), 80.0)
        resource.prlimit(pid, resource.RLIMIT_AS, unlimited)
        self.assert_as_before()


if __name__ == "__main__":
    main()
