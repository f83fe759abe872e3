"""The tour under way over REST: started, steered, reported; and every refusal."""

from __future__ import annotations

import asyncio
import csv
import io
from dataclasses import replace
from typing import Any

import httpx
import pytest

from app.console.records.tours import RunReportList, TourRunReport
from app.messages import TourFailure
from app.program.system import System
from app.tours.run_report import COLUMNS, RunReport, StopReport
from tests.console.answers import answered, is_problem
from tests.console.places import FakeMapServer, grid
from tests.tours.tours import ARM, tour_data

#: A tour that asks visitors, and waits long for their answer.
CONFIRM = {"ask": {"en": "Shall I?", "fr": "Puis-je ?"}, "agree": {"en": ["yes"]}, "at_most_s": 120}
TOUR = tour_data(id="new-tour", languages=["en", "fr"], greeting={"confirm": CONFIRM}, stops=[ARM | {"do": []}])
REPORT = RunReport(
    "20261123-080000-lab-tour",
    "lab-tour",
    {"en": "The lab"},
    "en",
    began=1795000000.0,
    ended=1795000300.5,
    outcome="the tour is over",
    people_most=3,
    stops=(StopReport("arm", 1795000010.0, 1795000030.0, 1795000090.0, presented=True, people=3, questions={"q": 2}),),
    failures=(TourFailure("arm", "not reached"),),
)


@pytest.fixture
async def there(client: httpx.AsyncClient, system: System) -> None:
    """All that the tour needs: its map is in use, with its place."""
    server = FakeMapServer(system.maps)
    system.map.attach(server)
    await system.map.resume("", same=False)
    system.graph.channel("map").publish(grid(system.clock.now()))
    await system.map.server.save("lab")
    made = await client.post(
        "/places", json={"id": "robotics-lab", "name": "Lab", "pose": {"x": 0, "y": -1, "heading": 0}}
    )
    assert made.status_code == 201, made.text
    assert (await client.post("/tours", json=TOUR)).status_code == 201


async def press(client: httpx.AsyncClient, **what: Any) -> httpx.Response:
    return await client.post("/tour-run/press", json=what)


async def test_a_tour_is_begun_and_steered(client: httpx.AsyncClient, there: None) -> None:
    started = answered(await client.post("/tours/new-tour/run", json={"language": "fr"}), TourRunReport)
    assert (started.progress.tour, started.progress.state, started.progress.language) == (
        "new-tour",
        "confirming",
        "fr",
    )
    assert started.progress.text == CONFIRM["ask"]
    assert started.progress.buttons == ("agree", "decline", "pause", "end")
    assert started.report is not None
    assert (started.report.run, started.report.ended) == (started.progress.run, None)
    is_problem(await client.post("/tours/new-tour/run", json={}), 409, "tour-refused")

    paused = answered(await press(client, button="pause"), TourRunReport).progress
    assert (paused.state, paused.buttons) == ("paused", ("resume", "end"))
    assert paused.question is not None
    assert paused.question.answers == ("resume", "end")
    refused = is_problem(await press(client, button="next"), 409, "tour-refused")
    assert refused["detail"] == "Next does nothing while the tour is paused; now there are: resume, end."
    assert answered(await press(client, button="resume"), TourRunReport).progress.state == "confirming"

    is_problem(await press(client, stop="arm"), 409, "tour-refused")
    is_problem(await press(client, ask="why"), 409, "tour-refused")
    is_problem(await client.delete("/tour-run"), 409, "tour-refused")
    over = answered(await press(client, button="decline"), TourRunReport)
    assert (over.progress.state, over.progress.reason) == ("idle", "visitors declined")
    assert over.report is not None
    assert over.report.outcome == "visitors declined"
    assert (await client.delete("/tour-run")).status_code == 204
    assert answered(await client.get("/tour-run"), TourRunReport).progress.tour == ""
    is_problem(await press(client, button="pause"), 409, "tour-refused")


async def test_a_tour_that_waits_for_visitors(client: httpx.AsyncClient, there: None) -> None:
    waits = answered(await client.post("/tours/new-tour/run", json={"begin": "visitors"}), TourRunReport).progress
    assert (waits.state, waits.waits, waits.buttons) == ("idle", True, ("start",))
    assert answered(await press(client, button="start"), TourRunReport).progress.state == "confirming"


async def test_a_tour_that_lacks_something_does_not_begin(client: httpx.AsyncClient, there: None) -> None:
    await client.patch("/tours/new-tour", json={"home": "dock"})
    refused = is_problem(await client.post("/tours/new-tour/run", json={}), 409, "tour-incomplete")
    assert refused["errors"][0]["field"] == "home"
    is_problem(await client.post("/tours/other/run", json={}), 404, "no-such-tour")
    is_problem(await client.post("/tours/new-tour/run", json={"begin": "soon"}), 422, "invalid-request")


@pytest.mark.parametrize("body", [{}, {"button": "pause", "stop": "arm"}, {"button": "jump"}, {"stop": "A"}])
async def test_a_press_is_one_thing(client: httpx.AsyncClient, body: dict[str, str]) -> None:
    is_problem(await press(client, **body), 422, "invalid-request")


async def test_reports_are_listed_exported_and_deleted(client: httpx.AsyncClient, system: System) -> None:
    other = replace(REPORT, run="20261123-090000-other", tour="other", stops=())
    for report in (REPORT, other):
        await asyncio.to_thread(system.runs.add, report)
    assert answered(await client.get("/tour-reports"), RunReportList).reports == (other, REPORT)
    assert answered(await client.get("/tour-reports?tour=lab-tour"), RunReportList).reports == (REPORT,)
    assert answered(await client.get(f"/tour-reports/{REPORT.run}"), RunReport) == REPORT
    exported = await client.get("/tour-reports.csv?tour=lab-tour")
    assert exported.headers["content-type"].startswith("text/csv")
    head, row = csv.reader(io.StringIO(exported.text))
    assert tuple(head) == COLUMNS
    found = dict(zip(head, row, strict=True))
    assert (found["stop"], found["questions"], found["failures"]) == ("arm", "q=2", "not reached")
    assert (found["began"], found["people_most"]) == ("2026-11-18T11:06:40+00:00", "3")
    assert (await client.delete(f"/tour-reports/{REPORT.run}")).status_code == 204
    is_problem(await client.delete(f"/tour-reports/{REPORT.run}"), 404, "no-such-run")
    is_problem(await client.get("/tour-reports/.hidden"), 422, "invalid-name")


async def test_cancelling_the_goal_pauses_a_tour_on_its_way(client: httpx.AsyncClient, there: None) -> None:
    await client.post("/tours/new-tour/run", json={})
    assert (await client.delete("/goal")).status_code == 204
    assert answered(await client.get("/tour-run"), TourRunReport).progress.state == "confirming", "it is not"
    agreed = answered(await press(client, button="agree"), TourRunReport).progress
    assert agreed.state in ("leading", "lost"), "without a pose"
    assert (await client.delete("/goal")).status_code == 204
    assert answered(await client.get("/tour-run"), TourRunReport).progress.state == "paused"
