"""Reaching, waving and resting on arms that go where they are commanded."""

from __future__ import annotations

import numpy as np
import pytest

from app.modules.behaviors.gestures.arm_kinematics import OutOfReach
from app.modules.behaviors.gestures.gesture import Servo
from app.modules.behaviors.gestures.reaching import (
    ReachGesture,
    RestGesture,
    SequenceGesture,
    reaching_route,
    waving_postures,
)
from tests.modules.behaviors.gestures.ideal_arms import ARMS, SERVOS, IdealBody, of


def reach(*sides: str, hold_s: float = 0.0) -> ReachGesture:
    return ReachGesture(of(*(sides or ("left", "right"))), SERVOS, hold_s)


def hand(side: str, body: IdealBody) -> np.ndarray:
    return ARMS[side].kinematics.hand(ARMS[side].positions(body.joints))


@pytest.mark.parametrize(("y", "side"), [(0.25, "left"), (-0.25, "right")])
def test_the_hand_of_the_nearer_shoulder_comes_to_the_point(y: float, side: str) -> None:
    body, point = IdealBody(), np.array([0.35, y, 0.95])
    ended = body.run(reach(), point)
    assert (ended.outcome, ended.reason) == ("done", f"the {side} hand is there")
    assert np.linalg.norm(hand(side, body) - point) < 0.03


def test_it_stays_there_and_follows_the_point_with_the_same_hand() -> None:
    body, gesture = IdealBody(), reach(hold_s=3.0)
    body.run(gesture, np.array([0.35, 0.05, 0.95]), most_s=3.0)
    ended = body.run(gesture, np.array([0.35, -0.02, 0.95]))
    assert ended.outcome == "done"
    assert {command.group for step in body.steps for command in step.commands} == {"left_arm"}
    assert np.linalg.norm(hand("left", body) - [0.35, -0.02, 0.95]) < 0.03


@pytest.mark.parametrize(
    ("point", "reason"),
    [
        ((1.5, 0.0, 0.9), "left arm: it is 1.54 m from the shoulder, and the arm reaches 0.5"),
        ((-0.03, 0.25, 0.85), "left arm: it is 0.07 m from the shoulder, and the bent arm comes no nearer than"),
        ((-0.35, 0.2, 1.2), "left arm: the joints' limits keep the hand from it"),
        ((-0.03, 0.0, 0.74), "the left arm would touch the body there"),
    ],
)
def test_what_cannot_be_reached_fails_at_once_with_the_reason_of_each_arm(
    point: tuple[float, float, float], reason: str
) -> None:
    body = IdealBody()
    ended = body.run(reach(), np.array(point))
    assert ended.outcome == "failed"
    assert ended.reason.startswith(reason)
    assert ";" in ended.reason
    assert len(body.steps) == 1


def test_every_posture_of_a_route_is_free_of_the_body() -> None:
    random, body, found = np.random.default_rng(7), IdealBody(), 0
    for point in random.uniform([0.0, -0.5, 0.6], [0.5, 0.5, 1.3], (60, 3)):
        chosen = reaching_route(ARMS, point, body.joints)
        if not isinstance(chosen, str):
            arm, route = chosen
            found += 1
            for posture in route:
                assert arm.collision.clearances(posture[None], body.joints)[0].distance_m > 0.0
            assert np.linalg.norm(arm.kinematics.hand(route[-1]) - point) < 1e-6
    assert found > 20


def test_a_wave_goes_to_and_fro_above_the_shoulder() -> None:
    for side, arm in ARMS.items():
        body = IdealBody()
        ended = body.run(SequenceGesture(arm, SERVOS[side], waving_postures(arm, 3), "it waved"))
        assert (ended.outcome, ended.reason) == ("done", "it waved")
        goals = list(dict.fromkeys(step.commands[0].positions for step in body.steps if step.commands))
        hands = [arm.kinematics.hand(np.array(goal)) for goal in goals]
        assert len(goals) == 2
        assert min(position[2] for position in hands) > 1.0
        assert abs(hands[0][1] - hands[1][1]) > 0.15
        assert abs(hands[1][1]) > abs(hands[0][1]), "it swings outwards"
        assert sum(a != b for a, b in zip(body.steps, body.steps[1:], strict=False)) > 0


def test_an_arm_that_cannot_be_raised_does_not_wave() -> None:
    arm = ARMS["left"]
    low = type(arm.kinematics)(
        tuple(type(j)(j.name, max(j.lower, -0.3), j.upper, j.velocity, j.acceleration) for j in arm.kinematics.joints),
        arm.kinematics.X_BS,
        arm.kinematics.upper_m,
        arm.kinematics.forearm_m,
        arm.kinematics.signs,
    )
    hanging = type(arm)("left", arm.group, None, kinematics=low, collision=arm.collision, rest=arm.rest)
    with pytest.raises(OutOfReach):
        waving_postures(hanging, 1)


def test_both_arms_rest_and_a_free_one_keeps_no_position() -> None:
    body = IdealBody()
    for arm in ARMS.values():
        body.joints.update(zip(arm.names, (-1.0, 0.0, 0.0, -1.0), strict=True))
    ended = body.run(RestGesture(ARMS, SERVOS, 0.0))
    assert ended.outcome == "done"
    for arm in ARMS.values():
        np.testing.assert_allclose(arm.positions(body.joints), arm.rest, atol=0.05)
    limp = {side: Servo("Tested", arm.group, (0.0, 0.5)) for side, arm in ARMS.items()}
    body = IdealBody(stuck=tuple(body.joints))
    ended = body.run(RestGesture(ARMS, limp, 2.0))
    assert ended.outcome == "done"
    assert len(body.steps) == pytest.approx(21, abs=1)
    assert {command.stiffness for step in body.steps for command in step.commands} == {(0.0,) * 4}
