"""Blocking client of the control socket."""
from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable, Mapping
from typing import Any

import zmq

from .errors import JobFailed, NoAnswer
from .methods import JobNumber, Methods
from .wire import CONTROL, KeyFile, key_hint, request_text, result_of, use_keys


class Client(Methods):
    """Blocking client of one daemon; keys as in use_keys. Not thread-safe.

    `timeout_s`: maximum time to wait for an answer. Errors are ClientError: NoAnswer, or Refused with the daemon's message.
    """

    def __init__(self, endpoint: str = CONTROL, timeout_s: float = 5.0, key: KeyFile | None = None, server_key: str | None = None) -> None:
        self.timeout_s = timeout_s
        self._ids = itertools.count(1)
        self._socket: zmq.Socket[bytes] = zmq.Context.instance().socket(zmq.DEALER)
        self._socket.linger = 0
        self._socket.sndtimeo = int(1e3 * timeout_s)
        self._hint = key_hint(use_keys(self._socket, key, server_key))
        self._socket.connect(endpoint)

    def call(self, method: str, params: Mapping[str, object] | None = None) -> Any:
        """Calls a method and returns its result; raises Refused with the daemon's message."""
        request_id = next(self._ids)
        request = request_text(request_id, method, params)
        return result_of(method, self.exchange(request, lambda r: isinstance(r, dict) and r.get("id") == request_id))

    def exchange(self, request: bytes, is_reply: Callable[[Any], bool] = lambda reply: True) -> Any:
        """Sends raw bytes and returns the first reply that `is_reply` accepts."""
        end = time.monotonic() + self.timeout_s
        try:
            self._socket.send(request)
        except zmq.Again:
            end = 0.0  # the queue is full: earlier requests were not taken, either
        while self._socket.poll(max(0, int(1e3 * (end - time.monotonic())))):
            reply = json.loads(self._socket.recv_multipart()[-1])
            if is_reply(reply):
                return reply
        raise NoAnswer(f"no answer within {self.timeout_s} s; does the daemon run, and {self._hint}")

    def wait_for_job(self, job: int | JobNumber, timeout_s: float = 600.0) -> Any:
        """Waits for the end of a job and returns its result. `job`: its number, or the result of the method that started it. Raises JobFailed
        if it failed or was cancelled, NoAnswer if it has not ended within `timeout_s` seconds (the job continues; `job_cancel` ends it)."""
        number = job if isinstance(job, int) else job["job"]
        end = time.monotonic() + timeout_s
        while (report := self.job_get(number))["state"] == "running":
            if time.monotonic() > end:
                raise NoAnswer(f"job {number} ({report['kind']}) has not ended within {timeout_s} s")
            time.sleep(0.05)
        if report["state"] != "done":
            raise JobFailed(report)
        return report["result"]

    def close(self) -> None:
        """Closes the connection."""
        self._socket.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
