"""Where a base will be: within its accelerations, wherever it is, and as the page predicts it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.base.motion_prediction import FARTHEST_S, Commanded, Motion, Velocity, predicted

EXAMPLES = Path(__file__).resolve().parents[2] / "web/src/drive/prediction.examples.json"
ACCELERATION, TURN = 0.8, 2.0

velocities = st.builds(Velocity, *(st.floats(-1.0, 1.0) for _ in range(3)))
poses = st.builds(Pose2, st.floats(-5, 5), st.floats(-5, 5), st.floats(-math.pi, math.pi))
commands = st.lists(st.builds(Commanded, st.floats(9.0, 11.5), velocities), max_size=6).map(
    lambda found: sorted(found, key=lambda each: each.stamp)
)
horizons = st.floats(0.0, FARTHEST_S)


def ahead(motion: Motion, given_commands: list[Commanded], until: float) -> Motion:
    return predicted(motion, given_commands, until, linear_mps2=ACCELERATION, angular_radps2=TURN)


@given(poses, velocities, commands)
def test_now_is_where_it_is(pose: Pose2, velocity: Velocity, given_commands: list[Commanded]) -> None:
    motion = Motion(10.0, pose, velocity)
    assert ahead(motion, given_commands, 10.0) == motion
    assert ahead(motion, given_commands, 9.0) == motion


@given(poses, velocities, commands, horizons)
def test_no_velocity_changes_faster_than_the_body_can(
    pose: Pose2, velocity: Velocity, given_commands: list[Commanded], s: float
) -> None:
    after = ahead(Motion(10.0, pose, velocity), given_commands, 10.0 + s)
    assert after.stamp == pytest.approx(10.0 + s)
    assert abs(after.velocity.linear - velocity.linear) <= ACCELERATION * s + 1e-9
    assert abs(after.velocity.lateral - velocity.lateral) <= ACCELERATION * s + 1e-9
    assert abs(after.velocity.angular - velocity.angular) <= TURN * s + 1e-9
    fastest = math.hypot(1.0, 1.0)
    assert math.hypot(after.X_OB.x - pose.x, after.X_OB.y - pose.y) <= fastest * s + 1e-9


@given(poses, velocities, commands, horizons)
def test_it_is_the_same_wherever_the_base_is(
    pose: Pose2, velocity: Velocity, given_commands: list[Commanded], s: float
) -> None:
    here = ahead(Motion(10.0, Pose2(0.0, 0.0, 0.0), velocity), given_commands, 10.0 + s)
    there = ahead(Motion(10.0, pose, velocity), given_commands, 10.0 + s)
    moved = pose @ here.X_OB
    assert (there.X_OB.x, there.X_OB.y) == pytest.approx((moved.x, moved.y), abs=1e-9)
    assert math.remainder(there.X_OB.theta - moved.theta, math.tau) == pytest.approx(0.0, abs=1e-9)


@given(velocities, horizons)
def test_what_no_command_changes_goes_on_along_its_arc(velocity: Velocity, s: float) -> None:
    after = ahead(Motion(0.0, Pose2(0.0, 0.0, 0.0), velocity), [], s).X_OB
    turn = velocity.angular * s
    straight, aside = (s, 0.0) if abs(turn) < 1e-6 else (math.sin(turn) / turn * s, (1 - math.cos(turn)) / turn * s)
    x = velocity.linear * straight - velocity.lateral * aside
    y = velocity.linear * aside + velocity.lateral * straight
    assert (after.x, after.y, after.theta) == pytest.approx((x, y, turn), abs=1e-3)


def test_it_stops_within_its_braking_distance() -> None:
    after = ahead(Motion(0.0, Pose2(0.0, 0.0, 0.0), Velocity(0.4)), [Commanded(0.0, Velocity())], 1.5)
    assert after.velocity.linear == 0.0
    assert after.X_OB.x == pytest.approx(0.4**2 / (2 * ACCELERATION), rel=0.02)


def test_the_page_predicts_the_same() -> None:
    for example in json.loads(EXAMPLES.read_text(encoding="utf-8")):
        start = example["motion"]
        after = predicted(
            Motion(start["stamp"], Pose2(*start["pose"]), Velocity(*start["velocity"])),
            [Commanded(each["stamp"], Velocity(*each["velocity"])) for each in example["commands"]],
            example["until"],
            linear_mps2=example["linear_mps2"],
            angular_radps2=example["angular_radps2"],
        )
        found = [after.X_OB.x, after.X_OB.y, after.X_OB.theta, after.velocity.linear, after.velocity.angular]
        assert found == pytest.approx(example["predicted"], abs=1e-6)
