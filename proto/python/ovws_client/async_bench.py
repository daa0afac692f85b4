"""What one does at a bench, for asyncio; see Bench."""
from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

from .async_subscription import AsyncSubscription
from .bench import Gathering, M, SettingsChange, as_seen_from, earliest_ns, no_image
from .measured import MeanWavefront
from .messages import Image, Wavefront
from .methods import AsyncMethods
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
        async with await self.subscribe(Image) as stream:
            earliest, end = await self._earliest_ns(), time.monotonic() + timeout_s
            exposure_us = (await self.camera_get())["settings"]["exposure_us"]
            while (image := await stream.next(max(0.0, end - time.monotonic()))) is not None:
                if image.t_arrival_ns - 1e3 * exposure_us >= earliest:
                    return image
        raise no_image(timeout_s)

    async def wavefront(self, frames: int = 50, timeout_s: float = 30.0) -> MeanWavefront:
        """Mean wavefront of the next valid frames, with standard errors, as Bench.wavefront."""
        gathering = Gathering(frames, await self._earliest_ns())
        async with await self.subscribe(Wavefront) as stream:
            end = time.monotonic() + timeout_s
            while not gathering.is_complete and (frame := await stream.next(max(0.0, end - time.monotonic()))) is not None:
                gathering.take(frame)
        return gathering.mean(timeout_s)

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

    async def _earliest_ns(self) -> float:
        return earliest_ns(await self.system_status(), await self.config_get())
