"""Reaching, waving and resting: moves of the arms to postures. No clock, no channel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from app.messages import JointCommand
from app.modules.behaviors.gestures.arm_kinematics import OutOfReach
from app.modules.behaviors.gestures.arms import Arm
from app.modules.behaviors.gestures.gesture import ArmMove, Gesture, GestureStep, GestureView, Servo, Stay, failed

Vector = NDArray[np.float64]

#: A point that has moved so far (m) is another one.
_MOVED_M = 0.01
#: Postures of one arm whose ways are tried.
_WAYS = 6
#: Hand before the shoulder, and beside it at either end of a wave (outwards), and above it: shares of the reach.
_WAVE = ((0.45, 0.20, 0.45), (0.45, 0.65, 0.45))


def reaching_route(
    arms: Mapping[str, Arm], p_BP: Vector, measured: Mapping[str, float]
) -> tuple[Arm, list[Vector]] | str:
    """The arm of ``arms`` with the nearest shoulder of those that reach ``p_BP`` (3,) m without touching the body, and
    the postures (4,) rad by which it does; the reason in words, where none does."""
    reasons: list[str] = []
    for arm in sorted(arms.values(), key=lambda arm: float(np.linalg.norm(p_BP - arm.kinematics.X_BS.translation))):
        try:
            postures = arm.kinematics.reach(p_BP, arm.positions(measured))
        except OutOfReach as failure:
            reasons.append(f"{arm.side} arm: {failure}")
            continue
        free = arm.free(postures, measured)
        problem = f"the {arm.side} arm would touch the body there"
        for posture in free[:_WAYS]:
            route = arm.route(posture, measured)
            if not isinstance(route, str):
                return arm, route
            problem = route
        reasons.append(problem)
    return "; ".join(reasons)


class ReachGesture(Gesture):
    """Brings a hand to the view's point and keeps it there for ``hold_s``. ``arms`` may reach, ``servos`` are their
    groups', by side."""

    def __init__(self, arms: Mapping[str, Arm], servos: Mapping[str, Servo], hold_s: float) -> None:
        self._arms = arms
        self._servos = servos
        self._hold_s = hold_s
        self._staying = Stay()
        self._move: ArmMove | None = None

    def step(self, view: GestureView) -> GestureStep:
        """What to do now."""
        if view.p_BP is None:
            return GestureStep(reason="it waits: where the point is, is not known")
        move = self._move
        if move is None or np.linalg.norm(move.arm.kinematics.hand(move.goal) - view.p_BP) > _MOVED_M:
            # An arm that is on its way stays the one.
            arms = self._arms if move is None else {move.arm.side: move.arm}
            found = reaching_route(arms, view.p_BP, view.measured)
            if isinstance(found, str):
                return failed(found)
            arm, route = found
            move = self._move = ArmMove(arm, self._servos[arm.side], route, view)
        if problem := move.problem(view):
            return failed(problem)
        commands, there = (move.command(view),), move.there(view)
        if self._staying.lasted(view.now, there) < self._hold_s or not there:
            return GestureStep(commands)
        return GestureStep(commands, outcome="done", reason=f"the {move.arm.side} hand is there")


class SequenceGesture(Gesture):
    """Moves an arm through ``postures`` (each (4,) rad), one after the other; ``done`` says so in words."""

    def __init__(self, arm: Arm, servo: Servo, postures: Sequence[Vector], done: str) -> None:
        self._arm = arm
        self._servo = servo
        self._postures = list(postures)
        self._done = done
        self._move: ArmMove | None = None

    def step(self, view: GestureView) -> GestureStep:
        """What to do now."""
        if self._move is None or self._move.there(view):
            if not self._postures:
                return GestureStep(outcome="done", reason=self._done)
            route = self._arm.route(self._postures.pop(0), view.measured)
            if isinstance(route, str):
                return failed(route)
            self._move = ArmMove(self._arm, self._servo, route, view)
        if problem := self._move.problem(view):
            return failed(problem)
        return GestureStep((self._move.command(view),))


def waving_postures(arm: Arm, times: int) -> list[Vector]:
    """The postures (4,) rad of ``times`` waves to and fro with the hand raised beside the shoulder.

    Raises OutOfReach for an arm whose joints do not let it.
    """
    outwards = 1.0 if arm.side == "left" else -1.0
    ends: list[Vector] = []
    for ahead, aside, above in _WAVE:
        offset = arm.kinematics.reach_m * np.array([ahead, outwards * aside, above])
        near = ends[0] if ends else arm.rest
        free = arm.free(arm.kinematics.reach(arm.kinematics.X_BS.translation + offset, near), {})
        if not len(free):
            raise OutOfReach("the raised hand would touch the body")
        ends.append(free[0])
    return ends * times


class RestGesture(Gesture):
    """Brings ``arms`` to rest and keeps them there for ``hold_s``; ``servos`` are their groups', by side."""

    def __init__(self, arms: Mapping[str, Arm], servos: Mapping[str, Servo], hold_s: float) -> None:
        self._arms = arms
        self._servos = servos
        self._hold_s = hold_s
        self._resting = Stay()
        self._moves: list[ArmMove] = []

    def step(self, view: GestureView) -> GestureStep:
        """What to do now."""
        if not self._moves:
            for side, arm in self._arms.items():
                route = [arm.rest] if self._servos[side].limp else arm.route(arm.rest, view.measured)
                if isinstance(route, str):
                    return failed(route)
                self._moves.append(ArmMove(arm, self._servos[side], route, view))
        commands: tuple[JointCommand, ...] = tuple(move.command(view) for move in self._moves)
        if problem := next(filter(None, (move.problem(view) for move in self._moves)), ""):
            return failed(problem)
        there = all(move.there(view) for move in self._moves)
        if self._resting.lasted(view.now, there) < self._hold_s or not there:
            return GestureStep(commands)
        return GestureStep(commands, outcome="done")
