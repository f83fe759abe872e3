"""While somebody watches, the console desires Telepresence: the camera's picture and the point cloud."""

from __future__ import annotations

import asyncio

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire

CLASS = "Telepresence"
INTENSITY = 4.0
UTILITY = 1.0
#: A page that is reloaded is gone for a moment: the desire outlives the last viewer by this.
LINGER_S = 2.0


class Presence:
    """Keeps at most one desire in the workspace, as long as :meth:`watched` was last told True."""

    def __init__(self, workspace: IntentionWorkspace) -> None:
        self._workspace = workspace
        self._desire: str | None = None
        self._leaving: asyncio.TimerHandle | None = None

    def watched(self, watched: bool) -> None:
        """Somebody came while nobody was there, or the last one left."""
        if CLASS not in self._workspace.classes:
            return
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        if watched:
            if self._desire is None:
                source = Source("operator", "console")
                self._desire = self._workspace.add(CLASS, intensity=INTENSITY, utility=UTILITY, source=source).id
        elif self._desire is not None:
            self._leaving = asyncio.get_running_loop().call_later(LINGER_S, self.withdraw)

    def withdraw(self) -> None:
        """Take the desire back now."""
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        desire, self._desire = self._desire, None
        if desire is not None:
            try:
                self._workspace.remove(desire)
            except UnknownDesire:
                # Somebody removed it by hand, as is their right.
                return
