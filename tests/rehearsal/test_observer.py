"""Notes of a rehearsal: what is made of the messages and poses that come."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import pytest

from app.base.geometry import Pose2
from app.messages import Speech, SpeechState, TourFailure, TourProgress, TourState
from app.rehearsal.observer import RehearsalObserver
from app.runtime.channel import Channel

IDLE = TourProgress(
    0.0, "run", "arm-tour", title={"en": "Arm"}, language="en", languages=("en",), waits=False, state="idle", since=0.0,
    reason="", stop="", stop_title={}, number=0, stops=1, step=0, steps=0, text={}, sentence=0, shown=None, press={},
    questions=(), buttons=(), question=None, people=0, farthest_m=None, presented=(), skipped=(), failures=(),
)  # fmt: skip
SILENT = Speech(0.0, "silent", "", 0, 0, viseme="closed", language="en", desire="", waiting=0)


@dataclass
class Run:
    """What the observer looks at of a rehearsal, moved by the test."""

    time_s: float = 0.0
    base: Any = field(default_factory=lambda: SimpleNamespace(pose=Pose2(), touches=0, driven_m=0.0))
    actors: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        now: Callable[[], float] = lambda: self.time_s  # noqa: E731
        self.speech: Channel[Speech] = Channel("speech", Speech, now)
        self.guide: Channel[TourProgress] = Channel("tour_progress", TourProgress, now)
        channels = {"speech": self.speech, "tour_progress": self.guide}
        self.system = SimpleNamespace(clock=SimpleNamespace(now=now), graph=SimpleNamespace(channels=channels))
        self.link = SimpleNamespace(base=self.base, scenario_state=SimpleNamespace(actors=self.actors))

    def observed(self) -> RehearsalObserver:
        return RehearsalObserver(self, wait_m=4.0)  # type: ignore[arg-type]


def test_states_are_noted_once_and_its_end_is_known() -> None:
    run = Run()
    course: list[tuple[int, TourState, str]] = [
        (1, "leading", "arm"), (2, "leading", "arm"), (9, "presenting", "arm"), (20, "idle", ""),
    ]  # fmt: skip
    with run.observed() as noted:
        for time_s, state, stop in course:
            run.time_s = time_s
            assert not noted.has_ended
            run.guide.publish(replace(IDLE, state=state, stop=stop, sentence=time_s))
        assert noted.has_ended
    assert [(line.at_s, line.state, line.stop) for line in noted.states] == [
        (1, "leading", "arm"), (9, "presenting", "arm"), (20, "idle", ""),
    ]  # fmt: skip
    assert noted.stood["arm"] == Pose2()


def test_sentences_have_a_begin_and_an_end() -> None:
    run = Run()
    course: list[tuple[int, SpeechState, str]] = [
        (1, "speaking", "One."), (2, "speaking", "One."), (3, "speaking", "Two."), (5, "silent", "Two."),
    ]  # fmt: skip
    with run.observed() as noted:
        for time_s, state, text in course:
            run.time_s = time_s
            run.speech.publish(replace(SILENT, state=state, text=text, word_begin=time_s))
    assert [(said.at_s, said.until_s, said.text) for said in noted.subtitles] == [(1, 3, "One."), (3, 5, "Two.")]


def test_failures_are_errors_of_their_stop_each_once() -> None:
    run = Run()
    with run.observed() as noted:
        failed = replace(IDLE, state="leading", stop="arm", failures=(TourFailure("arm", "not reached"),))
        run.guide.publish(failed)
        run.guide.publish(replace(failed, sentence=1))
    assert [(problem.severity, problem.stop, problem.message) for problem in noted.problems] == [
        ("error", "arm", "arm: not reached")
    ]


def test_an_obstacle_that_stops_it_is_an_error_once() -> None:
    run = Run()
    with run.observed() as noted:
        for touches in (0, 1, 1, 2):
            run.base.touches = touches
            noted.look()
    assert len(noted.problems) == 2
    assert "stopped by an obstacle" in noted.problems[0].message


@pytest.mark.parametrize(("state", "problems"), [("leading", 1), ("waiting", 0)])
def test_a_visitor_left_behind_is_a_problem_only_while_it_drives(state: Any, problems: int) -> None:
    run = Run(actors=[SimpleNamespace(x=6.0, y=0.0)])
    with run.observed() as noted:
        run.guide.publish(replace(IDLE, state=state, stop="arm"))
        for time_s in range(30):
            run.time_s = time_s
            noted.look()
    assert [problem.severity for problem in noted.problems] == ["warning"] * problems


def test_the_path_has_a_pose_for_each_step_and_one_now_and_then() -> None:
    run = Run(actors=[SimpleNamespace(x=1.0, y=0.0)])
    with run.observed() as noted:
        for look in range(101):
            run.time_s = look * 0.1
            run.base.pose = Pose2(min(look, 50) * 0.02, 0.0)
            noted.look()
    assert 10 <= len(noted.path) <= 13
    assert (noted.path[0].x, noted.path[0].farthest_m) == (0.0, 1.0)
    assert noted.path[-1].x == pytest.approx(1.0)
