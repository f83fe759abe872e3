"""Confidence as utility: what a perception says of how well it works now scales what its strategies produce.

After HAMMER (Demiris and Khadhouri 2006), whose models get attention by the confidence of their predictions. Bounded,
in steps, and with hysteresis: another level counts once it has differed for a while. A perception that says nothing
more, as one that attention has closed for it, is trusted again, so that it is tried.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from app.attention.strategies import CLOSED, Strategy

#: Steps of the level; what differs by less than this is the same.
_STEP: Final = 0.05
_DIFFERS: Final = 0.15
#: Another level counts after so long (s); a perception that is silent for so long (s) is trusted again.
_LASTS_S: Final = 2.0
_FORGOTTEN_S: Final = 30.0


@dataclass(slots=True)
class _Module:
    level: float = 1.0
    reason: str = ""
    heard: float = 0.0
    said: float = 1.0
    why: str = ""
    differs_since: float | None = None


class Confidences:
    """The level of each perception, from ``least`` to 1."""

    def __init__(self, least: float) -> None:
        """Raises ValueError for a least level that is not over 0 and at most 1."""
        if not 0 < least <= 1:
            raise ValueError(f"the least confidence is over 0 and at most 1, not {least!r}")
        self._least = least
        self._modules: dict[str, _Module] = {}

    def take(self, module: str, now: float, value: float, reason: str) -> None:
        """``module`` says that it works as well as ``value`` (0 to 1) of what it can, and why. NaN is not heard."""
        if value != value:
            return
        known = self._modules.setdefault(module, _Module())
        known.said = max(self._least, min(1.0, round(value / _STEP) * _STEP))
        known.why = reason
        known.heard = now
        self._judge(known, now)

    def expire(self, now: float) -> None:
        """Trust those again that are silent."""
        for known in self._modules.values():
            if now - known.heard >= _FORGOTTEN_S:
                known.level, known.said, known.reason, known.differs_since = 1.0, 1.0, "", None

    def clear(self) -> None:
        """Trust all again: time has jumped."""
        self._modules.clear()

    def levels(self) -> dict[str, tuple[float, str]]:
        """By module that works less well: its level, and why."""
        return {name: (known.level, known.reason) for name, known in self._modules.items() if known.level < 1}

    def _judge(self, known: _Module, now: float) -> None:
        full = known.said == 1.0 and known.level < 1
        if abs(known.said - known.level) < _DIFFERS - 1e-9 and not full:
            known.differs_since = None
            return
        if known.differs_since is None:
            known.differs_since = now
        if now - known.differs_since >= _LASTS_S:
            known.level, known.reason, known.differs_since = known.said, known.why, None


def factors(strategies: Iterable[Strategy], levels: Mapping[str, tuple[float, str]]) -> dict[str, float]:
    """By strategy that opens a module which works less well: the level of the worst of them."""
    found = {}
    for strategy in strategies:
        mine = [levels[name][0] for name in _opened(strategy) if name in levels]
        if mine:
            found[strategy.name] = min(mine)
    return found


def remarks(strategies: Iterable[Strategy], levels: Mapping[str, tuple[float, str]]) -> dict[str, str]:
    """By class whose strategies open such a module: what is the matter, in words."""
    found: dict[str, str] = {}
    for strategy in strategies:
        mine = sorted((levels[name], name) for name in _opened(strategy) if name in levels)
        if mine:
            (level, reason), name = mine[0]
            found.setdefault(strategy.cls, f"{name} works at {100 * level:.0f} %: {reason}")
    return found


def _opened(strategy: Strategy) -> Collection[str]:
    return {name.partition(".")[0] for name, phi in strategy.filters.items() if phi != CLOSED}
