"""The two ends of the console's stream on a link with delay: what the robot shows, and what the operator commands.

    robot ─▶ Shown, 20 a second ─▶ link ─▶ operator ─▶ Hands, 20 a second ─▶ link ─▶ command's age ─▶ lease ─▶ Teleop

The link is that of ``hbba run --link``, the way of a command that of a page's: it has the same limits when it is late.
"""

from __future__ import annotations

import asyncio
import random
from collections.abc import Callable
from dataclasses import dataclass, replace

from app.base.geometry import Pose2
from app.base.motion_prediction import Velocity
from app.base.network_link import Direction, LinkSettings, Stream
from app.console.drive import drive_lease
from app.console.drive.command_age import CommandAge, Times
from app.console.drive.drive_controller import Driving, teleop_channel
from app.messages import LaserScan
from app.program.system import System

SESSION, OPERATOR = "pursuit", "scripted operator"
#: Bytes of a report with its picture, and of a command, as the page's are.
SHOWN_BYTES, COMMAND_BYTES = 30_000, 250
#: Weight of a new round trip in the smoothed one.
_SMOOTHING = 0.2


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What the page shows of the instant ``stamp`` (s): the robot's pose ``X_WB`` and velocity, its head's ``pan``
    (rad), the laser's last ``scan``, and the ``person``, x and y (m) in the world, None while unseen.

    ``echo``: when the newest command had been sent that had come by then, and ``echo_age_s`` since it came.
    """

    stamp: float
    X_WB: Pose2
    velocity: Velocity
    pan: float
    scan: LaserScan | None
    person: tuple[float, float] | None
    echo: float | None = None
    echo_age_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Hands:
    """What the operator holds: ``linear``, ``angular`` of the base, if it is ``held``, and ``pan`` of the head, if that
    is, -1 to 1, left positive."""

    held: bool = False
    linear: float = 0.0
    angular: float = 0.0
    head_held: bool = False
    pan: float = 0.0


class RemoteConsole:
    """One operator's connection; times are the robot's clock, which the page knows. For the loop of a run."""

    def __init__(self, system: System, settings: LinkSettings, seed: int) -> None:
        channel = teleop_channel(system.graph)
        assert channel is not None, "the plan has checked that the program drives"
        console = system.config.program.console
        self._clock = system.clock
        self._settings = settings
        draw = random.Random(seed)
        self._up, self._down = Direction(draw), Direction(draw)
        self._up_stream, self._down_stream = Stream(), Stream()
        self._age = CommandAge(console.command_validity_s, console.full_speed_within_s)
        self._driving = Driving(system.clock, system.link, channel, self._notice, lambda: None)
        self._driving.handle(drive_lease.Connected(SESSION, OPERATOR))
        self._sequence = 0
        self._echo: tuple[float, float] | None = None
        self._heard: tuple[float, float] | None = None
        self._timers: set[asyncio.TimerHandle] = set()
        #: What the operator sees, None before the first report; the round trip (s) as the page measures it.
        self.shown: Shown | None = None
        self.round_trip_s = 0.0
        #: Shares of the speed that the commands were allowed, 0 for those that came too late.
        self.shares: list[float] = []
        self.notices: list[str] = []

    # The robot's end

    def show(self, shown: Shown) -> None:
        """Send the operator what is to be seen now."""
        if self._echo is not None:
            sent, came = self._echo
            shown = replace(shown, echo=sent, echo_age_s=shown.stamp - came)
        seen = shown
        passage = self._down.send(self._settings, self._down_stream, self._clock.now(), SHOWN_BYTES)
        self._at(passage.arrives, lambda: self._see(seen))

    def _take(self, hands: Hands, times: Times, sequence: int) -> None:
        now = self._clock.now()
        self._echo = times.sent, now
        judged = self._age.judge(now, times)
        self.shares.append(0.0 if judged.cause else judged.share)
        self._driving.handle(
            drive_lease.Drive(
                SESSION,
                sequence,
                held=hands.held,
                linear=judged.share * hands.linear,
                angular=judged.share * hands.angular,
                head_held=hands.head_held,
                pan=hands.pan,
                cause=judged.cause,
                lasting=judged.lasting,
            )
        )

    def _notice(self, session: str, level: str, text: str) -> None:
        self.notices.append(text)

    # The operator's end

    def _see(self, shown: Shown) -> None:
        now = self._clock.now()
        self.shown, self._heard = shown, (shown.stamp, now)
        if shown.echo is not None:
            measured = now - shown.echo - shown.echo_age_s
            self.round_trip_s += (_SMOOTHING if self.round_trip_s else 1.0) * (measured - self.round_trip_s)

    def command(self, hands: Hands) -> None:
        """Send what the operator holds now; nothing before something was seen."""
        if self._heard is None:
            return
        now = self._clock.now()
        self._sequence += 1
        times, sequence = Times(now, *self._heard), self._sequence
        passage = self._up.send(self._settings, self._up_stream, now, COMMAND_BYTES)
        self._at(passage.arrives, lambda: self._take(hands, times, sequence))

    def close(self) -> None:
        """End it: nothing more arrives, and the robot is let go."""
        for timer in self._timers:
            timer.cancel()
        self._driving.close()

    def _at(self, when: float, act: Callable[[], None]) -> None:
        def due() -> None:
            self._timers.discard(timer)
            act()

        timer = asyncio.get_running_loop().call_later(max(0.0, when - self._clock.now()), due)
        self._timers.add(timer)
