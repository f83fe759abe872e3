"""Runs of a tour as they should be, for tests to change."""

from __future__ import annotations

from typing import Any

from app.experiments.tour.result import OVER, Arrival, SaidText, Sample, TourResult


def good(**changes: Any) -> TourResult:
    """A run without a problem, but for ``changes``."""
    members: dict[str, Any] = {
        "seed": 1,
        "outcome": OVER,
        "duration_s": 120.0,
        "driven_m": 12.0,
        "stops": 2,
        "presented": 2,
        "arrivals": (Arrival("one", 0.1, -0.05), Arrival("two", 0.2, 0.1)),
        "texts": (SaidText("Hello.", ended=True),),
        "unsaid": (),
        "pointed_deg": (3.5,),
        "to_point": 1,
        "wait_m": 4.0,
        "left_behind_s": 6.0,
        "farthest_m": 5.0,
        "touched": 0,
        "people_m": 0.4,
        "cpu_share": 0.9,
        "asked": 1,
        "answered": 1,
        "waits": 1,
        "waited_s": 3.0,
        "failures": (),
        "wall_s": 10.0,
        "cpu_s": 9.0,
        "trace": tuple(sample(float(at), "leading" if at < 5 else "waiting", 1.0 + at) for at in range(8)),
    }
    return TourResult(**members | changes)


def sample(at_s: float, state: str, *away_m: float) -> Sample:
    """The robot at the origin, and visitors so far from it."""
    return Sample(at_s, (0.0, 0.0, 0.0), tuple((-away, 0.0) for away in away_m), state)
