"""What is noted of a run as it goes: counts and times. Pure functions on frozen values."""

from __future__ import annotations

from dataclasses import replace

from app.messages import TourFailure
from app.modules.motivations.tour_guide.entering import AT_A_STOP
from app.modules.motivations.tour_guide.progress import Progress, View
from app.modules.motivations.tour_guide.wishes import Scene, stop_of
from app.tours.run_report import RunReport, StopReport


def noted(
    report: RunReport, before: Progress, view: View, after: Progress, scene: Scene, *, driven_m: float
) -> RunReport:
    """``report`` once ``view`` has led from ``before`` to ``after``; the robot drove ``driven_m`` (m) meanwhile."""
    failures = tuple(TourFailure(failure.stop, failure.what) for failure in after.failures)
    report = replace(
        report,
        people_most=max(report.people_most, view.people),
        driven_m=report.driven_m + driven_m,
        failures=failures,
        stops=_stops(report.stops, before, view, after, scene),
    )
    if before.entry != after.entry:
        report = _entered(report, before, view, after)
    if after.state == "parting":
        report = replace(report, people_end=max(report.people_end, view.people))
    if not after.is_running:
        report = replace(report, ended=view.now, outcome=after.reason)
    return report


def _entered(report: RunReport, before: Progress, view: View, after: Progress) -> RunReport:
    lasted_s = max(view.now - before.since, 0.0)
    if before.state in ("waiting", "searching"):
        report = replace(report, waited_s=report.waited_s + lasted_s)
    if before.state == "paused":
        report = replace(report, paused_s=report.paused_s + lasted_s)
    if after.state == "waiting" and before.state != "searching":
        report = replace(report, waits=report.waits + 1)
    if after.state == "paused":
        report = replace(report, pauses=report.pauses + 1)
    if after.state == "leading":
        report = replace(report, agreed=True)
    return report


def _stops(
    stops: tuple[StopReport, ...], before: Progress, view: View, after: Progress, scene: Scene
) -> tuple[StopReport, ...]:
    now = view.now
    there = after.state in AT_A_STOP or after.state == "turning"
    under_way = after.state == "leading" or there
    stop = stop_of(after, scene.tour)
    last = stops[-1] if stops and stops[-1].ended is None else None
    left = last is not None and (after.state in ("parting", "going_home", "idle") or last.stop != stop.id)
    left = left or (last is not None and last.arrived is not None and after.state == "leading" and _sent(before, after))
    if last is not None and left:
        skipped = len(after.skipped) > len(before.skipped)
        presented = len(after.presented) > len(before.presented)
        stops, last = (*stops[:-1], replace(last, ended=now, presented=presented, skipped=skipped)), None
    if not under_way:
        return stops
    if last is None:
        last, stops = StopReport(stop.id, began=now), (*stops, StopReport(stop.id, began=now))
    if there:
        asked = last.questions
        if after.state == "answering" and after.entry != before.entry:
            id_ = stop.questions[after.question].id
            asked = {**asked, id_: asked.get(id_, 0) + 1}
        arrived = now if last.arrived is None else last.arrived
        last = replace(last, arrived=arrived, people=max(last.people, view.people), questions=asked)
    return (*stops[:-1], last)


def _sent(before: Progress, after: Progress) -> bool:
    """Whether it sets out again, and does not only go on after a pause."""
    return before.entry != after.entry and before.state != "paused"
