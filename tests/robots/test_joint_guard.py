"""The guard of a group of joints, stepped through time by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.link import ActuatorGroup, JointLimits, SafeAction
from app.messages import JointCommand
from app.robots import joint_guard
from app.robots.joint_guard import JointGuardState, JointMode

PAN = JointLimits("pan", -2.2, 2.2, velocity=1.05, acceleration=5.8)
TILT = JointLimits("tilt", -0.3, 0.44, velocity=1.05, acceleration=5.8)
HEAD = ActuatorGroup("head", (PAN, TILT), timeout_s=0.2)
ARM = ActuatorGroup(
    "arm", (PAN, TILT), stale=SafeAction.YIELD, stop=SafeAction.YIELD, timeout_s=0.2, compliant=True, stiffness=60.0,
    damping=6.0,
)  # fmt: skip
DT = 0.002
REST = (0.0, 0.0)


def command(
    stamp: float, *positions: float, names: tuple[str, ...] = ("pan", "tilt"), group: str = "head"
) -> JointCommand:
    return JointCommand(stamp, group, names, positions)


class Guarded:
    """A group whose joints follow their set-points exactly, commanded at ``now``."""

    def __init__(self, group: ActuatorGroup = HEAD) -> None:
        self.group, self.now, self.e_stop = group, 100.0, ""
        self.state = joint_guard.at_rest(group, REST)
        self.measured: tuple[float, ...] = REST
        self.positions: list[tuple[float, ...]] = [REST]
        self.velocities: list[tuple[float, ...]] = [REST]
        self.modes: list[JointMode] = []

    def take(self, given: JointCommand) -> None:
        self.state = joint_guard.accept(self.state, self.group, given)

    def run(self, seconds: float, *keep: float) -> None:
        """Step; ``keep`` are positions commanded afresh at every step."""
        for _ in range(round(seconds / DT)):
            self.now += DT
            if keep:
                self.take(command(self.now, *keep))
            action = joint_guard.decide(self.now, self.state, self.group, self.e_stop or None)
            self.state = joint_guard.step(self.state, action, self.group, self.measured, DT)
            self.modes.append(action.mode)
            self.positions.append(tuple(s.position for s in self.state.setpoints))
            self.velocities.append(tuple(s.velocity for s in self.state.setpoints))
            if all(s.stiffness > 0 for s in self.state.setpoints):
                self.measured = self.positions[-1]

    @property
    def pan(self) -> list[float]:
        return [positions[0] for positions in self.positions]


def test_without_a_command_the_joints_are_idle_and_keep_their_place() -> None:
    head = Guarded()
    head.run(0.1)
    assert head.positions[-1] == REST
    assert set(head.modes) == {JointMode.IDLE}
    status = joint_guard.status(head.now, head.state, HEAD, joint_guard.decide(head.now, head.state, HEAD, None))
    assert (status.group, status.guard, status.reason, status.command_age_s) == ("head", "idle", "no command yet", None)


def test_a_goal_is_reached_at_the_speed_and_acceleration_of_the_joint_without_overshoot() -> None:
    head = Guarded()
    head.run(2.0, 1.2, 0.0)
    assert head.pan[-1] == 1.2
    assert max(head.pan) == 1.2
    # Trapezoid: 1.2 m at 1.05 rad/s, and one ramp of 1.05 / 5.8 s
    arrived = next(step for step, position in enumerate(head.pan) if position == 1.2)
    assert arrived * DT == pytest.approx(1.2 / 1.05 + 1.05 / 5.8, abs=2 * DT)
    assert max(v[0] for v in head.velocities) == pytest.approx(1.05)
    assert head.velocities[-1] == REST


def test_a_goal_beyond_the_limits_is_clamped() -> None:
    head = Guarded()
    head.run(3.0, 9.0, -9.0)
    assert head.positions[-1] == (2.2, -0.3)
    assert head.velocities[-1] == REST


def test_joints_that_are_not_named_keep_their_goals() -> None:
    head = Guarded()
    head.run(0.05, 0.5, 0.2)
    for _ in range(500):
        head.take(command(head.now, 0.1, names=("pan",)))
        head.run(DT)
    assert head.positions[-1] == (0.1, 0.2)


def test_a_stale_command_brakes_within_the_acceleration_and_is_held() -> None:
    head = Guarded()
    head.run(0.5, 2.0, 0.0)
    assert head.velocities[-1][0] == pytest.approx(1.05)
    given, begin = head.now, len(head.pan)
    head.run(1.0)
    still = next(i for i, v in enumerate(head.velocities[begin:]) if v == REST) * DT
    assert still == pytest.approx(HEAD.timeout_s + 1.05 / 5.8, abs=3 * DT)
    assert head.modes.index(JointMode.HOLDING) * DT == pytest.approx(0.5 + 0.2, abs=2 * DT)
    assert head.modes[-1] is JointMode.IDLE, "it holds, and nothing moves"
    held = head.pan[-1]
    assert held == pytest.approx(head.pan[begin] + 1.05 * 0.2 + 1.05**2 / (2 * 5.8), abs=0.01)
    head.run(0.5)
    assert head.pan[-1] == held
    assert joint_guard.command_age(head.state, head.now) == pytest.approx(head.now - given)


def test_an_emergency_stop_holds_and_after_it_the_joints_wait_for_a_new_command() -> None:
    head = Guarded()
    head.run(0.5, 2.0, 0.0)
    head.e_stop = "the button"
    head.run(1.0, 2.0, 0.0)
    held = head.pan[-1]
    assert held == pytest.approx(head.pan[250] + 1.05**2 / (2 * 5.8), abs=0.01)
    action = joint_guard.decide(head.now, head.state, HEAD, "the button")
    assert (action.mode, action.reason) == (JointMode.HOLDING, "emergency stop: the button")
    head.e_stop = ""
    head.take(command(head.now, 2.0, 0.0))
    head.state = joint_guard.clear_e_stop(head.state, HEAD)
    head.run(0.2)
    assert head.pan[-1] == held
    head.run(0.2, 2.0, 0.0)
    assert head.pan[-1] > held


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        (command(101.0, math.nan, 0.0), "not a number"),
        (command(101.0, 0.0, math.inf), "not a number"),
        (command(math.nan, 0.0, 0.0), "not a number"),
        (command(101.0, 0.5, names=("roll",)), "head has no joint 'roll'; it has pan, tilt"),
        (command(101.0, 0.5), "1 positions for 2 joints"),
        (command(101.0, 0.5, 0.5, names=("pan", "pan")), "twice"),
        (JointCommand(101.0, "head", ("pan",), (0.5,), stiffness=(5.0,)), "not compliant"),
    ],
)
def test_a_bad_command_is_refused_and_the_joints_hold_until_a_good_one_comes(bad: JointCommand, says: str) -> None:
    head = Guarded()
    head.run(0.5, 2.0, 0.0)
    head.take(bad)
    head.run(0.1)
    assert set(head.modes[-50:]) == {JointMode.REFUSED}
    assert says in joint_guard.decide(head.now, head.state, HEAD, None).reason
    assert head.velocities[-1][0] == pytest.approx(1.05 - 0.1 * 5.8)
    head.run(0.1, 2.0, 0.0)
    assert head.modes[-1] is JointMode.MOVING


def test_a_command_older_than_the_newest_is_ignored_and_one_from_the_future_refused() -> None:
    head = Guarded()
    head.take(command(100.0, 0.5, 0.0))
    head.take(command(99.9, -0.5, 0.0))
    assert head.state.setpoints[0].goal == 0.5
    head.take(command(200.0, 0.5, 0.0))
    action = joint_guard.decide(100.0, head.state, HEAD, None)
    assert action.mode is JointMode.REFUSED
    assert "clock" in action.reason


def test_after_yielding_the_setpoints_begin_where_the_joints_were_pushed_to() -> None:
    arm = Guarded(ARM)
    arm.run(1.0, 0.8, 0.0)
    arm.run(1.0)
    assert arm.modes[-1] is JointMode.YIELDING
    assert {(s.stiffness, s.damping) for s in arm.state.setpoints} == {(0.0, 6.0)}
    arm.measured = (-0.4, 0.1)
    arm.run(DT)
    arm.run(DT, 0.8, 0.0)
    assert arm.positions[-1] == pytest.approx((-0.4, 0.1), abs=1e-4)
    assert [s.stiffness for s in arm.state.setpoints] == [60.0, 60.0]
    arm.run(3.0, 0.8, 0.0)
    assert arm.positions[-1] == (0.8, 0.0)


def test_raised_stiffness_leaves_the_torque_as_it_is() -> None:
    arm = Guarded(ARM)
    soft = JointCommand(100.0, "arm", ("pan", "tilt"), (0.0, 0.0), stiffness=(5.0, 5.0), damping=(2.0, 2.0))
    arm.take(soft)
    arm.run(0.1)
    arm.measured = (0.6, 0.0)  # pushed away by 3 N m
    arm.take(replace(soft, stamp=arm.now, stiffness=(300.0, 300.0)))
    arm.run(DT)
    pan = arm.state.setpoints[0]
    assert pan.stiffness * (pan.position - 0.6) == pytest.approx(-3.0, abs=0.1)


def test_a_position_that_is_no_number_does_not_get_through_while_a_group_yields() -> None:
    arm = Guarded(ARM)
    arm.measured = (math.nan, 0.1)
    arm.run(0.1)
    assert arm.positions[-1] == (0.0, 0.1)


@pytest.mark.parametrize("stopped", [True, False], ids=["stopped", "stale"])
def test_a_group_that_is_to_rest_goes_there_at_its_speed_and_stays(stopped: bool) -> None:
    face = Guarded(replace(HEAD, stale=SafeAction.REST, stop=SafeAction.REST, rest=(-0.5, 0.2)))
    face.run(0.4, 1.2, -0.3)
    begin = len(face.pan)
    face.e_stop = "test" if stopped else ""
    face.run(3.0, *((1.2, -0.3) if stopped else ()))
    assert face.positions[-1] == (-0.5, 0.2)
    assert max(abs(v[0]) for v in face.velocities[begin:]) <= PAN.velocity + 1e-12
    changes = [abs(after[0] - before[0]) for before, after in pairwise(face.velocities[begin:])]
    assert max(changes) <= PAN.acceleration * DT + 1e-12
    assert face.modes[-1] is (JointMode.HOLDING if stopped else JointMode.IDLE)
    if stopped:
        face.e_stop, face.state = "", joint_guard.clear_e_stop(face.state, face.group)
        face.run(0.5)
        assert face.positions[-1] == (-0.5, 0.2), "it waits for a new command"
    face.run(3.0, 1.2, -0.3)
    assert face.positions[-1] == (1.2, -0.3)


def test_a_group_rests_at_0_or_as_near_as_it_can_without_positions() -> None:
    away = replace(TILT, lower=0.1)
    face = Guarded(replace(HEAD, joints=(PAN, away), stale=SafeAction.REST))
    face.run(1.0, 0.5, 0.4)
    face.run(2.0)
    assert face.positions[-1] == (0.0, 0.1)


number = st.floats(allow_nan=True, allow_infinity=True)
goal = st.one_of(st.floats(-3.0, 3.0), number)
some_joints = st.sampled_from([("pan",), ("tilt",), ("pan", "tilt"), ("roll",), ()])
event = st.one_of(
    st.tuples(st.just("command"), st.floats(-0.3, 0.1), some_joints, goal, goal),
    st.tuples(st.sampled_from(["e_stop", "clear"]), st.just(0.0), st.just(()), st.just(0.0), st.just(0.0)),
)
moments = st.lists(st.tuples(st.one_of(st.none(), event), st.floats(0.0, 0.3), st.integers(1, 40)), max_size=30)


@given(moments, st.sampled_from(SafeAction), st.sampled_from(SafeAction), st.tuples(number, number))
def test_whatever_comes_position_speed_and_acceleration_stay_within_limits(
    events: list[tuple[tuple[str, float, tuple[str, ...], float, float] | None, float, int]],
    stale: SafeAction,
    stop: SafeAction,
    pushed: tuple[float, float],
) -> None:
    group = replace(HEAD, stale=stale, stop=stop, rest=(1.0, -0.2))
    state, now, e_stop = joint_guard.at_rest(group, REST), 1000.0, None
    for happening, dt, steps in events:
        if happening is not None:
            kind, offset, names, *positions = happening
            if kind == "command":
                given = JointCommand(now + offset, "head", names, tuple(positions[: len(names)]))
                state = joint_guard.accept(state, group, given)
            elif kind == "e_stop":
                e_stop = "test"
            else:
                e_stop, state = None, joint_guard.clear_e_stop(state, group)
        for _ in range(steps):
            now += dt
            before = state
            action = joint_guard.decide(now, state, group, e_stop)
            measured = pushed if before.setpoints[0].stiffness == 0 else tuple(s.position for s in state.setpoints)
            state = joint_guard.step(state, action, group, measured, dt)
            assert_within(before, state, dt)


def assert_within(before: JointGuardState, after: JointGuardState, dt: float) -> None:
    for was, now, limits in zip(before.setpoints, after.setpoints, HEAD.joints, strict=True):
        assert limits.lower <= now.position <= limits.upper
        assert abs(now.velocity) <= limits.velocity + 1e-12
        assert math.isfinite(now.goal)
        if was.stiffness == 0 or now.stiffness == 0:  # yields, or begins again where it was pushed to
            continue
        assert abs(now.velocity - was.velocity) <= limits.acceleration * dt + 1e-12
        assert abs(now.position - was.position) <= limits.velocity * dt + 1e-12
        assert_moved_as_it_says(was.position, was.velocity, now.position, velocity=now.velocity, dt=dt)


def assert_moved_as_it_says(
    from_position: float, from_velocity: float, position: float, *, velocity: float, dt: float
) -> None:
    """The set-point moved at constant acceleration from one velocity to the other, or stopped on the way."""
    moved = position - from_position
    if velocity != 0:
        assert moved == pytest.approx((from_velocity + velocity) / 2 * dt, abs=1e-9)
    else:
        assert moved * from_velocity >= -1e-9
        assert abs(moved) <= abs(from_velocity) / 2 * dt + 1e-9


limits = st.builds(
    JointLimits, st.just("any"), st.floats(-3, -0.1), st.floats(0.1, 3), st.floats(0.05, 5), st.floats(0.1, 50)
)


@given(limits, st.floats(-3, 3), st.floats(0.0005, 0.05))
def test_from_rest_any_goal_is_reached_without_overshoot(limits: JointLimits, goal: float, dt: float) -> None:
    goal = joint_guard.clamp(goal, limits)
    position, velocity = 0.0, 0.0
    ramp, cruise = limits.velocity / limits.acceleration, abs(goal) / limits.velocity
    triangle = 2 * math.sqrt(abs(goal) / limits.acceleration)
    for _ in range(math.ceil(max(ramp + cruise, triangle) / dt) + 4):
        position, velocity = joint_guard.advance(position, velocity, goal, limits, dt)
        assert (goal - position) * goal >= -1e-12
    assert (position, velocity) == (goal, 0.0)


@given(limits, st.floats(-1, 1), st.lists(st.tuples(st.floats(-4, 4), st.floats(0.0005, 0.5)), max_size=20))
def test_goals_that_move_while_a_joint_does_never_carry_it_beyond_its_limits(
    limits: JointLimits, speed: float, goals: list[tuple[float, float]]
) -> None:
    # As fast as it may be while it can still stop within its positions.
    room = limits.upper if speed > 0 else -limits.lower
    velocity = speed * min(limits.velocity, math.sqrt(2 * limits.acceleration * room))
    position = 0.0
    for goal, dt in goals:
        to = joint_guard.clamp(goal, limits)
        before, was = position, velocity
        position, velocity = joint_guard.advance(position, velocity, to, limits, dt)
        assert limits.lower <= position <= limits.upper
        assert abs(velocity) <= limits.velocity + 1e-9
        assert abs(velocity - was) <= limits.acceleration * dt + 1e-9
        assert_moved_as_it_says(before, was, position, velocity=velocity, dt=dt)


def test_stiffness_and_damping_beyond_the_groups_ranges_are_refused_by_name() -> None:
    arm = replace(ARM, stiffness_range=(0.0, 300.0), damping_range=(0.5, 40.0))
    for stiffness, damping, says in (
        (300.5, 6.0, "stiffness 300.5 of pan lies outside 0 to 300 N m/rad, the range of arm"),
        (60.0, 0.4, "damping 0.4 of pan lies outside 0.5 to 40 N m s/rad, the range of arm"),
        (60.0, 80.0, "damping 80 of pan lies outside 0.5 to 40 N m s/rad, the range of arm"),
    ):
        given = JointCommand(1.0, "arm", ("pan",), (0.0,), stiffness=(stiffness,), damping=(damping,))
        assert joint_guard.accept(joint_guard.at_rest(arm, REST), arm, given).refused == says
    for stiffness, damping in ((0.0, 0.5), (300.0, 40.0)):
        given = JointCommand(1.0, "arm", ("pan",), (0.0,), stiffness=(stiffness,), damping=(damping,))
        assert joint_guard.accept(joint_guard.at_rest(arm, REST), arm, given).refused is None


class Pressed(Guarded):
    """An arm with a limit of 8 N m for its first joint, which feels ``external`` there."""

    def __init__(self) -> None:
        limited = (replace(PAN, contact=8.0), TILT)
        super().__init__(replace(ARM, joints=limited, stale=SafeAction.HOLD, contact_s=0.1, contact_rest_s=1.0))
        self.external = 0.0

    def run(self, seconds: float, *keep: float) -> None:
        for _ in range(round(seconds / DT)):
            self.state = joint_guard.feel(self.now, self.state, self.group, (self.external, 100.0), DT)
            super().run(DT, *keep)


def test_a_contact_that_lasts_makes_the_group_yield_and_a_later_command_ends_it() -> None:
    arm = Pressed()
    arm.run(0.5, 1.0, 0.0)
    arm.external = -9.0
    arm.run(0.09, 1.0, 0.0)
    arm.external = 0.0
    arm.run(0.1, 1.0, 0.0)
    assert set(arm.modes) == {JointMode.MOVING}, "a jolt is no contact, nor is what the joint without a limit feels"
    arm.external = -9.0
    arm.run(0.11, 1.0, 0.0)
    assert arm.modes[-1] is JointMode.YIELDING
    reason = joint_guard.decide(arm.now, arm.state, arm.group, None).reason
    assert reason == "contact: pan felt 9.0 N m, more than 8"
    assert [s.stiffness for s in arm.state.setpoints] == [0.0, 0.0]
    arm.external, arm.measured = 0.0, (0.1, 0.0)  # it was pushed there
    began = len(arm.modes)
    arm.run(0.95, 1.0, 0.0)
    assert set(arm.modes[began:]) == {JointMode.YIELDING}, "commands that went on do not end it"
    arm.run(0.1, 1.0, 0.0)
    assert arm.modes[-1] is JointMode.MOVING
    assert 0.1 <= arm.pan[-1] < 0.1 + 0.5 * 5.8 * 0.1**2 + 1e-9, "it begins where it was pushed to"
    assert arm.state.setpoints[0].stiffness == 60.0


def test_after_a_contact_the_group_yields_until_there_is_a_command() -> None:
    arm = Pressed()
    arm.external = 9.0
    arm.run(0.2)
    arm.external = 0.0
    arm.run(5.0)
    assert arm.modes[-1] is JointMode.YIELDING
    arm.run(0.1, 0.0, 0.0)
    assert arm.modes[-1] is JointMode.MOVING


def test_an_emergency_stop_prevails_over_a_contact() -> None:
    arm = Pressed()
    arm.external = 9.0
    arm.run(0.2)
    arm.e_stop = "a test"
    action = joint_guard.decide(arm.now, arm.state, arm.group, arm.e_stop)
    assert action.reason == "emergency stop: a test"
