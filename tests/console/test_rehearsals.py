"""Rehearsals in processes of their own: followed, failed, cancelled, and never left behind."""

from __future__ import annotations

import asyncio
import math
import os
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import httpx
import msgspec
import psutil
import pytest
from fastapi import FastAPI

from app.console.records.tours import RehearsalReport
from app.console.rehearsal_process import RehearsalOrder, RehearsalWord, finished
from app.console.rehearsals import NOTHING, Rehearsals, RehearsalUnderWay
from app.rehearsal.result import Rehearsal, RehearsalProblem, Subtitle
from tests.console.answers import answered, described, is_problem
from tests.patience import PATIENCE_S
from tests.tours.tours import tour_data

ORDER = RehearsalOrder("id: lab-tour", "lab.yaml", "/maps", language="en", people=2, seed=1)
FOUND = Rehearsal(
    "lab-tour",
    "en",
    outcome="the tour is over",
    duration_s=104.5,
    driven_m=12.0,
    stops=("arm",),
    states=(),
    subtitles=(Subtitle(3.0, 5.5, "Hello.", "en"),),
    path=(),
    problems=(RehearsalProblem("error", "arm", "arm: not reached", 40.0),),
)


def says(*words: RehearsalWord, then: str = "") -> tuple[str, ...]:
    """A process that takes its order, says ``words`` and does ``then``."""
    lines = "\n".join(msgspec.json.encode(word).decode() for word in words)
    return ("sh", "-c", f"cat > /dev/null\ncat <<'END'\n{lines}\nEND\n{then}")


@pytest.fixture
async def rehearsals() -> AsyncIterator[Rehearsals]:
    """None yet; none left behind."""
    rehearsals = Rehearsals()
    yield rehearsals
    await rehearsals.close()


async def test_one_is_followed_to_its_result(rehearsals: Rehearsals) -> None:
    assert rehearsals.report == NOTHING
    rehearsals.command = says(RehearsalWord(seconds=10.0, stop="arm"), RehearsalWord(result=FOUND))
    rehearsals.start("lab-tour", ORDER)
    assert rehearsals.report.state == "running"
    done = await rehearsals.wait()
    assert (done.state, done.tour, done.seconds, done.can_be_led) == ("done", "lab-tour", 104.5, False)
    assert done.result == FOUND
    await rehearsals.cancel()
    assert rehearsals.report == NOTHING


async def test_only_one_at_a_time_and_a_cancelled_one_is_gone(rehearsals: Rehearsals, tmp_path: Path) -> None:
    note = tmp_path / "pids"
    os.mkfifo(note)
    rehearsals.command = says(then=f'sleep 600 & echo "$$ $!" > {note}; wait')
    rehearsals.start("lab-tour", ORDER)
    numbers = await asyncio.to_thread(note.read_text)
    with pytest.raises(RehearsalUnderWay, match="lab-tour is being rehearsed already"):
        rehearsals.start("other", ORDER)
    processes = [psutil.Process(int(number)) for number in numbers.split()]
    await rehearsals.cancel()
    assert rehearsals.report == NOTHING
    _, alive = await asyncio.to_thread(psutil.wait_procs, processes, PATIENCE_S)
    assert alive == [], "nor what it had started"
    rehearsals.command = says(RehearsalWord(result=FOUND))
    rehearsals.start("other", ORDER)
    assert (await rehearsals.wait()).state == "done"


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        (says(RehearsalWord(problem="map: there is no map 'lab'")), "Map: there is no map 'lab'."),
        (says(then="echo 'Error: it broke' >&2; exit 3"), "Error: it broke."),
        (says(RehearsalWord(seconds=10.0, stop="arm"), then="exit 3"), "It ended with status 3 and said nothing."),
        (("/no/such/program",), "Its process cannot be started: No such file or directory."),
    ],
)
async def test_why_there_is_no_result_is_said(rehearsals: Rehearsals, command: tuple[str, ...], problem: str) -> None:
    rehearsals.command = command
    rehearsals.start("lab-tour", ORDER)
    failed = await rehearsals.wait()
    assert (failed.state, failed.problem, failed.result) == ("failed", problem, None)
    assert (failed.seconds, failed.stop) == ((10.0, "arm") if "status" in problem else (0.0, "")), "how far it came"


def test_a_sentence_that_is_said_at_the_end_ends_with_it() -> None:
    open_ = Subtitle(100.0, math.inf, "Goodbye.", "en")
    whole = finished(replace(FOUND, subtitles=(*FOUND.subtitles, open_)))
    assert [said.until_s for said in whole.subtitles] == [5.5, FOUND.duration_s]
    assert msgspec.json.decode(msgspec.json.encode(whole), type=Rehearsal) == whole


async def test_over_rest(client: httpx.AsyncClient, app: FastAPI) -> None:
    assert answered(await client.get("/tour-rehearsal"), RehearsalReport) == NOTHING
    is_problem(await client.post("/tours/none/rehearsal", json={}), 404, "no-such-tour")
    assert (await client.post("/tours", json=tour_data(id="new-tour"))).status_code == 201
    refused = is_problem(
        await client.post("/tours/new-tour/rehearsal", json={"language": "fr"}), 422, "invalid-request"
    )
    assert refused["detail"] == "The tour new-tour is not in 'fr'; there are: en."
    is_problem(await client.post("/tours/new-tour/rehearsal", json={"people": 9}), 422, "invalid-request")
    rehearsals: Rehearsals = app.state.rehearsals
    rehearsals.command = says(then="sleep 600")
    started = await client.post("/tours/new-tour/rehearsal", json={"people": 0})
    assert started.status_code == 202
    assert answered(started, RehearsalReport).tour == "new-tour"
    is_problem(await client.post("/tours/new-tour/rehearsal", json={}), 409, "rehearsal-under-way")
    assert (await client.delete("/tour-rehearsal")).status_code == 204
    assert (await client.delete("/tour-rehearsal")).status_code == 204
    rehearsals.command = says(RehearsalWord(result=FOUND))
    await client.post("/tours/new-tour/rehearsal", json={})
    assert (await rehearsals.wait()).state == "done"
    answer = await client.get("/tour-rehearsal")
    described(answer, RehearsalReport)
    assert answered(answer, RehearsalReport).result == FOUND


async def test_the_process_itself_reads_the_tour_and_says_what_is_missing(
    client: httpx.AsyncClient, app: FastAPI
) -> None:
    assert (await client.post("/tours", json=tour_data(id="new-tour"))).status_code == 201
    await client.post("/tours/new-tour/rehearsal", json={})
    rehearsals: Rehearsals = app.state.rehearsals
    failed = await rehearsals.wait()
    assert (failed.state, failed.problem) == ("failed", "Map: there is no map 'lab'; there are: none.")
