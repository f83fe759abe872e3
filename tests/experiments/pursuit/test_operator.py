"""The scripted operator, on a body that does what its model says, seen and commanded late."""

from __future__ import annotations

import math
from collections import deque

import pytest

from app.base.geometry import Pose2
from app.base.motion_prediction import Commanded, Motion, Velocity, predicted
from app.experiments.pursuit.courses import COURSES, START_M, start_of, walker
from app.experiments.pursuit.operator import KEPT_M, PERIOD_S, Operator, Style
from app.experiments.pursuit.remote_console import Shown
from app.link import BaseLimits

LIMITS = BaseLimits(0.4, 1.0, 0.4, 4.0)
#: An L of a metre and a half each.
CORNER = ((1.5, 0.0), (1.5, 1.5))


class Drive:
    """An operator with ``style``, half of ``round_trip_s`` behind the body and before it."""

    def __init__(self, style: Style, round_trip_s: float, course: tuple[tuple[float, float], ...] = ()) -> None:
        self.operator = Operator(style, LIMITS, course)
        self.motion = Motion(0.0, Pose2())
        self.pan = 0.0
        self.round_trip_s = round_trip_s
        late = max(1, round(round_trip_s / 2 / PERIOD_S))
        self.shown: deque[Shown] = deque(maxlen=late)
        self.commands: deque[tuple[Velocity, float]] = deque([(Velocity(), 0.0)] * late, maxlen=late)

    def step(self, person: tuple[float, float] | None = None) -> None:
        now = self.motion.stamp
        self.shown.append(Shown(now, self.motion.X_OB, self.motion.velocity, self.pan, scan=None, person=person))
        hands = self.operator.act(now, self.shown[0], self.round_trip_s)
        velocity, pan = self.commands[0]
        self.commands.append((Velocity(hands.linear * 0.4, hands.angular * 1.0), hands.pan))
        self.pan += pan * 1.05 * PERIOD_S
        self.motion = predicted(
            self.motion, [Commanded(now, velocity)], now + PERIOD_S, linear_mps2=0.4, angular_radps2=4.0
        )


@pytest.mark.parametrize("prediction", [False, True])
@pytest.mark.parametrize("round_trip_s", [0.0, 0.15, 0.3])
def test_a_course_is_driven_to_its_end(round_trip_s: float, prediction: bool) -> None:
    drive = Drive(Style(1, prediction), round_trip_s, CORNER)
    off = 0.0
    while not drive.operator.arrived:
        drive.step()
        assert drive.motion.stamp < 30.0
        x, y = drive.motion.X_OB.x, drive.motion.X_OB.y
        off = max(off, -y, x - 1.5)
    assert off < 0.3
    assert math.dist((drive.motion.X_OB.x, drive.motion.X_OB.y), CORNER[-1]) < 0.5


def _swing(prediction: bool) -> float:
    """How far (rad) the heading swings on a straight way of 3 m that begins aside, after the first metre."""
    drive = Drive(Style(1, prediction), 0.9, ((0.0, 0.25), (8.0, 0.25)))
    swing = 0.0
    while drive.motion.X_OB.x < 4.0:
        drive.step()
        if drive.motion.X_OB.x > 1.0:
            swing = max(swing, abs(drive.motion.X_OB.theta))
    return swing


def test_with_prediction_it_swings_less() -> None:
    assert _swing(True) < 0.7 * _swing(False)


@pytest.mark.parametrize("mode", [1, 2])
def test_it_stops_before_a_person_who_stands(mode: int) -> None:
    drive = Drive(Style(mode), 0.0)
    while drive.motion.stamp < 15.0:
        drive.step((3.0, 0.5))
    away = math.dist((drive.motion.X_OB.x, drive.motion.X_OB.y), (3.0, 0.5))
    assert KEPT_M - 0.1 < away < KEPT_M + 0.2
    assert abs(drive.motion.velocity.linear) < 0.02


def test_in_mode_2_the_head_is_on_a_person_aside_who_is_near() -> None:
    drive = Drive(Style(2), 0.0)
    while drive.motion.stamp < 4.0:
        drive.step((1.0, 0.45))  # 24 degrees aside
    assert math.degrees(drive.pan + drive.motion.X_OB.theta) == pytest.approx(24.0, abs=3.0)


def test_a_robot_that_sees_nothing_is_left_alone() -> None:
    drive = Drive(Style(1), 0.0)
    for _ in range(20):
        drive.step(None)
    assert (drive.motion.X_OB.x, drive.motion.X_OB.theta) == (0.0, 0.0)


def test_courses_begin_before_the_robot_and_are_walked_by_the_seed() -> None:
    for course in COURSES:
        here = start_of(course, 7)
        assert math.dist((here.x, here.y), (course.start.x, course.start.y)) <= START_M * math.sqrt(2)
        towards = math.atan2(course.points[0][1] - here.y, course.points[0][0] - here.x)
        assert abs(math.remainder(towards - here.theta, math.tau)) < 0.4
        (person,) = walker(course, 7).people
        assert person.script[-1].walk == course.points[-1] or person.script[-2].walk == course.points[-1]
        assert walker(course, 7) == walker(course, 7) != walker(course, 10)
