"""What is tried when the body does not get on, in which order, and when people are asked (a pure state machine).

One *round*: **wait** (a person passes), **back off** (along the way it came), **turn** (look around), **clear** (what
the costmap remembers is forgotten; not before it stands further off, where the camera sees again what it looks over
from near), **open up** (what is unknown or was in the way once counts as free). After each, the way is tried again;
what gets the body nearer to its goal than it ever was ends the round. After ``rounds`` of them it **asks** people for
help, waits, and begins anew.

Lost on its map, it has another measure: it turns on the spot (:class:`SpinSearch`), for what it sees round about tells
where it is, and waits for people when that did not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class RecoveryAction(Enum):
    """What is done about not getting on; the values say it to people."""

    WAIT = "waiting for the way to clear"
    CLEAR = "looking afresh at what stands around"
    BACK_OFF = "backing off along the way it came"
    TURN = "turning to look around"
    OPEN_UP = "trying ways it does not know or that were blocked before"
    ASK = "it does not get on by itself: clear its way, or drive it into the open"


#: The order within a round.
LADDER = (
    RecoveryAction.WAIT,
    RecoveryAction.BACK_OFF,
    RecoveryAction.TURN,
    RecoveryAction.CLEAR,
    RecoveryAction.OPEN_UP,
)


@dataclass(frozen=True, slots=True)
class RecoverySettings:
    """``stuck_s`` without getting on begins a measure. Waiting takes ``wait_s``; backing off ends after ``back_m`` or
    ``back_s``, a turn after ``turn_rad`` or ``turn_s``; ``rounds`` of all measures before people are asked, who have
    ``ask_s``. ``find_rad`` is what it turns to find itself.
    """

    stuck_s: float = 1.5
    wait_s: float = 1.5
    back_m: float = 0.4
    back_s: float = 4.0
    turn_rad: float = 1.6
    turn_s: float = 6.0
    rounds: int = 2
    ask_s: float = 15.0
    find_rad: float = 4.0 * math.pi


class Recovery:
    """Chooses measures; knows nothing of how they are done."""

    def __init__(self, settings: RecoverySettings | None = None) -> None:
        self.settings = settings or RecoverySettings()
        #: Measures begun since the goal was given.
        self.count = 0
        self._rung = 0
        self._round = 0
        self._current: RecoveryAction | None = None
        self._began = 0.0

    @property
    def current(self) -> RecoveryAction | None:
        """What is being done; None while the way is followed."""
        return self._current

    def begin(self, now: float) -> RecoveryAction:
        """The body does not get on: the next measure, which becomes :attr:`current`."""
        if self._rung == len(LADDER):
            self._rung = 0
            self._round += 1
        if self._round >= self.settings.rounds:
            self._round = 0
            self._current = RecoveryAction.ASK
        else:
            self._current = LADDER[self._rung]
            self._rung += 1
            self.count += 1
        self._began = now
        return self._current

    def over(self, now: float, *, driven_m: float = 0.0, turned_rad: float = 0.0, barred: bool = False) -> bool:
        """Whether :attr:`current` has done what it can: ``driven_m`` and ``turned_rad`` since it began; ``barred``: the
        body may not move as the measure wants."""
        s, elapsed = self.settings, now - self._began
        match self._current:
            case None | RecoveryAction.CLEAR | RecoveryAction.OPEN_UP:
                return True
            case RecoveryAction.WAIT:
                return elapsed >= s.wait_s
            case RecoveryAction.ASK:
                return elapsed >= s.ask_s
            case RecoveryAction.BACK_OFF:
                return barred or driven_m >= s.back_m or elapsed >= s.back_s
            case RecoveryAction.TURN:
                return barred or turned_rad >= s.turn_rad or elapsed >= s.turn_s

    def end(self) -> None:
        """The measure is over: the way is followed again."""
        self._current = None

    def succeeded(self) -> None:
        """The body came nearer to its goal than ever: the next time it begins with the mildest measure."""
        self._rung = self._round = 0

    def reset(self) -> None:
        """Another goal."""
        self.succeeded()
        self.end()
        self.count = 0


class SpinSearch:
    """How a body that is lost turns to find itself: after a moment, since it may be found as it stands; then so far,
    or each way until it is barred; where that did not help, again when people have had time to."""

    def __init__(self, settings: RecoverySettings) -> None:
        self._settings = settings
        self._since: float | None = None
        self._left_rad = 0.0
        self._barred = 0

    def turns(self, now: float) -> bool:
        """Whether it turns now. The first call after :meth:`end` begins the search."""
        if self._since is None or (self._given_up and now - self._since >= self._settings.ask_s):
            self._since, self._left_rad, self._barred = now, self._settings.find_rad, 0
        return not self._given_up and now - self._since >= self._settings.wait_s

    def turned(self, rad: float, now: float) -> None:
        """It turned so much."""
        self._left_rad -= rad
        if self._given_up:
            self._since = now

    def barred(self, now: float) -> bool:
        """It cannot turn on as it did; returns whether it may try the other way."""
        self._barred += 1
        if self._given_up:
            self._since = now
        return not self._given_up

    def end(self) -> None:
        """The body is found, or is to go somewhere else."""
        self._since = None

    @property
    def _given_up(self) -> bool:
        return self._left_rad <= 0.0 or self._barred >= 2
