"""An action in progress, as the protocol `Status` of Bluesky."""
from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Generator
from concurrent.futures import Future
from typing import Any

from ovws_client.values import number


def _seconds(timeout: float | None) -> float | None:
    return None if timeout is None else min(number("timeout", timeout), threading.TIMEOUT_MAX)


class Action:
    """Runs `work` in a thread of its own. It is a `bluesky.protocols.Status`, and can be awaited."""

    def __init__(self, work: Callable[[], None], name: str) -> None:
        self._future: Future[None] = Future()
        self._name = name
        threading.Thread(target=self._run, args=(work,), name=name, daemon=True).start()

    def _run(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException as error:
            self._future.set_exception(error)
        else:
            self._future.set_result(None)

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self._future.done()

    @property
    def success(self) -> bool:
        """Whether it has ended without an error."""
        return self.done and self._future.exception() is None

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        """Its error, or None. Waits up to `timeout` seconds for the end (None: forever); raises TimeoutError if it has not ended by then."""
        return self._future.exception(_seconds(timeout))

    def wait(self, timeout: float | None = None) -> None:
        """Waits for the end and raises its error; raises TimeoutError after `timeout` seconds."""
        self._future.result(_seconds(timeout))

    def add_callback(self, callback: Callable[[Action], None]) -> None:
        """Calls `callback` with this object at the end, or at once if it has ended."""
        self._future.add_done_callback(lambda _: callback(self))

    def __await__(self) -> Generator[Any, None, None]:
        return asyncio.wrap_future(self._future).__await__()

    def __repr__(self) -> str:
        return f"<{self._name}: {'in progress' if not self.done else 'done' if self.success else repr(self.exception())}>"
