"""A simulated body discharges by what it does, and charges where its plate touches the dock's contacts."""

from __future__ import annotations

import math

import pytest

from app.messages import BatteryState, Twist
from app.robots.config import RobotConfig
from app.robots.simulated.link_protocol import ComputerLoad
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import VirtualClock, run_virtual
from tests.robots.conftest import make_hall

pytestmark = pytest.mark.slow

#: A dock whose plates meet at (10, 10) and whose V opens to the west.
HALL = make_hall(objects=[{"kind": "dock", "at": (10, 10), "yaw_deg": -90}])


def powers(
    robot: RobotConfig, world: WorldConfig, linear_mps: float, *, sensor: str = "", cores: float = 0.0
) -> list[BatteryState]:
    """States of the battery while the robot drives for four seconds, once a second; so many ``cores`` are busy."""

    async def run() -> list[BatteryState]:
        clock = VirtualClock()
        link = LockstepLink(robot, world, clock, None)
        states: list[BatteryState] = []
        link.attach("battery", states.append)
        await link.start()
        try:
            link._send(ComputerLoad(cores))
            for stream in filter(None, ("battery", sensor)):
                link.demand(stream, math.inf)
            for _ in range(80):
                link.command(Twist(clock.now(), linear_mps, 0.0))
                await clock.sleep(0.05)
            return states
        finally:
            await link.stop()

    return run_virtual(run())


def at(robot: RobotConfig, x: float) -> RobotConfig:
    start = robot.start.model_copy(update={"x": x, "y": 10.0, "heading_deg": 0.0})
    return robot.model_copy(update={"start": start})


def watts(state: BatteryState) -> float:
    return state.voltage_v * -state.current_a


def test_driving_and_each_sensor_draw_their_power(robot: RobotConfig, hall: WorldConfig) -> None:
    assert robot.battery is not None
    load = robot.battery.load
    still = powers(at(robot, 5.0), hall, 0.0)
    assert watts(still[-1]) == pytest.approx(load.idle_w + load.computer_w, rel=0.02)
    assert not still[-1].charging
    assert still[-1].charge < still[0].charge <= robot.battery.charge
    scanning = powers(at(robot, 5.0), hall, 0.0, sensor="hokuyo")
    assert watts(scanning[-1]) - watts(still[-1]) == pytest.approx(load.sensors_w["hokuyo"], abs=0.2)
    computing = powers(at(robot, 5.0), hall, 0.0, cores=1.5)
    assert watts(computing[-1]) - watts(still[-1]) == pytest.approx(1.5 * load.core_w, abs=0.2)
    driving = powers(at(robot, 5.0), hall, 0.4)
    assert watts(driving[-1]) - watts(still[-1]) > 0.9 * load.friction_n * 0.4 / load.efficiency


def test_a_robot_that_drives_into_the_dock_charges_and_one_beside_it_does_not(robot: RobotConfig) -> None:
    docked = powers(at(robot, 9.45), HALL, 0.08)
    assert not docked[0].charging
    assert docked[-1].charging
    assert docked[-1].charge > docked[-2].charge
    assert docked[-1].current_a > 0
    away = powers(at(robot, 8.0), HALL, 0.08)
    assert not any(state.charging for state in away)


def test_a_body_without_a_battery_has_no_such_stream(robot: RobotConfig, hall: WorldConfig) -> None:
    link = LockstepLink(robot.model_copy(update={"battery": None}), hall, VirtualClock(), None)
    assert "battery" not in link.description.streams
