"""What has become of each desire so far: intended, exploited, since when; and for how long it has waited. Pure.

*Desired* is a desire in the Intention Workspace. *Intended*: it is the strongest of its class and attention selected a
strategy for it. *Exploited*: what was selected does its work, by an arbiter's report or by a perception's activity
(thesis 2.2.3). *Accomplished*: a behavior reported so.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from app.attention.desires import Desire
from app.messages import DesireProgress


@dataclass(frozen=True, slots=True)
class Waiting:
    """A desire is intended, and has not been exploited for ``idle_s`` (s)."""

    desire: Desire
    idle_s: float


class ProgressLog:
    """Since when each desire is what it is. ``idle_after_s``: so long (s) intended without being exploited is noted."""

    def __init__(self, idle_after_s: float) -> None:
        self._idle_after_s = idle_after_s
        self._known: dict[str, DesireProgress] = {}
        self._noted: set[str] = set()

    @property
    def progress(self) -> tuple[DesireProgress, ...]:
        """Of each desire that is there, in the order they came."""
        return tuple(self._known.values())

    def update(
        self, now: float, desires: Iterable[Desire], intended: Collection[str], exploited: Collection[str]
    ) -> tuple[Waiting, ...]:
        """Take the state at ``now`` (s, robot's clock); ``intended`` and ``exploited`` are ids of desires.

        Returns the desires that have waited too long, each once until it is exploited or intended again.
        """
        desires = tuple(desires)
        known = {}
        for desire in desires:
            before = self._known.get(desire.id, DesireProgress(desire.id, intended=False, exploited=False))
            is_intended, is_exploited = desire.id in intended, desire.id in exploited
            known[desire.id] = DesireProgress(
                desire.id,
                intended=is_intended,
                exploited=is_exploited,
                intended_since=before.intended_since if is_intended == before.intended else now,
                exploited_since=before.exploited_since if is_exploited == before.exploited else now,
            )
        self._known = known
        waiting = []
        for desire in desires:
            idle_s = idle_time_s(known[desire.id], now)
            if idle_s is None or idle_s < self._idle_after_s:
                self._noted.discard(desire.id)
            elif desire.id not in self._noted:
                self._noted.add(desire.id)
                waiting.append(Waiting(desire, idle_s))
        self._noted &= known.keys()
        return tuple(waiting)

    def clear(self) -> None:
        """Time has jumped: nothing is known."""
        self._known.clear()
        self._noted.clear()


def idle_time_s(progress: DesireProgress, now: float) -> float | None:
    """For how long (s) it has been intended and not exploited at ``now``; None where that is not so."""
    if not progress.intended or progress.exploited:
        return None
    stamps = [stamp for stamp in (progress.intended_since, progress.exploited_since) if stamp is not None]
    return now - max(stamps) if stamps else None
