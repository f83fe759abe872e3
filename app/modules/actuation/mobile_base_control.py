"""MobileBaseControl: which behavior drives the base, within its limits and those of its surroundings (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ MobileBaseControl  in   one per behavior  Twist (m/s, rad/s in base_link); never filtered│
    │                    in   scans             LaserScan, each one; never filtered            │
    │                    in   odometry          Odometry; never filtered                       │
    │                    in   joints            JointState: where the arms are; never filtered │
    │                    in   operator          TeleopCommand: the override; never filtered    │
    │                    in   dock              DockSighting while docking; or none            │
    │                    out  exploitation      Exploitation, 10 Hz and when the driver changes│
    │                    out  status            LinkStatus, 20 Hz, as the guard reports        │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

At 10 Hz, with each command and with each scan that arrives: the highest priority among the behaviors with a fresh
command drives; its twist is clamped to the body's speeds, limited by the collision monitor, and approached with the
body's accelerations, then given to the robot link. Without a fresh command, zero is sent a few times, then nothing.
``exploitation`` reports whose command was let through, for attention, and why it was limited, for people.

On a body with a laser the collision monitor (``collision_monitor.py``) limits every command, of an operator or a
behavior: without a fresh scan the base stands still. Its outline includes what joints stretch out over the floor;
while they are not known it is the widest that they can make. Only the operator can override the monitor, at a crawl,
while both dead-man and override are held. The behavior ``docking`` may, at a crawl, come near the dock that it sees
(``dock``): its outline alone does not limit it. A program that does not wire the scans of such a body is refused,
unless its configuration says ``collision_monitor: off``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from types import MappingProxyType
from typing import Literal, TypeVar

from pydantic import Field, field_validator

from app.base.errors import ConfigError
from app.base.moving_shapes import BodyOutline
from app.link import BaseLimits, RobotDescription, RobotLink
from app.messages import (
    DockSighting,
    Exploitation,
    JointState,
    LaserScan,
    LinkStatus,
    Message,
    Odometry,
    TeleopCommand,
    Twist,
)
from app.modules.actuation.arbitration import Contender, approach, clamped, twist_is_finite
from app.modules.actuation.collision_context import CollisionContext
from app.modules.actuation.collision_monitor import CollisionMonitor, MonitorRules
from app.modules.actuation.group_arbiter import ArbiterSettings, GroupArbiter
from app.modules.body_shapes import moving_shapes
from app.modules.stream_module import attach, robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, Input, ModuleContext

M = TypeVar("M", bound=Message)

#: Zero commands sent after the last command, in case one is lost on the way to the motors.
PARTING_ZEROS = 3


class MobileBaseControlSettings(ArbiterSettings):
    """Settings of MobileBaseControl."""

    own_inputs = frozenset({"scans", "odometry", "joints", "operator", "dock"})

    behaviors: tuple[Contender, ...] = (Contender(input="teleop", behavior="Teleop", priority=1),)
    by_hand: str = Field("Teleop", description="the behavior that the operator drives by, who alone may override")
    docking: str = Field("Docking", description="the behavior that drives into a dock, whose outline alone it may near")
    collision_monitor: Literal["on", "off"] = Field("on", description="off: nothing keeps it from hitting things")
    monitor: MonitorRules = Field(MonitorRules(), description="the collision monitor, for bodies with a laser")

    @field_validator("behaviors")
    @classmethod
    def _are_desired(cls, behaviors: tuple[Contender, ...]) -> tuple[Contender, ...]:
        for contender in behaviors:
            if contender.unattended:
                raise ValueError(f"{contender.behavior} cannot be unattended: nothing drives the base without a desire")
        return behaviors


class MobileBaseControl(GroupArbiter[Twist]):
    title = "Mobile base control"
    streams = MappingProxyType({"status": "status"})
    Settings = MobileBaseControlSettings
    settings: MobileBaseControlSettings

    _link: RobotLink

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context, Twist)
        self.status = self.output("status", LinkStatus)
        self._scans = self.input("scans", LaserScan, always_open=True)
        self.on(self._scans, self._take_scan)
        # Read when a command is limited, not on arrival.
        self._odometry = self.input("odometry", Odometry, capacity=128, always_open=True)
        self._operator = self.input("operator", TeleopCommand, capacity=8, always_open=True)
        self._joints = self.input("joints", JointState, capacity=2, always_open=True)
        self._dock = self.input("dock", DockSighting, always_open=True)
        self._collision_context: CollisionContext | None = None
        self._sent = Twist(0.0, 0.0, 0.0)
        self._zeros_left = PARTING_ZEROS
        self._release: Callable[[], None] | None = None

    def check_wiring(self) -> None:
        """Raises ModuleFailed where the body has a laser and its scans are not wired, unless configuration says so."""
        body = robot_link(self).description
        if self.settings.collision_monitor == "on" and _has_laser(body) and not self._scans.connected:
            raise ModuleFailed(
                f"{self.name} has no input scans, and {body.name} has a laser: without its scans there is no collision "
                "monitor; wire them (scans: the laser's channel), or say `collision_monitor: off` in its settings"
            )

    def cautions(self) -> tuple[Caution, ...]:
        """A warning where no collision monitor runs."""
        if why := self._unmonitored():
            return (Caution("No collision monitor", why),)
        body = robot_link(self).description
        if body.groups and not self._joints.connected:
            why = f"{self.name} has no input joints: what {body.name} stretches out beyond its footprint may hit things"
            return (Caution("Joints are not watched", why),)
        return ()

    async def start(self) -> None:
        """Look up the body. Raises ModuleFailed for a body without status, with an invalid footprint, or with joints
        whose shapes cannot be read."""
        self._release = attach(self, "status", LinkStatus, self.status.publish)
        self._link = robot_link(self)
        self._collision_context = await self._start_collision_context()

    async def stop(self) -> None:
        if self._release is not None:
            self._release()
            self._link.command(Twist(self.clock.now(), 0.0, 0.0))

    def _unmonitored(self) -> str:
        """The reason why no collision monitor limits commands, as a sentence; "" where one does."""
        body = robot_link(self).description
        if not _has_laser(body):
            why = "has no laser"
        elif self.settings.collision_monitor == "off":
            why = "runs with its collision monitor switched off (collision_monitor: off)"
        elif not body.footprint:
            why = "has no footprint"
        else:
            return ""
        return f"{body.name} {why}: nothing keeps it from driving into things"

    async def _start_collision_context(self) -> CollisionContext | None:
        if self._unmonitored():
            return None
        body = self._link.description
        outline: BodyOutline | None = None
        try:
            monitor = CollisionMonitor(body.footprint, body.limits, self.settings.monitor)
            if body.groups and self._joints.connected:
                outline = BodyOutline(body.footprint, await self.compute(moving_shapes, body))
        except ValueError as problem:
            raise ModuleFailed(f"{body.name}: {problem}") from None
        except ConfigError as problem:
            raise ModuleFailed(f"the outline of {body.name} is not known: {problem}") from None
        return CollisionContext(monitor, body.limits, self.settings.max_age_s, outline)

    def _take_scan(self, scan: LaserScan) -> None:
        if self._collision_context is None:
            return
        self._collision_context.scanned(scan)
        if self.driver is not None:
            # An obstacle in this scan must not wait for the next period.
            self.arbitrate()

    def _gather(self) -> None:
        collision_context = self._collision_context
        for odometry in _waiting(self._odometry):
            if collision_context is not None:
                collision_context.moved(odometry)
        for joints in _waiting(self._joints):
            if collision_context is not None:
                collision_context.posed(joints)
        for drive in _waiting(self._operator):
            if collision_context is not None:
                collision_context.commanded(drive)
        for dock in _waiting(self._dock):
            if collision_context is not None:
                collision_context.sighted(dock)

    def usable(self, command: Twist) -> bool:
        """Whether its speeds are finite."""
        return twist_is_finite(command)

    def give(self, now: float, choice: tuple[str, Twist] | None) -> None:
        """Give the link the winner's twist within all limits; a few zeros without any, then nothing."""
        self._gather()
        limits = self._link.description.limits
        self.limited = ""
        if choice is None:
            # The stamp stays that of the last command: the first command after a pause then accelerates for one period.
            self._sent = Twist(self._sent.stamp, 0.0, 0.0)
            if self._zeros_left == 0:
                return
            self._zeros_left -= 1
        else:
            driver, wanted = choice
            target = clamped(replace(wanted, stamp=now), limits)
            self._sent, self.limited = self._within_sight(driver, target, limits)
            self._zeros_left = PARTING_ZEROS
        self._link.command(replace(self._sent, stamp=now))

    def report(self, now: float) -> Exploitation:
        """Whose twist was let through, and how it was limited."""
        return Exploitation(now, self.driver, replace(self._sent, stamp=now), self.limited)

    def _within_sight(self, driver: str, target: Twist, limits: BaseLimits) -> tuple[Twist, str]:
        if self._collision_context is None:
            return approach(self._sent, target, limits, self.settings.period_s), ""
        by_hand, docking = driver == self.settings.by_hand, driver == self.settings.docking
        return self._collision_context.limit(
            self._sent, target, self.settings.period_s, by_hand=by_hand, docking=docking
        )


def _has_laser(body: RobotDescription) -> bool:
    return any(stream.message_type is LaserScan for stream in body.streams.values())


def _waiting(port: Input[M]) -> Iterator[M]:
    """Messages that wait at ``port``, oldest first; none for a port that is not wired."""
    while port.connected and port.subscription.waiting:
        yield port.subscription.receive_nowait()
