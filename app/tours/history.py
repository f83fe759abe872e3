"""Versions of one tour since the program began: undo and redo. Pure values."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.tours.model import Tour

#: A tour keeps so many versions: its first, and the newest ones.
MOST_VERSIONS = 500

#: A version; None: there was no such tour then.
Version = Tour | None


@dataclass(frozen=True, slots=True)
class History:
    """Versions, oldest first, at least one; ``at`` is the index of the one in force."""

    versions: tuple[Version, ...]
    at: int = 0

    @property
    def current(self) -> Version:
        """The version in force."""
        return self.versions[self.at]

    @property
    def can_undo(self) -> bool:
        """Whether there is an older version."""
        return self.at > 0

    @property
    def can_redo(self) -> bool:
        """Whether a newer version was undone."""
        return self.at < len(self.versions) - 1

    def changed(self, version: Version) -> History:
        """With ``version`` in force: what was undone is forgotten, and nothing happens where it is in force already."""
        if version == self.current:
            return self
        versions = (*self.versions[: self.at + 1], version)
        if len(versions) > MOST_VERSIONS:
            versions = (versions[0], *versions[-(MOST_VERSIONS - 1) :])
        return History(versions, len(versions) - 1)

    def undone(self) -> History:
        """With the version before in force. Raises IndexError where there is none."""
        if not self.can_undo:
            raise IndexError("there is no older version")
        return replace(self, at=self.at - 1)

    def redone(self) -> History:
        """With the version after in force. Raises IndexError where there is none."""
        if not self.can_redo:
            raise IndexError("there is no newer version")
        return replace(self, at=self.at + 1)

    def at_first(self) -> History:
        """With the first version in force; all others can be redone."""
        return replace(self, at=0)
