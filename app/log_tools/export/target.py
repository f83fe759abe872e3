"""The interface of export formats, and the folder of their files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.logs.log import LogError, LoggedChannel
from app.logs.output_file import check_new, replacing

#: Takes the next message of a channel.
Write = Callable[[Any], None]


@dataclass(slots=True)
class Target:
    """The folder to write to, the time (robot's clock, s) that is asked for, and what has been written: a line for
    people each."""

    folder: Path
    force: bool
    begin: float
    end: float
    written: list[str] = field(default_factory=list)

    def file(self, name: str) -> AbstractContextManager[Path]:
        """A name to write to that becomes ``name`` in the folder when all went well. Raises LogError."""
        return replacing(self.folder / name, self.force)

    def check(self, name: str) -> None:
        """Raise LogError now where :meth:`file` would."""
        check_new(self.folder / name, self.force)

    def subfolder(self, name: str) -> Target:
        """A folder within, created if needed; its files are summed up in one line here. Raises LogError."""
        path = self.folder / name
        if path.is_dir() and any(path.iterdir()) and not self.force:
            raise LogError(f"{path} has files already; --force adds to them and replaces, -o names another folder")
        path.mkdir(exist_ok=True)
        return Target(path, self.force, self.begin, self.end, self.written)

    def put(self, name: str, data: bytes) -> None:
        """Write a small file whole."""
        with self.file(name) as part:
            part.write_bytes(data)


class Format(ABC):
    """A kind of files, for one export."""

    #: Whether it wants to see all messages once before any is written.
    surveys = False

    @abstractmethod
    def accepts(self, message_type: type[Any]) -> bool:
        """Whether messages of this class can be written so."""

    def survey(self, channel: str, message: Any) -> None:  # noqa: B027  # most formats look at nothing before
        """See a message before anything is written."""

    @abstractmethod
    def writer(self, channel: LoggedChannel, target: Target) -> AbstractContextManager[Write]:
        """Write the messages of ``channel``. On any exception the unfinished file is deleted. Raises LogError."""


def stamp_name(stamp: float) -> str:
    """A capture time as a file's name: seconds with microseconds, which sorts by time."""
    return f"{stamp:017.6f}"
