"""Who may use a socket of ZeroMQ: the process that made it, one thread at a time, and one event loop at a time."""
from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import zmq

from .errors import ClientError, NoAnswer


def connect(socket: zmq.Socket[Any], endpoint: str) -> None:
    """Connects; raises ClientError, and closes the socket, if this is no endpoint. IPv6 addresses are written in brackets: with IPV6 set, libzmq
    would resolve a name such as localhost to IPv6 only."""
    try:
        socket.ipv6 = str(endpoint).startswith("tcp://[")
        socket.connect(endpoint)
    except (zmq.ZMQError, TypeError) as error:
        socket.close()
        has_scheme = not isinstance(endpoint, str) or "://" in endpoint
        what = "it must be of the form tcp://HOST:PORT" if has_scheme else f"the scheme tcp:// is missing: give tcp://{endpoint}"
        raise ClientError(f"endpoint {endpoint!r}: {what} ({error})") from None


class Guard:
    """Refuses uses of a connection that ZeroMQ would answer with silence, or end the program for. `what`: the object, as its user knows it."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._process = os.getpid()
        self._is_closed = False
        self._is_used = False
        self._lock = threading.RLock()  # its owner is known from the start: a signal handler may interrupt any line
        self._to_close: zmq.Socket[Any] | None = None  # at the end of the use
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def is_fork(self) -> bool:
        """Whether this is another process than that which made the object."""
        return os.getpid() != self._process

    def check(self) -> None:
        """Raises ClientError in a fork of the process, and after the connection was closed."""
        if self.is_fork:
            raise ClientError(f"this {self._what} belongs to process {self._process}, and its connection does not work in the fork {os.getpid()}: "
                              f"make another {self._what} after the fork, in each worker")
        if self._is_closed:
            raise ClientError(f"this {self._what} is closed: make another one")

    @contextmanager
    def use(self, wait_s: float = 0.0) -> Iterator[None]:
        """The connection is this thread's during the block. Raises ClientError if another thread uses it; with `wait_s`, waits so many seconds
        for the end of that use, and then raises NoAnswer. Raises ClientError in a signal handler that interrupts a use of the same thread."""
        self.check()
        with self._locked(wait_s):
            if self._is_used:
                raise ClientError(f"this thread is within another call of this {self._what}: wait for its end, or make another {self._what}")
            try:
                self._is_used = True
                self.check()  # the other thread may have closed it
                yield
            finally:
                self._is_used = False
                if self._to_close is not None:
                    self._to_close.close()

    @contextmanager
    def _locked(self, wait_s: float) -> Iterator[None]:
        """Keeps other threads out; waits as `use`. Does not keep out this thread."""
        if not self._lock.acquire(timeout=min(wait_s, threading.TIMEOUT_MAX)):
            text = f"another thread uses this {self._what}"
            raise NoAnswer(f"{text} for longer than {wait_s:g} s") if wait_s > 0.0 else ClientError(f"{text}: make one for each thread")
        try:
            yield
        finally:
            self._lock.release()

    def enter_loop(self) -> bool:
        """Checks the connection and assigns it to the running event loop. Returns whether it belonged to another loop, which has ended. Raises
        ClientError if that loop still runs."""
        self.check()
        before, self._loop = self._loop, asyncio.get_running_loop()
        if before in (None, self._loop):
            return False
        if before.is_running():
            self._loop = before
            raise ClientError(f"another event loop uses this {self._what}: make one for each event loop")
        return True

    def close(self, socket: zmq.Socket[Any], wait_s: float = 0.0) -> None:
        """Closes the socket, once; in a fork it does nothing, because the socket is the other process's. Waits for another thread as `use`.
        Within a use of this thread, as in a signal handler, the socket is closed when that use ends."""
        if self._is_closed or self.is_fork:
            return
        with self._locked(wait_s):
            self._is_closed = True
            self._to_close = socket
            if not self._is_used:
                socket.close()
