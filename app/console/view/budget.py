"""How many points a viewer is sent and how often, from what was measured of it: pure functions."""

from __future__ import annotations

from dataclasses import dataclass, replace

FEWEST_POINTS = 400
#: With steps of the voxel map's share, a view that draws at ease has 75,000 points or more once the map is full.
MOST_POINTS = 110_000
FIRST_POINTS = 4_000
#: Greatest delay from the robot to the eye (s) that the budget aims at.
TARGET_LAG_S = 0.2
#: Two frames should not take longer: a page must have time for more than drawing.
TARGET_FRAMES_S = 0.1
#: A viewer that does not answer for this long does not draw (a hidden tab, a stalled computer).
SILENT_AFTER_S = 1.5

#: Weight of a new measurement, which come 4 times a second.
_SMOOTHING = 0.35
_GROWTH = 1.10
_COMFORT = 0.7
_STEEPEST_CUT = 0.6


#: Between two updates of a view that draws at ease, and of one that hardly draws at all.
SHORTEST_PERIOD_S = 0.04
LONGEST_PERIOD_S = 1.0
#: Two frames that take up to this long are drawn at ease.
_EASY_FRAMES_S = 0.05
#: A view gets this share of the time it takes to draw for other things: its page's keys and clocks.
_REST = 3.0


@dataclass(frozen=True, slots=True)
class PointBudget:
    """``points`` a viewer gets in all; its smoothed ``lag_s``, and ``frames_s`` that two of its frames take."""

    points: float = FIRST_POINTS
    lag_s: float | None = None
    frames_s: float = _EASY_FRAMES_S

    @property
    def period_s(self) -> float:
        """The time to leave between two updates."""
        if self.frames_s <= _EASY_FRAMES_S:
            return SHORTEST_PERIOD_S
        return min(_REST * self.frames_s, LONGEST_PERIOD_S)


def measured(budget: PointBudget, lag_s: float, frames_s: float = 0.0) -> PointBudget:
    """The budget after a measurement: it grows slowly well under both targets, shrinks the faster the further over."""
    smooth = lag_s if budget.lag_s is None else budget.lag_s + _SMOOTHING * (lag_s - budget.lag_s)
    frames = budget.frames_s + _SMOOTHING * (frames_s - budget.frames_s)
    points = budget.points
    # Judged by the better of the two: one late answer is no trend, and a trend that has ended must not cut on.
    excess = max(min(smooth, lag_s) / TARGET_LAG_S, min(frames, frames_s) / TARGET_FRAMES_S)
    if excess > 1.0:
        points *= max(_STEEPEST_CUT, 1.0 / excess)
    elif max(smooth / TARGET_LAG_S, frames / TARGET_FRAMES_S) < _COMFORT:
        points *= _GROWTH
    return PointBudget(min(max(points, FEWEST_POINTS), MOST_POINTS), smooth, frames)


def divided(points: int, cloud: int) -> tuple[int, int]:
    """How many of ``points`` the newest cloud of ``cloud`` points gets (at most half), and the voxel map (the rest)."""
    newest = min(cloud, points // 2)
    return newest, points - newest


def silent(budget: PointBudget) -> PointBudget:
    """The budget of a viewer that did not answer in time."""
    frames = budget.frames_s + _SMOOTHING * (SILENT_AFTER_S - budget.frames_s)
    return replace(budget, points=max(FEWEST_POINTS, budget.points * _STEEPEST_CUT), frames_s=frames)
