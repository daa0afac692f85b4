"""Crowds of subscribers: some never read, one is slow, a thousand connect and disconnect. Only they lose messages.

    OVWS_CROWD_FRAMES=6000   frames that are published beside each crowd

The latency beside a crowd is measured by tests/bench/crowd.
"""
import json
import os
from pathlib import Path

import zmq

from case import PATIENCE_S, BenchCase, main, wait_for

FRAMES = int(os.environ.get("OVWS_CROWD_FRAMES", "300"))
NEVER_READ, COME_AND_GO, AT_A_TIME = 100, 1000, 10
FRAMES_A_READ = 30  # of the slow subscriber
STREAMS, IMAGES = "tcp://127.0.0.1:7701", "tcp://127.0.0.1:7703"
MOST_GROWTH_MIB = 64


class Crowd(BenchCase):
    def setUp(self):
        super().setUp()
        self.reader = self.stream("wavefront")
        self.pid = self.bench.process("ovwsd").pid
        self.context = zmq.Context()
        self.addCleanup(self.context.destroy, 0)

    def resident_mib(self):
        return int(Path(f"/proc/{self.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

    def descriptors(self):
        return len(list(Path(f"/proc/{self.pid}/fd").iterdir()))

    def subscriber(self, endpoint=STREAMS):
        socket = self.context.socket(zmq.SUB)
        socket.rcvhwm = 1
        socket.rcvbuf = 4096
        socket.subscribe("")
        socket.connect(endpoint)
        return socket

    def watch(self, frames, each=lambda frame: None):
        """Checks that a fast subscriber gets each of the next messages; calls `each` with the number of each one."""
        self.reader.drain()
        last = None
        for frame in range(frames):
            message = self.reader.next(PATIENCE_S)
            self.assertIsNotNone(message, "the stream stopped")
            self.assertTrue(last is None or message["seq"] == last + 1, f"a message was lost: {message['seq']} after {last}")
            last = message["seq"]
            each(frame)

    def judge(self, name):
        grown_mib = self.resident_mib() - self.before_mib
        print(f"\n  {name}: memory +{grown_mib:.1f} MiB")
        self.assertLess(grown_mib, MOST_GROWTH_MIB)
        counters = self.call("system.status")["counters"]
        self.assertEqual((counters["frames_dropped"], counters["messages_dropped"]), (0, 0))

    def hundred_that_never_read(self):
        crowd = [self.subscriber() for _ in range(NEVER_READ)] + [self.subscriber(IMAGES) for _ in range(NEVER_READ // 10)]
        wait_for(lambda: self.descriptors() > NEVER_READ, what="their connections")
        self.watch(FRAMES)
        self.judge("100 that never read")
        for socket in crowd:
            socket.close(0)
        wait_for(lambda: self.descriptors() < NEVER_READ, what="the end of their connections")

    def one_that_reads_slowly(self):
        slow, numbers = self.subscriber(), []

        def read_one(frame):
            if frame % FRAMES_A_READ == 0:
                self.assertTrue(slow.poll(1e3 * PATIENCE_S), "no message for the slow subscriber")
                topic, text, *_ = slow.recv_multipart()  # whole, however late
                numbers.append((topic, json.loads(text)["seq"]))

        self.watch(FRAMES, read_one)
        self.judge("one that reads a message in thirty")
        for topic in {topic for topic, _ in numbers}:
            read = [number for own, number in numbers if own == topic]
            self.assertEqual(read, sorted(set(read)), topic)
        slow.close(0)

    def thousand_that_come_and_go(self):
        descriptors, heard = self.descriptors(), []

        def some(_):
            guests = [self.subscriber() for _ in range(AT_A_TIME)]
            heard.extend(guest.poll(1e3 * PATIENCE_S) > 0 for guest in guests)
            for guest in guests:
                guest.close(0)

        self.watch(COME_AND_GO // AT_A_TIME, some)
        self.judge("1000 that come and go")
        self.assertEqual((len(heard), sum(heard)), (COME_AND_GO, COME_AND_GO))
        wait_for(lambda: self.descriptors() <= descriptors, what="the end of their connections")

    def test_what_they_lose_is_theirs_alone(self):
        self.take_reference(20)
        self.settled_frames(self.reader, 10)
        self.before_mib = self.resident_mib()
        self.hundred_that_never_read()
        self.one_that_reads_slowly()
        self.thousand_that_come_and_go()


if __name__ == "__main__":
    main()
