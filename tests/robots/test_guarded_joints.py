"""Guards of joints whose own controllers take positions: where set-points begin, how they stop, when they are sent."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.link import ActuatorGroup, JointLimits
from app.messages import JointCommand
from app.robots.guarded_joints import GuardedJoints
from app.robots.link_protocol import ClearEStop

STEP_S = 0.02
PAN = JointLimits("pan", -1.5, 1.5, velocity=1.0, acceleration=5.0)
TILT = JointLimits("tilt", -0.5, 0.5, velocity=1.0, acceleration=5.0)


class Played:
    """A head that is where it was sent last."""

    def __init__(self, pan: float = 0.4) -> None:
        self.joints = GuardedJoints([ActuatorGroup("head", (PAN, TILT))])
        self.now = 10.0
        self.positions = (pan, 0.0)
        self.sent: list[tuple[float, ...]] = []
        self.e_stop: str | None = None
        self.fault = ""
        self.refusal = ""

    def measure(self) -> None:
        self.joints.measure({"pan": self.positions[0], "tilt": self.positions[1], "left_wheel": 3.0})

    def command(self, pan: float) -> None:
        self.joints.take(JointCommand(self.now, "head", ("pan",), (pan,)))

    def step(self, steps: int = 1, *, commanded: float | None = None) -> None:
        """Some steps, of each with a command where one is ``commanded``."""
        for _ in range(steps):
            if commanded is not None:
                self.command(commanded)
            self.joints.step(self.now, STEP_S, self.e_stop, {"head": self.fault}, {"head": self.refusal})
            if due := self.joints.due("head"):
                self.sent.append(due)
                self.positions = (due[0], due[1])
            self.now += STEP_S
            self.measure()

    @property
    def state(self) -> str:
        (status,) = self.joints.status(self.now)
        return status.guard


def test_nothing_moves_before_all_joints_were_measured() -> None:
    head = Played()
    head.joints.measure({"pan": 0.4})
    head.joints.measure({"pan": math.nan, "tilt": 0.0})
    head.command(1.0)
    head.joints.step(head.now, STEP_S, None, {})
    assert head.joints.due("head") == ()
    (status,) = head.joints.status(head.now)
    assert (status.guard, status.reason) == ("holding", "its joints were not measured yet")


def test_set_points_begin_where_the_joints_are_and_end_at_the_goal() -> None:
    head = Played()
    head.measure()
    head.step()
    assert head.sent == [], "what rests is not sent"
    head.step(100, commanded=1.0)
    assert abs(head.sent[0][0] - 0.4) <= PAN.velocity * STEP_S
    assert head.sent[-1] == pytest.approx((1.0, 0.0))
    speeds = [abs(b[0] - a[0]) / STEP_S for a, b in pairwise(head.sent)]
    assert max(speeds) <= PAN.velocity + 1e-9
    many = len(head.sent)
    head.step(100, commanded=1.0)
    assert len(head.sent) == many, "what stays is not sent again"


def test_others_may_have_moved_it_meanwhile() -> None:
    head = Played()
    head.measure()
    head.step(100, commanded=1.0)
    head.step(50)
    head.positions = (-1.0, 0.0)
    head.measure()
    head.step(1, commanded=1.0)
    assert abs(head.sent[-1][0] + 1.0) <= PAN.velocity * STEP_S


@pytest.mark.parametrize("why", ["stale", "e_stop", "fault", "refused"])
def test_it_brakes_and_stays(why: str) -> None:
    head = Played(pan=-1.0)
    head.measure()
    head.step(40, commanded=1.5)
    before = head.positions[0]
    match why:
        case "e_stop":
            head.e_stop = "a person pressed it"
        case "fault":
            head.fault = "joints has given nothing for 0.6 s"
        case "refused":
            head.command(math.nan)
    head.step(100, commanded=1.5 if why in ("e_stop", "fault") else None)
    braking_m = PAN.velocity**2 / (2 * PAN.acceleration)
    stale_m = 0.25 * PAN.velocity if why == "stale" else 0.0
    assert before < head.positions[0] <= before + braking_m + stale_m + 2 * STEP_S * PAN.velocity
    assert head.state in ("holding", "idle", "refused")
    many = len(head.sent)
    head.e_stop, head.fault = None, ""
    head.joints.take(ClearEStop())
    head.step(50)
    assert len(head.sent) == many, "nothing moves again without a new command"
    head.step(200, commanded=1.5)
    assert head.positions[0] == pytest.approx(1.5)


@given(goals=st.lists(st.one_of(st.none(), st.floats(-9, 9)), max_size=20), pan=st.floats(-1.5, 1.5))
def test_whatever_is_commanded_the_limits_hold(goals: list[float | None], pan: float) -> None:
    head = Played(pan)
    head.measure()
    for goal in goals:
        head.step(7, commanded=goal)
    head.step(100)
    path = [(pan, 0.0), *head.sent]
    assert all(PAN.lower <= at[0] <= PAN.upper for at in path)
    assert all(abs(b[0] - a[0]) <= PAN.velocity * STEP_S + 1e-9 for a, b in pairwise(path))


def test_what_the_body_refused_is_held_and_goes_on_from_where_it_is() -> None:
    head = Played(0.0)
    head.measure()
    head.step(20, commanded=1.0)
    assert head.joints.moves("head")
    head.refusal = "the action rejected the goal"
    head.step(50, commanded=1.0)
    (status,) = head.joints.status(head.now)
    assert (status.guard, status.reason) == ("refused", "the action rejected the goal")
    assert not head.joints.moves("head")
    # Others moved it meanwhile: set-points begin there.
    head.positions, head.refusal = (-0.5, 0.0), ""
    head.measure()
    head.step(1, commanded=1.0)
    assert head.sent[-1][0] == pytest.approx(-0.5, abs=0.01)
