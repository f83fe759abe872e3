"""How others speak to the Recorder without knowing the module: saving the ring while it turns."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

#: The desire class that a Recorder serves.
RECORD = "Record"

#: Saves the ring's last minutes (None: all of it) under a name (None: made of the time); returns the recording's name.
SaveRing = Callable[[float | None, str | None], Awaitable[str]]


class RecorderUnavailable(Exception):
    """What was asked cannot be done now; the message says why and what would help."""


class RecorderControl:
    """The one way to the Recorder: a service of the program. The module attaches itself while it lives."""

    def __init__(self) -> None:
        self._save: SaveRing | None = None

    def attach(self, save: SaveRing) -> Callable[[], None]:
        """The Recorder is there; returns what detaches it."""
        self._save = save

        def detach() -> None:
            if self._save is save:
                self._save = None

        return detach

    @property
    def available(self) -> bool:
        """Whether a Recorder runs."""
        return self._save is not None

    async def save_ring(self, minutes: float | None = None, name: str | None = None) -> str:
        """Keep the ring's last ``minutes`` as a recording of its own, and return its name.

        Raises RecorderUnavailable without a Recorder or where no ring turns, LogError where it cannot be written.
        """
        if self._save is None:
            raise RecorderUnavailable("this program has no Recorder running")
        return await self._save(minutes, name)
