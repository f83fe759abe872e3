"""What REST answers about tours: a tour with its tag and problems, the list of all, and refusals of what is none."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from fastapi import Path
from fastapi.responses import Response

from app.base.errors import ConfigError
from app.base.named_library import NAME
from app.console.problems import FieldFault, Problem
from app.console.records.tours import TourList, TourProblemReport, TourReport, TourSummary, TourVerdict
from app.console.rest.entity_tags import check_match, etag, tagged
from app.program.recognizer import recognizer_of
from app.tours.archive import BadArchive
from app.tours.checks import check
from app.tours.consistency import tour_of
from app.tours.library import (
    NoVersion,
    ShippedTour,
    TooManyTours,
    TourError,
    TourTaken,
    TourTooLarge,
    UnknownTour,
)
from app.tours.media import MediaError, NoRoom, ShippedMedia
from app.tours.media_content import NotShown
from app.tours.model import Tour
from app.tours.problems import InvalidTour, TourProblem
from app.tours.store import KeptTour
from app.tours.surroundings import surroundings

if TYPE_CHECKING:
    from app.program.system import System

T = TypeVar("T")

TourId = Annotated[
    str, Path(description="The tour's id.", examples=["lab-tour"], json_schema_extra={"pattern": f"^{NAME.pattern}$"})
]


class TourAnswers:
    """What is said of the tours of ``system``."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._store = system.tours
        self._recognizer = recognizer_of(system.config)

    def listing(self) -> TourList:
        """All tours. Blocking."""
        return TourList(str(self._store.library.folder), tuple(map(self._summary, self._store.names())))

    def verdict(self, draft: dict[str, Any]) -> TourVerdict:
        """What is wrong with ``draft``. Blocking."""
        try:
            found = self._checked(tour_of(draft))
        except InvalidTour as refusal:
            found = refusal.problems
        return TourVerdict(all(problem.severity == "warning" for problem in found), _reports(found))

    async def answer(self, change: Callable[..., KeptTour | None], *args: Any, status: int = 200) -> Response:
        """What ``change`` leads to, as an answer."""

        def report() -> TourReport | None:
            if (kept := change(*args)) is None:
                return None
            found = _reports(self._checked(kept.tour))
            return TourReport(version(kept.tour), kept.shipped, kept.can_undo, kept.can_redo, found)

        found = await on_disk(report)
        if found is None:
            return Response(status_code=204)
        headers = {"Location": f"/api/v1/tours/{found.tour['id']}"} if status == 201 else {}
        return tagged(found, version=found.tour, status=status, headers=headers)

    def _summary(self, name: str) -> TourSummary:
        try:
            kept = self._store.get(name)
        except (ConfigError, ValueError) as damage:
            return _damaged(name, str(damage))
        tour = kept.tour
        severities = [problem.severity for problem in self._checked(tour)]
        return TourSummary(
            id=tour.id,
            title=tour.title,
            languages=tour.languages,
            map=tour.map,
            stops=sum(not stop.left_out for stop in tour.stops),
            shipped=kept.shipped,
            etag=etag(version(tour)),
            errors=severities.count("error"),
            warnings=severities.count("warning"),
            problem=None,
        )

    def _checked(self, tour: Tour) -> tuple[TourProblem, ...]:
        system, folders = self._system, self._store.library.folders
        around = surroundings(
            tour, maps=system.maps, folders=folders, classes=system.classes, recognizer=self._recognizer
        )
        return check(tour, around)


def version(tour: Tour) -> dict[str, Any]:
    """All of ``tour``, as it is sent and as its tag is made of."""
    return tour.model_dump(mode="json", by_alias=True)


def matching(if_match: str | None) -> Callable[[Tour], None]:
    """Raises Problem for a tour that is of another version than ``If-Match`` names."""
    return lambda tour: check_match(if_match, version(tour))


def tour_from(data: dict[str, Any]) -> Tour:
    """The tour that ``data`` is. Raises Problem, which names every field that is wrong."""
    try:
        return tour_of(data)
    except InvalidTour as refusal:
        raise _invalid(refusal) from None


def no_tour(field: str, words: str, **more: Any) -> Problem:
    """The refusal of what is no tour."""
    return Problem(422, "invalid-tour", f"{words}.", errors=[(field, words)], **more)


async def on_disk(function: Callable[..., T], *args: Any) -> T:
    """``function(*args)`` of the store or of its media, in a thread. Raises Problem, and NotShown."""
    try:
        return await asyncio.to_thread(function, *args)
    except (TourError, MediaError, ConfigError, OSError) as refusal:
        raise _problem(refusal) from None
    except NotShown:
        raise  # its caller knows what people call the file
    except InvalidTour as refusal:
        raise _invalid(refusal) from None
    except BadArchive as refusal:
        raise Problem(422, "invalid-archive", f"{refusal}.", errors=[("body", str(refusal))]) from None
    except ValueError as refusal:
        raise Problem(422, "invalid-name", f"{refusal}.", errors=[("path.tour_id", str(refusal))]) from None


def _problem(refusal: Exception) -> Problem:
    match refusal:
        case UnknownTour():
            return Problem(404, "no-such-tour", f"{refusal}.")
        case TourTaken():
            return Problem(409, "tour-exists", f"{refusal}.", errors=[("id", str(refusal))])
        case ShippedTour():
            return Problem(409, "tour-shipped", f"{refusal}.")
        case TooManyTours():
            return Problem(409, "too-many-tours", f"{refusal}.")
        case TourTooLarge():
            return Problem(413, "body-too-large", f"{refusal}.", errors=[("body", str(refusal))])
        case NoVersion():
            return Problem(409, "no-other-version", f"{refusal}.")
        case NoRoom():
            return Problem(507, "no-room", f"It is not kept: {refusal}.")
        case ShippedMedia():
            return Problem(409, "media-shipped", f"{refusal}.")
        case MediaError():
            return Problem(404, "no-such-media", "There is no such picture or video.")
        case OSError():
            where = f"{refusal.filename}: " if refusal.filename else ""
            return Problem(409, "disk-refuses", f"The disk refuses: {where}{refusal.strerror or refusal}.")
    return Problem(409, "unreadable-tour", f"The tour's file is damaged: {refusal}")


def _invalid(refusal: InvalidTour) -> Problem:
    return Problem(
        422,
        "invalid-tour",
        f"{refusal}.",
        errors=[FieldFault(problem.field, problem.message, problem.rule) for problem in refusal.problems],
    )


def _damaged(name: str, problem: str) -> TourSummary:
    """The summary of a file that is no tour."""
    return TourSummary(
        id=name,
        title={},
        languages=(),
        map="",
        stops=0,
        shipped=False,
        etag="",
        errors=0,
        warnings=0,
        problem=problem,
    )


def _reports(found: tuple[TourProblem, ...]) -> tuple[TourProblemReport, ...]:
    return tuple(TourProblemReport(problem.field, problem.message, problem.severity) for problem in found)
