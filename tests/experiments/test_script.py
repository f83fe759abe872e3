"""The simulated operator: follows a script, releases the sticks before an obstacle, and never holds on to them."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.errors import ConfigError
from app.base.geometry import Pose2, Pose3, wrap_angle
from app.experiments.script import (
    PATIENCE_S,
    ScriptBlocked,
    StickCommand,
    Waypoint,
    drive_script,
    in_the_way,
    load_script,
    steer,
)
from app.messages import GroundTruth, LaserScan, TeleopCommand
from app.program.system import System
from app.runtime.clock import VirtualClock, run_virtual

LIMIT_MPS, LIMIT_RADPS = 0.4, 1.0


def scan(stamp: float, distance: float = 5.0, bearing_deg: float = 0.0) -> LaserScan:
    """180 rays: nothing within 5 m but one thing of 10 degrees."""
    angles = np.radians(np.arange(180) - 90.0)
    ranges = np.where(np.abs(angles - math.radians(bearing_deg)) < math.radians(5), distance, 5.0).astype(np.float32)
    return LaserScan(stamp, "laser", ranges, ranges, -math.pi / 2, math.pi / 180, 0.1, 30.0, 0.0, Pose3.identity())


class World:
    """A link and a channel whose sticks move a point robot: all that the operator uses of a program."""

    def __init__(self, clock: VirtualClock, start: Pose2, wall_x: float = math.inf) -> None:
        self.clock = clock
        self.pose = start
        self.wall_x = wall_x
        self.sent: list[TeleopCommand] = []
        self.follows = True
        self.problem = ""
        self._receivers: dict[str, Callable[[Any], None]] = {}
        self.description = SimpleNamespace(streams=("ground_truth", "hokuyo"))
        self.system = cast(
            System, SimpleNamespace(clock=clock, link=self, graph=SimpleNamespace(channels={"teleop_command": self}))
        )

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        self._receivers[stream] = receive
        return lambda: None

    def demand(self, stream: str, rate_hz: float) -> None: ...

    def periods(self, stream: str) -> int:
        return 1

    def publish(self, command: TeleopCommand) -> None:
        self.sent.append(command)

    async def run(self) -> None:
        dt = 0.02
        while True:
            await self.clock.sleep(dt)
            now = self.clock.now()
            if self.follows and self.sent and self.sent[-1].held:
                forward, turn = LIMIT_MPS * self.sent[-1].linear, LIMIT_RADPS * self.sent[-1].angular
                self.pose = self.pose @ Pose2(forward * dt, 0.0, turn * dt)
            self._receivers["ground_truth"](GroundTruth(now, self.pose, 0.0, 0.0))
            ahead = (self.wall_x - self.pose.x) / math.cos(self.pose.theta) if math.cos(self.pose.theta) > 0.1 else 9.0
            self._receivers["hokuyo"](scan(now, max(0.05, min(5.0, ahead))))


def driven(
    script: list[dict[str, Any]], start: Pose2 | None = None, wall_x: float = math.inf, follows: bool = True
) -> tuple[World, list[int], float]:
    """The world after the script, the reported legs, and the duration."""

    async def main() -> tuple[World, list[int], float]:
        clock = VirtualClock()
        world = World(clock, start or Pose2(), wall_x)
        world.follows = follows
        legs: list[int] = []
        running = asyncio.create_task(world.run())
        began = clock.now()
        try:
            await drive_script(
                world.system, [Waypoint.model_validate(leg) for leg in script], lambda i, _: legs.append(i)
            )
        except ScriptBlocked as blocked:
            world.problem = str(blocked)
        finally:
            running.cancel()
        return world, legs, clock.now() - began

    return run_virtual(main())


def test_a_script_is_driven_to_its_end() -> None:
    world, legs, seconds = driven([{"go": (2, 0)}, {"face": 90}, {"pause": 2}, {"go": (2, -1.5), "speed": 0.5}])
    assert legs == [0, 1, 2, 3]
    assert math.dist((world.pose.x, world.pose.y), (2, -1.5)) < 0.1
    assert 14 < seconds < 40
    assert not world.sent[-1].held
    assert [command.sequence for command in world.sent] == list(range(1, len(world.sent) + 1))
    slow = [abs(command.linear) for command in world.sent[-200:]]
    assert max(slow) <= 0.5


def test_it_stops_before_a_wall_and_gives_up() -> None:
    world, legs, seconds = driven([{"go": (4, 0), "label": "the wall"}, {"go": (0, 0)}], wall_x=2.0)
    assert legs == [0]
    assert 1.3 < world.pose.x < 1.5
    assert "in the robot's way" in world.problem
    assert "the wall" in world.problem
    assert PATIENCE_S < seconds < PATIENCE_S + 10
    assert not world.sent[-1].held


def test_it_gives_up_on_a_robot_that_does_not_follow() -> None:
    world, _, seconds = driven([{"face": 90}], follows=False)
    assert "does not do what the sticks say" in world.problem
    assert seconds < PATIENCE_S + 1
    assert not world.sent[-1].held


def test_who_ends_it_halfway_gets_a_released_stick() -> None:
    async def main() -> World:
        world = World(VirtualClock(), Pose2())
        running = asyncio.create_task(world.run())
        driving = asyncio.create_task(drive_script(world.system, [Waypoint(go=(9, 0))]))
        await world.clock.sleep(3.0)
        driving.cancel()
        await asyncio.wait({driving})
        running.cancel()
        return world

    world = run_virtual(main())
    assert world.sent[-2].held
    assert not world.sent[-1].held


@pytest.mark.parametrize(
    ("distance", "bearing_deg", "expected"),
    [
        (0.4, 0.0, pytest.approx(0.4, abs=0.01)),
        (0.7, 0.0, None),
        (0.45, 70.0, None),
        (0.3, 40.0, pytest.approx(0.21, abs=0.05)),
    ],
)
def test_what_is_in_the_way(distance: float, bearing_deg: float, expected: float | None) -> None:
    assert in_the_way(scan(0.0, distance, bearing_deg)) == expected


@given(x=st.floats(-5, 5), y=st.floats(-5, 5), theta=st.floats(-4, 4), turning=st.booleans(), speed=st.floats(0.1, 1))
def test_the_sticks_stay_in_their_range_and_turn_the_right_way(
    x: float, y: float, theta: float, turning: bool, speed: float
) -> None:
    sticks = steer(Waypoint(go=(x, y), speed=speed), Pose2(0, 0, theta), turning)
    assert abs(sticks.linear) <= speed
    assert abs(sticks.angular) <= speed
    assert sticks.linear >= 0
    error = wrap_angle(math.atan2(y, x) - theta)
    if sticks != StickCommand(done=True) and 1e-3 < abs(error) < 3.1:
        assert sticks.angular * error > 0


def test_the_thesiss_trial_has_a_script_and_who_has_none_is_reported(tmp_path: Path) -> None:
    script = load_script()
    assert sum(leg.pause is not None for leg in script) == 3
    empty = tmp_path / "empty.yaml"
    empty.write_text("name: empty\n")
    with pytest.raises(ConfigError, match="has no drive"):
        load_script(empty)
