"""Figures of actuator groups, from series with known answers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.experiments.body.measurement import Observation, group_figures, rest_after, spans, speeds
from app.link import ActuatorGroup, BaseLimits, JointLimits
from app.messages import Exploitation, GroupStatus, JointState, LinkStatus, Twist

HEAD = ActuatorGroup("head", (JointLimits("pan", lower=-1.0, upper=1.0, velocity=1.0, acceleration=5.0),))
BASE = BaseLimits(0.4, 1.0, 0.4, 4.0)


def observed(stop: float | None = 2.0) -> Observation:
    """The head turns at 0.5 rad/s until the stop at 2 s, and on for 0.2 s; the base drives at half its speed."""
    seen = Observation(stopped_at=stop)
    for beat in range(61):
        at = beat * 0.05
        still = Twist(at, 0.0, 0.0)
        mode = "moving" if at < 2.0 else "holding"
        groups = (GroupStatus("head", mode, "", 0.02 if at < 2.0 else at - 2.0),)
        base = "driving" if at < 2.0 else "e_stopped"
        seen.statuses.append((at, LinkStatus(at, base, "", at >= 2.0, 0.05, still, 1.0, groups)))
        seen.joints.append((at, JointState(at, ("pan",), (0.5 * min(at, 2.2),))))
        seen.odometry.append((at, 0.2 if at <= 2.1 else 0.0, 0.0))
        seen.exploitations.append((at, Exploitation(at, "LookAt" if 1 <= at < 2 else None, still, group="head")))
    return seen


def test_figures_of_a_turning_head_and_a_driving_base() -> None:
    base, head = group_figures(observed(), {"head": HEAD}, BASE)
    assert head.speed == pytest.approx(0.5)
    assert head.beyond == pytest.approx(0.1)
    assert head.behaviors == pytest.approx({"LookAt": 1.0})
    assert head.modes == pytest.approx({"moving": 2.0, "holding": 1.0})
    assert head.oldest_s == 0.02
    assert head.rest_s == pytest.approx(0.2, abs=0.06)
    assert base.group == "base"
    assert base.speed == pytest.approx(0.5)
    assert base.rest_s == pytest.approx(0.1, abs=1e-6)
    assert base.modes["driving"] == pytest.approx(2.0)


def test_without_a_stop_or_motion_at_it_there_is_no_time_to_rest() -> None:
    base, head = group_figures(observed(stop=None), {"head": HEAD}, BASE)
    assert base.rest_s is head.rest_s is None
    times = np.arange(0.0, 3.0, 0.1)
    assert rest_after(times, times > 2.5, 1.0) is None


def test_nothing_seen_gives_figures_of_nothing() -> None:
    base, head = group_figures(Observation(), {"head": HEAD}, BASE)
    assert (base.speed, head.speed, head.beyond, head.oldest_s) == (0.0, 0.0, 0.0, None)
    assert base.behaviors == head.modes == {}


@given(st.lists(st.sampled_from(["a", "b", None]), max_size=30))
def test_spans_cover_each_value_for_as_long_as_it_was(values: list[str | None]) -> None:
    """A value holds until the next sample; None is a gap."""
    times = [float(at) for at in range(len(values))]
    total = sum(end - start for start, end, _ in spans(times, values))
    assert total == sum(value is not None for value in values[:-1])


@given(st.floats(-3, 3), st.integers(20, 200))
def test_a_steady_motion_has_its_speed(speed: float, rate_hz: int) -> None:
    """At any rate of samples; the first sample has none."""
    times = np.arange(0.0, 2.0, 1 / rate_hz)
    assert np.allclose(speeds(times, speed * times)[1:], abs(speed), atol=1e-6)
    assert math.isclose(speeds(times, speed * times)[0], 0.0)
