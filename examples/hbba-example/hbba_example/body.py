"""A post whose laser sees one thing that circles round it, and whose lantern turns.

The lantern is the body's one actuator group. Its set-points go through the guard of the joints
(``app.robots.joint_guard``) as those of every body; this one is simulated, and its guard runs with its streams. A body
with motors runs it in a process of its own.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from app.base.geometry import Pose2, Pose3
from app.base.kinematic_model import load_model
from app.link import LinkFailed, RobotDescription, StreamDescription
from app.messages import Audio, JointCommand, JointState, LaserScan, LinkStatus, Odometry, Twist, read_only
from app.robots import joint_guard
from app.robots.actuator_config import LimitsConfig
from app.robots.config import BodyConfig, load_body_config
from app.robots.factory import BodyKind, standing_streams
from app.robots.receivers import Receivers

SCANS_HZ = 10.0
RAYS = 36
#: Rate of the joints' guard and of the stream ``joints``.
JOINTS_HZ = 20.0
#: Half the angle that the thing covers.
THING_RAD = math.radians(12)


class PostConfig(BodyConfig):
    """What the file of such a body says."""

    kind: Literal["example"]
    thing_m: Annotated[float, Field(gt=0.1, le=10, description="how far away the thing is")] = 1.0
    period_s: Annotated[float, Field(gt=0, description="how long the thing takes for a round")] = 20.0
    #: No wheels; limits are positive by contract.
    limits: LimitsConfig = LimitsConfig(linear_mps=1e-3, angular_radps=1e-3, linear_mps2=1e-3, angular_radps2=1e-3)

    @property
    def standing_rates_hz(self) -> tuple[float, float, float]:
        """How often the streams that every body has come: odometry, joints, status."""
        return 20.0, JOINTS_HZ, 20.0


class PostLink:
    """Implements ``app.link.RobotLink``; ``now`` is the robot's clock."""

    def __init__(self, config: PostConfig, now: Callable[[], float]) -> None:
        self._config = config
        self._now = now
        self._X_BL = load_model(config.model).pose("laser_link")
        streams = {**standing_streams(config), "hokuyo": StreamDescription("hokuyo", LaserScan, SCANS_HZ)}
        self._groups = dict(config.groups)
        self._description = RobotDescription(
            config.name, config.model, config.limits.base(), streams, simulated=True, groups=self._groups
        )
        self._setpoints = {
            name: joint_guard.at_rest(group, (0.0,) * len(group.joints)) for name, group in self._groups.items()
        }
        self._receivers = Receivers(self._description)
        self._tasks: list[asyncio.Task[None]] = []
        self._e_stop: str | None = None

    @property
    def description(self) -> RobotDescription:
        """What this body is."""
        return self._description

    async def start(self) -> None:
        """Let the streams run."""
        senses: dict[str, Callable[[], Any]] = {
            "odometry": lambda: Odometry(self._now(), Pose2(), 0.0, 0.0),
            "joints": self._turn,
            "status": self._status,
            "hokuyo": lambda: scan(self._now(), self._config, self._X_BL),
        }
        for stream, sense in senses.items():
            self._tasks.append(asyncio.create_task(self._run(stream, sense), name=f"post {stream}"))

    async def stop(self) -> None:
        """End the streams; idempotent."""
        tasks, self._tasks = self._tasks, []
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)

    async def wait_failed(self) -> LinkFailed:
        """It never fails."""
        await asyncio.Event().wait()
        raise AssertionError

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        """Call ``receive(message)`` for each message of ``stream``; returns the detacher."""
        return self._receivers.attach(stream, receive)

    def demand(self, stream: str, rate_hz: float) -> None:
        """A scan that is not wanted is not made."""
        self._receivers.demand(stream, rate_hz)

    def periods(self, stream: str) -> int:
        """How many periods of ``stream`` the message being delivered ends."""
        return self._receivers.periods(stream)

    def command(self, command: Twist | JointCommand) -> None:
        """Give a group of joints its set-points; there are no wheels."""
        if isinstance(command, JointCommand) and command.group in self._groups:
            state, group = self._setpoints[command.group], self._groups[command.group]
            self._setpoints[command.group] = joint_guard.accept(state, group, command)

    def play(self, audio: Audio) -> None:
        """There is no loudspeaker."""

    def e_stop(self, reason: str) -> None:
        """Latch the emergency stop: the lantern brakes and holds."""
        self._e_stop = self._e_stop or reason

    def clear_e_stop(self) -> None:
        """Release the latch; the lantern waits for the next command."""
        self._e_stop = None
        for name, group in self._groups.items():
            self._setpoints[name] = joint_guard.clear_e_stop(self._setpoints[name], group)

    async def _run(self, stream: str, sense: Callable[[], Any]) -> None:
        period_s = 1 / self._description.streams[stream].rate_hz
        while True:
            if stream != "hokuyo" or stream in self._receivers.wanted:
                self._receivers.deliver(stream, sense())
            await asyncio.sleep(period_s)

    def _decided(self, name: str, now: float) -> joint_guard.JointAction:
        return joint_guard.decide(now, self._setpoints[name], self._groups[name], self._e_stop)

    def _turn(self) -> JointState:
        """The joints one period later."""
        now = self._now()
        names: list[str] = []
        positions: list[float] = []
        for name, group in self._groups.items():
            before = self._setpoints[name]
            measured = tuple(setpoint.position for setpoint in before.setpoints)
            after = joint_guard.step(before, self._decided(name, now), group, measured, 1 / JOINTS_HZ)
            self._setpoints[name] = after
            names += [joint.name for joint in group.joints]
            positions += [setpoint.position for setpoint in after.setpoints]
        return JointState(now, tuple(names), tuple(positions))

    def _status(self) -> LinkStatus:
        now, stopped = self._now(), self._e_stop is not None
        guard = "e_stopped" if stopped else "idle"
        reason = self._e_stop or "This body has no wheels."
        groups = tuple(
            joint_guard.status(now, self._setpoints[name], group, self._decided(name, now))
            for name, group in self._groups.items()
        )
        return LinkStatus(now, guard, reason, stopped, None, Twist(now, 0.0, 0.0), 1.0, groups)


def scan(stamp: float, config: PostConfig, X_BL: Pose3) -> LaserScan:
    """What the laser sees at ``stamp`` (s)."""
    angles = np.linspace(-math.pi, math.pi, RAYS, endpoint=False)
    toward = 2 * math.pi * (stamp % config.period_s) / config.period_s
    off = np.abs((angles - toward + math.pi) % (2 * math.pi) - math.pi)
    ranges = np.where(off < THING_RAD, config.thing_m, np.inf).astype(np.float32)
    return LaserScan(
        stamp, "laser_link", read_only(ranges), read_only(np.ones_like(ranges)), -math.pi, 2 * math.pi / RAYS,
        0.1, 10.0, 0.0, X_BL,
    )  # fmt: skip


#: What the entry point names.
EXAMPLE = BodyKind(
    lambda path: load_body_config(path, PostConfig),
    lambda config, clock_offset: PostLink(config, lambda: clock_offset + time.monotonic()),
)
