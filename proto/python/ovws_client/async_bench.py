"""What one does at a bench, for asyncio; see Bench."""
from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

from .async_subscription import AsyncSubscription
from .bench import RETRY_S, Gathering, Later, M, SettingsChange, as_seen_from, check_refusal, no_image
from .errors import Refused
from .measured import MeanWavefront
from .messages import FrameMessage, Image, Wavefront
from .methods import AsyncMethods, GrabStamp
from .values import number, whole
from .wire import KeyFile


class AsyncBench(AsyncMethods):
    """Methods of an asyncio client that need the streams, too; as those of Bench."""

    endpoint: str
    keys: dict[str, KeyFile | str | None]

    async def subscribe(self, *kinds: type[M], timeout_s: float | None = None) -> AsyncSubscription[M]:
        """A subscription to this client's daemon, with the same keys."""
        streams = (await self.config_get())["stream"]
        return AsyncSubscription(*kinds, endpoint=as_seen_from(self.endpoint, streams["endpoint"]),
                                 image_endpoint=as_seen_from(self.endpoint, streams["image_endpoint"]), timeout_s=timeout_s,
                                 key=self.keys["key"], server_key=self.keys["server_key"])  # type: ignore[arg-type]

    async def image(self, timeout_s: float = 10.0) -> Image:
        """A camera image whose exposure began after this call, as Bench.image."""
        end = time.monotonic() + number("timeout_s", timeout_s, 0.0)
        async with await self.subscribe(Image) as stream:
            later = await self.later(timeout_s, "no image")
            while (image := await stream.next(max(0.0, end - time.monotonic()))) is not None:
                if await later(image):
                    return image
        raise no_image(timeout_s)

    async def wavefront(self, frames: int = 50, timeout_s: float = 30.0) -> MeanWavefront:
        """Mean wavefront of the next valid frames, with standard errors, as Bench.wavefront."""
        frames, end = whole("frames", frames), time.monotonic() + number("timeout_s", timeout_s, 0.0)
        async with await self.subscribe(Wavefront) as stream:
            gathering, later = Gathering(frames), await self.later(timeout_s, f"0 of {frames} valid frames")
            while not gathering.is_complete and (frame := await stream.next(max(0.0, end - time.monotonic()))) is not None:
                if await later(frame):
                    gathering.take(frame)
        return gathering.mean(timeout_s)

    async def later(self, timeout_s: float, missing: str = "no frame") -> Callable[[FrameMessage | Image], Awaitable[bool]]:
        """Selects messages of frames exposed after this call, as Bench.later."""
        end = time.monotonic() + timeout_s

        async def grab() -> GrabStamp:
            while True:
                try:
                    return (await self.camera_grab(**Later.params(end - time.monotonic())))[0]["frames"][0]
                except Refused as refused:
                    check_refusal(refused, end - time.monotonic(), missing, timeout_s)
                await asyncio.sleep(RETRY_S)

        later = Later(await grab())

        async def is_later(message: FrameMessage | Image) -> bool:
            known = later.of(message)
            return later.of_doubtful(message, await grab()) if known is None else known

        return is_later

    @asynccontextmanager
    async def settings(self, **settings: Any) -> AsyncIterator[dict[str, Any]]:
        """Changes settings of the camera and of the sensor for the `async with` block and restores them after it, as Bench.settings."""
        change = SettingsChange(settings, (await self.camera_get())["settings"], await self.sensor_get())
        applied: dict[str, Any] = {}
        async with AsyncExitStack() as restore:
            for method, params, before in change.calls():
                if before:
                    restore.push_async_callback(self.call, method, before)
                applied |= (await self.call(method, params))["applied"]
            yield applied
