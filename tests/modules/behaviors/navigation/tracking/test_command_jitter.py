"""How regularly a behavior commands."""

from __future__ import annotations

import pytest

from app.modules.behaviors.navigation.tracking.command_jitter import CommandJitter


def test_the_longest_of_late_is_reported_and_a_rest_is_no_period() -> None:
    periods = CommandJitter()
    assert periods.longest_s is None
    for now in (0.0, 0.1, 0.25):
        periods.commanded(now)
    assert periods.longest_s == pytest.approx(0.15)
    periods.rest()
    periods.commanded(9.0)
    assert periods.longest_s == pytest.approx(0.15)
    for k in range(1, 101):
        periods.commanded(9.0 + 0.1 * k)
    assert periods.longest_s == pytest.approx(0.1)
