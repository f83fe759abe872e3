"""What a run of a tour was: times, how many came along, questions, what failed. Of people, only counts."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Annotated

from app.messages import TourFailure
from app.messages.base import doc


@dataclass(frozen=True, slots=True)
class StopReport:
    """What became of one stop."""

    stop: Annotated[str, doc("Its id.")]
    began: Annotated[float, doc("When the robot set out for it (Unix time, s).")]
    arrived: Annotated[float | None, doc("When it was there (Unix time, s); null: never.")] = None
    ended: Annotated[float | None, doc("When it was presented, or left (Unix time, s); null: not yet.")] = None
    presented: Annotated[bool, doc("Whether all of it was presented.")] = False
    skipped: Annotated[bool, doc("Whether people skipped it.")] = False
    people: Annotated[int, doc("The most people that were seen there at once.")] = 0
    questions: Annotated[Mapping[str, int], doc("How often each question was asked, by its id.")] = field(
        default_factory=dict
    )


@dataclass(frozen=True, slots=True)
class RunReport:
    """What a run of a tour was."""

    run: Annotated[str, doc("Its id.")]
    tour: Annotated[str, doc("Id of the tour.")]
    title: Annotated[Mapping[str, str], doc("Of the tour, by language.")]
    language: Annotated[str, doc("That the robot spoke.")]
    began: Annotated[float, doc("Unix time, s.")]
    ended: Annotated[float | None, doc("Unix time, s; null: it is under way.")] = None
    outcome: Annotated[str, doc("Why it ended, in words; empty: it has not.")] = ""
    agreed: Annotated[bool, doc("Whether visitors came along.")] = False
    people_begin: Annotated[int, doc("How many were seen when it began.")] = 0
    people_most: Annotated[int, doc("The most that were seen at once.")] = 0
    people_end: Annotated[int, doc("How many were seen at the farewell.")] = 0
    driven_m: Annotated[float, doc("The way that was driven (m).")] = 0.0
    waits: Annotated[int, doc("How often it waited for visitors, or looked back for them.")] = 0
    waited_s: Annotated[float, doc("How long in all.")] = 0.0
    pauses: int = 0
    paused_s: float = 0.0
    stops: Annotated[
        tuple[StopReport, ...], doc("In the order of the way; one that was gone to twice is there twice.")
    ] = ()
    failures: tuple[TourFailure, ...] = ()


#: Columns of the table.
COLUMNS = (
    *("run", "tour", "language", "began", "ended", "outcome", "people_begin", "people_most", "people_end"),
    *("driven_m", "waits", "waited_s", "pauses", "paused_s"),
    *("stop", "stop_began", "stop_arrived", "stop_ended", "presented", "skipped", "people", "questions", "failures"),
)


def table(reports: Iterable[RunReport]) -> str:
    """``reports`` as CSV (RFC 4180) with a head: a line for each stop, one for a run without any. Times are UTC."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\r\n")
    lines.writerow(COLUMNS)
    for report in reports:
        whole = (
            *(report.run, report.tour, report.language, _utc(report.began), _utc(report.ended), report.outcome),
            *(report.people_begin, report.people_most, report.people_end, round(report.driven_m, 2)),
            *(report.waits, round(report.waited_s, 1), report.pauses, round(report.paused_s, 1)),
        )
        for stop in report.stops:
            questions = " ".join(f"{question}={count}" for question, count in sorted(stop.questions.items()))
            failed = "; ".join(failure.what for failure in report.failures if failure.stop == stop.stop)
            times = (_utc(stop.began), _utc(stop.arrived), _utc(stop.ended))
            flags = (int(stop.presented), int(stop.skipped), stop.people)
            lines.writerow((*whole, stop.stop, *times, *flags, questions, failed))
        if not report.stops:
            lines.writerow((*whole, *("",) * (len(COLUMNS) - len(whole))))
    return text.getvalue()


def _utc(at: float | None) -> str:
    return "" if at is None else datetime.fromtimestamp(at, UTC).isoformat(timespec="seconds")
