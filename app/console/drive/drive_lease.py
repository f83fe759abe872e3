"""The wheel: which page drives, and when it must stop. A pure state machine: (lease, now, event) -> (lease, actions).

One driver, many spectators. The first held command while the wheel is free takes it; it is given up after 10 s of
holding nothing, by word, by silence or by a supervisor's taking it, and the robot is always stopped first. Another may
ask for it: the driver gives it or keeps it, and one who does not answer for 5 s keeps it only if anything was held
meanwhile. A wheel that falls free while another asks for it is that other's. A hold that was
refused or ended by the robot's side (another drives, emergency stop) counts for nothing until released once: nothing
moves because a key happens to be down still.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal, TypeAlias

#: A held command that is not renewed for this long counts as released.
HOLD_GAP_S = 0.2
#: A driver who says nothing at all for this long is lost.
LOST_AFTER_S = 1.0
#: A driver who holds nothing for this long gives up the wheel.
IDLE_AFTER_S = 10.0
#: A driver who is asked for the wheel has this long to answer.
ANSWER_WITHIN_S = 5.0


@dataclass(frozen=True, slots=True)
class Connected:
    """A page opened its connection ``session``; ``operator`` is the name of its user."""

    session: str
    operator: str


@dataclass(frozen=True, slots=True)
class Disconnected:
    """The connection ended, however it did."""

    session: str


@dataclass(frozen=True, slots=True)
class KeepAlive:
    """A ping."""

    session: str


@dataclass(frozen=True, slots=True)
class Drive:
    """A drive command: ``linear``, ``angular`` and ``lateral`` should be in [-1, 1]; ``override`` is held too, or not.

    ``head_held`` is the hold of the head, beside that of the base or alone, with ``pan`` and ``tilt`` in [-1, 1].

    ``cause``: why it may move nothing (a clause for people; "": it may), as one that comes too late; ``lasting``: that
    has been so for a while.
    """

    session: str
    sequence: int
    held: bool
    linear: float
    angular: float
    override: bool = False
    cause: str = ""
    lasting: bool = False
    lateral: float = 0.0
    head_held: bool = False
    pan: float = 0.0
    tilt: float = 0.0

    @property
    def holds(self) -> bool:
        """Whether anything is held."""
        return self.held or self.head_held


@dataclass(frozen=True, slots=True)
class Garbled:
    """A command that could not be read; its sender must not keep the robot moving."""

    session: str


@dataclass(frozen=True, slots=True)
class AskControl:
    """A page asks for the wheel, which the driver may give or keep."""

    session: str


@dataclass(frozen=True, slots=True)
class AnswerControl:
    """The driver's answer to who asks for the wheel."""

    session: str
    give: bool


@dataclass(frozen=True, slots=True)
class TakeControl:
    """A supervisor's page takes the wheel, even from another driver."""

    session: str


@dataclass(frozen=True, slots=True)
class ReleaseControl:
    """The driver gives the wheel back."""

    session: str


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """The emergency stop is latched now, or not."""

    latched: bool


@dataclass(frozen=True, slots=True)
class Tick:
    """Time has passed."""


Event: TypeAlias = (
    Connected
    | Disconnected
    | KeepAlive
    | Drive
    | Garbled
    | AskControl
    | AnswerControl
    | TakeControl
    | ReleaseControl
    | EmergencyStop
    | Tick
)


@dataclass(frozen=True, slots=True)
class Command:
    """Publish this on behalf of ``operator``."""

    operator: str
    held: bool
    linear: float
    angular: float
    override: bool = False
    lateral: float = 0.0
    head_held: bool = False
    pan: float = 0.0
    tilt: float = 0.0


@dataclass(frozen=True, slots=True)
class PageNotice:
    """Show ``text`` on one page."""

    session: str
    level: Literal["info", "warning", "error"]
    text: str


Action: TypeAlias = Command | PageNotice


@dataclass(frozen=True, slots=True)
class Lease:
    """Who has the wheel.

    ``operators`` by session; the ``driver``'s session or None; ``moving``: its last command was held; its last
    ``sequence`` number; when it last commanded, was heard and held; ``blocked`` sessions must release before they
    count. ``asker``: the session that asks a driver for the wheel, since ``asked_at``; None: none does.
    """

    operators: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    driver: str | None = None
    moving: bool = False
    sequence: int = 0
    last_drive: float = -math.inf
    last_heard: float = -math.inf
    last_held: float = -math.inf
    blocked: frozenset[str] = frozenset()
    e_stopped: bool = False
    asker: str | None = None
    asked_at: float = -math.inf

    @property
    def driver_name(self) -> str | None:
        """The name of the driver."""
        return None if self.driver is None else self.operators[self.driver]


Step: TypeAlias = tuple[Lease, tuple[Action, ...]]


def step(lease: Lease, now: float, event: Event) -> Step:
    """The lease and the actions that follow from ``event`` at ``now`` (seconds)."""
    match event:
        case Connected(session, operator):
            return replace(lease, operators=MappingProxyType({**lease.operators, session: operator})), ()
        case Disconnected(session):
            return _gone(lease, now, session)
        case KeepAlive(session):
            return (replace(lease, last_heard=now) if session == lease.driver else lease), ()
        case Garbled(session):
            stopped, actions = _stopped(lease) if session == lease.driver else (lease, ())
            return stopped, (*actions, PageNotice(session, "error", "The robot could not read the last message."))
        case Drive():
            return _drive(lease, now, event)
        case AskControl(session):
            return _ask(lease, now, session)
        case AnswerControl(session, give):
            return _answer(lease, now, session, give=give)
        case TakeControl(session):
            return _take(lease, now, session)
        case ReleaseControl(session):
            return _free(lease, now) if session == lease.driver else (lease, ())
        case EmergencyStop(latched):
            return _e_stop(lease, latched)
        case Tick():
            return _tick(lease, now)


def deadline(lease: Lease) -> float:
    """When a Tick is due next (seconds; infinite: never)."""
    if lease.driver is None:
        return math.inf
    due = min(lease.last_heard + LOST_AFTER_S, lease.last_held + IDLE_AFTER_S)
    if lease.asker is not None:
        due = min(due, lease.asked_at + ANSWER_WITHIN_S)
    return min(due, lease.last_drive + HOLD_GAP_S) if lease.moving else due


def _gone(lease: Lease, now: float, session: str) -> Step:
    actions: tuple[Action, ...] = ()
    if session == lease.asker:
        lease = replace(lease, asker=None)
    if session == lease.driver:
        lease, actions = _free(lease, now)
    operators = MappingProxyType({key: name for key, name in lease.operators.items() if key != session})
    return replace(lease, operators=operators, blocked=lease.blocked - {session}), actions


def _stopped(lease: Lease) -> Step:
    if not lease.moving or lease.driver is None:
        return lease, ()
    return replace(lease, moving=False), (Command(lease.operators[lease.driver], False, 0.0, 0.0),)


def _free(lease: Lease, now: float) -> Step:
    """The driver has the wheel no more: who asks for it has it, once the robot is stopped."""
    lease, actions = _stopped(lease)
    lease, asker = replace(lease, driver=None, asker=None), lease.asker
    if asker is None:
        return lease, actions
    handed, notices = _handed(lease, now, asker)
    return handed, (*actions, *notices)


def _handed(lease: Lease, now: float, session: str) -> Step:
    """The wheel, which is free and commands nothing, is ``session``'s."""
    handed = replace(lease, driver=session, sequence=0, last_drive=now, last_heard=now, last_held=now)
    return handed, (PageNotice(session, "info", "You have control."),)


def _ask(lease: Lease, now: float, session: str) -> Step:
    if lease.driver is None:
        return _handed(lease, now, session)
    if session in (lease.driver, lease.asker):
        return lease, ()
    if lease.asker is not None:
        text = f"{lease.operators[lease.asker]} asks for the wheel already: wait for the answer."
        return lease, (PageNotice(session, "warning", text),)
    return replace(lease, asker=session, asked_at=now), ()


def _answer(lease: Lease, now: float, session: str, *, give: bool) -> Step:
    if session != lease.driver or lease.asker is None:
        return lease, ()
    if not give:
        return _kept(lease, f"{lease.driver_name} keeps the wheel.")
    asker = lease.operators[lease.asker]
    lease, actions = _free(lease, now)
    # Still holding, perhaps: that hold is over.
    lease = replace(lease, blocked=lease.blocked | {session})
    return lease, (*actions, PageNotice(session, "info", f"{asker} has control."))


def _kept(lease: Lease, text: str) -> Step:
    assert lease.asker is not None
    return replace(lease, asker=None), (PageNotice(lease.asker, "warning", text),)


def _refused(lease: Lease, session: str, level: Literal["info", "warning", "error"], text: str) -> Step:
    """Refuse a hold, saying why once."""
    if session in lease.blocked:
        return lease, ()
    return replace(lease, blocked=lease.blocked | {session}), (PageNotice(session, level, text),)


def _drive(lease: Lease, now: float, drive: Drive) -> Step:
    session = drive.session
    if not drive.holds:
        lease = replace(lease, blocked=lease.blocked - {session})
        if session != lease.driver:
            return lease, ()
        lease, actions = _stopped(lease)
        return replace(lease, last_drive=now, last_heard=now, sequence=drive.sequence), actions
    axes = (drive.linear, drive.angular, drive.lateral, drive.pan, drive.tilt)
    if not all(_within_range(axis) for axis in axes):
        stopped, actions = _stopped(lease) if session == lease.driver else (lease, ())
        given = [axis for axis in axes if not _within_range(axis)]
        text = f"Drive commands go from -1 to 1, not {' and '.join(f'{axis:g}' for axis in given)}: refused."
        refused, notices = _refused(stopped, session, "error", text)
        return refused, (*actions, *notices)
    if drive.cause:
        return _late(lease, now, drive)
    if lease.e_stopped:
        return _refused(
            lease, session, "warning", "The emergency stop is latched: clear it, then press again to drive."
        )
    if lease.driver not in (None, session):
        text = f"{lease.driver_name} drives; ask for the wheel first, then press again."
        return _refused(lease, session, "warning", text)
    if session in lease.blocked:
        return lease, ()
    if session == lease.driver and lease.moving and drive.sequence <= lease.sequence:
        # A repeated or an older command: the newest counts.
        return lease, ()
    # What is not held is as good as released, whatever it says.
    command = Command(
        lease.operators[session],
        drive.held,
        drive.linear if drive.held else 0.0,
        drive.angular if drive.held else 0.0,
        override=drive.held and drive.override,
        lateral=drive.lateral if drive.held else 0.0,
        head_held=drive.head_held,
        pan=drive.pan if drive.head_held else 0.0,
        tilt=drive.tilt if drive.head_held else 0.0,
    )
    held = replace(
        lease,
        driver=session,
        moving=True,
        sequence=drive.sequence,
        last_drive=now,
        last_heard=now,
        last_held=now,
    )
    return held, (command,)


def _late(lease: Lease, now: float, drive: Drive) -> Step:
    """A hold that may move nothing. One hitch stops the robot; what lasts ends the hold."""
    actions: tuple[Action, ...] = ()
    if drive.session == lease.driver:
        lease, actions = _stopped(replace(lease, last_heard=now))
    if not drive.lasting:
        return lease, actions
    lease, notices = _refused(lease, drive.session, "warning", f"{drive.cause}: driving waits.")
    return lease, (*actions, *notices)


def _within_range(value: float) -> bool:
    return math.isfinite(value) and -1.0 <= value <= 1.0


def _take(lease: Lease, now: float, session: str) -> Step:
    if session == lease.driver:
        return lease, ()
    taker = lease.operators[session]
    actions: tuple[Action, ...] = ()
    if lease.driver is not None:
        before = lease.driver
        lease, actions = _stopped(lease)
        # Still holding, perhaps: that hold is over.
        asker = lease.asker
        lease = replace(lease, driver=None, asker=None, blocked=lease.blocked | {before})
        notified = {before} if asker in (None, session) else {before, asker}
        text = f"{taker} has taken control."
        actions = (*actions, *(PageNotice(each, "warning", text) for each in sorted(filter(None, notified))))
    taken, notices = _handed(lease, now, session)
    return taken, (*actions, *notices)


def _e_stop(lease: Lease, latched: bool) -> Step:
    if latched == lease.e_stopped:
        return lease, ()
    actions: tuple[Action, ...] = ()
    if latched and lease.moving and lease.driver is not None:
        driver = lease.driver
        lease, actions = _stopped(lease)
        lease, notices = _refused(lease, driver, "warning", "Emergency stop: the robot stands until it is cleared.")
        actions = (*actions, *notices)
    return replace(lease, e_stopped=latched), actions


def _tick(lease: Lease, now: float) -> Step:
    if lease.driver is None:
        return lease, ()
    if now >= lease.last_heard + LOST_AFTER_S or now >= lease.last_held + IDLE_AFTER_S:
        return _free(lease, now)
    if lease.asker is not None and now >= lease.asked_at + ANSWER_WITHIN_S:
        # No answer: the wheel is given only where nothing moves by it.
        before = lease.driver
        if not lease.moving and lease.last_held <= lease.asked_at:
            lease, actions = _free(lease, now)
            given = f"{lease.driver_name} has control: you held nothing and did not answer."
            return lease, (*actions, PageNotice(before, "warning", given))
        return _kept(lease, f"{lease.driver_name} drives and does not answer: ask again in a moment.")
    if lease.moving and now >= lease.last_drive + HOLD_GAP_S:
        return _stopped(lease)
    return lease, ()
