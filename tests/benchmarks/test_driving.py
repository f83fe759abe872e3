"""What the benchmark of driving reads from the guard's log."""

from __future__ import annotations

from unittest.mock import MagicMock

import pytest

from app.robots.simulated.guard_log import GuardRow
from benchmarks import driving
from benchmarks.driving import latencies


def log(*speeds: float) -> list[GuardRow]:
    """The wheels were given these speeds, 10 ms apart, from 0 on."""
    return [GuardRow(0.01 * number, speed, 0.0) for number, speed in enumerate(speeds)]


def test_press_and_release_are_distinguished() -> None:
    # Held backward too: slower is nearer to zero.
    for sign in (1, -1):
        rows = log(*(sign * speed for speed in (0, 0, 0, 0.1, 0.2, 0.3, 0.3, 0.3, 0.2, 0.1, 0)))
        found = latencies(rows, 0.011, 0.052)
        assert found == pytest.approx((0.019, 0.028))


@pytest.mark.parametrize(
    "speeds",
    [
        (0, 0, 0, 0, 0, 0, 0),  # never moved
        (0, 0, 0.1, 0.1, 0, 0, 0, 0),  # a hitch had stopped it before the release
        (0, 0, 0, 0, 0, 0, 0.1, 0.2),  # only after it
        (0, 0, 0.1, 0.2, 0.2, 0.2, 0.2),  # the log ends before it brakes
    ],
)
def test_what_shows_no_latency_is_no_sample(speeds: tuple[float, ...]) -> None:
    assert latencies(log(*speeds), 0.011, 0.051) is None


def test_wheels_that_never_move_end_it_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driving, "PATIENCE_S", 0.0)
    robot, page = MagicMock(), MagicMock()
    robot.wheels.return_value = log(0, 0, 0)
    robot.get.return_value = {"guard": {"state": "e_stopped", "reason": "emergency stop: a test"}}
    page.evaluate.return_value = [[0.0, 1.0], [20.0, 1.0]]
    page.locator.return_value.all_inner_texts.return_value = ["The emergency stop is latched."]
    with pytest.raises(SystemExit) as end:
        driving._sample(robot, page, 0, 0.0)
    assert end.value.code == (
        "driving: 4 presses did not move the wheels until the key was let go; "
        "the guard says e_stopped: emergency stop: a test; the page says: The emergency stop is latched."
    )
