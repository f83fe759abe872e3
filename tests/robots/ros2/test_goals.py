"""The goals of a group at an action: one is pursued, cancelled at a stop, and what became of it is said in words."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.robots.ros2.goals import ABORTED, ANSWER_S, CANCELED, SUCCEEDED, Goals

PERIOD_S = 0.25


class Future:
    """What rclpy's futures do, at once."""

    def __init__(self) -> None:
        self._callbacks: list[Any] = []
        self.value: Any = None
        self._cancelled = False

    def add_done_callback(self, callback: Any) -> None:
        self._callbacks.append(callback)

    def result(self) -> Any:
        return self.value

    def cancelled(self) -> bool:
        return self._cancelled

    def cancel(self) -> None:
        self._cancelled = True
        self.done(None)

    def done(self, value: Any) -> None:
        self.value = value
        for callback in self._callbacks:
            callback(self)


@dataclass
class Answer:
    status: int = 0
    return_code: int = 0
    result: Any = None
    error_code: int = 0
    error_string: str = ""


@dataclass(eq=False)
class Handle:
    """A goal at the server."""

    accepted: bool = True
    cancels: list[Future] = field(default_factory=list)
    ended: Future = field(default_factory=Future)

    def cancel_goal_async(self) -> Future:
        self.cancels.append(Future())
        return self.cancels[-1]

    def get_result_async(self) -> Future:
        return self.ended

    def end(self, status: int, error: int = 0, words: str = "") -> None:
        self.ended.done(Answer(status, result=Answer(error_code=error, error_string=words)))


class Server:
    """A server that answers when it is let, and the goals of a group at it."""

    def __init__(self) -> None:
        self.now = 100.0
        self.asked: list[tuple[tuple[float, ...], Future]] = []
        self.said: list[str] = []
        self.goals = Goals("/head", self._send, lambda: self.now, self.said.append, period_s=PERIOD_S)

    def _send(self, positions: tuple[float, ...]) -> Future:
        self.asked.append((positions, Future()))
        return self.asked[-1][1]

    def answer(self, *, accepted: bool = True) -> Handle:
        handle = Handle(accepted)
        self.asked[-1][1].done(handle)
        return handle

    def pursue(self, position: float) -> Handle:
        """A goal that is taken."""
        self.now += PERIOD_S
        self.goals.pursue((position,))
        return self.answer()


def test_a_goal_is_replaced_by_the_next_which_comes_a_period_after_the_answer() -> None:
    server = Server()
    first = server.pursue(0.1)
    assert not server.goals.ready
    server.now += PERIOD_S / 2
    server.goals.pursue((0.2,))
    server.now += PERIOD_S / 2
    assert server.goals.ready
    server.goals.pursue((0.3,))
    assert not server.goals.ready, "it is not answered"
    assert [positions for positions, _ in server.asked] == [(0.1,), (0.3,)]
    first.end(ABORTED)
    server.answer()
    assert (server.goals.refusal, first.cancels, server.goals.pursued) == ("", [], True)


def test_a_stop_cancels_the_goal_and_one_that_is_not_answered_yet() -> None:
    server = Server()
    goal = server.pursue(0.1)
    server.now += PERIOD_S
    server.goals.pursue((0.2,))
    server.goals.halt()
    server.goals.halt()
    assert len(goal.cancels) == 1
    later = server.answer()
    assert len(later.cancels) == 1
    assert not server.goals.pursued
    goal.end(CANCELED)
    later.end(CANCELED)
    assert server.goals.refusal == ""
    goal.cancels[0].done(Answer(return_code=1))
    assert server.said == ["/head lets no goal be cancelled: joints go on to the set-point that was sent last"]


@pytest.mark.parametrize(
    ("status", "error", "words", "said"),
    [
        (ABORTED, -5, "pan", "/head: the goal was aborted: the joints did not get there: pan"),
        (ABORTED, 100, "", "/head: the goal was aborted"),
        (CANCELED, 0, "", "/head: the goal was cancelled by another"),
    ],
)
def test_a_goal_that_ends_badly_is_said(status: int, error: int, words: str, said: str) -> None:
    server = Server()
    server.pursue(0.1).end(status, error, words)
    assert server.goals.refusal == said
    assert not server.goals.pursued


def test_after_each_refusal_nothing_is_sent_for_twice_as_long() -> None:
    server = Server()
    rests = []
    for _ in range(6):
        server.goals.pursue((0.1,))
        server.answer(accepted=False)
        began = server.now
        assert server.goals.refusal == "/head rejected the goal"
        while server.goals.refusal:
            sent = len(server.asked)
            server.goals.pursue((0.1,))
            assert len(server.asked) == sent
            server.now += 0.25
        rests.append(server.now - began)
    assert rests == [1, 2, 4, 8, 16, 16]
    server.pursue(0.1).end(SUCCEEDED)
    server.now += PERIOD_S
    server.goals.pursue((0.2,))
    server.answer(accepted=False)
    server.now += 1.0
    assert server.goals.refusal == "", "it was well between the two"


def test_a_server_that_is_silent_or_gone_is_asked_again_later() -> None:
    server = Server()
    server.goals.pursue((0.1,))
    lost = server.asked[-1][1]
    server.now += ANSWER_S + 0.1
    server.goals.look(present=True)
    assert server.goals.refusal == "/head has not answered a goal for 1 s"
    late = Handle()
    lost.done(late)
    assert len(late.cancels) == 1, "it is not wanted any more"
    server.now += 2.0
    goal = server.pursue(0.2)
    server.goals.look(present=False)
    assert not server.goals.pursued
    goal.end(ABORTED)
    assert server.goals.refusal == ""


@given(st.lists(st.sampled_from(["pursue", "halt", "accept", "reject", "end", "wait", "look"]), max_size=40))
def test_whatever_comes_after_a_stop_no_goal_is_pursued(steps: list[str]) -> None:
    server = Server()
    taken: list[Handle] = []
    answered: set[int] = set()
    for step in steps:
        open_ = [at for at in range(len(server.asked)) if at not in answered]
        if step == "pursue":
            server.goals.pursue((0.1,))
        elif step == "halt":
            server.goals.halt()
        elif step in ("accept", "reject") and open_:
            answered.add(open_[0])
            taken.append(Handle(step == "accept"))
            server.asked[open_[0]][1].done(taken[-1])
        elif step == "end" and taken and taken[-1].accepted:
            taken.pop().end(ABORTED, -5)
        elif step == "wait":
            server.now += 0.6
        elif step == "look":
            server.goals.look(present=True)
    server.goals.halt()
    for at in range(len(server.asked)):
        if at not in answered:
            taken.append(Handle())
            server.asked[at][1].done(taken[-1])
            assert taken[-1].cancels, "a goal that is taken after the stop is cancelled"
    assert not server.goals.pursued
