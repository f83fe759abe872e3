"""Which arm points where, when the base turns, and when pointing has failed."""

from __future__ import annotations

import itertools
import math
import re

import numpy as np
import pytest

from app.modules.arm_way import touching, way
from app.modules.behaviors.gestures.pointing import PointingGesture, better_arm
from tests.modules.behaviors.gestures.ideal_arms import ARMS, SERVOS, IdealBody, beside_deg, of


def pointing(*sides: str, hold_s: float = 1.0, turn_radps: float | None = 0.5) -> PointingGesture:
    return PointingGesture(of(*(sides or ("left", "right"))), SERVOS, hold_s=hold_s, turn_radps=turn_radps)


@pytest.mark.parametrize(("y", "side"), [(1.0, "left"), (-1.0, "right")])
def test_the_arm_on_the_points_side_points(y: float, side: str) -> None:
    body, point = IdealBody(), np.array([2.0, y, 1.2])
    ended = body.run(pointing(), point)
    assert (ended.outcome, ended.reason) == ("done", f"the {side} arm pointed at it")
    assert beside_deg(side, body, point) < 5.0
    assert not body.turned
    other = {"left": "right", "right": "left"}[side]
    assert ARMS[other].positions(body.joints).tolist() == [0.0] * 4


def test_it_points_for_as_long_as_it_is_asked_to() -> None:
    lasts = []
    for hold_s in (0.0, 5.0):
        body = IdealBody()
        body.run(pointing(hold_s=hold_s), np.array([2.0, 0.5, 1.0]))
        lasts.append(len(body.steps) * 0.1)
    assert lasts[1] - lasts[0] == pytest.approx(5.0, abs=0.11)


@pytest.mark.parametrize("bearing_deg", [70, 150, -100, 179])
def test_the_base_turns_to_what_is_further_beside_and_the_arm_is_raised_only_then(bearing_deg: float) -> None:
    bearing = math.radians(bearing_deg)
    body, point = IdealBody(), np.array([2 * math.cos(bearing), 2 * math.sin(bearing), 1.0])
    ended = body.run(pointing(), point)
    assert ended.outcome == "done"
    assert {math.copysign(1.0, speed) for speed in body.turned} == {math.copysign(1.0, bearing)}
    assert max(map(abs, body.turned)) <= 0.5
    assert abs(bearing - body.heading) < math.radians(30)
    turning = [step for step in body.steps if step.turn_radps is not None]
    assert all(not step.commands for step in turning), "the arm hangs while it turns"
    p_BP = body.view(point).p_BP
    assert p_BP is not None
    assert min(beside_deg(side, body, p_BP) for side in ARMS) < 5.0


def test_a_raised_arm_is_lowered_before_the_base_turns_on_and_points_again_then() -> None:
    body, gesture = IdealBody(), pointing(hold_s=1.0)
    body.run(gesture, np.array([2.0, 1.0, 1.0]), most_s=2.0)
    body.steps.clear()
    ended = body.run(gesture, np.array([-2.0, 1.0, 1.0]))
    first = next(number for number, step in enumerate(body.steps) if step.turn_radps is not None)
    lowering = [command.positions for step in body.steps[:first] for command in step.commands]
    assert set(lowering) == {tuple(ARMS["left"].rest)}
    assert len(lowering) > 5
    assert ended.outcome == "done"
    p_BP = body.view(np.array([-2.0, 1.0, 1.0])).p_BP
    assert p_BP is not None
    assert beside_deg("left", body, p_BP) < 5.0


def test_without_turning_what_is_behind_is_out_of_reach() -> None:
    ended = IdealBody().run(pointing(turn_radps=None), np.array([-2.0, 0.0, 1.0]))
    assert ended.outcome == "failed"
    assert re.fullmatch(r"the (left|right) arm would point \d+° beside it(; .*)?", ended.reason)


def test_a_base_that_does_not_turn_ends_it() -> None:
    body, gesture = IdealBody(), pointing()
    for _ in range(400):
        body.heading = 0.0  # the collision monitor keeps it
        ended = body.run(gesture, np.array([-2.0, 1.0, 1.0]), most_s=0.1)
        if ended.outcome:
            break
    assert (ended.outcome, ended.reason) == ("failed", "the base does not turn to it; it is 153° beside")


def test_the_arm_asked_for_points_even_where_the_other_is_better() -> None:
    body, point = IdealBody(), np.array([2.5, 0.3, 1.0])
    assert body.run(pointing("right"), point).reason == "the right arm pointed at it"
    assert beside_deg("right", body, point) < 5.0


def test_an_arm_that_points_keeps_at_it_when_the_point_passes_to_the_other_side() -> None:
    body, gesture = IdealBody(), pointing(hold_s=100.0)
    for y in np.linspace(0.4, -0.2, 40):
        body.run(gesture, np.array([3.0, y, 1.0]), most_s=0.1)
    assert {command.group for step in body.steps for command in step.commands} == {"left_arm"}


def test_an_arm_goes_around_the_other_that_bars_its_way() -> None:
    arm, body = ARMS["left"], IdealBody()
    body.joints.update(zip(ARMS["right"].names, (-1.36, 0.05, 1.0, -1.14), strict=True))
    body.joints.update(zip(arm.names, (-0.5, 0.1, -0.9, -1.2), strict=True))
    goal = np.array([-1.9, 0.1, -0.9, -1.2])
    straight = way(arm.kinematics.joints, arm.positions(body.joints), goal)
    assert "would touch right_" in touching(arm.collision, straight, body.joints)
    route = arm.route(goal, body.joints)
    assert not isinstance(route, str)
    for begin, end in itertools.pairwise([arm.positions(body.joints), *route]):
        assert touching(arm.collision, way(arm.kinematics.joints, begin, end), body.joints) == ""


def test_points_all_around_in_front_are_pointed_at_without_touching_the_body() -> None:
    random = np.random.default_rng(8)
    for _ in range(60):
        azimuth, distance = random.uniform(-math.pi / 3, math.pi / 3), random.uniform(1.0, 5.0)
        height = 0.9 + distance * math.sin(random.uniform(-0.9, 0.9))
        point = np.array([distance * math.cos(azimuth), distance * math.sin(azimuth), height])
        aimed = better_arm(ARMS, point, IdealBody().joints)
        assert not isinstance(aimed, str), (point, aimed)
        hanging = IdealBody()
        hanging.joints.update(zip(aimed.arm.names, aimed.route[-1].tolist(), strict=True))
        assert beside_deg(aimed.arm.side, hanging, point) <= 5.0, point


def test_a_joint_that_does_not_move_and_a_refusal_end_it_with_the_reason() -> None:
    body = IdealBody(stuck=(ARMS["left"].names[0],))
    ended = body.run(pointing(), np.array([2.0, 1.0, 1.2]))
    assert ended.outcome == "failed"
    assert ended.reason.startswith("left_shoulder_pitch_joint stays ")
    body = IdealBody(stuck=ARMS["left"].names)
    body.report("left_arm", "Tested", "left_forearm_link would touch head_link")
    ended = body.run(pointing(), np.array([2.0, 1.0, 1.2]))
    assert ended.reason == "left_forearm_link would touch head_link"
    assert len(body.steps) < 20


def test_while_another_behavior_moves_the_arm_it_waits() -> None:
    body = IdealBody(stuck=ARMS["left"].names)
    body.report("left_arm", "Reach")
    assert body.run(pointing(), np.array([2.0, 1.0, 1.2]), most_s=30.0).outcome is None
    body.report("left_arm", "Tested")
    body.stuck = ()
    assert body.run(pointing("left"), np.array([2.0, 1.0, 1.2])).outcome == "done"


def test_without_the_point_it_waits() -> None:
    step = pointing().step(IdealBody().view(None))
    assert step.reason == "it waits: where the point is, is not known"
    assert not step.commands
