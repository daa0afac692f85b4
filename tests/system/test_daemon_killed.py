"""A daemon that is killed leaves the camera streaming to nobody: the next one stops that, and has frames."""
import os
import signal
import time

from case import BenchCase, main

TIMES = 20 if os.environ.get("OVWS_LONG_ABSENCE") else 5


class DaemonKilled(BenchCase):
    daemon_config = {"stream": {"image_rate_hz": 0}}

    def test_frames_flow_each_time(self):
        slowest_s = 0.0
        for time_no in range(TIMES):
            with self.subTest(time_no=time_no):
                daemon = self.bench.process("ovwsd")
                os.kill(daemon.pid, signal.SIGKILL)
                killed = time.monotonic()
                self.bench.stop("ovwsd")
                self.start_daemon()
                self.assertLess(time.monotonic() - killed, 5.0)
                stream = self.stream("wavefront")
                frames = [stream.next(30.0)]
                while len(frames) < 20:
                    frames.append(stream.next(5.0))
                self.assertNotIn(None, frames)
                slowest_s = max(slowest_s, time.monotonic() - killed)
                stream.close()
        print(f"\n  killed {TIMES} times: 20 frames after {slowest_s:.1f} s at most")


if __name__ == "__main__":
    main()
