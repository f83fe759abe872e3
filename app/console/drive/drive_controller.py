"""Carries out what the lease decides: publishes drive commands, latches the emergency stop, notifies the pages."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Literal

from app.console.access.identity import LOCAL, Identity
from app.console.access.roles import Role
from app.console.drive import drive_lease
from app.console.drive.command_age import Judgement
from app.console.drive.look_here import LookHere
from app.link import RobotLink
from app.messages import LinkStatus, TeleopCommand
from app.runtime.channel import Channel
from app.runtime.clock import Clock
from app.runtime.graph import Graph

CHANNEL = "teleop_command"
UNDRIVABLE = f"This program drives nothing: no module takes {CHANNEL}."
LOST = "The body does not answer"
PRESSED_AGAIN = "The emergency stop was pressed after what you saw: look again, then release it."
NOT_YOURS = "Another pressed the emergency stop: they release it, or a supervisor does."
RECORDING = "This is a recording: there is no robot to drive or to stop."

_WANTS = drive_lease.TakeControl | drive_lease.AskControl

Notify = Callable[[str, Literal["info", "warning", "error"], str], None]


def teleop_channel(graph: Graph) -> Channel[TeleopCommand] | None:
    """Where the driver's commands go; None: this program drives nothing, since no module asks for them by name (a
    recorder takes whatever there is)."""
    taken = any(CHANNEL in slot.spec.inputs.values() for slot in graph.modules.values())
    return graph.channels.get(CHANNEL) if taken else None


class Driving:
    """The lease at work. ``notify(session, level, text)`` sends a notice to one page. ``stopped()`` is called when the
    emergency stop is latched, by any source, and again when it is released: a released robot must not set out for an
    older goal, nor for one of the meantime.

    ``channel`` takes the driver's commands; None: this program drives nothing, and every page is refused the wheel, as
    in a ``recording``. ``look_here`` turns the head to where the picture is clicked, until the head is held by hand.
    """

    def __init__(
        self,
        clock: Clock,
        link: RobotLink,
        channel: Channel[TeleopCommand] | None,
        notify: Notify,
        stopped: Callable[[], None],
        *,
        recording: bool = False,
        look_here: LookHere | None = None,
    ) -> None:
        self._clock = clock
        self._link = link
        self._channel = None if recording else channel
        self._notify = notify
        self._stopped = stopped
        self.recording = recording
        self._look_here = look_here
        #: Who drives, and until when.
        self.lease = drive_lease.Lease()
        self._sequence = 0
        self._timer: asyncio.TimerHandle | None = None
        self._refused: set[str] = set()
        self._lost = False
        #: When the emergency stop was pressed last, or found latched (s, robot's clock).
        self._stopped_at = -math.inf
        #: Logins that pressed the emergency stop since it was released last; "": it was found latched.
        self._pressed_by: set[str] = set()

    @property
    def drivable(self) -> bool:
        return self._channel is not None

    def handle(self, event: drive_lease.Event) -> None:
        if self._channel is None and isinstance(event, drive_lease.Drive | _WANTS):
            self._refuse(event.session)
            return
        if self._lost and isinstance(event, drive_lease.Drive) and event.holds:
            event = replace(event, cause=LOST, lasting=True)
        now = self._clock.now()
        self.lease, actions = drive_lease.step(self.lease, now, event)
        for action in actions:
            match action:
                case drive_lease.Command() if self._channel is not None:
                    self._sequence += 1
                    if action.head_held and self._look_here is not None:
                        self._look_here.withdraw()
                    self._channel.publish(
                        TeleopCommand(
                            now,
                            action.operator,
                            sequence=self._sequence,
                            held=action.held,
                            linear=action.linear,
                            angular=action.angular,
                            override=action.override,
                            lateral=action.lateral,
                            head_held=action.head_held,
                            pan=action.pan,
                            tilt=action.tilt,
                        )
                    )
                case drive_lease.PageNotice(session, level, text):
                    self._notify(session, level, text)
        self._set_timer(now)

    def e_stop(self, who: str, session: str | None = None, by: Identity = LOCAL) -> None:
        """Latch the emergency stop, by the link's own path and before anything else."""
        if self._is_in_vain(session):
            return
        self._pressed_by.add(by.key)
        self._stopped_at = self._clock.now()
        self._link.e_stop(f"pressed by {who}")
        self.handle(drive_lease.EmergencyStop(True))
        self._stopped()

    def clear_e_stop(self, seen: float, session: str | None = None) -> bool:
        """Release the latch; nothing moves before a fresh command.

        ``seen`` is the newest stamp of the robot (s) known to the person who releases it: a stop that was pressed later
        is not released, since that person has not seen it. Returns whether it was released.
        """
        if self._is_in_vain(session) or seen <= self._stopped_at:
            return False
        self._stopped()
        self._link.clear_e_stop()
        self._pressed_by.clear()
        return True

    def may_release(self, by: Identity) -> bool:
        """Whether this login may release the emergency stop: a supervisor's, or the only one that pressed it."""
        return by.role is Role.SUPERVISOR or (by.role is Role.OPERATOR and self._pressed_by <= {by.key})

    def release_e_stop(self, session: str, judged: Judgement, seen: float | None, by: Identity = LOCAL) -> None:
        """A page asks for the release of the latch; if late, or if it knows of no stop so new, it gets the reason."""
        if self._is_in_vain(session):
            return
        if not self.may_release(by):
            self._notify(session, "warning", NOT_YOURS)
        elif judged.cause or seen is None:
            self._notify(session, "warning", f"{judged.cause}: the emergency stop stays latched.")
        elif not self.clear_e_stop(seen, session):
            self._notify(session, "warning", PRESSED_AGAIN)

    def take_control(self, session: str, judged: Judgement) -> None:
        """A supervisor's page takes the wheel; one whose commands come late could only keep it from others."""
        self._want_control(drive_lease.TakeControl(session), judged)

    def ask_control(self, session: str, judged: Judgement) -> None:
        """A page asks for the wheel, likewise."""
        self._want_control(drive_lease.AskControl(session), judged)

    def _want_control(self, event: drive_lease.TakeControl | drive_lease.AskControl, judged: Judgement) -> None:
        if self._channel is not None and judged.cause:
            self._notify(event.session, "warning", f"{judged.cause}: the wheel stays where it is.")
        else:
            self.handle(event)

    def look(self, session: str, judged: Judgement, *, stamp: float, u: float, v: float) -> None:
        """A page asks to look at ``u``, ``v`` (shares of its width and height) of the picture taken at ``stamp``.

        The head goes with the wheel: who does not drive while another does is refused.
        """
        if self._channel is None:
            self._refuse(session)
            return
        driver = self.lease.driver
        if self._look_here is None:
            problem = "This robot has no head to turn."
        elif judged.cause:
            problem = f"{judged.cause}: the head stays."
        elif driver not in (None, session):
            problem = f"{self.lease.driver_name} drives; ask for the wheel first to turn the head."
        elif self.lease.e_stopped:
            problem = "The emergency stop is latched: clear it, then click again to look there."
        elif not (0 <= u <= 1 and 0 <= v <= 1):
            problem = f"A place in the picture is from 0 to 1, not {u:g} and {v:g}."
        else:
            problem = self._look_here.look(self.lease.operators[session], stamp, u, v)
        if problem:
            self._notify(session, "warning", problem)

    def on_guard_status(self, status: LinkStatus) -> None:
        """Take over the state of the guard's latch."""
        if not status.e_stopped:
            self._pressed_by.discard("")
        elif not self._pressed_by:
            self._pressed_by.add("")
        if status.e_stopped != self.lease.e_stopped:
            if status.e_stopped:
                self._stopped_at = self._clock.now()
            self.handle(drive_lease.EmergencyStop(status.e_stopped))
            if not self.recording:
                self._stopped()

    def body(self, lost: bool) -> None:
        """The body does not answer any more, or does again: the driver must press again, and no goal is left."""
        self._lost = lost
        driver = self.lease.driver
        if lost and driver is not None and self.lease.moving:
            self.handle(drive_lease.Drive(driver, self.lease.sequence + 1, True, 0.0, 0.0))
        self._stopped()

    def close(self) -> None:
        """Stop the driver, if there is one, and cancel the timer."""
        if self.lease.driver is not None:
            self.handle(drive_lease.ReleaseControl(self.lease.driver))
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _refuse(self, session: str) -> None:
        if session not in self._refused:
            self._refused.add(session)
            self._notify(session, "warning", RECORDING if self.recording else UNDRIVABLE)

    def _is_in_vain(self, session: str | None) -> bool:
        if self.recording and session is not None:
            self._refuse(session)
        return self.recording

    def _set_timer(self, now: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        due = drive_lease.deadline(self.lease)
        if due < math.inf:
            self._timer = asyncio.get_running_loop().call_later(max(0.0, due - now), self._tick)

    def _tick(self) -> None:
        self._timer = None
        self.handle(drive_lease.Tick())
