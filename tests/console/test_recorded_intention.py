"""The intention on a recording: the recorded one, at the place in time that is shown."""

from __future__ import annotations

from typing import Any

import httpx
import pytest

from app.logs.log import Logged
from app.messages import IntentionReport, Reason
from tests.console.live_client import page
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_manifest, lab_messages
from tests.logs.replay.playing import Played, prepare
from tests.patience import PATIENCE_S


def intention(stamp: float, omega: float) -> IntentionReport:
    """An intention that the replay's own attention would never have."""
    return IntentionReport(
        stamp, strategies=(), fulfilled=(), omega=omega, bound=float("inf"), use={}, filters={"A.in": float("inf")},
        proven=True, solve_ms=1.0, relaxed=(), reasons={"GoTo": Reason("unfulfilled", 0.0, 1.0, 4.0, "Recorded.")},
        parameters={"A": {"x": 1}}, desires={},
    )  # fmt: skip


@pytest.fixture
def prepared() -> Any:
    """Four seconds of the lab with two intentions."""
    recorded = [Logged(BEGIN + at, "intention", intention(BEGIN + at, omega)) for at, omega in ((0.1, 111), (2.0, 222))]
    messages = sorted([*lab_messages(4.0), *recorded], key=lambda logged: logged.at)
    return prepare(MemoryLog(messages, lab_manifest()))


async def test_page_and_rest_show_the_intention_as_it_was(replay_url: str, play: Played) -> None:
    async with (
        httpx.AsyncClient(base_url=f"{replay_url}/api/v1", timeout=PATIENCE_S) as rest,
        page(replay_url) as ann,
    ):
        for position, omega in ((BEGIN + 1.0, 111), (BEGIN + 3.0, 222), (BEGIN + 1.0, 111)):
            await play.playback.seek(position)
            await ann.until("jump")
            shown = await ann.until("intention")
            assert (shown["omega"], shown["bound"], shown["filters"]) == (omega, None, {"A.in": None})
            assert shown["reasons"]["GoTo"]["text"] == "Recorded."
            assert {"type": "intention", **(await rest.get("/intention")).json()} == shown


async def test_a_page_that_comes_later_is_given_the_newest(replay_url: str, play: Played) -> None:
    await play.playback.seek(BEGIN + 3.0)
    async with page(replay_url) as ann:
        assert (await ann.until("intention"))["omega"] == 222
