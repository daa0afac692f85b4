"""Client of the control socket for asyncio; any number of calls may be pending at once."""
from __future__ import annotations

import asyncio
import itertools
from collections.abc import Mapping
from typing import Any

import zmq
import zmq.asyncio

from .async_bench import AsyncBench
from .errors import JobFailed, NoAnswer
from .guard import Guard, connect
from .methods import Binary, JobNumber, JobReport
from .values import number, whole
from .wire import CONTROL, KeyFile, daemon_waits_s, key_hint, reply_parts, request_text, result_of, use_keys


class AsyncClient(AsyncBench):
    """Client for asyncio, otherwise as Client. Any number of tasks of one event loop may call concurrently, and an event loop may follow
    another one. Close it with `async with` or `close`."""

    def __init__(self, endpoint: str = CONTROL, timeout_s: float = 5.0, key: KeyFile | None = None, server_key: str | None = None) -> None:
        self.timeout_s = number("timeout_s", timeout_s, 0.0)
        self.endpoint = endpoint
        self.keys = {"key": key, "server_key": server_key}
        self._ids = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[Any]] = {}
        self._reader: asyncio.Task[None] | None = None
        self._guard = Guard("client")
        self._connect()

    def _connect(self) -> None:
        self._socket = zmq.asyncio.Context.instance().socket(zmq.DEALER)
        self._socket.linger = 0
        self._hint = key_hint(use_keys(self._socket, **self.keys))  # type: ignore[arg-type]
        connect(self._socket, self.endpoint)

    def _begin(self) -> None:
        """Has replies read by the running event loop. The reader ends with its loop; the next loop has a connection of its own."""
        if self._guard.enter_loop():
            self._socket.close()
            self._connect()
            self._reader = None
        if self._reader is None or self._reader.done():
            self._reader = asyncio.create_task(self._read())

    async def call(self, method: str, params: Mapping[str, object] | None = None, binary: Binary = None) -> Any:
        """Calls a method and returns its result; raises Refused with the daemon's message."""
        return (await self.call_binary(method, params, binary))[0]

    async def call_binary(self, method: str, params: Mapping[str, object] | None = None, binary: Binary = None) -> Any:
        """The same with the binary frame of the reply: (result, bytes)."""
        request_id = next(self._ids)
        request = request_text(request_id, method, params)
        self._begin()
        self._waiting[request_id] = asyncio.get_running_loop().create_future()
        timeout_s = self.timeout_s + daemon_waits_s(method, params)
        try:
            async with asyncio.timeout(timeout_s):
                await self._socket.send_multipart([request] if binary is None else [request, binary])
                reply, pixels = await self._waiting[request_id]
        except TimeoutError:
            raise NoAnswer(f"no answer within {timeout_s} s; does the daemon run, and {self._hint}") from None
        finally:
            del self._waiting[request_id]
        return result_of(method, reply), pixels

    async def _read(self) -> None:
        while True:
            reply, pixels = reply_parts(await self._socket.recv_multipart())
            waiting = self._waiting.get(reply.get("id")) if isinstance(reply, dict) else None
            if waiting is not None and not waiting.done():
                waiting.set_result((reply, pixels))

    async def wait_for_job(self, job: int | JobNumber, timeout_s: float = 600.0) -> Any:
        """Waits for the end of a job, as Client.wait_for_job."""
        job_number = job["job"] if isinstance(job, Mapping) else whole("job", job)
        timeout_s = number("timeout_s", timeout_s, 0.0)
        try:
            async with asyncio.timeout(timeout_s):
                while (report := await self._report(job_number)) is None or report["state"] == "running":
                    await asyncio.sleep(0.05)
        except TimeoutError:
            raise NoAnswer(f"job {job_number} has not ended within {timeout_s} s") from None
        if report["state"] != "done":
            raise JobFailed(report)
        return report["result"]

    async def _report(self, job: int) -> JobReport | None:
        """State of a job, or None if the answer was lost."""
        try:
            return await self.job_get(job)
        except NoAnswer:
            if self._socket.closed:
                raise
            return None

    def close(self) -> None:
        """Closes the connection; pending calls raise NoAnswer."""
        if self._reader is not None:
            self._reader.cancel()
        for waiting in self._waiting.values():
            if not waiting.done():
                waiting.set_exception(NoAnswer("the client was closed before the answer came"))
        self._guard.close(self._socket)

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(self, *_: object) -> None:
        self.close()
