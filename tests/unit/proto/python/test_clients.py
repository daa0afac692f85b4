"""Both clients against a simulated daemon: answers, errors, time-outs, replies in any order."""
import asyncio
import contextlib
import copy
import itertools
import json
import math
import multiprocessing
import os
import pickle
import queue
import re
import socket
import tempfile
import threading
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from paths import ROOT

import numpy as np
import zmq

from ovws_bridges.bluesky import WavefrontSensor
from ovws_bridges.link import Link
from ovws_client import AsyncClient, Client, ClientError, JobFailed, NoAnswer, Refused, Status
from ovws_client.errors import CODES
from ovws_client.wire import daemon_waits_s, request_text

OUT_OF_RANGE = {"code": -32602, "message": "gain_db: must be a number from -100 to 100, not 1000",
                "data": {"field": "gain_db", "reason": "must be a number from -100 to 100, not 1000", "min": -100.0, "max": 100.0}}
UNKNOWN = {"code": -32602, "message": "exposure_su: unknown key",
           "data": {"field": "exposure_su", "reason": "unknown key", "nearest": "exposure_us"}}


def refuse(how):
    """For a worker process: raises an error that has more to it than a text."""
    if how == "refused":
        raise Refused("camera.set", OUT_OF_RANGE)
    raise JobFailed(job("failed", OUT_OF_RANGE))


def outcome_in(use, results):
    """For a forked process: what use() gives or raises, as text."""
    try:
        results.put(repr(use()))
    except Exception as error:
        results.put(f"{type(error).__name__}: {error}")


def own(endpoint):
    with Client(endpoint, 20.0) as client:
        return client.call("m")


def in_a_fork(use):
    """The outcome of use() in a fork of this process, as text, or "it hangs"."""
    context = multiprocessing.get_context("fork")
    results = context.Queue()
    process = context.Process(target=outcome_in, args=(use, results))
    process.start()
    try:
        return results.get(timeout=30.0)
    except queue.Empty:
        return "it hangs"
    finally:
        process.kill()
        process.join()


HAS_IPV6 = os.path.exists("/proc/net/if_inet6")


@contextlib.contextmanager
def free_port():
    with socket.create_server(("", 0)) as server:
        port = server.getsockname()[1]
    yield port


def job(state, error=None):
    result = {"frames": 9} if state == "done" else None
    return {"job": 3, "kind": "reference.take", "state": state, "progress": 0.5, "result": result, "error": error}


class Played(threading.Thread):
    """Simulated daemon: answers each request in turn with `replies`, {"result": …} or {"error": …}. Answers groups of `together` requests in
    this `order`."""

    def __init__(self, endpoint, replies, together=1, order=iter):
        super().__init__(daemon=True)
        self.requests = []
        self._replies, self._together, self._order = list(replies), together, order
        self._socket = zmq.Context.instance().socket(zmq.ROUTER)
        self._socket.ipv6 = "[" in endpoint
        self._socket.bind(endpoint)
        self.start()

    def run(self):
        with self._socket:
            while self._replies:
                waiting = []
                for _ in range(self._together):
                    peer, text = self._socket.recv_multipart()
                    self.requests.append(json.loads(text))
                    waiting.append((peer, self.requests[-1]["id"], self._replies.pop(0)))
                for peer, request_id, reply in self._order(waiting):
                    self._socket.send_multipart([peer, json.dumps({"jsonrpc": "2.0", "id": request_id} | reply).encode()])


class Clients(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.endpoints = (f"ipc://{folder.name}/control{number}" for number in itertools.count())

    def both(self, use, *replies, bound=None):
        """Results of use(client) with the blocking client and, awaited, with the asyncio client; `requests` holds what they sent."""
        endpoint = next(self.endpoints)
        played = Played(bound or endpoint, replies * 2)
        with Client(endpoint, 20.0) as client:
            outcomes = [self.outcome(lambda: use(client))]

        async def awaited():
            async with AsyncClient(endpoint, 20.0) as later:
                return await use(later)

        outcomes.append(self.outcome(lambda: asyncio.run(awaited())))
        played.join(20.0)
        self.assertFalse(played.is_alive(), "requests are missing")
        self.requests = played.requests
        return outcomes

    @staticmethod
    def outcome(act):
        try:
            return act()
        except ClientError as error:
            return error

    def test_a_result(self):
        outcomes = self.both(lambda client: client.camera_set(gain_db=np.float32(6.0), roi={"x": np.int64(8)}), {"result": {"applied": 1}})
        self.assertEqual(outcomes, [{"applied": 1}] * 2)
        self.assertEqual([(r["method"], r["params"]) for r in self.requests], [("camera.set", {"gain_db": 6.0, "roi": {"x": 8}})] * 2)

    def test_an_answer_over_ipv6_or_from_a_host_name(self):
        if not HAS_IPV6:
            self.skipTest("this machine has no IPv6")
        for bound, reached in (("[::1]", "[::1]"), ("[::]", "[::1]"), ("127.0.0.1", "localhost")):
            with self.subTest(bound), free_port() as port:
                self.endpoints = itertools.repeat(f"tcp://{reached}:{port}")
                self.assertEqual(self.both(lambda client: client.call("system.status"), {"result": "answer"}, bound=f"tcp://{bound}:{port}"), ["answer"] * 2)

    def test_an_error_says_what_and_what_to_do(self):
        for error in self.both(lambda client: client.camera_set(gain_db=1000), {"error": OUT_OF_RANGE}):
            self.assertIsInstance(error, Refused)
            self.assertEqual((error.code, error.field, error.limits, error.nearest), (-32602, "gain_db", (-100.0, 100.0), None))
            self.assertEqual((error.reason, error.what_to_do), (OUT_OF_RANGE["data"]["reason"], "fix it; see `field`"))
            self.assertEqual(str(error), f"camera.set: {OUT_OF_RANGE['message']}")
        for error in self.both(lambda client: client.call("camera.set", {"exposure_su": 1}), {"error": UNKNOWN}):
            self.assertEqual((error.field, error.limits, error.nearest), ("exposure_su", None, "exposure_us"))

    def test_a_job_that_is_done_failed_or_cancelled(self):
        failed = {"code": -32000, "message": "camera.exposure_us: too bright",
                  "data": {"field": "camera.exposure_us", "reason": "too bright"}}
        done = self.both(lambda client: client.wait_for_job({"job": 3}), {"result": job("running")}, {"result": job("done")})
        self.assertEqual(done, [{"frames": 9}] * 2)
        for error in self.both(lambda client: client.wait_for_job(3), {"result": job("failed", failed)}):
            self.assertIsInstance(error, JobFailed)
            self.assertEqual((error.state, error.code, error.field, error.reason), ("failed", -32000, "camera.exposure_us", "too bright"))
        for error in self.both(lambda client: client.wait_for_job(3), {"result": job("cancelled")}):
            self.assertEqual((error.state, error.reason), ("cancelled", "it was cancelled"))

    def test_a_job_that_does_not_end(self):
        Played(endpoint := next(self.endpoints), [{"result": job("running")}] * 1000)
        with Client(endpoint, 20.0) as client, self.assertRaisesRegex(NoAnswer, "job 3 .*not ended within 0.2 s"):
            client.wait_for_job(3, timeout_s=0.2)

        async def main():
            async with AsyncClient(endpoint, 20.0) as later:
                with self.assertRaisesRegex(NoAnswer, "job 3 .*not ended within 0.2 s"):
                    await later.wait_for_job(3, timeout_s=0.2)

        asyncio.run(main())

    def test_an_answer_about_a_job_that_is_lost_is_asked_for_again(self):
        def answers(waiting):  # of four requests, only the last; of more if a busy machine is late with that
            return waiting[-1:]

        replies = [{"result": job("done")}] * 40
        Played(endpoint := next(self.endpoints), replies, together=4, order=answers)
        with Client(endpoint, 0.2) as client:
            self.assertEqual(client.wait_for_job(3, timeout_s=20.0), {"frames": 9})

        async def main(endpoint):
            Played(endpoint, replies, together=4, order=answers)
            async with AsyncClient(endpoint, 0.2) as later:
                self.assertEqual(await later.wait_for_job(3, timeout_s=20.0), {"frames": 9})
            silent = AsyncClient(next(self.endpoints), timeout_s=20.0)
            waiting = asyncio.create_task(silent.wait_for_job(3))
            await asyncio.sleep(0.05)
            silent.close()
            with self.assertRaisesRegex(NoAnswer, "closed"):
                await waiting

        asyncio.run(main(next(self.endpoints)))

    def test_nobody_answers(self):
        words = "within 0.1 s; does the daemon run, and does it require a key"
        with Client(next(self.endpoints), timeout_s=0.1) as client, self.assertRaisesRegex(NoAnswer, words):
            client.system_status()

        async def main():
            async with AsyncClient(next(self.endpoints), timeout_s=0.1) as later:
                with self.assertRaisesRegex(NoAnswer, words):
                    await later.system_status()

        asyncio.run(main())

    def test_a_late_reply_is_not_taken_for_the_next_one(self):
        Played(endpoint := next(self.endpoints), [{"result": "first"}, {"result": "second"}], together=2)
        with Client(endpoint, timeout_s=0.1) as client:
            with self.assertRaises(NoAnswer):
                client.call("first")
            client.timeout_s = 20.0
            self.assertEqual(client.call("second"), "second")

    def test_calls_at_once_are_answered_in_any_order(self):
        Played(endpoint := next(self.endpoints), [{"result": number} for number in range(8)], together=4, order=reversed)

        async def main():
            async with AsyncClient(endpoint, timeout_s=20.0) as client:
                return [await asyncio.gather(*(client.call(f"m{number}") for number in range(4))) for _ in range(2)]

        self.assertEqual(asyncio.run(main()), [[0, 1, 2, 3], [4, 5, 6, 7]])

    def test_who_waits_when_the_client_is_closed_gets_an_error(self):
        async def main():
            client = AsyncClient(next(self.endpoints), timeout_s=20.0)
            waiting = asyncio.create_task(client.system_status())
            await asyncio.sleep(0)
            client.close()
            with self.assertRaisesRegex(NoAnswer, "closed"):
                await waiting

        asyncio.run(main())

    def test_what_json_does_not_know_is_not_sent(self):
        with Client(next(self.endpoints)) as client:
            for wrong, error in ((float("nan"), ValueError), (np.float64("inf"), ValueError), (object(), TypeError)):
                with self.assertRaisesRegex(error, r"^camera.set: gain_db: .* cannot be sent: "):
                    client.camera_set(gain_db=wrong)
            for waves in ({"defocus": float("nan")}, [float("nan")], np.array([np.nan])):
                with self.assertRaisesRegex(ValueError, r"^aberration.set: modes\[0\].waves: nan cannot be sent: "):
                    client.aberration_set(waves)
            circle = []
            circle.append(circle)
            with self.assertRaisesRegex(ValueError, "^m: .* cannot be sent: Circular"):
                client.call("m", {"a": circle})

    def test_errors_cross_to_another_process_whole(self):
        errors = [Refused("camera.set", OUT_OF_RANGE), JobFailed(job("failed", OUT_OF_RANGE)), JobFailed(job("cancelled")), NoAnswer("no answer"),
                  ClientError("text", 7, {"field": "x"})]
        for error in errors:
            for other in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
                self.assertEqual((type(other), str(other), other.args, vars(other)), (type(error), str(error), error.args, vars(error)))
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            for how, kind in (("refused", Refused), ("failed", JobFailed)):
                with self.assertRaises(kind) as caught:
                    pool.apply_async(refuse, (how,)).get(timeout=60.0)
                self.assertEqual((caught.exception.field, caught.exception.limits), ("gain_db", (-100.0, 100.0)))

    def test_a_fork_is_told_that_the_client_is_not_its_own(self):
        Played(endpoint := next(self.endpoints), [{"result": number} for number in range(4)])
        with Client(endpoint, 20.0) as client:
            self.assertEqual(client.call("first"), 0)
            words = f"^ClientError: this client belongs to process {os.getpid()}, .* after the fork"
            self.assertRegex(in_a_fork(lambda: client.call("again")), words)
            self.assertEqual(in_a_fork(client.close), "None")
            self.assertEqual(in_a_fork(lambda: own(endpoint)), "1", "one made after the fork")
            self.assertEqual(client.call("second"), 2, "that of the parent goes on")

        async def main():
            async with AsyncClient(endpoint, 20.0) as later:
                await later.call("third")
                return in_a_fork(lambda: asyncio.new_event_loop().run_until_complete(later.call("again")))

        self.assertRegex(asyncio.run(main()), words)

    def test_threads_share_a_client(self):
        Played(endpoint := next(self.endpoints), [{"result": 1}] * 80)
        with Client(endpoint, 20.0) as client, ThreadPoolExecutor(4) as pool:
            self.assertEqual(list(pool.map(lambda _: client.call("m"), range(80))), [1] * 80)

    def test_a_call_waits_no_longer_than_its_time_out_for_that_of_another_thread(self):
        with Client(next(self.endpoints), 0.1) as client, client._guard.use():
            with ThreadPoolExecutor(1) as pool, self.assertRaisesRegex(NoAnswer, "another thread uses this client for longer than 0.1 s"):
                pool.submit(client.call, "m").result(60.0)

    def within_a_call(self, client, use):
        """Outcome of use() in a handler that interrupts a call of `client`."""
        outcomes = []
        reply = client.exchange(b'{"id": 7}', lambda reply: not outcomes.append(self.outcome(use)))
        self.assertEqual(reply["result"], 1)
        return outcomes[0]

    def test_a_handler_that_interrupts_a_call_may_close_the_client_and_is_refused_another_call(self):
        Played(endpoint := next(self.endpoints), [{"result": 1}] * 2)
        with Client(endpoint, 20.0) as client:
            self.assertRegex(str(self.within_a_call(client, lambda: client.call("m"))), "this thread is within another call of this client")
            self.assertIsNone(self.within_a_call(client, client.close))
            self.assertTrue(client._socket.closed)
            with self.assertRaisesRegex(ClientError, "this client is closed"):
                client.call("m")

    def test_a_handler_may_close_the_connection_of_a_bridge(self):
        link = Link(endpoint=next(self.endpoints), timeout_s=0.1)
        with link.client() as client:
            link.close()
            with self.assertRaisesRegex(ClientError, "this client is closed"):
                client.call("m")

    def test_an_event_loop_may_follow_another_one(self):
        Played(endpoint := next(self.endpoints), [{"result": number} for number in range(4)])
        client = AsyncClient(endpoint, 20.0)
        self.assertEqual([asyncio.run(client.call("m")) for _ in range(3)], [0, 1, 2])

        async def inside():
            with ThreadPoolExecutor(1) as pool:
                self.assertEqual(await client.call("m"), 3)
                with self.assertRaisesRegex(ClientError, "another event loop uses this client"):
                    await asyncio.get_running_loop().run_in_executor(pool, asyncio.run, client.call("m"))

        asyncio.run(inside())
        client.close()
        with self.assertRaisesRegex(ClientError, "closed"):
            asyncio.run(client.call("m"))

    def test_what_is_no_endpoint_is_refused_with_the_reason(self):
        for kind in (Client, AsyncClient):
            for endpoint, words in (("127.0.0.1:7702", "scheme tcp:// is missing: give tcp://127.0.0.1:7702"), ("tcp://127.0.0.1", "form tcp://HOST:PORT"),
                                    ("http://127.0.0.1:7702", "form tcp://HOST:PORT"), (7702, "form tcp://HOST:PORT")):
                with self.assertRaisesRegex(ClientError, words):
                    kind(endpoint)
        client = Client(next(self.endpoints))
        client.close()
        client.close()
        with self.assertRaisesRegex(ClientError, "this client is closed"):
            client.call("m")

    def test_the_connection_of_a_bridge_refuses_a_fork_and_a_wrong_endpoint(self):
        with self.assertRaisesRegex(ClientError, "scheme tcp:// is missing"):
            Link(endpoint="127.0.0.1:7702")
        link = Link(endpoint=next(self.endpoints))
        self.addCleanup(link.close)
        for use in (lambda: link.newest(Status), lambda: link.client().__enter__(), lambda: link.wait_until_connected(0.0)):
            self.assertRegex(in_a_fork(use), "^ClientError: this connection of a bridge belongs to process")
        self.assertEqual(in_a_fork(link.close), "None")

    def test_a_bridge_that_waits_for_a_frame_goes_on_with_other_calls(self):
        exposure = {"result": {"settings": {"exposure_us": 500.0, "frame_rate_hz": 50.0}}}
        grab = queue.Queue()

        def serve():  # all but camera.grab, which waits for the second camera.get
            seen = []
            while seen.count("camera.get") < 2:
                peer, text = server.recv_multipart()
                request = json.loads(text)
                seen.append(request["method"])
                if seen[-1] == "camera.grab":
                    grab.put((peer, request["id"]))
                elif seen[-1] == "camera.get":
                    server.send_multipart([peer, json.dumps({"id": request["id"]} | exposure).encode()])

        with zmq.Context.instance().socket(zmq.ROUTER) as server:
            server.bind(endpoint := next(self.endpoints))
            serving = threading.Thread(target=serve, daemon=True)
            serving.start()
            sensor = WavefrontSensor(endpoint=endpoint)
            self.addCleanup(sensor.close)
            taken = sensor.trigger()
            peer, request_id = grab.get(timeout=60.0)
            self.assertEqual((sensor.exposure_us.position, taken.done), (500.0, False))
            serving.join(60.0)
            server.send_multipart([peer, json.dumps({"id": request_id, "error": OUT_OF_RANGE}).encode()])
            self.assertIsInstance(taken.exception(60.0), Refused)

    def test_a_wrong_key_file_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "key.json")
            for text in (None, "{", "[]", '{"server_key": "x"}', '{"server_key": "x", "public_key": "short", "secret_key": "short"}'):
                if text is not None:
                    file.write_text(text)
                with self.assertRaisesRegex(ClientError, "key.json.*ovws keygen"):
                    Client(key=file, server_key="x" * 40)

    def test_numbers_of_numpy_are_numbers(self):
        waits = np.float32(20.0)
        done = self.both(lambda client: client.wait_for_job(np.int64(3), timeout_s=waits), {"result": job("done")})
        self.assertEqual(done, [{"frames": 9}] * 2)
        self.assertEqual([r["params"] for r in self.requests], [{"job": 3}] * 2)
        for job_number in (4.5, "3", None, -1):
            for wait in (Client.wait_for_job, lambda client, job_number: asyncio.run(AsyncClient.wait_for_job(client, job_number))):
                with self.assertRaisesRegex(ValueError, "^job: must be a whole number"):
                    wait(None, job_number)
        for timeout_s in (np.float32(0.5), np.int64(2), np.bool_(True), np.array(1.5), 2):
            self.assertEqual(daemon_waits_s("camera.grab", {"timeout_s": timeout_s}), float(timeout_s))
            Client(next(self.endpoints), timeout_s).close()
        self.assertEqual((daemon_waits_s("camera.grab", {"frames": 8}), daemon_waits_s("camera.get", None)), (10.0, 0.0), "the daemon's default")
        self.assertEqual(json.loads(request_text(1, "m", {"on": np.bool_(True), "n": np.int64(3)}))["params"], {"on": True, "n": 3})
        for timeout_s in (-1.0, math.nan, "5", None):
            for kind in (Client, AsyncClient):
                with self.assertRaisesRegex(ValueError, "^timeout_s: must be a number"):
                    kind(next(self.endpoints), timeout_s)

    def test_the_codes_are_those_of_the_document(self):
        rows = re.findall(r"^\| (-32\d+) \| (.*) \| (.*) \|$", (ROOT / "proto" / "WIRE.md").read_text(), re.M)
        self.assertEqual({int(code): (meaning, to_do) for code, meaning, to_do in rows}, CODES)


if __name__ == "__main__":
    unittest.main()
