"""A body without physics for the tests of modules, and graphs of one module under test."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import cv2  # noqa: F401  # the graph imports modules on the loop, where importing OpenCV for the first time would block

from app.link import (
    ActuatorGroup,
    BaseLimits,
    JointLimits,
    LinkFailed,
    RobotDescription,
    RobotLink,
    StreamDescription,
)
from app.messages import Audio, Image, Imu, JointCommand, JointState, LaserScan, LinkStatus, Odometry, Twist
from app.modules.behaviors.face.expression import JOINTS as FACE_JOINTS
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.subscription import Subscription
from app.runtime.supervisor import Supervisor

LIMITS = BaseLimits(0.40, 1.00, 0.40, 4.00)
HEAD = ActuatorGroup("head", (JointLimits("pan", -2, 2, 1, 5), JointLimits("tilt", -0.3, 0.4, 1, 5)))
FACE = ActuatorGroup("face", tuple(JointLimits(name, -0.5, 1.2, 10, 100) for name in FACE_JOINTS))
STREAMS = {
    name: StreamDescription(name, message_type, rate_hz)
    for name, message_type, rate_hz in (
        ("kinect", Image, 15.0),
        ("hokuyo", LaserScan, 40.0),
        ("imu", Imu, 50.0),
        ("odometry", Odometry, 100.0),
        ("joints", JointState, 30.0),
        ("status", LinkStatus, 20.0),
    )
}


class FakeLink:
    """A RobotLink whose streams the test feeds with ``emit`` and whose commands it reads from ``commands``."""

    def __init__(self, without: tuple[str, ...] = ()) -> None:
        streams = {name: stream for name, stream in STREAMS.items() if name not in without}
        self.description = RobotDescription(
            "a test body", Path("none.urdf"), LIMITS, streams, simulated=True, groups={"head": HEAD, "face": FACE}
        )
        self.receivers: dict[str, list[Callable[[Any], None]]] = {name: [] for name in streams}
        self.demands: dict[str, list[float]] = {}
        #: How many periods each message ends, by stream; 1 unless set.
        self.ended: dict[str, int] = {}
        #: (time of arrival, twist) of every command.
        self.commands: list[tuple[float, Twist]] = []
        self.joint_commands: list[JointCommand] = []
        self.now: Callable[[], float] = lambda: 0.0

    async def start(self) -> None: ...

    async def stop(self) -> None: ...

    async def wait_failed(self) -> LinkFailed:
        raise AssertionError("a fake body does not fail")

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        self.receivers[stream].append(receive)
        return lambda: self.receivers[stream].remove(receive)

    def demand(self, stream: str, rate_hz: float) -> None:
        self.demands.setdefault(stream, []).append(rate_hz)

    def periods(self, stream: str) -> int:
        return self.ended.get(stream, 1)

    def command(self, command: Twist | JointCommand) -> None:
        if isinstance(command, JointCommand):
            self.joint_commands.append(command)
        else:
            self.commands.append((self.now(), command))

    def play(self, audio: Audio) -> None: ...

    def e_stop(self, reason: str) -> None: ...

    def clear_e_stop(self) -> None: ...

    def emit(self, stream: str, message: Any) -> None:
        """What the body's stream gives now."""
        for receive in list(self.receivers[stream]):
            receive(message)


class Bench:
    """One module in a graph of its own: ``async with Bench(...) as bench`` runs it under a supervisor.

    Each port is wired to a channel of its own name. ``bench.feed(port, message)`` publishes on an input,
    ``bench.listen(port)`` subscribes to an output.
    """

    def __init__(
        self,
        module: str,
        *,
        inputs: Mapping[str, type[Any]] | None = None,
        outputs: Mapping[str, type[Any]] | None = None,
        settings: Mapping[str, Any] | None = None,
        link: FakeLink | None = None,
        services: Mapping[type[Any], Any] | None = None,
        attended: tuple[str, ...] = (),
    ) -> None:
        inputs, outputs = inputs or {}, outputs or {}
        self.clock = VirtualClock()
        self.link = link or FakeLink()
        self.link.now = self.clock.now
        channels = {
            name: {"type": kind.__name__, "external": name in inputs} for name, kind in {**inputs, **outputs}.items()
        }
        spec = {
            "class": module,
            "inputs": {name: name for name in inputs},
            "outputs": {name: name for name in outputs},
            "settings": dict(settings or {}),
        }
        self.graph = Graph(
            clock=self.clock,
            channels={name: ChannelSpec.model_validate(channel) for name, channel in channels.items()},
            modules={"Tested": ModuleSpec.model_validate(spec)},
            services={RobotLink: self.link, **(services or {})},
            attended=[f"Tested.{port}" for port in attended],
        )
        self.slot = self.graph.modules["Tested"]
        self.supervisor = Supervisor(self.graph.modules, self.clock)

    async def __aenter__(self) -> Bench:
        await self.supervisor.__aenter__()
        await self.settle()
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.supervisor.__aexit__(*error)

    async def settle(self) -> None:
        """Let everything that can happen now happen: the virtual clock moves on by 1 ms once all tasks wait."""
        await self.clock.sleep(0.001)

    def feed(self, port: str, message: Any) -> None:
        self.graph.channel(port).publish(message)

    def listen(self, port: str, capacity: int = 1000) -> Subscription[Any]:
        return self.graph.channel(port).subscribe(f"test.{port}", capacity=capacity)

    @property
    def problem(self) -> str:
        """Why the module last failed, in words."""
        return self.supervisor.states["Tested"].problem


def drain(subscription: Subscription[Any]) -> list[Any]:
    """All messages that wait."""
    return [subscription.receive_nowait() for _ in range(subscription.statistics().depth)]
