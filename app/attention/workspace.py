"""The Intention Workspace: every desire there is, edited in transactions (thesis 2.2.3).

Not for use from several threads: all edits belong on the event loop, and a transaction must not await.
"""

from __future__ import annotations

import math
import secrets
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

import msgspec

from app.attention.desires import (
    Desire,
    DesireClasses,
    InvalidDesire,
    Source,
    checked_number,
    effective,
    strongest_first,
)
from app.attention.ended_desires import EndedDesires
from app.base.observers import Observers
from app.messages import Accomplishment, DesireOutcome, DesireReport, Modulation


class _Unset:
    """The type of KEEP."""


KEEP: Final = _Unset()
"""Default of the arguments of :meth:`IntentionWorkspace.change`: this field stays as it is."""


class UnknownDesire(Exception):
    """No desire in the workspace has this id (any more)."""

    def __init__(self, desire_id: str) -> None:
        self.id = desire_id
        super().__init__(f"no desire has the id {desire_id!r}: it may have ended")


@dataclass(frozen=True, slots=True)
class Removal:
    """A desire that left, and why: it was accomplished (``done``, ``failed``), ``withdrawn``, or it ``expired``."""

    desire: Desire
    reason: DesireOutcome


@dataclass(frozen=True, slots=True)
class WorkspaceChange:
    """The net effect of one transaction: what came, what changed (before, after), what left, and what behaviors
    reported of desires."""

    added: tuple[Desire, ...] = ()
    changed: tuple[tuple[Desire, Desire], ...] = ()
    removed: tuple[Removal, ...] = ()
    accomplished: tuple[tuple[Desire, Accomplishment], ...] = ()

    def __bool__(self) -> bool:
        return bool(self.added or self.changed or self.removed or self.accomplished)


@dataclass(frozen=True, slots=True)
class WorkspaceStatistics:
    """Counters since the start: ``desires`` there are now, how many came and changed, and how many left, by reason."""

    desires: int
    added: int
    changed: int
    done: int
    failed: int
    withdrawn: int
    expired: int


Observer = Callable[[WorkspaceChange], None]


def random_id() -> str:
    """A new desire id: ``d-`` and 40 random bits in hexadecimal, so that no restart ever reuses an id."""
    return f"d-{secrets.token_hex(5)}"


class IntentionWorkspace:
    """All desires, several of one class allowed.

    ``clock_now`` gives stamps (seconds); ``new_id`` gives ids (called again while it returns one in use).
    Every single edit is a transaction of its own unless made inside ``with workspace.transaction():``.
    """

    def __init__(
        self,
        classes: DesireClasses,
        clock_now: Callable[[], float],
        *,
        new_id: Callable[[], str] = random_id,
    ) -> None:
        self.classes = classes
        self._now = clock_now
        self._new_id = new_id
        self._desires: dict[str, Desire] = {}
        #: The last report on each desire that stays, by id.
        self._reports: dict[str, Accomplishment] = {}
        #: Desires that left in the transaction under way otherwise than withdrawn.
        self._leaving: dict[str, DesireOutcome] = {}
        self._ended = EndedDesires()
        self._observers: Observers[[WorkspaceChange]] = Observers("the Intention Workspace")
        #: Whether any desire may have a modulation.
        self._modulated = False
        self._depth = 0
        self._pending: list[WorkspaceChange] = []
        self._notifying = False
        self._counts = dict.fromkeys(("added", "changed", "done", "failed", "withdrawn", "expired"), 0)

    # --- Reading ---------------------------------------------------------------------------------------------------

    def get(self, desire_id: str) -> Desire:
        """The desire with this id; raises UnknownDesire."""
        try:
            return self._desires[desire_id]
        except KeyError:
            raise UnknownDesire(desire_id) from None

    def desires(self) -> tuple[Desire, ...]:
        """All desires in the order they came."""
        return tuple(self._desires.values())

    def strongest(self) -> Mapping[str, Desire]:
        """Intensity-based selection: per class its most intense desire (see :func:`strongest_first`), with the
        intensity that counts. What emotions add decides among classes, not within one."""
        strongest: dict[str, Desire] = {}
        for desire in self._desires.values():
            rival = strongest.get(desire.cls)
            if rival is None or strongest_first(desire) <= strongest_first(rival):
                strongest[desire.cls] = desire
        return {cls: effective(desire) for cls, desire in strongest.items()} if self._modulated else strongest

    def wanted(self, cls: str) -> Desire | None:
        """The strongest desire of class ``cls``; None where there is none, or one that inhibits it."""
        desire = self.strongest().get(cls)
        return desire if desire is not None and desire.utility > 0 else None

    def report(self, desire_id: str) -> DesireReport:
        """A desire and what became of it, also for a while after it left; raises UnknownDesire."""
        desire = self._desires.get(desire_id)
        if desire is not None:
            return _report(desire, self._reports.get(desire_id))
        ended = self._ended.find(desire_id, self._now())
        if ended is None:
            raise UnknownDesire(desire_id)
        return ended

    def accomplishments(self) -> tuple[Accomplishment, ...]:
        """The last report on each desire there is a report on, of those that stay."""
        return tuple(self._reports.values())

    def ended(self, count: int) -> tuple[DesireReport, ...]:
        """The last ``count`` desires that left, the newest first."""
        return self._ended.newest(count, self._now())

    @property
    def next_expiry(self) -> float | None:
        """The stamp at which the next desire expires; None while none will."""
        return min((d.expires for d in self._desires.values() if d.expires is not None), default=None)

    def statistics(self) -> WorkspaceStatistics:
        return WorkspaceStatistics(desires=len(self._desires), **self._counts)

    # --- Editing ---------------------------------------------------------------------------------------------------

    def add(
        self,
        cls: str,
        *,
        intensity: float,
        utility: float,
        source: Source,
        security: bool = False,
        params: Mapping[str, Any] | None = None,
        ttl: float | None = None,
    ) -> Desire:
        """Add a desire. ``ttl`` is its time to live in seconds, None for ever.

        Raises UnknownDesireClass, or InvalidDesire naming the field.
        """
        now = self._now()
        desire_id = self._new_id()
        while desire_id in self._desires:
            desire_id = self._new_id()
        desire = Desire(
            id=desire_id,
            cls=cls,
            intensity=checked_number("intensity", intensity, above=0),
            utility=checked_number("utility", utility),
            security=_checked_flag(security),
            params=self.classes[cls].validated(params),
            source=source,
            created=now,
            expires=None if ttl is None else now + _checked_ttl(ttl),
        )
        with self.transaction():
            self._desires[desire.id] = desire
        return desire

    def change(
        self,
        desire_id: str,
        *,
        intensity: float | _Unset = KEEP,
        utility: float | _Unset = KEEP,
        security: bool | _Unset = KEEP,
        params: Mapping[str, Any] | _Unset = KEEP,
        ttl: float | _Unset | None = KEEP,
    ) -> Desire:
        """Change a desire in place; what is not given stays. ``params`` replaces all, ``ttl`` counts from now, None:
        for ever.

        Raises UnknownDesire, or InvalidDesire naming the field; then nothing has changed.
        """
        before = self.get(desire_id)
        after = msgspec.structs.replace(
            before,
            intensity=(
                before.intensity if isinstance(intensity, _Unset) else checked_number("intensity", intensity, above=0)
            ),
            utility=before.utility if isinstance(utility, _Unset) else checked_number("utility", utility),
            security=before.security if isinstance(security, _Unset) else _checked_flag(security),
            params=before.params if isinstance(params, _Unset) else self.classes[before.cls].validated(params),
            expires=(
                before.expires if isinstance(ttl, _Unset) else None if ttl is None else self._now() + _checked_ttl(ttl)
            ),
        )
        with self.transaction():
            self._desires[desire_id] = after
            if after.params != before.params:
                self._reports.pop(desire_id, None)
        return after

    def modulate(self, raised: Mapping[str, Modulation]) -> None:
        """Raise the intensities of these desires, by id, and of no others. What was stated of a desire stays; one that
        has left is passed over, and one that inhibits or is security keeps its intensity."""
        with self.transaction():
            for desire in self.desires():
                modulation = raised.get(desire.id)
                if modulation != desire.modulation:
                    self._desires[desire.id] = msgspec.structs.replace(desire, modulation=modulation)
            self._modulated = any(desire.modulation is not None for desire in self._desires.values())

    def remove(self, desire_id: str) -> Desire:
        """Withdraw a desire and return it; raises UnknownDesire."""
        desire = self.get(desire_id)
        with self.transaction():
            del self._desires[desire_id]
        return desire

    def accomplish(self, report: Accomplishment) -> None:
        """Take a behavior's report. The desire leaves if its class is an achievement, else it stays.

        A report on a desire that has left meanwhile is void.
        """
        desire = self._desires.get(report.desire_id)
        if desire is None:
            return
        with self.transaction():
            self._reports[desire.id] = report
            if self.classes[desire.cls].achievement:
                del self._desires[desire.id]
                self._leaving[desire.id] = report.outcome

    def expire(self) -> tuple[Desire, ...]:
        """Remove expired desires in one transaction, and return them."""
        now = self._now()
        over = tuple(d for d in self._desires.values() if d.expires is not None and d.expires <= now)
        with self.transaction():
            for desire in over:
                del self._desires[desire.id]
                self._leaving[desire.id] = "expired"
        return over

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Join all edits of the block: one notification at the end of the outermost block, with the net effect.

        A block that raises restores the workspace as it was at that block's begin; earlier edits of an enclosing block
        stay.
        """
        before, reports, leaving = dict(self._desires), dict(self._reports), dict(self._leaving)
        self._depth += 1
        try:
            yield
        except BaseException:
            self._desires, self._reports, self._leaving = before, reports, leaving
            raise
        finally:
            self._depth -= 1
        if self._depth == 0:
            change = self._difference(before, reports)
            self._leaving.clear()
            if change:
                self._account(change)
            self._reports = {key: report for key, report in self._reports.items() if key in self._desires}
            if change:
                self._pending.append(change)
                self._notify()

    def clear_ended(self) -> None:
        """Time has jumped: what became of desires that left is of another time."""
        self._ended.clear()

    def observe(self, callback: Observer) -> Callable[[], None]:
        """Call ``callback`` with every change from now on; returns a function that ends this.

        Callbacks run at the end of the transaction, in the order they were added. A callback may edit the workspace:
        observers are notified of its change after the current one. The exception of a callback is logged.
        """
        return self._observers.add(callback)

    # --- Inside ----------------------------------------------------------------------------------------------------

    def _difference(self, before: Mapping[str, Desire], reports: Mapping[str, Accomplishment]) -> WorkspaceChange:
        after = self._desires
        either = {**before, **after}
        return WorkspaceChange(
            added=tuple(d for key, d in after.items() if key not in before),
            changed=tuple((before[key], d) for key, d in after.items() if key in before and before[key] != d),
            removed=tuple(
                Removal(d, self._leaving.get(key, "withdrawn")) for key, d in before.items() if key not in after
            ),
            accomplished=tuple(
                (either[key], report)
                for key, report in self._reports.items()
                if key in either and reports.get(key) != report
            ),
        )

    def _account(self, change: WorkspaceChange) -> None:
        """Count, and keep what became of the desires that left."""
        now = self._now()
        self._counts["added"] += len(change.added)
        self._counts["changed"] += len(change.changed)
        for desire, reason in ((removal.desire, removal.reason) for removal in change.removed):
            self._counts[reason] += 1
            self._ended.add(_report(desire, self._reports.get(desire.id), reason, now))

    def _notify(self) -> None:
        if self._notifying:
            return
        self._notifying = True
        try:
            while self._pending:
                self._observers.notify(self._pending.pop(0))
        finally:
            self._notifying = False


def _checked_flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise InvalidDesire("security", f"must be true or false, not {value!r}")
    return value


def _checked_ttl(ttl: object) -> float:
    if isinstance(ttl, bool) or not isinstance(ttl, int | float) or not math.isfinite(ttl) or ttl <= 0:
        raise InvalidDesire("ttl", f"must be a number of seconds greater than 0, not {ttl!r}")
    return float(ttl)


def _report(
    desire: Desire, report: Accomplishment | None, left: DesireOutcome | None = None, ended: float | None = None
) -> DesireReport:
    known = msgspec.structs.asdict(desire)
    if report is None:
        return DesireReport(**known, outcome=left, ended=ended)
    return DesireReport(**known, outcome=report.outcome, behavior=report.behavior, reason=report.reason, ended=ended)
