"""Calls in threads that are under way: they must end before time is moved by a jump."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager

#: Turns of the loop after which it counts as quiet, where its ready tasks are unknown: no chain of tasks is longer.
LONGEST_SPIN = 100


class PendingWork:
    """Counts the calls under way; for use on the event loop."""

    def __init__(self) -> None:
        #: The number of calls under way.
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
        """Wait until every task of the loop waits and no call in a thread is under way.

        Tasks that never wait are not waited for: the wait ends after :data:`LONGEST_SPIN` turns of the loop. The tasks
        that are ready to run are read from the loop's private ``_ready``, which asyncio's own loops have; on another
        loop all these turns are taken each time.
        """
        # Callbacks due in this turn of the loop or the next; empty here if every task waits.
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
