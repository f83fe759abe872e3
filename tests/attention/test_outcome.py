"""Waiting for what becomes of a desire."""

from __future__ import annotations

import asyncio

import pytest

from app.attention.desires import DesireClass, DesireClasses, Source
from app.attention.ended_desires import KEPT
from app.attention.outcome import outcome_of
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import Accomplishment, DesireReport

CLASSES = DesireClasses([DesireClass("GoTo", "Go to", "", achievement=True), DesireClass("LookAt", "Look at", "")])


class Scene:
    def __init__(self) -> None:
        self.workspace = IntentionWorkspace(CLASSES, lambda: 100.0)

    def desire(self, cls: str = "GoTo") -> str:
        return self.workspace.add(cls, intensity=4, utility=1, source=Source("rest", "test")).id

    def waiting(self, desire_id: str) -> asyncio.Task[DesireReport]:
        return asyncio.create_task(outcome_of(self.workspace, desire_id))


@pytest.mark.parametrize("cls", ["GoTo", "LookAt"])
async def test_all_who_wait_are_answered_with_the_report_of_their_desire(cls: str) -> None:
    scene = Scene()
    desire, other = scene.desire(cls), scene.desire(cls)
    waiting = [scene.waiting(desire) for _ in range(3)]
    others = scene.waiting(other)
    await asyncio.sleep(0)
    scene.workspace.change(desire, intensity=5)
    scene.workspace.accomplish(Accomplishment(100.0, desire, "Drive", "done", "there"))
    for report in await asyncio.gather(*waiting):
        assert report == scene.workspace.report(desire)
        assert (report.outcome, report.reason) == ("done", "there")
    assert await outcome_of(scene.workspace, desire) == scene.workspace.report(desire), "a report of before"
    assert not others.done()
    scene.workspace.remove(other)
    assert (await others).outcome == "withdrawn"


async def test_who_waits_no_more_observes_no_more() -> None:
    scene = Scene()
    waiting = scene.waiting(scene.desire())
    await asyncio.sleep(0)
    assert scene.workspace._observers
    waiting.cancel()
    await asyncio.wait({waiting})
    assert not scene.workspace._observers


async def test_an_unknown_desire_is_an_error_at_once_and_when_it_is_no_longer_known() -> None:
    scene = Scene()
    with pytest.raises(UnknownDesire):
        await outcome_of(scene.workspace, "d-0")
    waiting = scene.waiting(scene.desire())
    await asyncio.sleep(0)
    with scene.workspace.transaction():
        for _ in range(KEPT):
            scene.desire()
    with scene.workspace.transaction():
        for desire in scene.workspace.desires():
            scene.workspace.remove(desire.id)
    with pytest.raises(UnknownDesire):
        await waiting
