"""LookWhereGoing by itself: down and ahead while the base moves, aside for others while it stands."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.messages import Exploitation, JointCommand, Localization, PlannedPath, Twist, read_only
from app.runtime.clock import in_virtual_time
from tests.modules.behaviors.gaze.head_bench import HEAD, commanded, desire, head_bench
from tests.modules.fakes import Bench

INPUTS = {"base": Exploitation, "path": PlannedPath, "localization": Localization}


def bench() -> Bench:
    return head_bench("look_where_going:LookWhereGoing", INPUTS)


async def driven(
    b: Bench, seconds: float, linear: float, angular: float, behavior: str | None = "Teleop"
) -> list[JointCommand]:
    """What it commands while the base is given this twist."""
    commands = []
    for _ in range(round(seconds / 0.1)):
        now = b.clock.now()
        b.feed("base", Exploitation(now, behavior, Twist(now, linear, angular)))
        commands += await commanded(b, 0.1, Pose2())
    return commands


@in_virtual_time
async def test_straight_ahead_it_looks_down_as_far_as_it_can() -> None:
    async with bench() as b:
        desire(b)
        pan, tilt = (await driven(b, 1.0, 0.3, 0.0))[-1].positions
        assert pan == pytest.approx(0.0, abs=0.01)
        assert tilt == pytest.approx(HEAD.joints[1].lower)


@in_virtual_time
async def test_it_looks_into_the_turn() -> None:
    async with bench() as b:
        desire(b)
        left = (await driven(b, 0.5, 0.3, 0.5))[-1].positions[0]
        spot = (await driven(b, 0.5, 0.0, -0.9))[-1].positions[0]
        assert 0.2 < left < 0.9
        assert spot == pytest.approx(-math.radians(50), abs=0.05)


@in_virtual_time
async def test_a_path_is_looked_along_while_its_behavior_drives() -> None:
    async with bench() as b:
        desire(b)
        now, X_MO = b.clock.now(), Pose2(5.0, 0.0, 0.0)
        poses = read_only(np.array([[5.0, 0.0, 0.0], [5.5, 0.0, 0.0], [5.5, 3.0, 0.0]]))
        b.feed("path", PlannedPath(now, "map", poses))
        b.feed("localization", Localization(now, X_MO, X_MO, np.zeros((3, 3)), "tracking", 0.9, ""))
        await b.settle()
        by_path = (await driven(b, 0.5, 0.3, 0.0, "PlanAndFollowPath"))[-1].positions[0]
        assert by_path == pytest.approx(math.atan2(0.5, 0.5), abs=0.15)
        by_hand = (await driven(b, 0.5, 0.3, 0.0, "Teleop"))[-1].positions[0]
        assert by_hand == pytest.approx(0.0, abs=0.01)


@in_virtual_time
async def test_it_steps_aside_while_the_base_stands_or_backs() -> None:
    async with bench() as b:
        desire(b)
        assert await driven(b, 1.0, 0.0, 0.0, None) == []
        assert await driven(b, 1.0, 0.3, 0.0) != []
        lingering = await driven(b, 3.0, 0.0, 0.0, None)
        assert len(lingering) == pytest.approx(10, abs=2)
        assert await driven(b, 1.0, -0.3, 0.0) == []
