"""The robots of a fleet, by what their consoles answer to ``GET /robot``. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import msgspec

from app.console.records.fleet import FleetRobot, FleetState

#: States of a guard in which a robot cannot be driven until somebody sees to it.
_PROBLEMS: Final = frozenset({"sensor_failure", "silent"})


class _Facts(msgspec.Struct):
    name: str
    called: str = ""
    simulated: bool = False


class _Guard(msgspec.Struct):
    state: str
    reason: str = ""
    e_stopped: bool = False


class _Battery(msgspec.Struct):
    charge: float


class _Robot(msgspec.Struct):
    """What is read of the answer to GET /robot; robots of other versions may say more."""

    robot: _Facts
    guard: _Guard
    driver: str | None = None
    exploited: str | None = None
    battery: _Battery | None = None


def robot_of(answer: bytes, url: str) -> FleetRobot:
    """The robot that answered GET /robot with ``answer``; one that is no such answer is unreachable."""
    try:
        robot = msgspec.json.decode(answer, type=_Robot)
    except msgspec.DecodeError as failure:
        return unreachable(url, f"What answers there is no robot's console: {failure}.")
    state, detail = state_of(robot.guard.state, robot.guard.reason, e_stopped=robot.guard.e_stopped)
    return FleetRobot(
        name=robot.robot.called or robot.robot.name,
        body=robot.robot.name,
        url=url,
        state=state,
        detail=detail,
        driver=robot.driver,
        exploited=robot.exploited,
        charge=None if robot.battery is None else robot.battery.charge,
        simulated=robot.robot.simulated,
    )


def state_of(guard: str, reason: str, *, e_stopped: bool) -> tuple[FleetState, str]:
    """The state in the fleet, and its words, of a robot whose guard is in the state ``guard`` for ``reason``."""
    if e_stopped:
        return "stopped", reason
    return ("problem", reason) if guard in _PROBLEMS else ("well", "")


def unreachable(url: str, detail: str) -> FleetRobot:
    """The robot behind ``url``, of which nothing is known."""
    return FleetRobot(name="", body="", url=url, state="unreachable", detail=detail)


def with_unique_names(robots: Sequence[FleetRobot]) -> tuple[FleetRobot, ...]:
    """``robots``; those of one name are a problem each, for nobody could say which of them is meant."""
    names = [robot.name for robot in robots if robot.name]
    twice = {name for name in names if names.count(name) > 1}
    detail = "Two robots are called {}: give one of them another name (`console.name`, or `hbba run --name`)."
    return tuple(
        replace(robot, state="stopped" if robot.state == "stopped" else "problem", detail=detail.format(robot.name))
        if robot.name in twice
        else robot
        for robot in robots
    )
