"""Blocking client of the control socket."""
from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import zmq

from .bench import Bench
from .errors import NoAnswer
from .guard import Guard, connect
from .job import Job
from .methods import Binary, JobNumber
from .values import milliseconds, number, whole
from .wire import CONTROL, KeyFile, daemon_waits_s, key_hint, reply_parts, request_text, result_of, use_keys


class Client(Bench):
    """Blocking client of one daemon; keys as in use_keys. Thread-safe: calls of several threads follow one another. Not for a fork of the process.

    `timeout_s`: maximum time to wait for an answer, after a `timeout_s` of the request itself; also for the call of another thread to end. Errors are ClientError: NoAnswer, or Refused with the daemon's message.
    """

    def __init__(self, endpoint: str = CONTROL, timeout_s: float = 5.0, key: KeyFile | None = None, server_key: str | None = None) -> None:
        self.timeout_s = number("timeout_s", timeout_s, 0.0)
        self.endpoint = endpoint
        self.keys = {"key": key, "server_key": server_key}
        self._ids = itertools.count(1)
        self._guard = Guard("client")
        self._socket: zmq.Socket[bytes] = zmq.Context.instance().socket(zmq.DEALER)
        self._socket.linger = 0
        send_ms = milliseconds("timeout_s", timeout_s)
        self._socket.sndtimeo = -1 if send_ms is None else send_ms
        self._hint = key_hint(use_keys(self._socket, key, server_key))
        connect(self._socket, endpoint)

    def call(self, method: str, params: Mapping[str, object] | None = None, binary: Binary = None) -> Any:
        """Calls a method and returns its result; raises Refused with the daemon's message."""
        return self.call_binary(method, params, binary)[0]

    def call_binary(self, method: str, params: Mapping[str, object] | None = None, binary: Binary = None) -> Any:
        """The same with the binary frame of the reply: (result, bytes)."""
        request_id = next(self._ids)
        request = request_text(request_id, method, params)
        reply, pixels = self._exchange([request] if binary is None else [request, binary],
                                       lambda r: isinstance(r, dict) and r.get("id") == request_id, self.timeout_s + daemon_waits_s(method, params))
        return result_of(method, reply), pixels

    def exchange(self, request: bytes, is_reply: Callable[[Any], bool] = lambda reply: True) -> Any:
        """Sends raw bytes and returns the first reply that `is_reply` accepts."""
        return self._exchange([request], is_reply, self.timeout_s)[0]

    def _exchange(self, request: Sequence[bytes | bytearray | memoryview], is_reply: Callable[[Any], bool], timeout_s: float) -> tuple[Any, bytes]:
        timeout_s = number("timeout_s", timeout_s, 0.0)
        end = time.monotonic() + timeout_s
        with self._guard.use(timeout_s):
            try:
                self._socket.send_multipart(request)
            except zmq.Again:
                end = 0.0  # the queue is full: earlier requests were not taken, either
            while self._socket.poll(milliseconds("timeout_s", max(0.0, end - time.monotonic()))):
                reply, pixels = reply_parts(self._socket.recv_multipart())
                if is_reply(reply):
                    return reply, pixels
        raise NoAnswer(f"no answer within {timeout_s} s; does the daemon run, and {self._hint}")

    def wait_for_job(self, job: int | JobNumber, timeout_s: float = 600.0, progress: bool = False) -> Any:
        """Waits for the end of a job and returns its result, as Job.wait. `job`: its number, or the result of the method that started it."""
        return Job(self, job if isinstance(job, Mapping) else {"job": whole("job", job)}).wait(timeout_s, progress)

    def close(self) -> None:
        """Closes the connection, after the call of another thread. In a signal handler that interrupts a call of this thread, after that call."""
        self._guard.close(self._socket, math.inf)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
