"""Blocking stream subscriptions: iterators of typed messages, with detection of lost messages."""
from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Generic, Literal, TypeVar

import zmq

from .errors import Lost, NoAnswer
from .guard import Guard, connect
from .messages import FrameMessage, Message
from .values import milliseconds, whole
from .wire import IMAGES, NUMBERS, KeyFile, key_hint, use_keys

M = TypeVar("M", bound=Message)
OnLoss = Literal["report", "raise"]
MAX_IMAGES = 10  # queued at most: each is as large as a frame


class Losses:
    """Counts lost messages by gaps in the sequence numbers of each topic."""

    def __init__(self) -> None:
        self._expected: dict[str, int] = {}
        self.messages = 0

    def before(self, topic: str, seq: int) -> int:
        """Number of messages of this topic lost just before this one; 0 before the first. A restarted daemon counts from 0 again: then the
        number lost since its start."""
        expected = self._expected.get(topic, seq)
        lost = seq - expected if seq >= expected else seq
        self._expected[topic] = seq + 1
        self.messages += lost
        return lost


class Decoder(Generic[M]):
    """Decodes multipart messages of the subscribed kinds into objects."""

    def __init__(self, kinds: Sequence[type[M]], on_loss: OnLoss) -> None:
        if not kinds:
            raise ValueError("give the kinds to subscribe to: Wavefront, Spots, Corrector, Refined, Status, Event, Image or Phase")
        self._kinds = {kind.topic.encode(): kind for kind in kinds}
        self._raises = on_loss == "raise"
        self.losses = Losses()

    def configure(self, socket: zmq.Socket[Any], endpoint: str, image_endpoint: str, queue_messages: int) -> None:
        """Subscribes and connects to the endpoints that publish these kinds."""
        queue_messages = whole("queue_messages", queue_messages)
        socket.linger = 0
        for topic in self._kinds:
            socket.subscribe(topic)
        homes = {NUMBERS: endpoint, IMAGES: image_endpoint}
        for home in sorted({kind.endpoint for kind in self._kinds.values()}):
            socket.rcvhwm = min(queue_messages, MAX_IMAGES) if home == IMAGES else queue_messages  # applies to later connections
            connect(socket, homes[home])

    def decode(self, frames: Sequence[zmq.Frame]) -> M | None:
        """The message; None if its topic merely begins with the name of a subscribed one. May raise Lost."""
        kind = self._kinds.get(frames[0].bytes)
        if kind is None:
            return None
        body = json.loads(frames[1].bytes)
        lost = self.losses.before(kind.topic, int(body["seq"]))
        message = kind.of(body, frames[2].buffer if len(frames) > 2 else None, lost)
        gap = message.gap if isinstance(message, FrameMessage) else 0
        if self._raises and (lost or gap):
            raise Lost(message, gap)
        return message


class Subscription(Generic[M]):
    """Subscription to some kinds of messages: `for frame in Subscription(Wavefront): …`. For one thread at a time, and not for a
    fork of the process.

    timeout_s: how long iterating waits for a message before it raises NoAnswer; None: forever
    on_loss: "report": losses are counted in `lost_messages` of each message and of the subscription; "raise": additionally raises Lost,
             which holds the message, also for frames that the daemon did not receive (`gap`); iterating may continue
    queue_messages: messages queued for a slow program, at most ten of images and phase maps; further ones are lost
    key, server_key: as in use_keys
    """

    def __init__(self, *kinds: type[M], endpoint: str = NUMBERS, image_endpoint: str = IMAGES, timeout_s: float | None = None,
                 on_loss: OnLoss = "report", queue_messages: int = 1000, key: KeyFile | None = None, server_key: str | None = None) -> None:
        self.timeout_s = timeout_s
        self._decoder = Decoder(kinds, on_loss)
        self._guard = Guard("subscription")
        self._socket: zmq.Socket[bytes] = zmq.Context.instance().socket(zmq.SUB)
        self._hint = key_hint(use_keys(self._socket, key, server_key))
        self._decoder.configure(self._socket, endpoint, image_endpoint, queue_messages)

    @property
    def lost_messages(self) -> int:
        """Number of messages lost so far on the way to this program."""
        return self._decoder.losses.messages

    def next(self, timeout_s: float | None = None) -> M | None:
        """The next message, or None if none came within `timeout_s` seconds (None: waits forever)."""
        wait_ms = milliseconds("timeout_s", timeout_s)
        with self._guard.use():
            while self._socket.poll(wait_ms):
                message = self._decoder.decode(self._socket.recv_multipart(copy=False))
                if message is not None:
                    return message
        return None

    def newest(self, timeout_s: float | None = None) -> M | None:
        """The newest message received, for programs slower than the stream. Skipped messages do not count as lost. Waits as `next`."""
        message = self.next(timeout_s)
        while message is not None and (later := self.next(0.0)) is not None:
            message = later
        return message

    def __iter__(self) -> Subscription[M]:
        return self

    def __next__(self) -> M:
        message = self.next(self.timeout_s)
        if message is None:
            raise NoAnswer(f"no message within {self.timeout_s} s; does the daemon run, and {self._hint}")
        return message

    def close(self) -> None:
        """Closes the connection."""
        self._guard.close(self._socket)

    def __enter__(self) -> Subscription[M]:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
