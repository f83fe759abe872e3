"""Requests that wait for what becomes of a desire."""

from __future__ import annotations

import asyncio
from typing import Final

from fastapi import Request

from app.attention.outcome import outcome_of
from app.attention.workspace import IntentionWorkspace
from app.messages import DesireReport

LONGEST_WAIT_S: Final = 60.0
MOST_WAITING: Final = 24
"""Of the connections that WebSockets never take, some stay for requests that do not wait, the emergency stop among
them."""


class OutcomeWaits:
    """All requests that wait, ``most`` at a time; when another comes, the one that has waited longest is answered as if
    its time were over."""

    def __init__(self, workspace: IntentionWorkspace, most: int = MOST_WAITING) -> None:
        self._workspace = workspace
        self._most = most
        #: Ends with the connection, in the order in which they came; cancelling one ends its wait.
        self._waiting: dict[asyncio.Task[None], None] = {}

    def __len__(self) -> int:
        return len(self._waiting)

    async def report(self, desire_id: str, wait_s: float, request: Request) -> DesireReport:
        """A desire and what became of it, as soon as something did, after ``wait_s``, or once the client of ``request``
        has gone. Raises UnknownDesire.
        """
        report = self._workspace.report(desire_id)
        if report.outcome is not None or wait_s == 0:
            return report
        while len(self._waiting) >= self._most:
            longest = next(iter(self._waiting))
            del self._waiting[longest]
            longest.cancel()
        gone = asyncio.create_task(_disconnected(request), name="client of a waiting request")
        outcome = asyncio.create_task(outcome_of(self._workspace, desire_id), name=f"outcome of {desire_id}")
        self._waiting[gone] = None
        try:
            await asyncio.wait({gone, outcome}, timeout=wait_s, return_when=asyncio.FIRST_COMPLETED)
            return outcome.result() if outcome.done() else self._workspace.report(desire_id)
        finally:
            self._waiting.pop(gone, None)
            gone.cancel()
            outcome.cancel()


async def _disconnected(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
