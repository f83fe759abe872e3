"""The simulated battery and the dock's contacts: values and times alone."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from app.base import paths
from app.base.geometry import Pose2
from app.base.yaml_source import load_yaml
from app.robots.battery_config import BatteryConfig
from app.robots.simulated.battery import Battery
from app.robots.simulated.dock import dock_poses, touches
from app.robots.simulated.world_config import WorldConfig

PLATE_M = 0.275
#: A dock at (3, 1) whose V opens to the west.
DOCK = Pose2(3.0, 1.0, math.pi)


def test_it_gives_its_capacity_and_then_is_empty() -> None:
    battery = Battery(BatteryConfig(capacity_wh=100, charge=0.5))
    for _ in range(3600):
        battery.advance(0.5, 50.0, charging=False)
    state = battery.state(7.0)
    assert state.stamp == 7.0
    assert state.charge == pytest.approx(0.25)
    assert state.remaining_s == pytest.approx(1800.0)
    assert not state.charging
    battery.advance(7200.0, 50.0, charging=False)
    empty = battery.state(8.0)
    assert empty.charge == 0.0
    assert empty.remaining_s == 0.0


def test_a_charger_supplies_the_load_first_and_a_full_battery_takes_nothing() -> None:
    battery = Battery(BatteryConfig(capacity_wh=100, charge=0.5, charger_w=150))
    battery.advance(1800.0, 50.0, charging=True)
    state = battery.state(0.0)
    assert state.charge == pytest.approx(1.0)
    assert state.charging
    assert state.current_a > 0
    battery.advance(10.0, 50.0, charging=True)
    full = battery.state(0.0)
    assert full.charge == 1.0
    assert full.charging
    assert full.current_a == 0.0
    assert full.remaining_s is None


def test_voltage_times_current_is_the_power_and_a_load_lowers_the_voltage() -> None:
    config = BatteryConfig(charge=0.5, empty_v=22, full_v=26, resistance_ohm=0.05)
    battery = Battery(config)
    battery.advance(1.0, 60.0, charging=False)
    state = battery.state(0.0)
    assert state.current_a < 0
    assert state.voltage_v * state.current_a == pytest.approx(-60.0, rel=1e-3)
    assert state.voltage_v < 24.0


def test_the_remaining_time_follows_the_mean_power_of_a_minute() -> None:
    battery = Battery(BatteryConfig(capacity_wh=100))
    for _ in range(600):
        battery.advance(1.0, 100.0, charging=False)
    before = battery.state(0.0).remaining_s
    battery.advance(1.0, 1000.0, charging=False)
    after = battery.state(0.0).remaining_s
    assert before is not None
    assert after is not None
    assert 0.8 < after / before < 0.95  # a second of a greater load changes little


@given(
    charge=st.floats(0, 1),
    steps=st.lists(st.tuples(st.floats(0.001, 1000), st.floats(0, 500), st.booleans()), max_size=20),
)
def test_the_charge_stays_a_share_and_time_is_never_negative(
    charge: float, steps: list[tuple[float, float, bool]]
) -> None:
    battery = Battery(BatteryConfig(charge=charge, capacity_wh=10))
    for seconds, load_w, charging in steps:
        battery.advance(seconds, load_w, charging=charging)
        state = battery.state(0.0)
        assert 0.0 <= state.charge <= 1.0
        assert state.remaining_s is None or state.remaining_s >= 0.0
        assert state.voltage_v > 0


def test_a_voltage_that_falls_with_the_charge_is_refused() -> None:
    with pytest.raises(ValidationError, match="full_v"):
        BatteryConfig(empty_v=26, full_v=22)


@pytest.mark.parametrize(
    ("x", "aside", "turned_deg", "touching"),
    [
        (0.40, 0.0, 0.0, True),
        (0.38, 0.03, 4.0, True),
        (0.42, 0.0, 0.0, False),  # not there yet
        (0.40, 0.08, 0.0, False),  # beside it
        (0.40, 0.0, 12.0, False),  # askew
        (0.40, 0.0, 180.0, False),  # its back to the dock
    ],
)
def test_contacts_touch_the_plate_of_a_robot_that_stands_right(
    x: float, aside: float, turned_deg: float, touching: bool
) -> None:
    X_WB = DOCK @ Pose2(x, aside, math.pi + math.radians(turned_deg))
    assert touches(X_WB, [DOCK], PLATE_M) is touching


def test_the_lab_has_one_dock_and_its_V_opens_to_the_north() -> None:
    world = load_yaml(paths.config_dir() / "worlds" / "lab.yaml").validate(WorldConfig)
    (X_WD,) = dock_poses(world)
    assert (X_WD.x, X_WD.y, X_WD.theta) == pytest.approx((11.1, 0.3, math.pi / 2))
