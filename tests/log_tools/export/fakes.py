"""A log in memory, for formats: whatever messages a test wants, of any class."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.logs.log import Logged, LoggedChannel, LogInfo
from app.logs.manifest import Manifest


@dataclass
class MemoryLog:
    """Implements ``app.logs.log.Log`` on a list of messages."""

    content: list[Logged]
    rate_hz: float | None = None
    manifest: Manifest = Manifest()  # noqa: RUF009  # it is frozen

    @property
    def info(self) -> LogInfo:
        counts = Counter(logged.channel for logged in self.content)
        types: dict[str, type[Any]] = {logged.channel: type(logged.message) for logged in self.content}
        channels = {name: LoggedChannel(name, types[name], count, self.rate_hz) for name, count in counts.items()}
        times = [logged.at for logged in self.content] or [0.0]
        return LogInfo(Path("made.mcap"), "made", min(times), max(times), channels, 0)

    def messages(self, begin: float | None = None, channels: Collection[str] | None = None) -> Iterator[Logged]:
        for logged in self.content:
            if (begin is None or logged.at >= begin) and (channels is None or logged.channel in channels):
                yield logged

    def close(self) -> None:
        """Nothing to release."""
