"""Tours that several editors change: each change is kept at once, and can be undone since the program began.

Files that are changed by others meanwhile (in a text editor) are noticed, and are versions as well.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from app.base.errors import ConfigError
from app.tours.history import History, Version
from app.tours.library import MOST_TOURS, NoVersion, ShippedTour, TooManyTours, TourLibrary, TourTaken, UnknownTour
from app.tours.media import MediaLibrary
from app.tours.model import Tour


@dataclass(frozen=True, slots=True)
class KeptTour:
    """A tour as it is kept; ``shipped``: it is the program's own, as it came."""

    tour: Tour
    shipped: bool
    can_undo: bool
    can_redo: bool


class TourStore:
    """The tours in ``library``; ``media`` are their pictures and videos. Methods touch the disk; any thread may call.

    Methods that take a name raise UnknownTour, ValueError for one that cannot be an id, ConfigError for a damaged file
    and OSError. ``before`` is called with the version that is about to be changed: what it raises prevents the change.
    """

    def __init__(self, library: TourLibrary) -> None:
        self.library = library
        self.media = MediaLibrary(library.folders)
        self._lock = threading.Lock()
        self._histories: dict[str, History] = {}

    def names(self) -> list[str]:
        """The id of every tour, sorted."""
        return self.library.names()

    def get(self, name: str) -> KeptTour:
        """The tour ``name``."""
        with self._lock:
            return self._kept(name, self._synced(name))

    def create(self, tour: Tour) -> KeptTour:
        """Keep a new tour. Raises TourTaken where another has its id, and TooManyTours."""
        with self._lock:
            names = self.library.names()
            if tour.id in names:
                raise TourTaken(f"there is a tour {tour.id!r} already; give this one another id, or replace that one")
            if len(names) >= MOST_TOURS:
                raise TooManyTours(f"there are {MOST_TOURS} tours, the most that are kept; delete some first")
            return self._changed(tour.id, tour, _anything)

    def replace(self, tour: Tour, before: Callable[[Tour], None]) -> KeptTour:
        """Keep ``tour`` in place of the one of its id."""
        with self._lock:
            self.library.file(tour.id)
            return self._changed(tour.id, tour, before)

    def edit(self, name: str, change: Callable[[Tour], Tour]) -> KeptTour:
        """Keep what ``change`` makes of the tour ``name``; what it raises prevents that."""
        with self._lock:
            kept = self._kept(name, self._synced(name))
            return self._changed(name, change(kept.tour), _anything)

    def delete(self, name: str, before: Callable[[Tour], None]) -> None:
        """Delete the tour ``name``; where it hid one of the program's, that one is there again.

        Raises ShippedTour for the program's own.
        """
        with self._lock:
            self.library.file(name)
            if self.library.is_shipped(name):
                raise ShippedTour(f"the tour {name!r} came with the program and is not deleted; a copy of it can be")
            history = self._checked(name, before)
            self.library.delete(name)
            self._histories[name] = history.changed(self.library.shipped(name))

    def undo(self, name: str, before: Callable[[Tour], None], *, to_begin: bool = False) -> KeptTour | None:
        """Take the newest change of the tour ``name`` back, or all since the program began.

        None: there was no such tour before. Raises NoVersion where there is nothing to undo.
        """

        def back(history: History) -> History:
            if not history.can_undo:
                raise NoVersion(f"there is nothing to undo: {name} is as it was when the program began")
            return history.at_first() if to_begin else history.undone()

        return self._moved(name, before, back)

    def redo(self, name: str, before: Callable[[Tour], None]) -> KeptTour | None:
        """Do again what was undone last. None: that deletes it. Raises NoVersion where there is nothing to redo."""

        def forth(history: History) -> History:
            if not history.can_redo:
                raise NoVersion(f"there is nothing to redo: no change of {name} was undone since the last one")
            return history.redone()

        return self._moved(name, before, forth)

    def _moved(self, name: str, before: Callable[[Tour], None], step: Callable[[History], History]) -> KeptTour | None:
        with self._lock:
            if name not in self._histories:
                self.library.file(name)
            history = step(self._checked(name, before))
            self._put(name, history.current)
            self._histories[name] = history
            return None if history.current is None else self._kept(name, history)

    def _changed(self, name: str, tour: Tour, before: Callable[[Tour], None]) -> KeptTour:
        history = self._checked(name, before)
        self._put(name, tour)
        self._histories[name] = history.changed(tour)
        return self._kept(name, self._histories[name])

    def _checked(self, name: str, before: Callable[[Tour], None]) -> History:
        """The history of ``name``; ``before`` is asked where there is a version to be changed."""
        try:
            history = self._synced(name)
        except ConfigError:
            # A damaged file may be replaced and deleted; the versions before it are those there are.
            return self._histories.get(name, History((None,)))
        if history.current is not None:
            before(history.current)
        return history

    def _synced(self, name: str) -> History:
        """The history of ``name``, with what others made of its file."""
        version = self._read(name)
        known = self._histories.get(name)
        if known is None and version is None:
            return History((None,))  # names that are nothing's are not remembered
        self._histories[name] = History((version,)) if known is None else known.changed(version)
        return self._histories[name]

    def _read(self, name: str) -> Version:
        try:
            return self.library.read(name)
        except UnknownTour:
            return None

    def _put(self, name: str, version: Version) -> None:
        if version is None or version == self.library.shipped(name):
            self.library.delete(name)
        else:
            self.library.write(version)

    def _kept(self, name: str, history: History) -> KeptTour:
        if history.current is None:
            self.library.file(name)  # which says what there is
            raise UnknownTour(f"there is no tour {name!r}")
        return KeptTour(history.current, self.library.is_shipped(name), history.can_undo, history.can_redo)


def _anything(version: Tour) -> None:
    """Any version may be changed."""
