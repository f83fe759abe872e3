"""Configuration of what a body moves: limits of the base, actuator groups, arms; in ``config/robots/*.yaml``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import Field, model_validator

from app.base.kinematic_model import KinematicModel
from app.link import ActuatorGroup, ArmDescription, BaseLimits, JointLimits, SafeAction
from app.robots.config_model import ConfigModel, NotNegative, Positive
from app.robots.guard import GuardLimits

BASE_GROUP = "base"
"""The group of the wheels, as exploitation names it: it takes velocities, and is no group of joints."""


class LimitsConfig(ConfigModel):
    """Limits of the base (thesis 4.2), and its deceleration when the guard stops it."""

    linear_mps: Positive = 0.40
    angular_radps: Positive = 1.00
    linear_mps2: Positive = 0.40
    angular_radps2: Positive = 4.00
    emergency_mps2: Annotated[float, Field(gt=0, le=5)] = Field(
        default=2.5, description="braking of a safety stop; the drives' torque limit follows from it"
    )
    command_timeout_s: Annotated[float, Field(gt=0, le=1)] = 0.2
    sensor_timeout_s: Positive = 0.5
    required_sensors: tuple[str, ...] = Field(
        default=("odometry",), description="streams without which the base must not drive"
    )
    lateral_mps: NotNegative = Field(default=0.0, description="sideways; 0: the base cannot, as a differential drive")

    def base(self) -> BaseLimits:
        """Speeds and accelerations alone."""
        return BaseLimits(
            self.linear_mps, self.angular_radps, self.linear_mps2, self.angular_radps2, lateral_mps=self.lateral_mps
        )

    def guard(self) -> GuardLimits:
        """The limits as the guard uses them."""
        return GuardLimits(self.base(), self.command_timeout_s, self.sensor_timeout_s)


def check_footprint(corners: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """``corners`` if they are a convex polygon, counter-clockwise, around the base's origin. Raises ValueError."""
    following = (*corners[1:], corners[0])
    edges = [(bx - ax, by - ay) for (ax, ay), (bx, by) in zip(corners, following, strict=True)]
    if any(math.hypot(*edge) < 1e-6 for edge in edges):
        raise ValueError("two corners that follow each other are the same")
    turns = [ax * by - ay * bx for (ax, ay), (bx, by) in zip(edges, (*edges[1:], edges[0]), strict=True)]
    if all(turn < 0 for turn in turns):
        raise ValueError("the corners go clockwise; name them counter-clockwise, as seen from above")
    around = sum(math.atan2(turn, ax * bx + ay * by) for turn, (ax, ay), (bx, by) in zip(
        turns, edges, (*edges[1:], edges[0]), strict=True
    ))  # fmt: skip
    if any(turn < -1e-9 for turn in turns) or abs(around - 2 * math.pi) > 1e-6:
        raise ValueError("the polygon is not convex: going round it, every corner must turn left")
    if any(ex * -ay - ey * -ax <= 0 for (ax, ay), (ex, ey) in zip(corners, edges, strict=True)):
        raise ValueError("base_link, at (0, 0), does not lie inside it")
    return corners


def circle(radius_m: float, corners: int = 16) -> tuple[tuple[float, float], ...]:
    """A regular polygon around a circle of ``radius_m``: a round body's footprint."""
    reach = radius_m / math.cos(math.pi / corners)
    angles = (2 * math.pi * number / corners for number in range(corners))
    return tuple((round(reach * math.cos(a), 4), round(reach * math.sin(a), 4)) for a in angles)


class ActuatorConfig(ConfigModel):
    """One actuator group of joints: what is commanded together, and what the guard does with it.

    Positions are limited by the model (URDF), speeds by the lower of ``velocity`` and the model's.
    """

    joints: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="names of movable joints of the model")
    velocity: Positive = Field(default=1.0, description="greatest speed (rad/s, m/s where prismatic)")
    acceleration: Positive = Field(default=5.0, description="greatest acceleration (rad/s^2, m/s^2)")
    stale: SafeAction = Field(default=SafeAction.HOLD, description="without a fresh command: hold, yield or rest")
    stop: SafeAction = Field(default=SafeAction.HOLD, description="in an emergency stop: hold, yield or rest")
    rest: tuple[float, ...] = Field(
        default=(), description="positions (rad) of the action rest, in the order of the joints; none: all 0"
    )
    timeout_s: Annotated[float, Field(gt=0, le=1)] = Field(default=0.25, description="an older command is stale")
    compliant: bool = Field(default=False, description="commands may set stiffness and damping")
    stiffness: NotNegative = Field(default=60.0, description="N m/rad, of a compliant group without a value given")
    damping: NotNegative = Field(default=6.0, description="N m s/rad, likewise")
    stiffness_range: tuple[NotNegative, Positive] = Field(default=(0.0, 300.0), description="that commands may set")
    damping_range: tuple[NotNegative, Positive] = Field(default=(0.5, 40.0), description="that commands may set")
    contact: tuple[Positive, ...] = Field(
        default=(), description="efforts from outside (N m), one for each joint, beyond which the group yields"
    )
    contact_s: Positive = Field(default=0.1, description="how long they must last")
    contact_rest_s: Positive = Field(default=1.0, description="how long it yields, at least")
    kinematic: bool = Field(
        default=False, description="in the simulated world its joints are where the guard sets them, without physics"
    )

    @model_validator(mode="after")
    def _is_within_its_ranges(self) -> Self:
        if self.contact and len(self.contact) != len(self.joints):
            raise ValueError(f"contact has {len(self.contact)} efforts for {len(self.joints)} joints")
        if not self.compliant:
            return self
        ranges = {"stiffness": (self.stiffness, self.stiffness_range), "damping": (self.damping, self.damping_range)}
        for what, (value, (least, most)) in ranges.items():
            if not least <= value <= most:
                raise ValueError(f"{what} {value:g} lies outside its {what}_range, {least:g} to {most:g}")
        return self

    @model_validator(mode="after")
    def _compliance_is_of_physics(self) -> Self:
        if self.kinematic and self.compliant:
            raise ValueError("a kinematic group has no forces, so it cannot be compliant")
        return self

    @model_validator(mode="after")
    def _rests_where_it_does_no_harm(self) -> Self:
        if self.rest and len(self.rest) != len(self.joints):
            raise ValueError(f"rest has {len(self.rest)} positions for {len(self.joints)} joints")
        if SafeAction.REST in (self.stale, self.stop) and not self.kinematic:
            raise ValueError(
                "rest moves joints in an emergency stop: only a kinematic group may, whose parts touch nothing"
            )
        return self

    def group(self, name: str, model: KinematicModel) -> ActuatorGroup:
        """The group's description. Raises ValueError for a joint that the model does not have or that cannot move, and
        for a rest beyond its limits."""
        limits: list[JointLimits] = []
        contacts = self.contact or (math.inf,) * len(self.joints)
        for joint_name, contact in zip(self.joints, contacts, strict=True):
            joint = model.joints.get(joint_name)
            if joint is None or not joint.moves:
                allowed = ", ".join(model.joint_names)
                raise ValueError(f"the model has no movable joint {joint_name!r}; it has {allowed}")
            if joint.velocity <= 0:
                raise ValueError(f"the model's greatest velocity of {joint_name} is 0: it cannot move")
            speed = min(self.velocity, joint.velocity)
            limits.append(
                JointLimits(
                    joint.name, joint.lower, joint.upper, velocity=speed, acceleration=self.acceleration,
                    effort=joint.effort, contact=contact,
                )
            )  # fmt: skip
        for position, joint_limits in zip(self.rest, limits, strict=False):
            if not joint_limits.lower <= position <= joint_limits.upper:
                raise ValueError(
                    f"rest {position:g} of {joint_limits.name} lies outside its limits, {joint_limits.lower:g} to "
                    f"{joint_limits.upper:g}"
                )
        return ActuatorGroup(
            name, tuple(limits), stale=self.stale, stop=self.stop, rest=self.rest, timeout_s=self.timeout_s,
            compliant=self.compliant, stiffness=self.stiffness, damping=self.damping,
            stiffness_range=self.stiffness_range, damping_range=self.damping_range,
            contact_s=self.contact_s, contact_rest_s=self.contact_rest_s,
        )  # fmt: skip


class ArmConfig(ConfigModel):
    """One arm: which groups it is made of, and how it hangs at rest."""

    group: str = Field(description="actuator group of its joints")
    hand: str = Field(description="link of the model that it reaches with")
    gripper: str = Field(
        default="", description="actuator group of its gripper: one joint, closed at its least position"
    )
    rest: tuple[float, ...] = Field(
        default=(), description="positions (rad) at rest, in the group's order; none: all 0"
    )

    def described(self, groups: Mapping[str, ActuatorGroup], model: KinematicModel) -> ArmDescription:
        """The arm's description. Raises ValueError for a group or a link that there is not, and for a rest beyond the
        joints' limits."""
        for group in filter(None, (self.group, self.gripper)):
            if group not in groups:
                raise ValueError(f"there is no actuator group {group!r}; there are {', '.join(groups) or 'none'}")
        joints = groups[self.group].joints
        if self.hand not in model.links:
            raise ValueError(f"the model has no link {self.hand!r}; it has {', '.join(model.links)}")
        if self.gripper and len(groups[self.gripper].joints) != 1:
            raise ValueError(f"{self.gripper} has {len(groups[self.gripper].joints)} joints; a gripper has one")
        rest = self.rest or (0.0,) * len(joints)
        if len(rest) != len(joints):
            raise ValueError(f"rest has {len(rest)} positions for the {len(joints)} joints of {self.group}")
        for joint, position in zip(joints, rest, strict=True):
            if not joint.lower <= position <= joint.upper:
                raise ValueError(f"rest: {position:g} of {joint.name} is not within {joint.lower:g} to {joint.upper:g}")
        return ArmDescription(self.group, self.hand, self.gripper, rest)
