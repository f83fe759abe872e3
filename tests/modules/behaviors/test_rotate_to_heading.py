"""Turning in place: the shorter way round, to a standstill, again when the heading changes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.desires import DesireClasses, InvalidDesire, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2, wrap_angle
from app.messages import Accomplishment, Localization, Odometry, Twist
from app.modules.behaviors.rotate_to_heading import ROTATE_TO_HEADING
from app.modules.behaviors.rotation import Rotation
from app.runtime.clock import in_virtual_time
from tests.modules.fakes import Bench, drain

PERIOD_S = 0.1


def turned(rotation: Rotation, theta: float, heading: float, seconds: float = 30.0) -> tuple[float, float]:
    """Where an ideal base ends, and by how much it turned in all."""
    all_rad = 0.0
    for count in range(round(seconds / PERIOD_S)):
        step = rotation.step(count * PERIOD_S, wrap_angle(heading - theta))
        rad = (step.radps or 0.0) * PERIOD_S
        theta, all_rad = theta + rad, all_rad + abs(rad)
    return theta, all_rad


@given(theta=st.floats(-3.1, 3.1), heading=st.floats(-3.1, 3.1))
def test_it_turns_the_shorter_way_and_stops_there(theta: float, heading: float) -> None:
    rotation = Rotation(0.5, tolerance_rad=0.1, begin_rad=0.3)
    end, all_rad = turned(rotation, theta, heading)
    assert abs(wrap_angle(heading - end)) <= 0.1
    assert all_rad <= abs(wrap_angle(heading - theta)) + 1e-6


def test_it_begins_again_only_for_a_change_that_is_seen() -> None:
    rotation = Rotation(0.5, tolerance_rad=0.1, begin_rad=0.3)
    assert rotation.step(0.0, 1.0).radps == 0.5
    assert rotation.step(1.0, 0.05).radps == 0.0
    assert rotation.step(1.1, 0.05).radps is None
    assert rotation.step(1.2, 0.29).radps is None
    assert rotation.step(1.3, -0.31).radps == pytest.approx(-0.465)


def test_a_base_that_does_not_turn_is_stuck() -> None:
    rotation = Rotation(0.5, tolerance_rad=0.1, begin_rad=0.3)
    assert not any(rotation.step(count * 0.1, 1.0).stuck for count in range(50))
    assert rotation.step(5.0, 1.0).stuck
    assert not rotation.step(5.1, 0.9).stuck, "it turns again"


class Base:
    """The behavior, and a base that does what it commands."""

    def __init__(self) -> None:
        self.bench = Bench(
            "app.modules.behaviors.rotate_to_heading:RotateToHeading",
            inputs={"odometry": Odometry, "localization": Localization},
            outputs={"twist": Twist, "accomplishments": Accomplishment},
            services={IntentionWorkspace: self.workspace()},
            attended=("twist",),
        )
        self.theta = 0.0

    def workspace(self) -> IntentionWorkspace:
        self.desires = IntentionWorkspace(DesireClasses([ROTATE_TO_HEADING]), lambda: self.bench.clock.now())
        return self.desires

    def desire(self, **params: object) -> None:
        added = self.desires.add(
            "RotateToHeading", intensity=1, utility=1, params=params, source=Source("operator", "ada")
        )
        self.bench.graph.filters.apply({"Tested.twist": 1})
        self.bench.graph.configure("Tested", added.params)

    async def live(self, seconds: float) -> None:
        twists = self.bench.listen("twist")
        for _ in range(round(seconds / PERIOD_S)):
            for twist in drain(twists):
                assert (twist.linear_mps, twist.lateral_mps) == (0, 0)
                self.theta += twist.angular_radps * PERIOD_S
            now = self.bench.clock.now()
            self.bench.feed("odometry", Odometry(now, Pose2(1.0, 2.0, wrap_angle(self.theta)), 0.0, 0.0))
            await self.bench.clock.sleep(PERIOD_S)


@in_virtual_time
async def test_the_base_turns_and_reports_it() -> None:
    base = Base()
    async with base.bench:
        done = base.bench.listen("accomplishments")
        base.bench.graph.channel("accomplishments").observe(base.desires.accomplish)
        base.desire(heading=2.0)
        await base.live(10)
        assert base.theta == pytest.approx(2.0, abs=0.1)
        (report,) = drain(done)
        assert (report.outcome, report.desire_id) == ("done", base.desires.desires()[0].id)


@in_virtual_time
async def test_a_heading_on_the_map_needs_the_map() -> None:
    base = Base()
    async with base.bench:
        base.desire(heading=0.0, frame="map")
        await base.live(2)
        assert base.theta == 0.0
        X_MO = Pose2(0, 0, -math.pi / 2)
        now = base.bench.clock.now()
        base.bench.feed("localization", Localization(now, X_MO, X_MO, np.zeros((3, 3)), "tracking", 1.0, ""))
        await base.live(10)
        assert base.theta == pytest.approx(math.pi / 2, abs=0.1)


@in_virtual_time
async def test_what_is_no_heading_is_refused() -> None:
    base = Base()
    with pytest.raises(InvalidDesire, match="heading"):
        base.desire()
