"""Pointing: which arm points how at a point, and how the base turns towards one that is too far beside. No clock."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.gestures.arm_kinematics import OutOfReach
from app.modules.behaviors.gestures.arms import POINTING_ERROR_RAD, Arm
from app.modules.behaviors.gestures.gesture import ArmMove, Gesture, GestureStep, GestureView, Servo, Stay, failed

Vector = NDArray[np.float64]

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


@dataclass(frozen=True, slots=True, eq=False)
class Aimed:
    """The ``arm`` that points, and its ``route`` (postures (4,) rad)."""

    arm: Arm
    route: list[Vector]


def better_arm(arms: Mapping[str, Arm], p_BP: Vector, measured: Mapping[str, float]) -> Aimed | str:
    """The arm of ``arms`` with the nearest shoulder of those that point at ``p_BP`` (3,) m well enough, on a route on
    which it touches nothing; the reasons in words, where none does."""
    reasons: list[str] = []
    for arm in sorted(arms.values(), key=lambda arm: float(np.linalg.norm(p_BP - arm.kinematics.X_BS.translation))):
        posture = _posture(arm, p_BP, measured)
        if isinstance(posture, str):
            reasons.append(posture)
            continue
        route = arm.route(posture, measured)
        if not isinstance(route, str):
            return Aimed(arm, route)
        reasons.append(route)
    return "; ".join(dict.fromkeys(reasons))


def _posture(arm: Arm, p_BP: Vector, measured: Mapping[str, float]) -> Vector | str:
    """The posture (4,) rad of an arm that points at a point well enough; the reason in words, where there is none."""
    try:
        pointing = arm.pointing(p_BP, measured)
    except OutOfReach as failure:
        return str(failure)
    if pointing.error_rad > POINTING_ERROR_RAD:
        return f"the {arm.side} arm would point {math.degrees(pointing.error_rad):.0f}° beside it"
    return pointing.positions


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
        #: The way back to rest of an arm that pointed before the base turns.
        self._lowering: ArmMove | None = None

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
            self._lowering = None
        return self._point(view, view.p_BP)

    def _turn(self, view: GestureView, beside: float) -> GestureStep:
        """Turn, once an arm that was raised is at rest: stretched out, it would sweep the room."""
        assert self._turn_radps is not None
        self._pointing.lasted(view.now, so=False)
        speed = min(max(_GAIN * (abs(beside) - _FACED_RAD), _LEAST_RADPS), self._turn_radps)
        if self._move is not None:
            arm = self._move.arm
            self._lowering = ArmMove(arm, self._servos[arm.side], [arm.rest], view)
            self._move = None
        reason = "the base turns to it"
        if self._lowering is not None and not self._lowering.there(view):
            if problem := self._lowering.problem(view):
                return failed(problem)
            return GestureStep((self._lowering.command(view),), reason=reason)
        return GestureStep(turn_radps=math.copysign(speed, beside), reason=reason)

    def _point(self, view: GestureView, p_BP: Vector) -> GestureStep:
        move = self._move
        posture = None if move is None else _posture(move.arm, p_BP, view.measured)
        if move is None or posture is None or isinstance(posture, str):
            # An arm that points well goes on, even where the other were better.
            aimed = better_arm(self._arms, p_BP, view.measured)
            if isinstance(aimed, str):
                return failed(aimed)
            move = self._move = ArmMove(aimed.arm, self._servos[aimed.arm.side], aimed.route, view)
        elif np.abs(move.goal - posture).max() > _ANOTHER_RAD:
            route = move.arm.route(posture, view.measured)
            if isinstance(route, str):
                return failed(route)
            move = self._move = ArmMove(move.arm, self._servos[move.arm.side], route, view)
        else:
            move.goal = posture
        if problem := move.problem(view):
            return failed(problem)
        commands, there = (move.command(view),), move.there(view)
        if self._pointing.lasted(view.now, there) < self._hold_s or not there:
            return GestureStep(commands)
        return GestureStep(commands, outcome="done", reason=f"the {move.arm.side} arm pointed at it")
