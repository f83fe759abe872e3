"""While a page watches, pictures and the point cloud must come; while one listens, the sound.

On a robot that costs something, so the console desires Telepresence and Listen like any other source of desires. A
recording has its intentions already, and one more desire would change them: there, the filters that the desires would
open are opened past attention.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.runtime.filter import CLOSED
from app.runtime.filter_bank import Pin

if TYPE_CHECKING:
    from app.program.system import System

WATCH = "Telepresence"
LISTEN = "Listen"
INTENSITY = 4.0
UTILITY = 1.0
#: A page that is reloaded is gone for a moment: the desire outlives the last viewer by this.
LINGER_S = 2.0


class Presence:
    """Keeps at most one desire of class ``cls`` in the workspace, while the last call of :meth:`attend` said True.

    None where no strategy of the program serves it (``served`` False): it would stay unfulfilled for good.
    """

    def __init__(self, workspace: IntentionWorkspace, cls: str, *, served: bool = True) -> None:
        self._workspace = workspace
        self._class = cls
        self._served = served and cls in workspace.classes
        self._desire: str | None = None
        self._leaving: asyncio.TimerHandle | None = None

    def attend(self, attended: bool) -> None:
        """The first viewer came (``attended``), or the last one left."""
        if not self._served:
            return
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        if attended:
            if self._desire is None:
                source = Source("operator", "console")
                self._desire = self._workspace.add(self._class, intensity=INTENSITY, utility=UTILITY, source=source).id
        elif self._desire is not None:
            self._leaving = asyncio.get_running_loop().call_later(LINGER_S, self.withdraw)

    def withdraw(self) -> None:
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        desire, self._desire = self._desire, None
        if desire is not None:
            try:
                self._workspace.remove(desire)
            except UnknownDesire:
                # An operator may remove it, like any desire.
                return


class Spectators:
    """Opens, past attention, the filters of the best strategy for class ``cls`` while :meth:`attend` last said True."""

    def __init__(self, system: System, cls: str) -> None:
        self._system = system
        self._class = cls
        self._opened: list[str] = []

    def attend(self, attended: bool) -> None:
        """The first viewer came (``attended``), or the last one left."""
        self.withdraw()
        if not attended:
            return
        serving = [s for s in self._system.table.strategies if s.cls == self._class]
        best = max(serving, key=lambda strategy: strategy.utility, default=None)
        filters = self._system.graph.filters
        for name, divisor in (best.filters if best is not None else {}).items():
            if name not in filters.pinned():
                filters.pin(name, Pin(divisor))
                self._opened.append(name)

    def withdraw(self) -> None:
        """Leave the filters to attention again."""
        current = self._system.translator.current
        for name in self._opened:
            self._system.graph.filters.unpin(name, CLOSED if current is None else current.divisors.get(name, CLOSED))
        self._opened.clear()
