"""What became of the desires that left the Intention Workspace, for those who ask later."""

from __future__ import annotations

from typing import Final

from app.messages import DesireReport

KEPT: Final = 2000
"""So many desires, the last that left."""
KEPT_FOR_S: Final = 600.0
"""So long each (s)."""


class EndedDesires:
    """The last ``kept`` desires that left, each for ``kept_for_s``. Times are of the robot's clock (s)."""

    def __init__(self, kept: int = KEPT, kept_for_s: float = KEPT_FOR_S) -> None:
        self._kept = kept
        self._kept_for_s = kept_for_s
        #: In the order they left.
        self._reports: dict[str, DesireReport] = {}

    def add(self, report: DesireReport) -> None:
        """Keep ``report``; an earlier one of the same id is replaced. Raises ValueError if the desire has not ended."""
        if report.ended is None:
            raise ValueError(f"the desire {report.id!r} has not ended")
        self._reports.pop(report.id, None)
        self._reports[report.id] = report
        while len(self._reports) > self._kept or self._is_over(next(iter(self._reports.values())), report.ended):
            del self._reports[next(iter(self._reports))]

    def find(self, desire_id: str, now: float) -> DesireReport | None:
        """What became of a desire; None where nothing is known of it (any more)."""
        report = self._reports.get(desire_id)
        return None if report is None or self._is_over(report, now) else report

    def newest(self, count: int, now: float) -> tuple[DesireReport, ...]:
        """The last ``count`` that left, the newest first."""
        found: list[DesireReport] = []
        for report in reversed(self._reports.values()):
            if len(found) == count or self._is_over(report, now):
                break
            found.append(report)
        return tuple(found)

    def clear(self) -> None:
        """Time has jumped: nothing has ended."""
        self._reports.clear()

    def _is_over(self, report: DesireReport, now: float) -> bool:
        return report.ended is not None and now - report.ended >= self._kept_for_s
