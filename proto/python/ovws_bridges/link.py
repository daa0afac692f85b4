"""Connection of a bridge to one daemon: calls from any thread, and a thread that receives the streams."""
from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import zmq

from ovws_client import Client, ClientError, Message, NoAnswer, Status, Subscription
from ovws_client.guard import Guard
from ovws_client.values import number
from ovws_client.wire import CONTROL, KeyFile

Listener = Callable[[Message | None], None]
RECONNECT_S = 2.5  # longest wait for an answer between two attempts to receive
MAX_QUEUED = 1000  # messages for one action, also while it waits for an answer of the daemon; further ones are dropped
_log = logging.getLogger("ovws_bridges")


class Link:
    """Connection to one daemon, which may start, stop and restart at any time. Thread-safe; not for a fork of the process. Raises ClientError if
    endpoint or keys are wrong.

    kinds: messages to receive, besides Status
    endpoint, timeout_s, key, server_key: as in ovws_client.Client
    silent_s: the daemon counts as lost if it sends no message for this long; it publishes its status once a second
    """

    def __init__(self, *kinds: type[Message], endpoint: str | None = None, timeout_s: float = RECONNECT_S, key: KeyFile | None = None,
                 server_key: str | None = None, silent_s: float = 3.0) -> None:
        self.endpoint = endpoint or CONTROL
        self.lost_messages = 0  # on the way to this process, since its start
        self._kinds = (Status, *kinds)
        self._arguments = {"endpoint": self.endpoint, "timeout_s": timeout_s, "key": key, "server_key": server_key}
        self._silent_s = number("silent_s", silent_s, 0.0)
        self._guard = Guard("connection of a bridge")
        self._client: Client | None = Client(**self._arguments)  # type: ignore[arg-type]
        self._calls = threading.RLock()  # a signal handler may close the connection during a call
        self._newest: dict[type[Message], Message] = {}
        self._listeners: list[Listener] = []
        self._changed = threading.Condition()
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ovws-link", daemon=True)
        self._thread.start()

    @contextmanager
    def client(self) -> Iterator[Client]:
        """The client, for this thread alone during the block. After NoAnswer its socket is replaced, so that a daemon that comes back does
        not carry out requests that their caller has given up."""
        self._guard.check()
        with self._calls:
            client = self._client = self._client or Client(**self._arguments)  # type: ignore[arg-type]
            try:
                yield client
            except NoAnswer:
                client.close()
                self._client = None
                raise

    @contextmanager
    def own_client(self) -> Iterator[Client]:
        """Another client, for calls that wait for frames: other calls go on meanwhile. Closed after the block."""
        self._guard.check()
        with Client(**self._arguments) as client:  # type: ignore[arg-type]
            yield client

    def newest(self, kind: type[Message]) -> Message | None:
        """The newest message of a kind; None if there was none since the daemon was lost."""
        self._guard.check()
        return self._newest.get(kind)

    def wait_until_connected(self, timeout_s: float) -> None:
        """Returns when the daemon sends messages; raises NoAnswer if it does not within `timeout_s` seconds."""
        self._guard.check()
        with self._changed:
            if not self._changed.wait_for(lambda: Status in self._newest, min(number("timeout_s", timeout_s, 0.0), threading.TIMEOUT_MAX)):
                raise NoAnswer(f"no status of the daemon at {self.endpoint} within {timeout_s} s; does it run?")

    def add_listener(self, listener: Listener) -> None:
        """Calls `listener` with each message in the receiving thread, and with None when the daemon is lost. It must return soon."""
        with self._changed:
            self._listeners = [*self._listeners, listener]

    def remove_listener(self, listener: Listener) -> None:
        """Ends the calls; one may still be in progress."""
        with self._changed:
            self._listeners = [other for other in self._listeners if other != listener]

    @contextmanager
    def messages(self, timeout_s: float) -> Iterator[Iterator[Message]]:
        """The messages that arrive from now on, until `timeout_s` seconds have passed: an iterator that then ends."""
        self._guard.check()
        arrived: queue.Queue[Message] = queue.Queue(MAX_QUEUED)
        end = time.monotonic() + min(number("timeout_s", timeout_s, 0.0), threading.TIMEOUT_MAX)

        def put(message: Message | None) -> None:
            if message is not None and not arrived.full():
                arrived.put(message)

        def until_the_end() -> Iterator[Message]:
            while (left := end - time.monotonic()) > 0.0:
                try:
                    yield arrived.get(timeout=left)
                except queue.Empty:
                    return

        self.add_listener(put)
        try:
            yield until_the_end()
        finally:
            self.remove_listener(put)

    def close(self) -> None:
        """Ends the thread and the connections; in a fork they are the other process's."""
        if self._guard.is_fork:
            return
        self._stopped.set()
        if threading.current_thread() is not self._thread:
            self._thread.join(5.0)  # its listener may wait for a lock of the caller
        with self._calls:
            if self._client is not None:
                self._client.close()
                self._client = None

    def _run(self) -> None:
        while not self._stopped.is_set():
            try:
                with Client(**self._arguments | {"timeout_s": RECONNECT_S}) as client, client.subscribe(*self._kinds) as stream:  # type: ignore
                    self._receive(stream)
            except Exception as error:  # whatever it is, the bridge goes on
                expected = isinstance(error, (ClientError, zmq.ZMQError))
                _log.log(logging.INFO if expected else logging.ERROR, "%s: %r; trying again", self.endpoint, error)
            if not self._stopped.wait(0.5):
                self._publish(None)

    def _receive(self, stream: Subscription[Message]) -> None:
        """Receives until the daemon is silent."""
        heard = time.monotonic()
        while not self._stopped.is_set():
            message = stream.next(0.2)
            if message is not None:
                heard = time.monotonic()
                self.lost_messages += message.lost_messages
                self._publish(message)
            elif time.monotonic() - heard > self._silent_s:
                return

    def _publish(self, message: Message | None) -> None:
        with self._changed:
            if message is None:
                if not self._newest:
                    return
                self._newest = {}
            else:
                self._newest[type(message)] = message
            listeners = self._listeners
            self._changed.notify_all()
        for listener in listeners:
            try:
                listener(message)
            except Exception:
                _log.exception("a listener failed")
