"""Recovery without progress: order of the recovery actions, and when people are asked for help (a pure state machine).

One *round*: **wait** (a person passes), **back off** (along the driven area), **turn** (look around), **clear** (the
local costmap is cleared, after backing off to where the camera sees low obstacles again), **open up** (unknown cells
and transient obstacles count as free). After each action the path is tried again; progress beyond the best so far ends
the round. After ``rounds`` of them the robot **asks** people for help, waits ``ask_s``, and starts the first round
again.

A robot that is lost on its map turns on the spot (:class:`SpinSearch`), which gives the relocalization scans from all
sides, and then waits for people.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class RecoveryAction(Enum):
    """A recovery action; the values are texts for people."""

    WAIT = "waiting for the way to clear"
    CLEAR = "clearing the costmap"
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
    """``stuck_s``: time without progress before an action. ``wait_s``: duration of waiting. Backing off ends after
    ``back_m`` or ``back_s``, a turn after ``turn_rad`` or ``turn_s``. ``rounds``: rounds of all actions before people
    are asked; ``ask_s``: time for them to help. ``find_rad``: angle of a search turn."""

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
    """Chooses recovery actions; does not carry them out."""

    def __init__(self, settings: RecoverySettings | None = None) -> None:
        self.settings = settings or RecoverySettings()
        #: Actions started since the goal was given.
        self.count = 0
        self._rung = 0
        self._round = 0
        self._current: RecoveryAction | None = None
        self._began = 0.0

    @property
    def current(self) -> RecoveryAction | None:
        """The action in progress; None while the path is followed."""
        return self._current

    def begin(self, now: float) -> RecoveryAction:
        """Start the next action, which becomes :attr:`current`, for lack of progress."""
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
        """Whether :attr:`current` is complete. ``driven_m``, ``turned_rad``: motion since its start; ``barred``:
        obstacles forbid its motion."""
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
        """End the action: the path is followed again."""
        self._current = None

    def succeeded(self) -> None:
        """The body came nearer to its goal than before: the next recovery starts with the first action."""
        self._rung = self._round = 0

    def reset(self) -> None:
        """Reset for another goal."""
        self.succeeded()
        self.end()
        self.count = 0


class SpinSearch:
    """Turning on the spot of a lost robot: after a pause, since relocalization may succeed without motion; then by
    ``find_rad``, or each way until an obstacle bars it; again after ``ask_s`` without success."""

    def __init__(self, settings: RecoverySettings) -> None:
        self._settings = settings
        self._since: float | None = None
        self._left_rad = 0.0
        self._barred = 0

    def turns(self, now: float) -> bool:
        """Whether to turn now. The first call after :meth:`end` starts the search."""
        if self._since is None or (self._given_up and now - self._since >= self._settings.ask_s):
            self._since, self._left_rad, self._barred = now, self._settings.find_rad, 0
        return not self._given_up and now - self._since >= self._settings.wait_s

    def turned(self, rad: float, now: float) -> None:
        """Add an angle turned (rad)."""
        self._left_rad -= rad
        if self._given_up:
            self._since = now

    def barred(self, now: float) -> bool:
        """An obstacle bars the turn; returns whether to try the other way."""
        self._barred += 1
        if self._given_up:
            self._since = now
        return not self._given_up

    def end(self) -> None:
        """Localization is restored, or there is another goal."""
        self._since = None

    @property
    def _given_up(self) -> bool:
        return self._left_rad <= 0.0 or self._barred >= 2
