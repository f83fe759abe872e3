"""How long the goals that are left may take."""

from __future__ import annotations

from app.experiments.goals.report import Pace


def test_the_time_left_is_told_from_the_goals_done_since_the_map_was_there() -> None:
    pace = Pace(0.0)
    pace.begin(100.0)  # a hundred seconds of mapping count for nothing
    pace.done(160.0, 30.0)
    pace.done(220.0, 90.0)
    assert pace.told(10) == "about 10 min left, 1.0 simulated s a second"
