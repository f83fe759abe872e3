"""Courses through the laboratory, and the person who walks one: m in the world (config/worlds/lab.yaml)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from app.base.geometry import Pose2
from app.robots.simulated.scenery.scenario_config import PersonConfig, ScenarioConfig, StepConfig

Point = tuple[float, float]

#: How fast the person walks a leg (m/s; the robot drives 0.4), and how long they stand after some of them (s).
SPEEDS_MPS, STANDS_S, STANDS_SHARE = (0.24, 0.36), (1.0, 4.0), 0.35
#: The robot begins so far (m, rad) from where it should.
START_M, START_RAD = 0.08, 0.2


@dataclass(frozen=True, slots=True)
class Course:
    """``points`` that are walked or driven one after the other; the robot begins at ``start``, the person at the first
    of them."""

    name: str
    start: Pose2
    points: tuple[Point, ...]

    @property
    def length_m(self) -> float:
        """From the robot's start to the end."""
        return sum(math.dist(a, b) for a, b in pairwise(((self.start.x, self.start.y), *self.points)))


COURSES = (
    Course(
        "robotics lab and workshop",
        Pose2(11.1, 4.6, math.pi / 2),
        ((11.1, 6.2), (11.1, 7.6), (12.3, 8.3), (12.3, 10.2), (11.8, 13.0), (11.6, 13.8), (9.2, 13.8), (6.6, 14.1),
         (6.45, 12.0), (7.1, 11.0), (6.9, 10.0), (4.9, 10.6), (4.5, 10.2), (4.5, 8.4), (4.8, 7.9), (7.0, 7.9),
         (9.2, 7.9)),
    ),
    Course(
        "living room",
        Pose2(11.1, 4.6, math.pi / 2),
        ((11.1, 6.2), (11.2, 7.6), (13.5, 7.9), (17.2, 7.75), (17.2, 5.6), (18.4, 4.6), (16.2, 4.1), (13.9, 3.2),
         (13.7, 2.6), (11.3, 2.6), (11.1, 4.6)),
    ),
    Course(
        "office",
        Pose2(11.2, 5.0, -math.pi / 2),
        ((11.2, 3.4), (11.2, 1.6), (9.0, 1.6), (8.2, 1.15), (6.4, 1.4), (5.6, 2.1), (3.4, 3.0), (3.3, 5.6),
         (6.9, 5.45), (8.5, 5.4), (9.0, 1.7), (11.2, 1.6), (11.2, 3.6)),
    ),
)  # fmt: skip


def course_of(seed: int) -> Course:
    """Seeds take the courses in turn."""
    return COURSES[seed % len(COURSES)]


def start_of(course: Course, seed: int) -> Pose2:
    """Where the robot begins: not quite at the course's start."""
    x, y, turn = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, 3)
    at = course.start
    return Pose2(at.x + START_M * x, at.y + START_M * y, at.theta + START_RAD * turn)


def walker(course: Course, seed: int) -> ScenarioConfig:
    """The person who walks ``course`` once: each leg at a speed of its own, with stands, drawn by ``seed``."""
    rng = np.random.default_rng([seed, 2])
    first, *others = course.points
    steps = [StepConfig(wait=2.0)]
    for point in others:
        steps.append(StepConfig(walk=point, speed=round(float(rng.uniform(*SPEEDS_MPS)), 3)))
        if rng.random() < STANDS_SHARE:
            steps.append(StepConfig(wait=round(float(rng.uniform(*STANDS_S)), 1)))
    dx, dy = others[0][0] - first[0], others[0][1] - first[1]
    person = PersonConfig(
        name="person who walks",
        face="pilot",
        at=first,
        heading_deg=math.degrees(math.atan2(dy, dx)),
        script=tuple(steps),
        repeat=False,
        gives_way_s=4.0,
    )
    return ScenarioConfig(name=f"a person who walks: {course.name}", seed=seed, people=(person,))
