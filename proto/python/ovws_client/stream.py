"""Raw streams: messages as dicts."""
from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import zmq

from .guard import Guard, connect
from .values import milliseconds
from .wire import NUMBERS, KeyFile, use_keys


class Stream:
    """Subscription to topics, with messages as dicts; a binary part is under the key "binary". Keys as in use_keys."""

    def __init__(self, topics: Iterable[str], endpoint: str = NUMBERS, key: KeyFile | None = None, server_key: str | None = None) -> None:
        self._guard = Guard("stream")
        self._socket: zmq.Socket[bytes] = zmq.Context.instance().socket(zmq.SUB)
        self._socket.linger = 0
        self._socket.rcvhwm = 100000
        for topic in topics:
            self._socket.subscribe(topic)
        use_keys(self._socket, key, server_key)
        connect(self._socket, endpoint)

    def next(self, timeout_s: float = 1.0) -> dict[str, Any] | None:
        """The next message with its "topic", or None if none came within `timeout_s` seconds."""
        with self._guard.use():
            if not self._socket.poll(milliseconds("timeout_s", timeout_s)):
                return None
            topic, text, *binary = self._socket.recv_multipart()
        message: dict[str, Any] = json.loads(text)
        message["topic"] = topic.decode()
        if binary:
            message["binary"] = binary[0]
        return message

    def drain(self) -> None:
        """Discards all messages that have already arrived."""
        while self.next(0.0) is not None:
            pass

    def close(self) -> None:
        """Closes the connection."""
        self._guard.close(self._socket)
