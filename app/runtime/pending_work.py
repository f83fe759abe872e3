"""Work in threads that the program waits for: who moves time by hand must let it end first."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager

#: A loop that does not say what it has left to do is quiet after so many turns, too: no chain of tasks is longer.
LONGEST_SPIN = 100


class PendingWork:
    """Counts the calls under way; for use on the event loop."""

    def __init__(self) -> None:
        #: How many there are now.
        self.under_way = 0
        self._waiting: list[asyncio.Future[None]] = []

    @contextmanager
    def one(self) -> Iterator[None]:
        """Count one more while the block runs."""
        self.under_way += 1
        try:
            yield
        finally:
            self.under_way -= 1
            if not self.under_way:
                waiting, self._waiting = self._waiting, []
                for future in waiting:
                    if not future.done():
                        future.set_result(None)

    async def quiet(self) -> None:
        """Wait until no task of the loop has anything to do but wait, and none of this is under way.

        Tasks that never wait are not waited for: after :data:`LONGEST_SPIN` turns of the loop it is quiet enough. What
        the loop has left to do is read from its private ``_ready``, which asyncio's own loops have; on a loop without,
        all those turns are taken each time.
        """
        # What is due in this turn of the loop or the next; empty, when it is asked for here, if everybody waits.
        ready = getattr(asyncio.get_running_loop(), "_ready", None)
        for _ in range(LONGEST_SPIN):
            await self.ended()
            await asyncio.sleep(0)
            if ready is not None and not ready and not self.under_way:
                return

    async def ended(self) -> None:
        """Wait until none is under way."""
        while self.under_way:
            future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self._waiting.append(future)
            await future
