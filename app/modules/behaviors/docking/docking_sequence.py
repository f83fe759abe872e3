"""What docking does next: a state machine on values, without clock or sensors of its own.

idle ─▶ going ─▶ searching ─▶ approaching ─▶ docked ─▶ undocking ─▶ idle
                     ▲             │ no charge, askew, or lost
                     └── backing ◀─┘             (after the last attempt: failed)
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from app.base.geometry import Pose2
from app.messages import DockingState
from app.modules.behaviors.docking.approach import ApproachRules, approach, offset_of

Velocity = tuple[float, float]
STOP: Velocity = (0.0, 0.0)
#: Time (s) at the dock within which the charger has come on, or its contacts do not touch.
_CHARGE_S = 2.5
SEEN_S = 1.5
"""Greatest age (s) of the newest sight of the dock that is approached."""
#: Offsets (m, rad) beyond which the robot would not fit into the dock, judged in the last ``_JUDGED_M``.
_ASKEW = (0.04, math.radians(5))
_JUDGED_M = 0.06
#: Less than this (m) driven in so many s: something holds it.
_HELD_M, _HELD_S = 0.01, 3.0


@dataclass(frozen=True, slots=True)
class SequenceRules:
    """``staging_m``: distance from where the plates meet, of the place in front of the dock. ``attempts``: so many in
    all. ``back_mps``: speed backwards. ``undock_m``: so far back before anything else drives."""

    approach: ApproachRules = field(default_factory=ApproachRules)
    staging_m: float = 1.2
    search_s: float = 8.0
    attempts: int = 3
    back_mps: float = 0.1
    undock_m: float = 0.5


@dataclass(frozen=True, slots=True)
class DockingInput:
    """What is known at ``now`` (s): ``X_OB``; ``X_OD`` where the dock is surely seen, and how long ago (``seen_s``);
    whether the battery is ``charging``; whether docking is ``wanted``, and whether the robot should ``leave`` a dock
    that it stands in. ``at_staging``: whether it stands in front of the dock; ``unreachable``: why it never will, or
    ""."""

    now: float
    X_OB: Pose2
    wanted: bool
    leave: bool
    charging: bool
    at_staging: bool
    X_OD: Pose2 | None = None
    seen_s: float = math.inf
    unreachable: str = ""


class DockingSequence:
    """One robot's docking; :meth:`step` ten times a second."""

    def __init__(self, rules: SequenceRules) -> None:
        self.rules = rules
        self.state: DockingState = "idle"
        self.reason = ""
        self.attempt = 0
        self._since = 0.0
        self._begin = Pose2()
        self._held = (0.0, Pose2())
        self._arrived: float | None = None

    @property
    def needs_way(self) -> bool:
        """Whether the robot is to be driven to the place in front of the dock."""
        return self.state == "going"

    def _is_in_dock(self, known: DockingInput) -> bool:
        if self.state not in ("approaching", "backing") or known.X_OD is None:
            return False
        X_DB = known.X_OD.inverse() @ known.X_OB
        return math.hypot(X_DB.x, X_DB.y) < self.rules.approach.docked_m + self.rules.undock_m

    def abort(self) -> None:
        """Nothing is desired of it any more, in whatever state it is."""
        self.state, self.reason = "idle", "no longer desired"

    def again(self) -> None:
        """Another desire, or another dock: what failed may succeed now."""
        if self.state == "failed":
            self.state, self.reason = "idle", ""

    def step(self, known: DockingInput) -> Velocity | None:
        """The velocity to ask for (m/s, rad/s); None: none, others may drive."""
        if self.state not in ("idle", "failed", "docked", "undocking") and not known.wanted:
            # Beside the plates there is no room to turn.
            self._enter("undocking" if known.leave and self._is_in_dock(known) else "idle", known)
        match self.state:
            case "idle":
                return self._idle(known)
            case "going":
                return self._going(known)
            case "searching":
                return self._searching(known)
            case "approaching":
                return self._approaching(known)
            case "docked":
                return self._docked(known)
            case "backing":
                return self._backing(known)
            case "undocking":
                return self._undocking(known)
            case "failed":
                if not known.wanted:
                    self._enter("idle", known)
                return None

    def _idle(self, known: DockingInput) -> Velocity | None:
        if known.charging:
            self._enter("docked", known)
        elif known.wanted:
            self.attempt = 1
            self._enter("going", known)
        return None

    def _going(self, known: DockingInput) -> Velocity | None:
        if known.charging:
            self._enter("docked", known)
        elif known.at_staging:
            self._enter("searching", known)
            return STOP
        elif known.unreachable:
            self._enter("failed", known, f"the place in front of the dock was not reached: {known.unreachable}")
        return None

    def _searching(self, known: DockingInput) -> Velocity | None:
        if known.X_OD is not None:
            self._arrived = None
            self._held = (known.now, known.X_OB)
            self._enter("approaching", known)
        elif known.now - self._since > self.rules.search_s:
            self._enter("failed", known, "no dock is seen where it should be")
            return None
        return STOP

    def _approaching(self, known: DockingInput) -> Velocity | None:
        if known.charging:
            self._enter("docked", known)
            return STOP
        if known.X_OD is None or known.seen_s > SEEN_S:
            return self._again(known, "the dock was lost from sight")
        rules = self.rules.approach
        offset = offset_of(known.X_OD.inverse() @ known.X_OB, rules)
        if self._arrived is not None or offset.remaining_m <= 0.0:
            self._arrived = known.now if self._arrived is None else self._arrived
            return STOP if known.now - self._arrived <= _CHARGE_S else self._again(known, "the charger gives no power")
        askew = abs(offset.aside_m) > _ASKEW[0] or abs(offset.turned_rad) > _ASKEW[1]
        if offset.remaining_m < _JUDGED_M and askew:
            return self._again(known, "it stood askew in front of the dock")
        since, place = self._held
        if math.hypot(known.X_OB.x - place.x, known.X_OB.y - place.y) > _HELD_M:
            self._held = (known.now, known.X_OB)
        elif known.now - since > _HELD_S:
            return self._again(known, "something holds it in front of the dock")
        return approach(offset, rules)

    def _docked(self, known: DockingInput) -> Velocity | None:
        if known.leave:
            self._enter("undocking", known)
            return STOP
        if known.charging:
            self._arrived = None
            return STOP if known.wanted else None
        # Its contacts may bounce as it stops.
        self._arrived = known.now if self._arrived is None else self._arrived
        if known.now - self._arrived <= _CHARGE_S:
            return STOP if known.wanted else None
        if known.wanted:
            return self._again(known, "the charger gives no power any more")
        self._enter("idle", known, "it was taken off the dock")
        return None

    def _backing(self, known: DockingInput) -> Velocity | None:
        driven = math.hypot(known.X_OB.x - self._begin.x, known.X_OB.y - self._begin.y)
        away = math.inf if known.X_OD is None else (known.X_OD.inverse() @ known.X_OB).x
        if driven >= self.rules.staging_m - self.rules.approach.docked_m or away >= self.rules.staging_m:
            self._enter("searching", known, self.reason)
            return STOP
        if known.now - self._since > 3 * self.rules.staging_m / self.rules.back_mps:
            self._enter("failed", known, f"{self.reason}, and something behind it lets it not back off")
            return None
        return (-self.rules.back_mps, 0.0)

    def _undocking(self, known: DockingInput) -> Velocity | None:
        driven = math.hypot(known.X_OB.x - self._begin.x, known.X_OB.y - self._begin.y)
        if driven >= self.rules.undock_m:
            self._enter("idle", known, "undocked")
            return None
        return (-self.rules.back_mps, 0.0)

    def _again(self, known: DockingInput, why: str) -> Velocity | None:
        if self.attempt >= self.rules.attempts:
            self._enter("failed", known, f"{why}, after {self.attempt} attempts")
            return None
        self.attempt += 1
        self._enter("backing", known, why)
        return STOP

    def _enter(self, state: DockingState, known: DockingInput, reason: str = "") -> None:
        self.state, self.reason = state, reason
        self._since, self._begin = known.now, known.X_OB
        self._arrived = None
