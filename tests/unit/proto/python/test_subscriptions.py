"""Both subscriptions against a simulated publisher: iterating, losses, time-outs."""
import asyncio
import itertools
import json
import math
import multiprocessing
import os
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor

import paths  # noqa: F401  the client's folder

import numpy as np
import zmq

from ovws_client import AsyncSubscription, ClientError, Event, NoAnswer, Stream, Subscription

EVENT = {"schema": "ovws.event/1", "seq": 0, "t_ns": 1, "kind": "job", "severity": "info", "text": "done", "data": None}


shared = []  # with forks


def next_of_shared():
    return shared[0].next()


class Subscriptions(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.endpoint = f"ipc://{folder.name}/numbers"
        self.socket = zmq.Context.instance().socket(zmq.XPUB)  # reports new subscriptions
        self.addCleanup(self.socket.close, 0)
        self.socket.bind(self.endpoint)

    def publish(self, *seqs):
        self.assertTrue(self.socket.poll(10000))
        self.socket.recv()
        for seq in seqs:
            self.socket.send_multipart([b"event", json.dumps(EVENT | {"seq": seq}).encode()])

    def ipv6_endpoint(self):
        """The endpoint of a new publisher."""
        self.socket = zmq.Context.instance().socket(zmq.XPUB)
        self.addCleanup(self.socket.close, 0)
        self.socket.ipv6 = True
        return f"tcp://[::1]:{self.socket.bind_to_random_port('tcp://[::1]')}"

    def test_iterating_and_the_newest(self):
        with Subscription(Event, endpoint=self.endpoint, timeout_s=20.0) as stream:
            self.publish(0, 1, 4)
            self.assertEqual([(m.seq, m.lost_messages) for m in itertools.islice(stream, 3)], [(0, 0), (1, 0), (4, 2)])
            self.assertEqual(stream.lost_messages, 2)
            self.assertIsNone(stream.next(0.0))
            for seq in (5, 6, 7):
                self.socket.send_multipart([b"event", json.dumps(EVENT | {"seq": seq}).encode()])
            seen = []
            while 7 not in seen:
                seen.append(stream.newest(20.0).seq)
            self.assertEqual((seen, stream.lost_messages), (sorted(seen), 2))

    def test_over_ipv6(self):
        if not os.path.exists("/proc/net/if_inet6"):
            self.skipTest("this machine has no IPv6")
        with Subscription(Event, endpoint=self.ipv6_endpoint(), timeout_s=20.0) as stream:
            self.publish(0)
            self.assertEqual(next(stream).seq, 0)

        async def main():
            async with AsyncSubscription(Event, endpoint=self.ipv6_endpoint(), timeout_s=20.0) as stream:
                await asyncio.to_thread(self.publish, 0)
                self.assertEqual((await anext(stream)).seq, 0)

        asyncio.run(main())
        stream = Stream(["event"], self.ipv6_endpoint())
        self.addCleanup(stream.close)
        self.publish(0)
        self.assertEqual(stream.next(20.0)["seq"], 0)

    def test_silence(self):
        with Subscription(Event, endpoint=self.endpoint, timeout_s=0.05) as stream:
            with self.assertRaisesRegex(NoAnswer, "0.05 s"):
                next(stream)
            self.assertIsNone(stream.newest(0.0))

    def test_a_fork_and_a_second_thread_are_told_so(self):
        with Subscription(Event, endpoint=self.endpoint, timeout_s=20.0) as stream, ThreadPoolExecutor(1) as pool:
            self.publish(0)
            self.assertEqual(next(stream).seq, 0)
            shared.append(stream)
            self.addCleanup(shared.clear)
            with multiprocessing.get_context("fork").Pool(1) as fork:
                with self.assertRaisesRegex(ClientError, f"this subscription belongs to process {os.getpid()}, .* after the fork"):
                    fork.apply_async(next_of_shared).get(timeout=30.0)
            waiting = pool.submit(stream.next, 20.0)
            while not stream._guard._is_used:
                time.sleep(0.001)
            for act in (lambda: stream.next(0.0), lambda: stream.newest(0.0), stream.close):
                with self.assertRaisesRegex(ClientError, "another thread uses this subscription: make one for each thread"):
                    act()
            self.socket.send_multipart([b"event", json.dumps(EVENT | {"seq": 1}).encode()])
            self.assertEqual(waiting.result(60.0).seq, 1)
        with self.assertRaisesRegex(ClientError, "this subscription is closed"):
            stream.next(0.0)

    def test_numbers_of_numpy_are_numbers_and_wrong_ones_are_refused_by_name(self):
        with Subscription(Event, endpoint=self.endpoint, timeout_s=np.float32(20.0), queue_messages=np.int64(10)) as stream:
            self.publish(0)
            self.assertEqual(next(stream).seq, 0)
            for timeout_s in (np.int64(0), np.float32(0.0), np.bool_(False)):
                self.assertIsNone(stream.next(timeout_s))
            for timeout_s in (-1, math.nan, "1"):
                with self.assertRaisesRegex(ValueError, "^timeout_s: must be a number of at least 0, not "):
                    stream.next(timeout_s)
        for queue_messages in (0, 4.5, None):
            with self.assertRaisesRegex(ValueError, "^queue_messages: must be a whole number of at least 1, not "):
                Subscription(Event, endpoint=self.endpoint, queue_messages=queue_messages)
        for kind in (Subscription, AsyncSubscription):
            with self.assertRaisesRegex(ClientError, "scheme tcp:// is missing: give tcp://127.0.0.1:7701"):
                kind(Event, endpoint="127.0.0.1:7701")

    def test_one_event_loop_after_another(self):
        stream = AsyncSubscription(Event, endpoint=self.endpoint, timeout_s=20.0)
        self.addCleanup(stream.close)
        self.publish(0, 1, 2)
        self.assertEqual([asyncio.run(stream.next(20.0)).seq for _ in range(2)], [0, 1])

        async def inside():
            self.assertEqual((await stream.next(20.0)).seq, 2)
            with self.assertRaisesRegex(ClientError, "another event loop uses this subscription"):
                await asyncio.to_thread(asyncio.run, stream.next(0.0))

        asyncio.run(inside())

    def test_for_asyncio(self):
        async def main():
            async with AsyncSubscription(Event, endpoint=self.endpoint, timeout_s=20.0) as stream:
                await asyncio.to_thread(self.publish, 0, 3)
                heard = [(await anext(stream)).lost_messages for _ in range(2)]
                self.assertEqual((heard, stream.lost_messages), ([0, 2], 2))
                self.assertIsNone(await stream.newest(0.0))
                stream.timeout_s = 0.05
                with self.assertRaises(NoAnswer):
                    await anext(stream)

        asyncio.run(main())


if __name__ == "__main__":
    unittest.main()
