"""One channel of grids to the pages: the newest is encoded off the loop, once for all, while some page wants it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from app.console.grids import known_part, looks_as
from app.console.live.messages import GridInfo
from app.console.live.protocol import picture_header
from app.console.taps import Tap
from app.console.wire import frame
from app.messages import OccupancyGrid
from app.runtime.channel import Channel
from app.runtime.clock import Clock


class GridFeed:
    """Pictures of ``kind``, each announced by a message ``info``; at most one in ``period_s`` of ``pace``.

    ``deliver`` takes each new one (frame and message); :attr:`standing` is the last.
    """

    def __init__(
        self,
        channel: Channel[OccupancyGrid],
        kind: int,
        info: str,
        period_s: float,
        pace: Clock,
        deliver: Callable[[bytes, str], None],
    ) -> None:
        self._channel = channel
        self._kind = kind
        self._info = info
        self._period_s = period_s
        self._pace = pace
        self._deliver = deliver
        self._count = self._times_cleared = 0
        self._newest: OccupancyGrid | None = None
        self._came = asyncio.Event()
        self.standing: tuple[bytes, str] | None = None
        self._tap: Tap[OccupancyGrid] | None = None
        self._working: asyncio.Task[None] | None = None

    def take(self, wanted: bool) -> None:
        """Subscribe to the grid while any viewer wants it."""
        if wanted and self._tap is None:
            self._tap = Tap(self._channel, f"console.{self._channel.name}", self._on_grid)
            self._working = asyncio.create_task(self._work(), name=f"console {self._channel.name}")
            # It may stay as it is for hours.
            if self._channel.latest is not None:
                self._on_grid(self._channel.latest)
        elif not wanted and self._tap is not None:
            self._tap.close()
            self._tap = None
            assert self._working is not None
            self._working.cancel()
            self.clear()

    def clear(self) -> None:
        """Drop the newest and the sent grid: they are of another time."""
        self._times_cleared += 1
        self._newest = self.standing = None

    def _on_grid(self, grid: OccupancyGrid) -> None:
        self._newest = grid
        self._came.set()

    async def _work(self) -> None:
        shown: OccupancyGrid | None = None
        while True:
            await self._came.wait()
            self._came.clear()
            grid, self._newest = self._newest, None
            if grid is None:
                continue
            if self.standing is None:
                shown = None
            times_cleared = self._times_cleared
            part, encoded = await asyncio.to_thread(_encoded, grid, shown)
            if encoded is None or self._times_cleared != times_cleared:
                continue
            shown = part
            self.standing = self._announced(part, encoded)
            self._deliver(*self.standing)
            await self._pace.sleep(self._period_s)

    def _announced(self, part: OccupancyGrid, encoded: bytes) -> tuple[bytes, str]:
        self._count += 1
        height, width = part.cells.shape
        x, y = part.origin
        info = GridInfo(
            seq=self._count,
            stamp=part.stamp,
            frame=part.frame,
            version=part.version,
            resolution_m=part.resolution_m,
            origin=(round(x, 6), round(y, 6)),
            width=width,
            height=height,
        )
        header = picture_header(self._kind, self._count, part.stamp, (width, height))
        return header + encoded, frame(self._info, info)


def _encoded(grid: OccupancyGrid, shown: OccupancyGrid | None) -> tuple[OccupancyGrid, bytes | None]:
    """The known part of ``grid`` and its PNG; None if it looks as what is ``shown`` already."""
    # OpenCV's first import takes 0.3 s: not on the event loop.
    from app.maps.picture import values_png

    part = known_part(grid)
    return part, None if shown is not None and looks_as(part, shown) else values_png(part)
