"""Notes of a rehearsal under way: what the guide, the voice, the body and the visitors did. No decisions."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Literal

from app.base.geometry import Pose2, wrap_angle
from app.messages import Speech, TourProgress
from app.rehearsal.play import RehearsalRun
from app.rehearsal.result import RehearsalProblem, RehearsedPose, RehearsedState, Subtitle

#: The path has a pose for each of these ways and turns (m, rad), and one each so many seconds.
_STEP_M, _STEP_RAD, _STEP_S = 0.1, 0.2, 5.0
#: A visitor may be farther than the tour's ``wait_m`` for so long (s) before the robot has to wait.
LEFT_BEHIND_S = 10.0
#: States in which the robot does not drive away from visitors.
STANDS = frozenset(
    {"idle", "waiting", "searching", "turning", "presenting", "listening", "answering", "paused", "blocked", "lost"}
)


class RehearsalObserver:
    """Notes of ``run``, whose visitors should not be farther than ``wait_m`` (m) from the robot; a context manager."""

    def __init__(self, run: RehearsalRun, wait_m: float) -> None:
        self._run = run
        self._wait_m = wait_m
        self._begin = run.system.clock.now()
        self._stack = ExitStack()
        self._far_since: float | None = None
        self._touches = 0
        self.states: list[RehearsedState] = []
        self.subtitles: list[Subtitle] = []
        self.path: list[RehearsedPose] = []
        self.problems: list[RehearsalProblem] = []
        self.progress: TourProgress | None = None
        #: How far from the place the robot stood when it began to present, by stop (m, rad).
        self.stood: dict[str, Pose2] = {}

    def __enter__(self) -> RehearsalObserver:
        takers: dict[type[Any], Callable[[Any], None]] = {Speech: self._speech, TourProgress: self._guide}
        for channel in self._run.system.graph.channels.values():
            if (take := takers.get(channel.message_type)) is not None:
                self._stack.callback(channel.observe(take))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def elapsed_s(self) -> float:
        """Since the begin (s)."""
        return self._run.system.clock.now() - self._begin

    @property
    def has_ended(self) -> bool:
        """Whether a tour was under way and is no more."""
        running = any(line.state != "idle" for line in self.states)
        return running and self.states[-1].state == "idle"

    def look(self) -> None:
        """Note where all are; to be called at least each second."""
        base, people = self._run.link.base, self._run.link.scenario_state.actors
        away = [math.hypot(person.x - base.pose.x, person.y - base.pose.y) for person in people]
        farthest_m = max(away, default=None)
        last = self.path[-1] if self.path else None
        if last is None or _apart(last, base.pose) or self.elapsed_s - last.at_s >= _STEP_S:
            place = (round(base.pose.x, 3), round(base.pose.y, 3), round(base.pose.theta, 3))
            far = None if farthest_m is None else round(farthest_m, 2)
            self.path.append(RehearsedPose(round(self.elapsed_s, 2), *place, farthest_m=far))
        if base.touches > self._touches:
            self._touches = base.touches
            self._problem("error", f"the robot is stopped by an obstacle at ({base.pose.x:.1f}, {base.pose.y:.1f})")
        self._watch(farthest_m)

    def _watch(self, farthest_m: float | None) -> None:
        state = self.states[-1].state if self.states else "idle"
        if farthest_m is None or farthest_m <= self._wait_m or state in STANDS or state in ("parting", "going_home"):
            self._far_since = None
            return
        since = self._far_since
        self._far_since = self.elapsed_s if since is None else since
        if since is not None and since != math.inf and self.elapsed_s - since > LEFT_BEHIND_S:
            self._far_since = math.inf
            self._problem("warning", f"a visitor is {farthest_m:.1f} m behind, and the robot does not wait")

    def _guide(self, progress: TourProgress) -> None:
        before, self.progress = self.progress, progress
        for failure in progress.failures[len(before.failures) if before is not None else 0 :]:
            self.problems.append(
                RehearsalProblem("error", failure.stop, f"{failure.stop}: {failure.what}", round(self.elapsed_s, 2))
            )
        if not self.states and progress.state == "idle":
            return  # it did not begin yet
        line = RehearsedState(round(self.elapsed_s, 2), progress.state, progress.stop, progress.reason)
        last = self.states[-1] if self.states else None
        if last is None or (last.state, last.stop, last.reason) != (line.state, line.stop, line.reason):
            self.states.append(line)
        if progress.state == "presenting" and progress.stop not in self.stood:
            self.stood[progress.stop] = self._run.link.base.pose

    def _speech(self, speech: Speech) -> None:
        now = round(self.elapsed_s, 2)
        last = self.subtitles[-1] if self.subtitles else None
        open_ = last is not None and math.isinf(last.until_s)
        if open_ and last is not None and (speech.state != "speaking" or speech.text != last.text):
            self.subtitles[-1] = Subtitle(last.at_s, now, last.text, last.language)
            open_ = False
        if speech.state == "speaking" and not open_:
            self.subtitles.append(Subtitle(now, math.inf, speech.text, speech.language))

    def _problem(self, severity: Literal["error", "warning"], message: str) -> None:
        stop = self.states[-1].stop if self.states else ""
        self.problems.append(RehearsalProblem(severity, stop, message, round(self.elapsed_s, 2)))


def _apart(last: RehearsedPose, now: Pose2) -> bool:
    return (
        math.hypot(now.x - last.x, now.y - last.y) >= _STEP_M or abs(wrap_angle(now.theta - last.heading)) >= _STEP_RAD
    )
