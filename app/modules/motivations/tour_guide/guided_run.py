"""A tour that is under way, or waits for visitors: what belongs to it, and how it goes on by one look. No channels."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

from app.modules.motivations.tour_guide.kept import KeptRun
from app.modules.motivations.tour_guide.perceptions import perceptions
from app.modules.motivations.tour_guide.progress import Progress, View
from app.modules.motivations.tour_guide.run_record import noted
from app.modules.motivations.tour_guide.transitions import advance
from app.modules.motivations.tour_guide.wishes import Scene, Wish, wishes
from app.tours.model import Begin, Tour
from app.tours.run_report import RunReport
from app.tours.tour_file import digest


@dataclass(slots=True)
class GuidedRun:
    """``tour`` as its author made it, and ``scene`` with what is led by; ``waits``: visitors begin it, again and again.

    ``report`` is of the run under way, or of the last; reports of runs that have ended are added to ``over``.
    """

    tour: Tour
    scene: Scene
    waits: bool
    progress: Progress = field(default_factory=Progress)
    view: View = field(default_factory=lambda: View(0.0))
    report: RunReport | None = None
    over: list[RunReport] = field(default_factory=list)
    #: The tour that was digested last: writing one out takes some 20 ms, and it is asked for at each look.
    _digested: tuple[Tour, str] | None = None

    def see(self, view: View) -> None:
        """Go on with what is seen now."""
        before, driven_m = self.progress, max(view.driven_m - self.view.driven_m, 0.0)
        after = advance(before, view, self.scene)
        self.progress, self.view = after, view
        if after.is_running and not before.is_running:
            self.report, driven_m = self._new_report(view), 0.0
        if self.report is not None and (before.is_running or after.is_running):
            self.report = noted(self.report, before, view, after, self.scene, driven_m=driven_m)
            if not after.is_running:
                self.over.append(self.report)

    def resume(self, kept: KeptRun, progress: Progress, view: View) -> None:
        """Take over ``kept``, which goes on with ``progress``."""
        self.progress, self.view = progress, view
        self.report = kept.report if kept.progress.is_running else None
        if self.report is not None and not progress.is_running:
            self.report = replace(self.report, ended=view.now, outcome=progress.reason)
            self.over.append(self.report)

    def wishes(self, now: float) -> tuple[Wish, ...]:
        """All desires of the guide."""
        return (*wishes(self.progress, self.scene, now), *perceptions(self.progress, self.scene))

    def kept(self, now: float) -> KeptRun:
        """What a program that is started again goes on with."""
        return KeptRun(self._digest(), now, self.progress, self.report or self._new_report(self.view), self.waits)

    def _digest(self) -> str:
        tour = self.scene.tour
        if self._digested is None or self._digested[0] is not tour:
            self._digested = tour, digest(tour)
        return self._digested[1]

    def _new_report(self, view: View) -> RunReport:
        # Ids begin with their time, so that the newest report is the last by name.
        run = f"{time.strftime('%Y%m%d-%H%M%S', time.gmtime(view.now))}-{self.tour.id}"
        return RunReport(
            run, self.tour.id, self.tour.title, self.scene.language, began=view.now, people_begin=view.people
        )


def led_by(tour: Tour, *, waits: bool) -> Tour:
    """``tour`` as it is led by: one that does not wait for visitors begins by a press alone."""
    return tour if waits else tour.model_copy(update={"begin": Begin(by=("press",)), "schedule": ()})
