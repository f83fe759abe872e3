"""Gestures without a body: arms whose joints go where they are commanded at their speed, and a base that turns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.messages import Exploitation, JointCommand, Twist
from app.modules.behaviors.gestures.arms import Arm, load_arms
from app.modules.behaviors.gestures.gesture import Gesture, GestureStep, GestureView, Servo
from tests.modules.actuation.arms import GROUPS, JOINTS, link

PERIOD_S = 0.1
ARMS: Mapping[str, Arm] = load_arms(link().description)
SERVOS = {side: Servo("Tested", arm.group, None) for side, arm in ARMS.items()}
SPEEDS = {joint.name: joint.velocity for group in GROUPS.values() for joint in group.joints}


@dataclass
class IdealBody:
    """Joints by name, and the base's heading (rad); ``stuck`` joints do not move; ``reports`` are the arbiters'."""

    joints: dict[str, float] = field(default_factory=lambda: dict.fromkeys(JOINTS, 0.0))
    heading: float = 0.0
    now: float = 100.0
    stuck: tuple[str, ...] = ()
    reports: dict[str, Exploitation] = field(default_factory=dict)
    steps: list[GestureStep] = field(default_factory=list)

    def view(self, p_OP: NDArray[np.float64] | None) -> GestureView:
        """What a gesture sees, with a point of the room."""
        p_BP = None
        if p_OP is not None:
            c, s = math.cos(self.heading), math.sin(self.heading)
            p_BP = np.array([c * p_OP[0] + s * p_OP[1], c * p_OP[1] - s * p_OP[0], p_OP[2]])
        return GestureView(self.now, dict(self.joints), dict(self.reports), p_BP)

    def obey(self, command: JointCommand) -> None:
        """Move as far as the joints' speed lets them in one period."""
        for name, goal in zip(command.names, command.positions, strict=True):
            if name not in self.stuck:
                most = SPEEDS[name] * PERIOD_S
                self.joints[name] += min(max(goal - self.joints[name], -most), most)

    def report(self, group: str, behavior: str | None, limited: str = "") -> None:
        """An arbiter's report from now on."""
        self.reports[group] = Exploitation(self.now, behavior, Twist(self.now, 0.0, 0.0), limited, group=group)

    def run(self, gesture: Gesture, p_OP: NDArray[np.float64] | None = None, most_s: float = 60.0) -> GestureStep:
        """Step until the gesture ends, or for ``most_s``; return the last step."""
        for _ in range(round(most_s / PERIOD_S)):
            step = gesture.step(self.view(p_OP))
            self.steps.append(step)
            for command in step.commands:
                self.obey(command)
            self.heading += (step.turn_radps or 0.0) * PERIOD_S
            self.now += PERIOD_S
            if step.outcome is not None:
                break
        return step

    @property
    def turned(self) -> list[float]:
        """The turning speeds that were given."""
        return [step.turn_radps for step in self.steps if step.turn_radps is not None]


def of(*sides: str) -> dict[str, Arm]:
    """The arms of ``sides``."""
    return {side: ARMS[side] for side in sides}


def beside_deg(side: str, body: IdealBody, p_BP: NDArray[np.float64]) -> float:
    """Angle at the shoulder between the hand and the point."""
    kinematics = ARMS[side].kinematics
    shoulder = kinematics.X_BS.translation
    to_hand, to_point = kinematics.hand(ARMS[side].positions(body.joints)) - shoulder, p_BP - shoulder
    return math.degrees(math.atan2(np.linalg.norm(np.cross(to_hand, to_point)), to_hand @ to_point))
