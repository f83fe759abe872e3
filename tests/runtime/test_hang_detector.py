from __future__ import annotations

from typing import Any

import pytest

from app.messages import Twist
from app.runtime.channel import Channel
from app.runtime.hang_detector import HangDetector
from app.runtime.ports import Input


class Stage:
    """An input port, timers and a clock turned by hand."""

    def __init__(self, limit_s: float = 1.0) -> None:
        self.now = 100.0
        channel = Channel("numbers", Twist, lambda: self.now)
        self.port: Input[Any] = Input("M", "numbers", Twist)
        self.port.connect(channel, 1)
        self.channel = channel
        self.ticks: dict[str, tuple[float, float]] = {}
        unwired: Input[Any] = Input("M", "other", Twist)
        self.watch = HangDetector((self.port, unwired), self.ticks, limit_s, self.now)

    def pass_time(self, seconds: float, step_s: float = 0.1) -> str | None:
        stuck = None
        for _ in range(round(seconds / step_s)):
            self.now += step_s
            stuck = stuck or self.watch.look(self.now)
        return stuck

    def publish(self) -> None:
        self.channel.publish(Twist(self.now, 0.0, 0.0))


def test_waiting_messages_that_are_not_taken_mean_stuck() -> None:
    stage = Stage()
    assert stage.pass_time(10) is None
    stage.publish()
    assert stage.pass_time(1.0) is None
    stuck = stage.pass_time(0.3)
    assert stuck is not None
    assert stuck.startswith("messages wait at numbers and none was taken for 1.")


def test_a_slow_consumer_that_takes_now_and_then_is_not_stuck() -> None:
    stage = Stage()
    for _ in range(20):
        stage.publish()
        assert stage.pass_time(0.9) is None
        stage.port.subscription.receive_nowait()


def test_a_newer_message_does_not_hide_that_none_is_taken() -> None:
    stage = Stage()
    stuck = None
    for _ in range(15):
        stage.publish()
        stuck = stuck or stage.pass_time(0.1)
    assert stuck is not None


def test_closing_the_filter_is_not_progress_and_not_a_fault() -> None:
    stage = Stage()
    stage.publish()
    assert stage.pass_time(0.9) is None
    stage.port.subscription.filter.divisor = float("inf")
    assert stage.pass_time(10) is None


def test_no_module_is_blamed_for_time_in_which_the_loop_was_blocked() -> None:
    stage = Stage()
    stage.publish()
    assert stage.pass_time(0.1) is None
    # Another module blocked the loop for 5 s: no message could be taken.
    assert stage.pass_time(5, step_s=5) is None
    assert stage.pass_time(0.7) is None
    assert stage.pass_time(0.4) is not None


@pytest.mark.parametrize(("period_s", "limit_s"), [(0.01, 1.0), (0.5, 5.0)])
def test_a_timer_is_stuck_after_ten_periods_but_not_before_the_limit(period_s: float, limit_s: float) -> None:
    stage = Stage()
    stage.ticks["beat-0"] = (stage.now, period_s)
    assert stage.pass_time(limit_s) is None
    stuck = stage.pass_time(0.3)
    assert stuck is not None
    assert stuck.startswith("its periodic beat-0 did not come round for")


def test_while_nothing_waits_there_is_nothing_to_look_at() -> None:
    stage = Stage()
    assert not any(stage.watch.signs)
    stage.publish()
    assert any(stage.watch.signs)
    stage.pass_time(0.2)
    stage.port.subscription.receive_nowait()
    assert any(stage.watch.signs), "what the last look saw is not forgotten yet"
    stage.pass_time(0.1)
    assert not any(stage.watch.signs)
    stage.ticks["beat"] = (stage.now, 0.1)
    assert any(stage.watch.signs)


def test_what_was_not_looked_at_while_idle_counts_for_nothing() -> None:
    stage = Stage()
    stage.publish()
    stage.pass_time(0.9)
    stage.port.subscription.discard()
    stage.pass_time(0.1)
    stage.now += 60.0
    stage.publish()
    assert stage.pass_time(1.0) is None
    assert stage.pass_time(0.3) is not None
