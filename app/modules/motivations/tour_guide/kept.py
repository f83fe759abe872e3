"""What is kept of a run at each change, so that a program that is started again goes on or says why not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import msgspec

from app.modules.motivations.tour_guide.entering import go_home
from app.modules.motivations.tour_guide.passing_time import resumed
from app.modules.motivations.tour_guide.progress import Progress, State, View
from app.modules.motivations.tour_guide.wishes import Scene
from app.tours.run_report import RunReport
from app.tours.tour_file import digest

#: A run is not gone on with after so long (s).
LONGEST_BREAK_S: Final = 600.0


@dataclass(frozen=True, slots=True)
class KeptRun:
    """A run of the tour with this ``digest``, as it was at ``at`` (Unix time, s); ``report``: what it was until then;
    ``waits``: whether the tour waits for visitors again after it; ``pose``: x, y (m) and heading (rad) of the robot on
    the tour's map, None where it was not known."""

    digest: str
    at: float
    progress: Progress
    report: RunReport | None = None
    waits: bool = False
    pose: tuple[float, float, float] | None = None

    def is_fresh(self, at: float) -> bool:
        """Whether it is gone on with at ``at`` (Unix time, s)."""
        return 0 <= at - self.at <= LONGEST_BREAK_S


def kept_bytes(run: KeptRun) -> bytes:
    """``run`` as JSON."""
    return msgspec.json.encode(run)


def read_kept(data: bytes) -> KeptRun | None:
    """The run that ``data`` is; None for anything else."""
    try:
        return msgspec.json.decode(data, type=KeptRun)
    except msgspec.DecodeError:
        return None


def after_restart(run: KeptRun, at: float, view: View, scene: Scene) -> Progress:
    """How ``run`` goes on at ``at`` (Unix time, s) in a program that was started again.

    A run that was paused stays so until a press, and so does what the emergency stop holds. One that cannot go on ends,
    and the robot goes home; ``reason`` says why.
    """
    before = run.progress
    tour = scene.tour
    if before.stop >= len(tour.stops) or before.question >= max(1, len(tour.stops[before.stop].questions)):
        return Progress(held=before.held, reason="what was kept of the run is not of this tour")
    state: State = before.resume if before.state == "paused" else before.state
    fresh = replace(before, state="paused", resume=state, since=view.now, gone_since=None, near_since=None)
    fresh = replace(fresh, towards=None, stuck_since=None, homed=False)  # of another odometry
    if not before.is_running:
        return Progress(held=before.held, reason=before.reason)
    if before.state == "paused" and before.to_press:
        return replace(fresh, to_press=True, pause_spoken=False)
    reasons = {
        "the tour was changed meanwhile": run.digest != digest(tour),
        "the program was away too long": not run.is_fresh(at),
        "no visitor was there when the program was back": view.there == 0 and state not in ("parting", "going_home"),
    }
    for reason, holds in reasons.items():
        if holds:
            home = go_home(replace(fresh, reason=reason), view, scene)
            return replace(home, excuse="interrupted" if home.state == "going_home" else "")
    again = resumed(fresh, view, scene)
    return replace(again, excuse="again") if again.state in ("leading", "presenting", "listening") else again
