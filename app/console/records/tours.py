"""Guided tours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from msgspec import Meta

from app.messages import TourProgress
from app.messages.base import doc
from app.rehearsal.result import Rehearsal
from app.tours.run_report import RunReport

Severity = Literal["mistake", "error", "warning"]


@dataclass(frozen=True, slots=True)
class TourProblemReport:
    """A problem of a tour."""

    field: Annotated[str, doc("The value that it is about, as `stops.0.place`.")]
    message: str
    severity: Annotated[
        Severity, doc("`mistake`: not kept; `error`: kept, and cannot run; `warning`: runs all the same.")
    ]


@dataclass(frozen=True, slots=True)
class TourSummary:
    """A tour in the list of all."""

    id: Annotated[str, Meta(examples=["lab-tour"])]
    title: Annotated[dict[str, str], doc("By language.")]
    languages: tuple[str, ...]
    map: str
    stops: Annotated[int, doc("How many are not left out.")]
    shipped: Annotated[bool, doc("Whether it came with the program and was not changed.")]
    etag: str
    errors: Annotated[int, doc("Problems for which it cannot run.")]
    warnings: int
    problem: Annotated[str | None, doc("Why its file cannot be read, in words; all else is empty then.")]


@dataclass(frozen=True, slots=True)
class TourList:
    """Every tour, by id."""

    folder: Annotated[str, doc("Of the user's tours, on the robot's computer.")]
    tours: tuple[TourSummary, ...]


@dataclass(frozen=True, slots=True)
class TourReport:
    """A tour, and what is to be said of it."""

    tour: Annotated[dict[str, Any], doc("As `GET /tour-schema` describes it, every member there.")]
    shipped: Annotated[bool, doc("Whether it came with the program and was not changed.")]
    can_undo: bool
    can_redo: bool
    problems: Annotated[tuple[TourProblemReport, ...], doc("The worst first.")]


@dataclass(frozen=True, slots=True)
class TourVerdict:
    """What became of a check."""

    runs: Annotated[bool, doc("Whether it has neither mistakes nor errors.")]
    problems: Annotated[tuple[TourProblemReport, ...], doc("The worst first.")]


@dataclass(frozen=True, slots=True)
class TourMedia:
    """A picture or a video that tours can show."""

    file: Annotated[str, doc("As a tour's `show` names it."), Meta(examples=["media/arm.jpg"])]
    type: Annotated[str, Meta(examples=["image/jpeg"])]
    video: Annotated[bool, doc("Whether it is a video.")]
    size: Annotated[int, doc("In bytes.")]
    changed: Annotated[float, doc("Unix time, s.")]
    shipped: Annotated[bool, doc("Whether it came with the program.")]
    tours: Annotated[tuple[str, ...], doc("Ids of the tours that show it.")]


@dataclass(frozen=True, slots=True)
class TourMediaList:
    """All that tours can show, by name."""

    media: tuple[TourMedia, ...]
    largest_picture: Annotated[int, doc("Pictures with more bytes are not taken.")]
    largest_video: Annotated[int, doc("Videos with more bytes are not taken.")]


@dataclass(frozen=True, slots=True)
class TourRunReport:
    """The tour that is under way."""

    progress: Annotated[TourProgress, doc("How it goes now.")]
    report: Annotated[RunReport | None, doc("What the run has been so far, or the last one was; null: none.")]


@dataclass(frozen=True, slots=True)
class RunReportList:
    """Reports on runs of tours, the newest first."""

    reports: tuple[RunReport, ...]


@dataclass(frozen=True, slots=True)
class RehearsalReport:
    """The rehearsal that is under way, or the last."""

    state: Literal["none", "running", "done", "failed"]
    tour: Annotated[str, doc("Id of the tour; empty: there was none.")]
    language: Annotated[str, doc("Of the visitors.")]
    began: Annotated[float | None, doc("Unix time, s.")]
    seconds: Annotated[float, doc("How much of the tour was played (s).")]
    stop: Annotated[str, doc("Id of the stop that it is at; empty: none.")]
    problem: Annotated[str, doc("Why it failed, in words; empty: it did not.")]
    can_be_led: Annotated[bool | None, doc("Whether nothing keeps the tour from being led; null: not known.")]
    result: Annotated[Rehearsal | None, doc("What was found; null: nothing yet.")]
