"""The service of episodic memory, for other parts of the program; the module that remembers attaches its server."""

from __future__ import annotations

from typing import Protocol

from app.base.service_slot import ServiceSlot
from app.messages import MemoryReport


class MemoryOff(Exception):
    """Nothing is remembered; the message is one sentence."""


class UnknownEpisode(Exception):
    """There is no such episode; the message is one sentence."""


class MemoryRefused(Exception):
    """The disk refuses; the message is one sentence."""


class MemoryServer(Protocol):
    """Remembers; all methods are called on the event loop."""

    async def report(self) -> MemoryReport:
        """All that is remembered."""
        ...

    async def forget(self, episode: int) -> None:
        """Remove one episode. Raises UnknownEpisode, MemoryRefused."""
        ...

    async def forget_all(self) -> None:
        """Remove all that is remembered. Raises MemoryRefused."""
        ...


class MemoryService(ServiceSlot[MemoryServer]):
    """The service of episodic memory: its server, which a module attaches while it remembers."""

    def __init__(self) -> None:
        super().__init__(lambda: MemoryOff("this program remembers nothing: no EpisodicMemory is enabled"))

    @property
    def server(self) -> MemoryServer:
        """The server. Raises MemoryOff while there is none."""
        return self.provider
