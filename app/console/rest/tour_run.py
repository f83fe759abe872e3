"""The tour that is under way: started, steered, reported; reports of those that are over."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, TypeVar

from fastapi import APIRouter, Path, Query
from fastapi.responses import Response

from app.base.named_library import NAME
from app.console.problems import Problem
from app.console.records.tours import RunReportList, TourRunReport
from app.console.rest.answers import Json, problems
from app.console.rest.routing import router as api_router
from app.console.rest.tour_answers import TourId, on_disk
from app.console.rest.tour_run_models import NewTourRun, TourPress
from app.program.recognizer import recognizer_of
from app.tours.checks import check
from app.tours.run_library import UnknownRun
from app.tours.run_report import RunReport, table
from app.tours.run_service import TourRefused, TourRunServer
from app.tours.surroundings import surroundings

if TYPE_CHECKING:
    from app.program.system import System

T = TypeVar("T")
CSV = "text/csv"
RunId = Annotated[str, Path(description="The run's id.", json_schema_extra={"pattern": f"^{NAME.pattern}$"})]


def tour_run_router(system: System) -> APIRouter:
    """Routes of ``/tour-run`` and ``/tour-reports``."""
    router = api_router("tours")
    recognizer = recognizer_of(system.config)

    @router.post(
        "/tours/{tour_id}/run",
        response_model=TourRunReport,
        summary="Begin a tour",
        responses=problems(400, 404, 409, 422),
    )
    async def start_tour(tour_id: TourId, how: NewTourRun) -> Response:
        """Now, or when visitors come. Refused while another is under way, while the robot is held, and where the tour
        lacks something that it needs (`errors` of its `problems`)."""
        server = _server()
        tour = (await on_disk(system.tours.get, tour_id)).tour

        def lacking() -> list[tuple[str, str]]:
            folders = system.tours.library.folders
            around = surroundings(
                tour, maps=system.maps, folders=folders, classes=system.classes, recognizer=recognizer
            )
            return [(each.field, each.message) for each in check(tour, around) if each.severity != "warning"]

        if errors := await on_disk(lacking):
            field, message = errors[0]
            raise Problem(409, "tour-incomplete", f"{tour_id} cannot run: {field}: {message}.", errors=errors)
        language = how.language or tour.languages[0]
        _refused(lambda: server.start_tour(tour, language=language, waits=how.begin == "visitors"))
        return _answer(server)

    @router.get("/tour-run", response_model=TourRunReport, summary="The tour under way")
    async def get_tour_run() -> Response:
        """How it goes, and what the run has been so far; of the last one after its end."""
        return _answer(_server())

    @router.post(
        "/tour-run/press",
        response_model=TourRunReport,
        summary="Steer the tour under way",
        responses=problems(400, 409, 422),
    )
    async def press_tour(press: TourPress) -> Response:
        """A `button` (`pause`, `resume`, `skip`, `undo_skip`, `repeat`, `retry`, `end`, and the visitors' `agree`,
        `decline`, `next`), a `stop` to go to, or a question that a visitor asks. What does nothing now is refused; the
        answer's `buttons` are those that do."""
        given = [name for name in ("button", "stop", "ask") if getattr(press, name) is not None]
        if len(given) != 1:
            words = "exactly one of button, stop and ask is needed"
            errors = [(name, words) for name in given or ["button"]]
            raise Problem(422, "invalid-request", f"{words[0].upper()}{words[1:]}.", errors=errors)
        server = _server()
        if press.button is not None:
            button = press.button
            _refused(lambda: server.press(button))
        elif press.stop is not None:
            stop = press.stop
            _refused(lambda: server.choose(stop))
        elif press.ask is not None:
            question = press.ask
            _refused(lambda: server.ask(question))
        return _answer(server)

    @router.delete("/tour-run", status_code=204, summary="Wait for visitors no more", responses=problems(409))
    async def dismiss_tour() -> Response:
        """A tour that is under way is ended by its button `end` before."""
        server = _server()
        _refused(server.dismiss)
        return Response(status_code=204)

    @router.get("/tour-reports", response_model=RunReportList, summary="List reports on tours", responses=problems(409))
    async def list_tour_reports(
        tour: Annotated[str | None, Query(max_length=40, description="Id of a tour; left out: all.")] = None,
    ) -> Response:
        """The newest first. Of people, they have counts alone."""
        return Json(RunReportList(await _reports(tour)))

    @router.get(
        "/tour-reports.csv",
        response_class=Response,
        summary="Export reports on tours as a table",
        responses={200: {"content": {CSV: {"schema": {"type": "string"}}}, "description": "CSV."}, **problems(409)},
    )
    async def export_tour_reports(
        tour: Annotated[str | None, Query(max_length=40, description="Id of a tour; left out: all.")] = None,
    ) -> Response:
        """A line for each stop; times are UTC."""
        named = {"Content-Disposition": 'attachment; filename="tour-reports.csv"'}
        return Response(table(await _reports(tour)), media_type=CSV, headers=named)

    @router.get(
        "/tour-reports/{run_id}",
        response_model=RunReport,
        summary="One report on a tour",
        responses=problems(404, 409, 422),
    )
    async def get_tour_report(run_id: RunId) -> Response:
        return Json(await _of_run(system.runs.report, run_id))

    @router.delete(
        "/tour-reports/{run_id}", status_code=204, summary="Delete a report", responses=problems(404, 409, 422)
    )
    async def delete_tour_report(run_id: RunId) -> Response:
        await _of_run(system.runs.delete, run_id)
        return Response(status_code=204)

    async def _reports(tour: str | None) -> tuple[RunReport, ...]:
        found = await on_disk(system.runs.reports)
        return tuple(report for report in found if tour is None or report.tour == tour)

    def _server() -> TourRunServer:
        try:
            return system.tour_run.server
        except TourRefused as refusal:
            raise _problem(refusal) from None

    return router


def _answer(server: TourRunServer) -> Json:
    return Json(TourRunReport(server.progress, server.report))


def _refused(action: Callable[[], None]) -> None:
    """``action()``; raises Problem where it is refused."""
    try:
        action()
    except TourRefused as refusal:
        raise _problem(refusal) from None


def _problem(refusal: TourRefused) -> Problem:
    words = str(refusal)
    return Problem(409, "tour-refused", f"{words[:1].upper()}{words[1:]}.")


async def _of_run(function: Callable[[str], T], run: str) -> T:
    try:
        return await asyncio.to_thread(function, run)
    except UnknownRun as refusal:
        raise Problem(404, "no-such-run", f"{refusal}.") from None
    except ValueError as refusal:
        raise Problem(422, "invalid-name", f"{refusal}.", errors=[("path.run_id", str(refusal))]) from None
    except OSError as refusal:
        raise Problem(409, "disk-refuses", f"The disk refuses: {refusal.strerror or refusal}.") from None
