"""The link of a kinematic body, in the program's own process, on the program's clock.

It has no motors, so its guard protects nothing: its rules are there, so that the program meets what it meets on a
robot. World and map are one frame: the map's.

Streams: ``odometry``, ``joints``, ``status``, ``hokuyo`` where it has a laser, and the truth (``ground_truth``,
``scene_truth``), by which modules stand in for perceptions that need pictures (``app/modules/perception/stand_ins``).
What is played is silent.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any

from app.base.geometry import Pose2
from app.base.kinematic_model import load_model
from app.link import LinkFailed, RobotDescription, StreamDescription
from app.maps.grid_rays import GridRays
from app.messages import (
    Audio,
    GroundTruth,
    JointCommand,
    JointState,
    LaserScan,
    LinkStatus,
    OccupancyGrid,
    Odometry,
    PersonTruth,
    SceneTruth,
    Twist,
)
from app.robots.guard import BaseVelocity, VelocityCommand, command_age
from app.robots.receivers import ALWAYS_ON, Receivers
from app.robots.simulated.kinematic.base import Discs, KinematicBase, Outline
from app.robots.simulated.kinematic.config import KinematicConfig
from app.robots.simulated.kinematic.joints import KinematicJoints
from app.robots.simulated.kinematic.laser import KinematicLaser, legs
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.scenery.scenario_state import ScenarioState
from app.runtime.clock import Clock

BODY_RADIUS_SHARE = 0.13
"""Of a person's height: the floor that a person takes, as in the simulated lab."""
_CATCH_UP_S = 1.0
"""Of a longer break of the program, only this is made up for: the body stands for the rest."""


class KinematicLink:
    """Implements ``app.link.RobotLink`` for the body ``config`` on ``grid``, with the people of ``scenario``."""

    def __init__(
        self, config: KinematicConfig, grid: OccupancyGrid, clock: Clock, scenario: ScenarioConfig | None = None
    ) -> None:
        scenario = scenario or ScenarioConfig(name="empty")
        self._clock = clock
        self.description = describe(config)
        #: ``X_WO``: pose of odometry's origin on the map.
        self.start_pose = Pose2(config.start.x, config.start.y, math.radians(config.start.heading_deg))
        rays, model = GridRays(grid), load_model(config.model)
        outline = Outline(config.footprint, grid.resolution_m)
        self.base = KinematicBase(self.start_pose, config.limits.guard(), outline, rays)
        self.scenario_state = ScenarioState(scenario)
        self._joints = KinematicJoints(config.groups.values())
        self._unmoved = dict.fromkeys(model.joint_names, 0.0)
        self._laser: KinematicLaser | None = None
        self._laser_config = config.laser
        if config.laser is not None:
            self._laser = KinematicLaser(config.laser, model.pose(config.laser.link), rays, scenario.seed)
        self._receivers = Receivers(self.description)
        self._rate_hz = config.rate_hz
        self._period_s = 1.0 / config.rate_hz
        self._steps = 0
        #: Each so many steps a stream gives a message.
        self._every = {
            name: max(1, round(config.rate_hz / stream.rate_hz)) for name, stream in self.description.streams.items()
        }
        self._turning: asyncio.Task[None] | None = None

    # The truth, for rehearsals and tests alone.

    def true_pose(self) -> Pose2:
        """``X_WB`` now."""
        return self.base.pose

    @property
    def people(self) -> tuple[PersonTruth, ...]:
        """Everyone on the map."""
        return self.scenario_state.people

    def let_pass(self) -> None:
        """The robot asks those who follow it to let it pass: what is said is heard by no person here."""
        self.scenario_state.let_pass()

    # app.link.RobotLink

    async def start(self) -> None:
        """Begin to move. Raises LinkFailed where it runs already."""
        if self._turning is not None and not self._turning.done():
            raise LinkFailed("The kinematic robot runs already.")
        self._turning = asyncio.create_task(self._turn(), name="kinematic body")

    async def stop(self) -> None:
        """Stop where it is; idempotent."""
        turning, self._turning = self._turning, None
        if turning is not None:
            turning.cancel()
            await asyncio.wait({turning})

    async def wait_failed(self) -> LinkFailed:
        """Wait until it ends."""
        if self._turning is None:
            return LinkFailed("The kinematic robot was not started.")
        turning = self._turning
        await asyncio.wait({turning})
        error = None if turning.cancelled() else turning.exception()
        failure = LinkFailed(f"The kinematic robot stopped: {error or 'it was ended'}.")
        failure.__cause__ = error
        return failure

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        """As ``RobotLink.attach``."""
        return self._receivers.attach(stream, receive)

    def demand(self, stream: str, rate_hz: float) -> None:
        """As ``RobotLink.demand``."""
        self._receivers.demand(stream, rate_hz)

    def periods(self, stream: str) -> int:
        """As ``RobotLink.periods``."""
        return self._receivers.periods(stream)

    def command(self, command: Twist | JointCommand) -> None:
        """As ``RobotLink.command``."""
        if isinstance(command, JointCommand):
            self._joints.accept(command)
            return
        velocity = BaseVelocity(command.linear_mps, command.angular_radps, command.lateral_mps)
        self.base.accept(VelocityCommand(command.stamp, velocity))

    def play(self, audio: Audio) -> None:
        """Nothing is heard of it."""

    def e_stop(self, reason: str) -> None:
        """As ``RobotLink.e_stop``."""
        self.base.e_stop(reason)

    def clear_e_stop(self) -> None:
        """As ``RobotLink.clear_e_stop``."""
        self.base.clear_e_stop()
        self._joints.clear_e_stop()

    # Its steps

    async def _turn(self) -> None:
        due = self._clock.now()
        while True:
            due = max(due + self._period_s, self._clock.now() - _CATCH_UP_S)
            await self._clock.sleep_until(due)
            self._step(due)

    def _step(self, now: float) -> None:
        self._steps += 1
        self.scenario_state.advance(self._steps * self._period_s, self.base.pose)
        self.base.step(now, self._period_s, self._people_on_the_floor())
        self._joints.step(now, self._period_s, self.base.state.e_stop)
        self._send(now)

    def _people_on_the_floor(self) -> Discs:
        return [(actor.x, actor.y, BODY_RADIUS_SHARE * actor.height_m) for actor in self.scenario_state.actors]

    def _send(self, now: float) -> None:
        base, velocity = self.base, self.base.velocity
        speeds = velocity.linear_mps, velocity.angular_radps, velocity.lateral_mps
        X_OB = self.start_pose.inverse() @ base.pose
        self._receivers.deliver("odometry", Odometry(now, X_OB, speeds[0], speeds[1], lateral_mps=speeds[2]))
        if self._due("joints"):
            positions = {**self._unmoved, **self._joints.positions()}
            self._receivers.deliver("joints", JointState(now, tuple(positions), tuple(positions.values())))
        if self._due("ground_truth"):
            truth = GroundTruth(now, base.pose, speeds[0], speeds[1], lateral_mps=speeds[2])
            self._receivers.deliver("ground_truth", truth)
        if self._due("scene_truth"):
            self._receivers.deliver("scene_truth", SceneTruth(now, self.scenario_state.people, ()))
        self._sweep(now)
        if self._due("status"):
            self._receivers.deliver("status", self._status(now))

    def _sweep(self, now: float) -> None:
        """Give a scan, if one is due; it ends all periods of the laser since the last."""
        laser, config, wanted_hz = self._laser, self._laser_config, self._receivers.rates.get("hokuyo", 0.0)
        if laser is None or config is None or not wanted_hz:
            return
        every = max(1, round(self._rate_hz / min(wanted_hz, config.rate_hz, self._rate_hz)))
        if self._steps % every == 0:
            scan = laser.scan(now, self.base.pose, discs=legs(self.scenario_state.actors))
            self._receivers.deliver("hokuyo", scan, max(1, round(every * config.nominal_hz / self._rate_hz)))

    def _due(self, stream: str) -> bool:
        wanted = stream in ALWAYS_ON or stream in self._receivers.wanted
        return wanted and self._steps % self._every[stream] == 0

    def _status(self, now: float) -> LinkStatus:
        base, applied = self.base, self.base.state.applied
        return LinkStatus(
            stamp=now,
            guard=base.action.mode.value,
            reason=base.action.reason,
            e_stopped=base.state.e_stop is not None,
            command_age_s=command_age(base.state, now),
            applied=Twist(now, applied.linear_mps, applied.angular_radps, applied.lateral_mps),
            world_rate=1.0,
            groups=self._joints.status(now),
        )


def describe(config: KinematicConfig) -> RobotDescription:
    """The description of the body that ``config`` configures."""
    odometry_hz, joints_hz, status_hz = config.standing_rates_hz
    table: dict[str, tuple[type[Any], float]] = {
        "odometry": (Odometry, odometry_hz),
        "joints": (JointState, joints_hz),
        "status": (LinkStatus, status_hz),
        "ground_truth": (GroundTruth, odometry_hz),
        "scene_truth": (SceneTruth, status_hz),
    }
    if config.laser is not None:
        table["hokuyo"] = (LaserScan, config.laser.nominal_hz)
    return RobotDescription(
        config.name,
        config.model,
        config.limits.base(),
        {
            name: StreamDescription(name, kind, rate_hz, thins=kind is LaserScan)
            for name, (kind, rate_hz) in table.items()
        },
        simulated=True,
        loudspeaker=True,
        footprint=config.footprint,
        height_m=config.height_m,
        groups=dict(config.groups),
        arms=dict(config.arm_descriptions),
    )
