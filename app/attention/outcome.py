"""Waiting for what becomes of a desire."""

from __future__ import annotations

import asyncio

from app.attention.workspace import IntentionWorkspace, UnknownDesire, WorkspaceChange
from app.messages import DesireReport


async def outcome_of(workspace: IntentionWorkspace, desire_id: str) -> DesireReport:
    """Wait until a behavior has reported on a desire, or the desire has left.

    Returns at once where that was so before. Raises UnknownDesire.
    """
    report = workspace.report(desire_id)
    if report.outcome is not None:
        return report
    outcome: asyncio.Future[DesireReport] = asyncio.get_running_loop().create_future()

    def look(_: WorkspaceChange) -> None:
        if outcome.done():
            return
        try:
            now = workspace.report(desire_id)
        except UnknownDesire as failure:
            outcome.set_exception(failure)
            return
        if now.outcome is not None:
            outcome.set_result(now)

    stop = workspace.observe(look)
    try:
        return await outcome
    finally:
        stop()
