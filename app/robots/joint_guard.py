"""The guard of one group of joints: last check between the program and the motors, as pure functions.

It runs beside the base's guard (``guard.py``), at every control step, independent of the runtime.

- Set-points approach their goals within each joint's speed and acceleration, and stop there without overshoot. Where a
  goal comes too near to brake in time, the joint overshoots it, but never its own limits of position.
- A command older than the group's ``timeout_s``, a refused one and an emergency stop end in the group's safe action:
  ``hold`` brakes within the accelerations and keeps the position; ``yield`` takes the stiffness away; ``rest`` goes to
  the group's positions at rest.
- A joint that feels more from outside than its limit of contact, for a while, makes its group yield: for a time, and
  then until the next command.
- A joint whose stiffness rises (after yielding, from zero) begins where its torque is unchanged: raised stiffness
  towards a former set-point would be a jump of the arm.

The profile is trapezoidal: at constant acceleration within a step, the greatest speed from which the joint can still
stop at its goal. It is exact for any sequence of steps, however long each is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

from app.link import ActuatorGroup, JointLimits, SafeAction
from app.messages import GroupStatus, JointCommand
from app.robots.guard import FUTURE_TOLERANCE_S

#: A joint that yields has moved when it is so far (rad, m) from where it was.
RESTING = 1e-6


class JointMode(StrEnum):
    """State of the guard of a group; the values of ``GroupStatus.guard``."""

    IDLE = "idle"
    MOVING = "moving"
    HOLDING = "holding"
    YIELDING = "yielding"
    REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class JointSetpoint:
    """What one joint is given now, and where its set-point goes.

    ``position`` (rad, or m where prismatic) and ``velocity`` of the set-point; ``goal`` (rad) that it approaches.
    ``stiffness`` (N m/rad) is 0 while the joint yields, ``damping`` in N m s/rad. ``wanted_stiffness`` and
    ``wanted_damping`` are those of the newest command.
    """

    position: float
    goal: float
    velocity: float
    stiffness: float
    damping: float
    wanted_stiffness: float
    wanted_damping: float


@dataclass(frozen=True, slots=True)
class JointContact:
    """A contact: its reason in words; commands stamped before ``until`` (s, robot's clock) do not end it."""

    reason: str
    until: float


@dataclass(frozen=True, slots=True)
class JointGuardState:
    """State between steps: a set-point per joint of the group, in its order.

    ``command_stamp``: stamp (s, robot's clock) of the newest command; ``refused``: reason of refusing the newest, or
    None. ``pressed_s``: how long (s) some joint has felt more than its limit; ``contact``: the contact that the group
    yields to, or None.
    """

    setpoints: tuple[JointSetpoint, ...]
    command_stamp: float | None = None
    refused: str | None = None
    pressed_s: float = 0.0
    contact: JointContact | None = None


@dataclass(frozen=True, slots=True)
class JointAction:
    """Action now: approach the goals, or ``safe`` instead; with mode and reason."""

    mode: JointMode
    reason: str
    safe: SafeAction | None = None


def at_rest(group: ActuatorGroup, positions: tuple[float, ...]) -> JointGuardState:
    """The state of joints that keep ``positions`` (rad), within their limits."""
    return JointGuardState(
        tuple(
            JointSetpoint(
                position=clamp(position, limits),
                goal=clamp(position, limits),
                velocity=0.0,
                stiffness=group.stiffness,
                damping=group.damping,
                wanted_stiffness=group.stiffness,
                wanted_damping=group.damping,
            )
            for position, limits in zip(positions, group.joints, strict=True)
        )
    )


def clamp(position: float, limits: JointLimits) -> float:
    """``position`` within the joint's limits."""
    return min(max(position, limits.lower), limits.upper)


def accept(state: JointGuardState, group: ActuatorGroup, command: JointCommand) -> JointGuardState:
    """The state after ``command``: refused if it is no command of this group, ignored if older than the last.

    Joints that it does not name keep their goals.
    """
    problem = _problem(group, command)
    if problem:
        return replace(state, refused=problem)
    if state.command_stamp is not None and command.stamp < state.command_stamp:
        return state
    places = {joint.name: place for place, joint in enumerate(group.joints)}
    setpoints = list(state.setpoints)
    for number, name in enumerate(command.names):
        place = places[name]
        setpoints[place] = replace(
            setpoints[place],
            goal=clamp(command.positions[number], group.joints[place]),
            wanted_stiffness=command.stiffness[number] if command.stiffness else group.stiffness,
            wanted_damping=command.damping[number] if command.damping else group.damping,
        )
    contact = state.contact if state.contact is not None and command.stamp < state.contact.until else None
    return replace(state, setpoints=tuple(setpoints), command_stamp=command.stamp, refused=None, contact=contact)


def feel(
    now: float, state: JointGuardState, group: ActuatorGroup, external: tuple[float, ...], dt_s: float
) -> JointGuardState:
    """The state after the joints felt ``external`` from outside (N m, N where prismatic; in the group's order) for
    ``dt_s`` seconds until ``now`` (s, robot's clock)."""
    over = [number for number, limits in enumerate(group.joints) if abs(external[number]) > limits.contact]
    if not over or state.contact is not None:
        return state if state.pressed_s == 0.0 else replace(state, pressed_s=0.0)
    pressed_s = state.pressed_s + dt_s
    if pressed_s < group.contact_s:
        return replace(state, pressed_s=pressed_s)
    limits, felt = group.joints[over[0]], external[over[0]]
    reason = f"contact: {limits.name} felt {abs(felt):.1f} N m, more than {limits.contact:g}"
    return replace(state, pressed_s=0.0, contact=JointContact(reason, now + group.contact_rest_s))


def clear_e_stop(state: JointGuardState, group: ActuatorGroup) -> JointGuardState:
    """The state with the emergency stop released: earlier commands are dropped, so the joints wait for a new one."""
    setpoints = tuple(
        replace(setpoint, goal=_stopping_point(setpoint.position, setpoint.velocity, limits))
        for setpoint, limits in zip(state.setpoints, group.joints, strict=True)
    )
    return replace(state, setpoints=setpoints, command_stamp=None, refused=None)


def command_age(state: JointGuardState, now: float) -> float | None:
    """Age (s) of the newest command at ``now``, None before the first."""
    return None if state.command_stamp is None else now - state.command_stamp


def decide(now: float, state: JointGuardState, group: ActuatorGroup, e_stop: str | None) -> JointAction:
    """The allowed motion at ``now`` (s, robot's clock). ``e_stop``: reason of the latched emergency stop, or None.

    The most severe state wins: emergency stop, contact, refused command, no command or a stale one.
    """
    if e_stop is not None:
        mode = JointMode.YIELDING if group.stop is SafeAction.YIELD else JointMode.HOLDING
        return JointAction(mode, f"emergency stop: {e_stop}", group.stop)
    if state.contact is not None:
        return JointAction(JointMode.YIELDING, state.contact.reason, SafeAction.YIELD)
    if state.refused is not None:
        return JointAction(JointMode.REFUSED, state.refused, group.stale)
    if state.command_stamp is None:
        return _unattended(state, group, "no command yet")
    age = now - state.command_stamp
    if age < -FUTURE_TOLERANCE_S:
        reason = f"the command's time lies {-age:.1f} s in the future: is its sender's clock the robot's?"
        return JointAction(JointMode.REFUSED, reason, group.stale)
    # Written so that an age that is no number is stale.
    if not age <= group.timeout_s:
        return _unattended(state, group, f"no fresh command for {age:.1f} s")
    return JointAction(JointMode.MOVING, "")


def step(
    state: JointGuardState, action: JointAction, group: ActuatorGroup, measured: tuple[float, ...], dt_s: float
) -> JointGuardState:
    """The state ``dt_s`` seconds later. ``measured``: positions (rad) of the group's joints now, in its order."""
    setpoints = tuple(
        _step(setpoint, action.safe, group, number, measured=position, dt_s=dt_s)
        for number, (setpoint, position) in enumerate(zip(state.setpoints, measured, strict=True))
    )
    if all(after is before for after, before in zip(setpoints, state.setpoints, strict=True)):
        return state
    # At every control step of a joint that moves: replace() takes five times as long
    return JointGuardState(
        setpoints,
        state.command_stamp,
        refused=state.refused,
        pressed_s=state.pressed_s,
        contact=state.contact,
    )


def status(now: float, state: JointGuardState, group: ActuatorGroup, action: JointAction) -> GroupStatus:
    """The group's state as a message."""
    return GroupStatus(group.name, action.mode.value, action.reason, command_age(state, now))


def _problem(group: ActuatorGroup, command: JointCommand) -> str:
    """Why ``command`` is refused, in words; "" where it is not."""
    known = {joint.name for joint in group.joints}
    if unknown := [name for name in command.names if name not in known]:
        return f"{group.name} has no joint {unknown[0]!r}; it has {', '.join(joint.name for joint in group.joints)}"
    if len(set(command.names)) < len(command.names):
        return "the last command names a joint twice"
    values = {"positions": command.positions, "stiffness": command.stiffness, "damping": command.damping}
    for what, numbers in values.items():
        if len(numbers) != len(command.names) and (numbers or what == "positions"):
            return f"the last command has {len(numbers)} {what} for {len(command.names)} joints"
        if not all(math.isfinite(number) for number in numbers):
            return "the last command was not a number"
    if not math.isfinite(command.stamp):
        return "the last command's time was not a number"
    given = command.stiffness + command.damping
    if given and not group.compliant:
        return f"{group.name} is not compliant: its commands set no stiffness and no damping"
    ranges = {"stiffness": (command.stiffness, group.stiffness_range, "N m/rad")}
    ranges["damping"] = (command.damping, group.damping_range, "N m s/rad")
    for what, (numbers, (least, most), unit) in ranges.items():
        for name, number in zip(command.names, numbers, strict=False):
            if not least <= number <= most:
                return (
                    f"{what} {number:g} of {name} lies outside {least:g} to {most:g} {unit}, the range of {group.name}"
                )
    return ""


def _unattended(state: JointGuardState, group: ActuatorGroup, reason: str) -> JointAction:
    if group.stale is SafeAction.YIELD:
        return JointAction(JointMode.YIELDING, reason, SafeAction.YIELD)
    moving = any(setpoint.velocity != 0.0 for setpoint in state.setpoints)
    return JointAction(JointMode.HOLDING if moving else JointMode.IDLE, reason, group.stale)


def _at_rest(group: ActuatorGroup, number: int) -> float:
    return clamp(group.rest[number] if group.rest else 0.0, group.joints[number])


def _step(
    setpoint: JointSetpoint,
    safe: SafeAction | None,
    group: ActuatorGroup,
    number: int,
    *,
    measured: float,
    dt_s: float,
) -> JointSetpoint:
    limits = group.joints[number]
    if safe is SafeAction.YIELD:
        return _yielding(setpoint, group, limits, measured)
    stiffness = setpoint.wanted_stiffness if safe is None else group.stiffness
    damping = setpoint.wanted_damping if safe is None else group.damping
    position, velocity = setpoint.position, setpoint.velocity
    if stiffness > setpoint.stiffness and math.isfinite(measured):
        # The set-point moves towards the joint, so that the rise leaves the torque as it is.
        position = clamp(measured + setpoint.stiffness / stiffness * (position - measured), limits)
        velocity = 0.0
    if safe is SafeAction.REST:
        goal = _at_rest(group, number)
    else:
        goal = setpoint.goal if safe is None else _stopping_point(position, velocity, limits)
    same = stiffness == setpoint.stiffness and damping == setpoint.damping and goal == setpoint.goal
    if same and velocity == 0.0 and goal == position:
        return setpoint
    position, velocity = advance(position, velocity, goal, limits, dt_s)
    return JointSetpoint(
        position,
        goal,
        velocity=velocity,
        stiffness=stiffness,
        damping=damping,
        wanted_stiffness=setpoint.wanted_stiffness,
        wanted_damping=setpoint.wanted_damping,
    )


def _yielding(setpoint: JointSetpoint, group: ActuatorGroup, limits: JointLimits, measured: float) -> JointSetpoint:
    here = clamp(measured, limits) if math.isfinite(measured) else setpoint.position
    resting = setpoint.goal == setpoint.position and abs(here - setpoint.position) < RESTING
    if resting and setpoint.stiffness == 0.0 and setpoint.velocity == 0.0 and setpoint.damping == group.damping:
        return setpoint
    return JointSetpoint(
        here,
        here,
        velocity=0.0,
        stiffness=0.0,
        damping=group.damping,
        wanted_stiffness=setpoint.wanted_stiffness,
        wanted_damping=setpoint.wanted_damping,
    )


def _stopping_point(position: float, velocity: float, limits: JointLimits) -> float:
    return clamp(position + math.copysign(velocity**2 / (2 * limits.acceleration), velocity), limits)


def advance(position: float, velocity: float, goal: float, limits: JointLimits, dt_s: float) -> tuple[float, float]:
    """Position and velocity of a set-point ``dt_s`` seconds later, on its way to ``goal`` (within the limits).

    Given a velocity within the joint's speed from which it can stop within its positions, so is the result; the
    velocity changes by at most the joint's acceleration.
    """
    side = math.copysign(1.0, goal - position)
    distance, ahead = abs(goal - position), side * velocity
    most = limits.acceleration * dt_s
    least = ahead**2 / (2 * limits.acceleration)
    if ahead <= -most:  # away from the goal: brake first
        reached = ahead + most
        travelled = (ahead + reached) / 2 * dt_s
    elif ahead < 0:
        reached, travelled = 0.0, -least
    else:
        # Where (ahead + v)/2 * dt + v^2/(2a) is the distance left; none where even braking to zero in a step is more.
        inside = most**2 / 4 - most * ahead + 2 * limits.acceleration * distance
        stoppable = math.sqrt(inside) - most / 2 if inside >= 0 else -1.0
        reached = max(min(limits.velocity, ahead + most, stoppable), ahead - most)
        travelled = (ahead + reached) / 2 * dt_s
        if reached < 0:  # it stops within this step
            reached, travelled = 0.0, max(min(distance, ahead / 2 * dt_s), least)
    moved = position + side * travelled
    # Rounding alone can carry it beyond a limit, or past a goal that it stops at.
    return clamp(goal if reached == 0.0 and abs(moved - goal) < 1e-12 else moved, limits), side * reached
