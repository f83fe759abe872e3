"""Closed-form inverse kinematics of an arm of four joints, read from the body's model. Pure functions.

The kind of arm: three joints whose axes meet in the shoulder (pitch, roll, and twist of the upper arm about itself), an
elbow whose axis is parallel to the first; the arm is straight when all joints are at 0. Which way it hangs, how long it
is and which way the axes point is read from the model.

In the shoulder's frame S (x the roll axis, y the pitch axis, the straight arm along -z) the hand is at

    p_SH = Ry(pitch) Rx(roll) Rz(twist) ((0, 0, -upper arm) + Ry(elbow) (0, 0, -forearm))

The elbow follows from the distance alone. One joint more than a point asks for is free: for each of a number of twists,
roll follows from p_y, then pitch from the rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.base.kinematic_model import KinematicModel
from app.link import JointLimits

Vector = NDArray[np.float64]

#: Numbers of twists that are tried for one point: the second where the limits let none of the first through.
_TWISTS = (17, 513)
#: Cost of one radian (squared) from the posture asked for, by joint. The elbow follows from the distance.
_COSTS = np.array([1.0, 1.0, 0.5, 0.0])
#: Greatest angle (rad) and distance (m) by which a model may miss the kind of arm.
_ANGLE, _DISTANCE_M = 1e-3, 1e-3
#: A hand that points stays so far (m) before the point.
_STANDOFF_M = 0.05


class OtherArm(ValueError):
    """The model's arm is of another kind; the message says in what."""


class OutOfReach(ValueError):
    """The hand cannot be where it is wanted; the message says why."""


@dataclass(frozen=True, slots=True, eq=False)
class Pointing:
    """Joint ``positions`` (4,) rad, in the order of the arm's joints, and the angle (rad) that is left at the shoulder
    between the hand and the point."""

    positions: Vector
    error_rad: float


@dataclass(frozen=True, slots=True, eq=False)
class ArmKinematics:
    """An arm: its ``joints`` (pitch, roll, twist, elbow) with limits, ``X_BS`` of its shoulder in the model's root
    link, and the lengths (m) of upper arm and forearm (up to the hand). ``signs`` (4,): 1 where a joint turns about S's
    axes, -1 where against them."""

    joints: tuple[JointLimits, ...]
    X_BS: Pose3
    upper_m: float
    forearm_m: float
    signs: Vector

    @property
    def names(self) -> tuple[str, ...]:
        """The joints' names, from the shoulder to the elbow."""
        return tuple(joint.name for joint in self.joints)

    @property
    def reach_m(self) -> float:
        """The greatest distance of the hand from the shoulder."""
        return self.upper_m + self.forearm_m

    @property
    def nearest_m(self) -> float:
        """The least distance of the hand from the shoulder, the elbow bent as far as it can be."""
        bend = min(max(abs(self.joints[3].lower), abs(self.joints[3].upper)), math.pi)
        return math.sqrt(self.upper_m**2 + self.forearm_m**2 + 2 * self.upper_m * self.forearm_m * math.cos(bend))

    @property
    def lower(self) -> Vector:
        """Least positions (4,) rad."""
        return np.array([joint.lower for joint in self.joints])

    @property
    def upper(self) -> Vector:
        """Greatest positions (4,) rad."""
        return np.array([joint.upper for joint in self.joints])

    def hand(self, positions: Vector) -> Vector:
        """``p_BH`` (..., 3) m of the hand at joint ``positions`` (..., 4) rad."""
        return np.asarray(self.X_BS.transform(self._hand(self.signs * positions)))

    def reach(self, p_BP: Vector, near: Vector) -> Vector:
        """Joint positions (N, 4) rad within the limits with the hand at ``p_BP`` (3,) m, those nearest to the posture
        ``near`` (4,) first. Raises OutOfReach."""
        p = self._in_shoulder(p_BP)
        distance = float(np.linalg.norm(p))
        if distance > self.reach_m:
            raise OutOfReach(f"it is {distance:.2f} m from the shoulder, and the arm reaches {self.reach_m:.2f} m")
        if distance < self.nearest_m - 1e-9:
            bent = f"the bent arm comes no nearer than {self.nearest_m:.2f} m"
            raise OutOfReach(f"it is {distance:.2f} m from the shoulder, and {bent}")
        for twists in _TWISTS:
            found = self._postures(p, distance, twists)
            inside = ((found >= self.lower - 1e-9) & (found <= self.upper + 1e-9)).all(axis=1)
            if inside.any():
                found = np.clip(found[inside], self.lower, self.upper)
                return np.asarray(found[np.argsort((found - near) ** 2 @ _COSTS, kind="stable")])
        raise OutOfReach("the joints' limits keep the hand from it")

    def point(self, p_BP: Vector, near: Vector) -> Pointing:
        """The posture that points at ``p_BP`` (3,) m: the straight arm as nearly as limits let it; for a point within
        reach the hand on the line to it, before it, bent as is nearest to ``near`` (4,). Raises OutOfReach for a point
        so near that no hand fits between."""
        p = self._in_shoulder(p_BP)
        distance = float(np.linalg.norm(p))
        if distance >= self.reach_m + _STANDOFF_M:
            return self._straight(p / distance)
        if distance <= _STANDOFF_M:
            raise OutOfReach("it is in the shoulder")
        p_BH = p_BP - self.X_BS.rotation @ p * (_STANDOFF_M / distance)
        return Pointing(self.reach(p_BH, near)[0], 0.0)

    def _in_shoulder(self, p_BP: Vector) -> Vector:
        return np.asarray(self.X_BS.rotation.T @ (p_BP - self.X_BS.translation))

    def _straight(self, direction: Vector) -> Pointing:
        x, y, z = (float(value) for value in direction)
        roll, pitch = math.asin(min(max(y, -1.0), 1.0)), math.atan2(-x, -z)
        options = np.array([[pitch, roll, 0.0, 0.0], [pitch + math.pi, math.copysign(math.pi, roll) - roll, 0.0, 0.0]])
        options[:, 0] = _wrapped(options[:, 0])
        positions = np.clip(self.signs * options, self.lower, self.upper)
        hands = self._hand(self.signs * positions)
        cosines = hands @ direction / np.linalg.norm(hands, axis=1)
        best = int(np.argmax(cosines))
        # From the chord: an arc cosine loses half the digits near 0.
        chord = hands[best] / np.linalg.norm(hands[best]) - direction
        return Pointing(positions[best], 2.0 * math.asin(min(float(np.linalg.norm(chord)) / 2.0, 1.0)))

    def _postures(self, p: Vector, distance: float, twists: int) -> Vector:
        """All postures (N, 4) of the model's joints with the hand at ``p`` (3,), limits aside."""
        cosine = (distance**2 - self.upper_m**2 - self.forearm_m**2) / (2 * self.upper_m * self.forearm_m)
        bend = math.acos(min(max(cosine, -1.0), 1.0))
        tried = self.signs[2] * np.linspace(*self._range(2), twists)
        elbow, twist, side = (grid.ravel() for grid in np.meshgrid([-bend, bend], tried, [1.0, -1.0], indexing="ij"))
        # The hand in the frame of the roll joint's child.
        vx = -self.forearm_m * np.sin(elbow) * np.cos(twist)
        vy = -self.forearm_m * np.sin(elbow) * np.sin(twist)
        vz = -self.upper_m - self.forearm_m * np.cos(elbow)
        across = np.hypot(vy, vz)
        possible = across >= abs(p[1])
        vx, vy, vz, across = vx[possible], vy[possible], vz[possible], across[possible]
        roll = _wrapped(side[possible] * np.arccos(np.clip(p[1] / across, -1.0, 1.0)) - np.arctan2(vz, vy))
        forward = vy * np.sin(roll) + vz * np.cos(roll)
        pitch = _wrapped(np.arctan2(p[0], p[2]) - np.arctan2(vx, forward))
        return np.asarray(self.signs * np.stack([pitch, roll, twist[possible], elbow[possible]], axis=1))

    def _range(self, joint: int) -> tuple[float, float]:
        limits = self.joints[joint]
        return max(limits.lower, -math.pi), min(limits.upper, math.pi)

    def _hand(self, angles: Vector) -> Vector:
        pitch, roll, twist, elbow = np.moveaxis(angles, -1, 0)
        out = -self.forearm_m * np.sin(elbow)
        x, y = out * np.cos(twist), out * np.sin(twist)
        z = -self.upper_m - self.forearm_m * np.cos(elbow)
        y, z = y * np.cos(roll) - z * np.sin(roll), y * np.sin(roll) + z * np.cos(roll)
        return np.stack([x * np.cos(pitch) + z * np.sin(pitch), y, z * np.cos(pitch) - x * np.sin(pitch)], axis=-1)


def arm_kinematics(model: KinematicModel, joints: Sequence[JointLimits], hand: str) -> ArmKinematics:
    """The arm of ``model`` whose ``joints``, in any order, move the link ``hand``.

    Raises OtherArm where it is of another kind, KeyError for a link that the model does not have.
    """
    chain = model.moved_by(hand)[::-1]
    limits = {joint.name: joint for joint in joints}
    if len(chain) != 4 or set(chain) != set(limits):
        raise OtherArm(
            f"{hand} is moved by {', '.join(chain) or 'no joint'}, and the arm's joints are {', '.join(limits)}; they "
            "must be the same four: pitch, roll and twist of the shoulder, and the elbow"
        )
    if turning := [name for name in chain if model.joints[name].kind == "prismatic"]:
        raise OtherArm(f"{turning[0]} slides; the joints of the arm must turn")
    frames = [model.pose(model.joints[name].child) for name in chain]
    axes = [frame.rotation @ model.joints[name].axis for name, frame in zip(chain, frames, strict=True)]
    origins = [frame.translation for frame in frames]
    p_BH = model.pose(hand).translation

    shoulder = _crossing(origins[0], axes[0], origins[1], axes[1])
    if shoulder is None or _beside(shoulder, origins[2], axes[2]) > _DISTANCE_M:
        raise OtherArm(f"the axes of {', '.join(chain[:3])} must meet in one point, the shoulder")
    if abs(axes[0] @ axes[1]) > _ANGLE or abs(axes[1] @ axes[2]) > _ANGLE or abs(axes[0] @ axes[2]) > _ANGLE:
        raise OtherArm(f"at position 0, the axes of {', '.join(chain[:3])} must be at right angles")
    if abs(abs(axes[3] @ axes[0]) - 1.0) > _ANGLE:
        raise OtherArm(f"at position 0, the axes of {chain[3]} and {chain[0]} must be parallel")
    down = axes[2] * math.copysign(1.0, float(axes[2] @ (p_BH - shoulder)))
    # The elbow may be anywhere on its own axis: what counts is where that axis crosses the arm.
    elbow = origins[3] + axes[3] * float(axes[3] @ (shoulder - origins[3]))
    upper_m, whole_m = float(down @ (elbow - shoulder)), float(down @ (p_BH - shoulder))
    beside = max(_beside(elbow, shoulder, down), _beside(p_BH, shoulder, down))
    if beside > _DISTANCE_M or not 0 < upper_m < whole_m:
        raise OtherArm(f"at position 0, shoulder, {chain[3]} and {hand} must be on one line, the straight arm's")
    x = np.cross(axes[0], -down)
    signs = [1.0, *(math.copysign(1.0, float(side)) for side in (axes[1] @ x, axes[2] @ -down, axes[3] @ axes[0]))]
    return ArmKinematics(
        tuple(limits[name] for name in chain),
        Pose3(np.column_stack([x, axes[0], -down]), shoulder),
        upper_m=upper_m,
        forearm_m=whole_m - upper_m,
        signs=np.array(signs),
    )


def _crossing(p: Vector, u: Vector, q: Vector, v: Vector) -> Vector | None:
    """Where the lines through ``p`` along ``u`` and through ``q`` along ``v`` meet; None where they do not."""
    normal = np.cross(u, v)
    if np.linalg.norm(normal) < _ANGLE:
        return None
    s, t, gap = np.linalg.solve(np.column_stack([u, -v, normal]), q - p)
    if abs(gap) * np.linalg.norm(normal) > _DISTANCE_M:
        return None
    return np.asarray((p + s * u + q + t * v) / 2)


def _beside(point: Vector, origin: Vector, axis: Vector) -> float:
    """Distance (m) of ``point`` from the line through ``origin`` along the unit vector ``axis``."""
    return float(np.linalg.norm(np.cross(axis, point - origin)))


def _wrapped(angles: Vector) -> Vector:
    return np.asarray((angles + math.pi) % (2 * math.pi) - math.pi)
