"""Pointing: which arm points how at a point, and how the base turns towards one that is too far beside. No clock."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from app.messages import JointCommand
from app.modules.behaviors.gestures.arm_kinematics import OutOfReach, Pointing
from app.modules.behaviors.gestures.arms import Arm
from app.modules.behaviors.gestures.gesture import ArmMove, Gesture, GestureStep, GestureView, Servo, Stay, failed

Vector = NDArray[np.float64]

ERROR_RAD = math.radians(5)
"""Greatest angle at the shoulder between arm and point."""
TURN_BEYOND_RAD = math.radians(60)
"""Points further beside than this are turned to."""
#: ... until they are no further beside.
_FACED_RAD = math.radians(25)
#: Gain (1/s) of turning: the speed falls with the angle that is left.
_GAIN = 1.5
_LEAST_RADPS = 0.15
#: A posture so far (rad) from the last is another move.
_ANOTHER_RAD = 0.2
#: Turning that takes longer (s) has failed.
_TURNS_S = 20.0


def better_arm(arms: Mapping[str, Arm], p_BP: Vector, measured: Mapping[str, float]) -> tuple[Arm, Pointing] | str:
    """The arm of ``arms`` that points best at ``p_BP`` (3,) m on a way on which it touches nothing; of those that point
    well, the one whose shoulder is nearest. The reason in words, where none can."""
    found: list[tuple[float, float, Arm, Pointing]] = []
    reasons: list[str] = []
    for arm in arms.values():
        try:
            pointing = arm.kinematics.point(p_BP, arm.rest)
        except OutOfReach as failure:
            reasons.append(str(failure))
            continue
        if problem := arm.blocked(pointing.positions, measured):
            reasons.append(problem)
            continue
        error = 0.0 if pointing.error_rad <= ERROR_RAD else pointing.error_rad
        distance = float(np.linalg.norm(p_BP - arm.kinematics.X_BS.translation))
        found.append((error, distance, arm, pointing))
    if not found:
        return "; ".join(dict.fromkeys(reasons))
    return min(found, key=lambda option: option[:2])[2:]


class PointingGesture(Gesture):
    """Points at the view's point for ``hold_s``; ``turn_radps``: the greatest speed of the base's turns, None: it does
    not turn. ``arms`` are those that may point, ``servos`` their groups', by side."""

    def __init__(
        self, arms: Mapping[str, Arm], servos: Mapping[str, Servo], *, hold_s: float, turn_radps: float | None
    ) -> None:
        self._arms = arms
        self._servos = servos
        self._hold_s = hold_s
        self._turn_radps = turn_radps
        self._turning = Stay()
        self._turns = False
        self._pointing = Stay()
        self._move: ArmMove | None = None

    def step(self, view: GestureView) -> GestureStep:
        """What to do now."""
        if view.p_BP is None:
            return GestureStep(reason="it waits: where the point is, is not known")
        beside = math.atan2(view.p_BP[1], view.p_BP[0])
        if self._turn_radps is not None:
            self._turns = abs(beside) > (_FACED_RAD if self._turns else TURN_BEYOND_RAD)
            if self._turning.lasted(view.now, self._turns) > _TURNS_S:
                return failed(f"the base does not turn to it; it is {math.degrees(beside):.0f}° beside")
            if self._turns:
                return self._turn(view, beside)
        return self._point(view, view.p_BP)

    def _turn(self, view: GestureView, beside: float) -> GestureStep:
        """Turn, with an arm that was raised at rest: stretched out, it would sweep the room."""
        assert self._turn_radps is not None
        self._pointing.lasted(view.now, so=False)
        speed = min(max(_GAIN * (abs(beside) - _FACED_RAD), _LEAST_RADPS), self._turn_radps)
        commands: tuple[JointCommand, ...] = ()
        if self._move is not None:
            commands = (self._begin(self._move.arm, self._move.arm.rest, view).command(view.now),)
        return GestureStep(commands, turn_radps=math.copysign(speed, beside), reason="the base turns to it")

    def _point(self, view: GestureView, p_BP: Vector) -> GestureStep:
        choice = self._going_on(p_BP) or better_arm(self._arms, p_BP, view.measured)
        if isinstance(choice, str):
            return failed(choice)
        arm, pointing = choice
        if pointing.error_rad > ERROR_RAD:
            beside = math.degrees(pointing.error_rad)
            return failed(f"it is out of the arms' reach: the {arm.side} arm stays {beside:.0f}° beside it")
        move = self._move
        if move is None or move.arm is not arm or np.abs(move.goal - pointing.positions).max() > _ANOTHER_RAD:
            move = self._move = self._begin(arm, pointing.positions, view)
        move.goal = pointing.positions
        if problem := move.problem(view):
            return failed(problem)
        commands = (move.command(view.now),)
        there = move.there(view)
        if self._pointing.lasted(view.now, there) < self._hold_s or not there:
            return GestureStep(commands)
        return GestureStep(commands, outcome="done", reason=f"the {arm.side} arm pointed at it")

    def _going_on(self, p_BP: Vector) -> tuple[Arm, Pointing] | None:
        """The arm that points already, while it points well: that the other one were better is no reason to change."""
        if self._move is None:
            return None
        try:
            pointing = self._move.arm.kinematics.point(p_BP, self._move.arm.rest)
        except OutOfReach:
            return None
        return (self._move.arm, pointing) if pointing.error_rad <= ERROR_RAD else None

    def _begin(self, arm: Arm, goal: Vector, view: GestureView) -> ArmMove:
        begin = arm.positions(view.measured)
        return ArmMove(arm, self._servos[arm.side], goal, begin=begin, now=view.now)
