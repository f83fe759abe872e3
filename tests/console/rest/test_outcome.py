"""Waiting over REST for what becomes of a desire, on the console really served."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any

import httpx
import pytest
from fastapi import FastAPI, Request

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.console.rest.outcome_waits import OutcomeWaits
from app.messages import Accomplishment, Desire, DesireReport, Desires
from app.program.system import System
from tests.console.answers import answered, described, is_problem
from tests.console.program import NEW, served
from tests.console.raw import connected, request
from tests.patience import PATIENCE_S


class Watch:
    """Who waits in ``workspace``: :attr:`arrived` counts requests that wait, :attr:`ended` those that do no more."""

    def __init__(self, workspace: IntentionWorkspace, monkeypatch: pytest.MonkeyPatch) -> None:
        self.arrived, self.ended = asyncio.Semaphore(0), asyncio.Semaphore(0)
        observe = workspace.observe

        def watched(callback: Callable[[Any], None]) -> Callable[[], None]:
            stop = observe(callback)
            self.arrived.release()

            def stopped() -> None:
                stop()
                self.ended.release()

            return stopped

        monkeypatch.setattr(workspace, "observe", watched)


@pytest.fixture
def watch(system: System, monkeypatch: pytest.MonkeyPatch, url: str) -> Watch:
    return Watch(system.workspace, monkeypatch)


@pytest.fixture
async def rest(url: str) -> AsyncIterator[httpx.AsyncClient]:
    async with httpx.AsyncClient(base_url=f"{url}/api/v1", timeout=PATIENCE_S) as client:
        yield client


async def desired(rest: httpx.AsyncClient) -> Desire:
    return answered(await rest.post("/desires", json=NEW), Desire)


def accomplished(system: System, desire: Desire, reason: str = "there") -> None:
    system.workspace.accomplish(Accomplishment(system.clock.now(), desire.id, "Drive", "done", reason))


async def test_a_request_waits_until_a_behavior_reports(rest: httpx.AsyncClient, system: System, watch: Watch) -> None:
    desire = await desired(rest)
    waiting = [asyncio.create_task(rest.get(f"/desires/{desire.id}", params={"wait": 60})) for _ in range(2)]
    for _ in waiting:
        await watch.arrived.acquire()
    accomplished(system, desire)
    for answer in await asyncio.gather(*waiting):
        report = answered(answer, DesireReport)
        described(answer, DesireReport)
        assert (report.id, report.outcome, report.behavior, report.reason) == (desire.id, "done", "Drive", "there")
        assert report.ended is None, "a class that is maintained"
    described(await rest.get("/desires"), Desires)
    assert (await rest.get("/desires")).json()["accomplishments"][0]["desire_id"] == desire.id


async def test_it_ends_with_the_desire_which_is_known_for_a_while(
    rest: httpx.AsyncClient, system: System, watch: Watch
) -> None:
    desire = await desired(rest)
    waiting = asyncio.create_task(rest.get(f"/desires/{desire.id}?wait=60"))
    await watch.arrived.acquire()
    assert (await rest.delete(f"/desires/{desire.id}")).status_code == 204
    report = answered(await waiting, DesireReport)
    assert report.outcome == "withdrawn"
    assert report.ended is not None
    assert answered(await rest.get(f"/desires/{desire.id}?wait=60"), DesireReport) == report, "at once"
    (ended,) = answered(await rest.get("/desires"), Desires).ended
    assert ended == report
    is_problem(await rest.delete(f"/desires/{desire.id}"), 404, "no-such-desire")


async def test_it_is_answered_without_an_outcome_when_its_time_is_over(rest: httpx.AsyncClient) -> None:
    desire = await desired(rest)
    for wait in ({}, {"wait": 0}, {"wait": 0.01}):
        report = answered(await rest.get(f"/desires/{desire.id}", params=wait), DesireReport)
        assert (report.outcome, report.ended, report.expires) == (None, None, desire.expires)


async def test_what_was_never_desired_is_no_wait(rest: httpx.AsyncClient) -> None:
    problem = is_problem(await rest.get("/desires/d-0?wait=60"), 404, "no-such-desire")
    assert problem["detail"] == "no desire has the id 'd-0': it may have ended"


@pytest.mark.parametrize(
    ("wait", "message", "kind", "values"),
    [
        ("61", "should be less than or equal to 60, not '61'", "less_than_equal", {"le": 60}),
        ("-1", "should be greater than or equal to 0, not '-1'", "greater_than_equal", {"ge": 0}),
        ("nan", "should be a finite number, not 'nan'", "finite_number", {}),
        ("soon", "should be a valid number, unable to parse string as a number, not 'soon'", "float_parsing", {}),
    ],
)
async def test_a_wait_that_is_not_allowed_is_refused(
    rest: httpx.AsyncClient, wait: str, message: str, kind: str, values: dict[str, float]
) -> None:
    desire = await desired(rest)
    problem = is_problem(await rest.get(f"/desires/{desire.id}?wait={wait}"), 422, "invalid-request")
    given = {**values, "given": repr(wait)}
    assert problem["errors"] == [{"field": "query.wait", "message": message, "kind": kind, "values": given}]


async def test_a_client_that_goes_waits_no_more(rest: httpx.AsyncClient, url: str, watch: Watch) -> None:
    desire = await desired(rest)
    async with connected(url) as raw:
        await raw.send(request(f"GET /api/v1/desires/{desire.id}?wait=60"))
        await watch.arrived.acquire()
    await watch.ended.acquire()


async def test_a_request_that_waits_does_not_keep_the_console_up(
    app: FastAPI, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S) as client:
        async with served(app) as url:
            watch = Watch(system.workspace, monkeypatch)
            desire = answered(await client.post(f"{url}/api/v1/desires", json=NEW), Desire)
            waiting = asyncio.create_task(client.get(f"{url}/api/v1/desires/{desire.id}?wait=60"))
            await watch.arrived.acquire()
        with pytest.raises(httpx.TransportError):
            await waiting


async def test_of_too_many_that_wait_the_first_is_answered_at_once(system: System) -> None:
    async def never() -> Any:
        await asyncio.Event().wait()

    client = Request({"type": "http"}, never)
    waits = OutcomeWaits(system.workspace, most=2)
    desire = system.workspace.add("Telepresence", intensity=1, utility=1, source=Source("rest", "rest"))
    first, second, third = (asyncio.create_task(waits.report(desire.id, 60, client)) for _ in range(3))
    report = await first
    assert report.outcome is None
    assert not second.done()
    assert len(waits) == 2
    system.workspace.remove(desire.id)
    assert [(await each).outcome for each in (second, third)] == ["withdrawn", "withdrawn"]
    assert len(waits) == 0
    with pytest.raises(UnknownDesire):
        await waits.report("d-0", 60, client)
