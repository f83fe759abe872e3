"""Keeps the run that is under way, and reports of those that are over, on the disk."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Final

from app.base.errors import ConfigError
from app.modules.motivations.tour_guide.guided_run import GuidedRun
from app.modules.motivations.tour_guide.kept import KeptRun, kept_bytes, read_kept
from app.tours.library import TourError
from app.tours.model import Tour
from app.tours.run_library import RunLibrary
from app.tours.run_report import RunReport
from app.tours.store import TourStore

#: A run is kept so often (s) even while nothing changes, so that a restart knows how long the program was away.
KEEP_S: Final = 30.0
#: ... and whenever the robot has moved by this (m, m, rad): half of what localization starts from a rough pose with.
POSE_STEPS: Final = (0.5, 0.5, 0.25)


class RunKeeper:
    """Writes to ``library`` by ``behind``, which runs a function in a thread. ``over``: reports that are to be kept."""

    def __init__(self, library: RunLibrary, behind: Callable[..., Awaitable[None]], log: logging.Logger) -> None:
        self._library = library
        self._behind = behind
        self._log = log
        self.over: list[RunReport] = []
        self._saved: tuple[object, ...] | None = None
        self._saved_at = 0.0

    def expect(self) -> None:
        """List the reports that the next :meth:`save` writes: it is asked for as soon as a run is over."""
        for report in self.over:
            self._library.expect(report)

    async def save(self, now: float, run: GuidedRun | None, pose: tuple[float, float, float] | None = None) -> None:
        """Keep ``run``, once something of it has changed, and the reports of those that are over.

        ``pose``: the robot's on the tour's map (m, m, rad), which is kept with it.
        """
        facets = None
        if run is not None and (run.waits or run.progress.is_running):
            progress = run.progress
            moved = () if pose is None else tuple(round(at / by) for at, by in zip(pose, POSE_STEPS, strict=True))
            facets = (
                run.tour.id, progress.entry, progress.state, progress.stop, progress.step, progress.sentence,
                progress.to_press, progress.held, progress.skipped, moved,
            )  # fmt: skip
        reports = tuple(self.over)
        if facets == self._saved and not reports and (facets is None or now - self._saved_at < KEEP_S):
            return
        self._saved, self._saved_at = facets, now
        kept = None if run is None or facets is None else kept_bytes(replace(run.kept(now), pose=pose))
        self.over.clear()
        try:
            await self._behind(self._write, kept, reports)
        except OSError as refusal:
            self._log.warning("the tour cannot be kept: %s", refusal)

    def read(self, tours: TourStore) -> tuple[KeptRun, Tour] | None:
        """The run that was under way when the program ended, and its tour; None without. Touches the disk."""
        try:
            data = self._library.kept()
            kept = None if data is None else read_kept(data)
            if kept is None or kept.report is None:
                return None
            return kept, tours.get(kept.report.tour).tour
        except (TourError, ConfigError, ValueError, OSError) as refusal:
            self._log.warning("the tour that was under way is not resumed: %s", refusal)
            return None

    def _write(self, kept: bytes | None, reports: tuple[RunReport, ...]) -> None:
        for report in reports:
            self._library.add(report)
        self._library.keep(kept)
