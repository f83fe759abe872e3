"""Whether a node may be used: a pure state machine of beats and round trips, without a clock of its own.

Beats are counted, not timed: a robot's program that was held up itself must not take the node for lost. What counts is
in ``tests/remote/test_health.py``.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Literal

BEAT_S = 0.2
#: So many beats in a row without an answer: frozen, within a second.
MISSED_BEATS = 3
#: The newest round trips that are looked at; with 20, the second longest is the 95th percentile (nearest rank).
WINDOW = 20
#: A link that was not well must answer so many beats in a row, within the deadline, before it is used again.
GOOD_BEATS = 5
#: ... and rest for so long (s), twice as long each time that it fails again soon.
SHORTEST_REST_S, LONGEST_REST_S = 1.0, 60.0
#: A link that stays well for so long (s) is trusted as at first.
TRUSTED_AFTER_S = 60.0

State = Literal["absent", "proving", "well"]


@dataclass(slots=True)
class LinkHealth:
    """The health of one link; times are the robot's clock (s), round trips in s (inf: never answered).

    :attr:`why` says in words why it is not used; "" while it is.
    """

    name: str
    deadline_s: float
    state: State = "absent"
    why: str = ""
    _unanswered: int = 0
    _good: int = 0
    _trips: deque[float] = field(default_factory=lambda: deque(maxlen=WINDOW))
    _rest_s: float = SHORTEST_REST_S
    _rests_until: float = 0.0
    _well_since: float = 0.0

    def __post_init__(self) -> None:
        self.why = f"{self.name} has not joined"

    @property
    def usable(self) -> bool:
        return self.state == "well"

    @property
    def p95_s(self) -> float | None:
        """The 95th percentile of the newest round trips; None with fewer than two."""
        return sorted(self._trips)[-2] if len(self._trips) > 1 else None

    def join(self) -> None:
        """It was admitted, and has to answer some beats first."""
        self._clear()
        self.state, self.why = "proving", f"{self.name} has just joined"

    def leave(self, why: str) -> None:
        """It has gone, or is no longer connected."""
        self._clear()
        self.state, self.why = "absent", why

    def beat(self, now: float) -> None:
        """A beat is about to be sent: judge those before."""
        if self._unanswered >= MISSED_BEATS:
            self._good = 0
            self._fail(now, f"{self.name} does not answer")
        self._unanswered += 1

    def answered(self, now: float, round_trip_s: float, down: str = "") -> None:
        """The newest beat was answered; ``down``: a module there that does not run, and why."""
        self._unanswered = 0
        if down:
            self._good = 0
            self._fail(now, f"at {self.name}, {down}")
        elif self.state == "well":
            # A beat waits behind what was sent before: sound, of which nothing is confirmed, makes it late.
            self.trip(now, round_trip_s)
        elif round_trip_s > self.deadline_s:
            self._good = 0
        elif self.state == "proving":
            self._good += 1
            if self._good >= GOOD_BEATS and now >= self._rests_until:
                self._trips.clear()
                self.state, self.why, self._well_since = "well", "", now

    def trip(self, now: float, round_trip_s: float) -> None:
        """A message was handled there, or was not within the deadline (inf)."""
        if self.state != "well":
            return
        self._trips.append(round_trip_s)
        p95_s = self.p95_s
        if p95_s is not None and p95_s > self.deadline_s:
            late = "nothing" if p95_s == float("inf") else f"p95 {p95_s:.2f} s"
            self._fail(now, f"{self.name} answers too late: {late} within {self.deadline_s:g} s")

    def _fail(self, now: float, why: str) -> None:
        if self.state == "well":
            soon = now - self._well_since < TRUSTED_AFTER_S
            self._rest_s = min(2 * self._rest_s, LONGEST_REST_S) if soon else SHORTEST_REST_S
            self._rests_until = now + self._rest_s
        if self.state != "absent":
            self.state, self.why = "proving", why
        self._good = 0
        self._trips.clear()

    def _clear(self) -> None:
        self._unanswered = self._good = 0
        self._trips.clear()
