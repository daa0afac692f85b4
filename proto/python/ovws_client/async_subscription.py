"""Stream subscriptions for asyncio: iterators of typed messages."""
from __future__ import annotations

from typing import Generic

import zmq
import zmq.asyncio

from .errors import NoAnswer
from .guard import Guard
from .subscription import Decoder, M, OnLoss
from .values import milliseconds
from .wire import IMAGES, NUMBERS, KeyFile, key_hint, use_keys


class AsyncSubscription(Generic[M]):
    """Subscription for asyncio: `async for frame in AsyncSubscription(Wavefront): …`. Parameters as in Subscription. For one task at a
    time; an event loop may follow another one."""

    def __init__(self, *kinds: type[M], endpoint: str = NUMBERS, image_endpoint: str = IMAGES, timeout_s: float | None = None,
                 on_loss: OnLoss = "report", queue_messages: int = 1000, key: KeyFile | None = None, server_key: str | None = None) -> None:
        self.timeout_s = timeout_s
        self._decoder = Decoder(kinds, on_loss)
        self._guard = Guard("subscription")
        self._socket = zmq.asyncio.Context.instance().socket(zmq.SUB)
        self._hint = key_hint(use_keys(self._socket, key, server_key))
        self._decoder.configure(self._socket, endpoint, image_endpoint, queue_messages)

    @property
    def lost_messages(self) -> int:
        """Number of messages lost so far on the way to this program."""
        return self._decoder.losses.messages

    async def next(self, timeout_s: float | None = None) -> M | None:
        """The next message, or None if none came within `timeout_s` seconds (None: waits forever)."""
        wait_ms = milliseconds("timeout_s", timeout_s)
        self._guard.enter_loop()
        while await self._socket.poll(wait_ms):
            message = self._decoder.decode(await self._socket.recv_multipart(copy=False))
            if message is not None:
                return message
        return None

    async def newest(self, timeout_s: float | None = None) -> M | None:
        """The newest message received, for programs slower than the stream. Skipped messages do not count as lost. Waits as `next`."""
        message = await self.next(timeout_s)
        while message is not None and (later := await self.next(0.0)) is not None:
            message = later
        return message

    def __aiter__(self) -> AsyncSubscription[M]:
        return self

    async def __anext__(self) -> M:
        message = await self.next(self.timeout_s)
        if message is None:
            raise NoAnswer(f"no message within {self.timeout_s} s; does the daemon run, and {self._hint}")
        return message

    def close(self) -> None:
        """Closes the connection."""
        self._guard.close(self._socket)

    async def __aenter__(self) -> AsyncSubscription[M]:
        return self

    async def __aexit__(self, *_: object) -> None:
        self.close()
