"""The Recorder's service for other parts of the program: saving the ring while it records."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from app.base.service_slot import ServiceSlot

#: The desire class that a Recorder serves.
RECORD = "Record"

#: Saves the last minutes of the ring (None: all of it) under a name (None: made of the time); returns the recording's
#: name.
SaveRing = Callable[[float | None, str | None], Awaitable[str]]


class RecorderUnavailable(Exception):
    """The request cannot be met now; the message says why and what would help."""


class RecorderService(ServiceSlot[SaveRing]):
    """The service of the Recorder, which attaches its function while it runs."""

    def __init__(self) -> None:
        super().__init__(lambda: RecorderUnavailable("this program has no Recorder running"))

    async def save_ring(self, minutes: float | None = None, name: str | None = None) -> str:
        """Keep the ring's last ``minutes`` as a recording of its own, and return its name.

        Raises RecorderUnavailable without a Recorder or without a ring, LogError if the file cannot be written.
        """
        return await self.provider(minutes, name)
