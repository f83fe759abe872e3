"""The file of episodic memory: SQLite. All functions touch the disk; for one thread at a time.

Each update is one transaction that is on the disk when it returns, so that a program killed at any moment leaves all
episodes that were closed before. What is deleted is overwritten in the file (``secure_delete``).
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import Any, Final

from app.base.named_library import data_folder
from app.memory.deeds import Deed
from app.memory.em_art import Episode, Event
from app.memory.kept import Kept, Update

FILE: Final = "memory.sqlite"
#: Version of the tables, in the file's ``user_version``.
VERSION: Final = 1
#: Text of one item, or of one desire's parameters, is not longer.
_LONGEST: Final = 10_000

_TABLES: Final = f"""
CREATE TABLE event (id INTEGER PRIMARY KEY, learning_rate REAL NOT NULL, used INTEGER NOT NULL) STRICT;
CREATE TABLE event_item (
    event INTEGER NOT NULL REFERENCES event ON DELETE CASCADE, channel TEXT NOT NULL, item TEXT NOT NULL,
    weight REAL NOT NULL CHECK (weight > 0 AND weight <= 1), PRIMARY KEY (event, channel, item)
) STRICT, WITHOUT ROWID;
CREATE TABLE episode (
    id INTEGER PRIMARY KEY, learning_rate REAL NOT NULL, vigilance REAL NOT NULL, times INTEGER NOT NULL,
    first REAL NOT NULL, last REAL NOT NULL
) STRICT;
CREATE TABLE episode_event (
    episode INTEGER NOT NULL REFERENCES episode ON DELETE CASCADE,
    event INTEGER NOT NULL REFERENCES event ON DELETE CASCADE,
    weight REAL NOT NULL CHECK (weight > 0 AND weight <= 1), PRIMARY KEY (episode, event)
) STRICT, WITHOUT ROWID;
CREATE TABLE deed (
    episode INTEGER NOT NULL REFERENCES episode ON DELETE CASCADE, key TEXT NOT NULL, class TEXT NOT NULL,
    params TEXT NOT NULL CHECK (length(params) <= {_LONGEST}),
    weight REAL NOT NULL CHECK (weight > 0 AND weight <= 1), PRIMARY KEY (episode, key)
) STRICT, WITHOUT ROWID;
PRAGMA user_version = {VERSION};
"""


class StoreUnreadable(Exception):
    """The file holds no memory that can be read; the message is one sentence, that says why."""


class StoreBusy(Exception):
    """Another program has the file open; the message is one sentence."""


class MemoryStore:
    """The file ``memory.sqlite`` in ``folder``, which is made when something is kept first, not before."""

    def __init__(self, folder: Path, *, keeps: bool = True) -> None:
        """``keeps``: whether anything is read or written at all; else all of it is forgotten with the program."""
        self.path = folder / FILE
        self._keeps = keeps
        self._connection: sqlite3.Connection | None = None

    def read(self) -> Kept:
        """All that is kept; nothing where there is no file. The file stays open, for this program alone.

        Raises StoreUnreadable for a file that is damaged, of another kind or of a newer program; StoreBusy; OSError.
        """
        if not self._keeps or not self.path.exists():
            return Kept()
        try:
            connection = self._open()
            (version,) = connection.execute("PRAGMA user_version").fetchone()
            if version != VERSION:
                self.close()
                made_by = "a newer program" if version > VERSION else "another program"
                raise StoreUnreadable(f"{self.path} is of {made_by}: its version is {version}, not {VERSION}")
            (fault,) = connection.execute("PRAGMA integrity_check(1)").fetchone()
            if fault != "ok":
                self.close()
                raise StoreUnreadable(f"{self.path} is damaged: {fault}")
            return _read(connection)
        except sqlite3.OperationalError as failure:
            self.close()
            raise self._operational(failure) from None
        except (sqlite3.DatabaseError, ValueError, TypeError) as failure:
            self.close()
            raise StoreUnreadable(f"{self.path} cannot be read: {failure}") from None

    def keep(self, update: Update) -> None:
        """Keep ``update``; it is on the disk when this returns, wholly or, if this raises, not at all.

        Raises StoreBusy; StoreUnreadable; OSError where the disk refuses.
        """
        if not self._keeps:
            return
        try:
            connection = self._open()
            with connection:
                connection.execute("BEGIN IMMEDIATE")
                _write(connection, update)
        except sqlite3.OperationalError as failure:
            raise self._operational(failure) from None
        except sqlite3.DatabaseError as failure:
            raise OSError(f"{self.path} cannot be written: {failure}") from None

    def set_aside(self) -> Path:
        """Rename the file, which then is out of use, and return where it is. Raises OSError."""
        self.close()
        number = 1
        while (aside := self.path.with_name(f"memory.unreadable-{number}.sqlite")).exists():
            number += 1
        for ending in ("-journal", "-wal", "-shm"):
            beside = self.path.with_name(self.path.name + ending)
            if beside.exists():
                os.replace(beside, aside.with_name(aside.name + ending))
        os.replace(self.path, aside)
        return aside

    def delete(self) -> bool:
        """Remove the file; whether there was one. Raises OSError."""
        self.close()
        if not self._keeps or not self.path.exists():
            return False
        for ending in ("", "-journal", "-wal", "-shm"):
            self.path.with_name(self.path.name + ending).unlink(missing_ok=True)
        return True

    def close(self) -> None:
        """Close the file."""
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.close()

    def _open(self) -> sqlite3.Connection:
        if self._connection is None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            # Calls come one at a time, each from a thread of the module's choice.
            connection = sqlite3.connect(self.path, timeout=0, isolation_level=None, check_same_thread=False)
            self._connection = connection
            for pragma in ("locking_mode = EXCLUSIVE", "synchronous = FULL", "secure_delete = ON", "foreign_keys = ON"):
                connection.execute(f"PRAGMA {pragma}")
            os.chmod(self.path, 0o600)
            with connection:
                connection.execute("BEGIN IMMEDIATE")  # the lock of the file, which then is kept
                with closing(connection.execute("SELECT count(*) FROM sqlite_schema")) as found:
                    (tables,) = found.fetchone()
                if tables == 0:
                    for statement in _TABLES.split(";\n"):
                        connection.execute(statement)
        return self._connection

    def _operational(self, failure: sqlite3.OperationalError) -> Exception:
        code = failure.sqlite_errorcode if hasattr(failure, "sqlite_errorcode") else None
        if code is not None and code & 0xFF in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            return StoreBusy(f"another program has {self.path} open")
        if code is not None and code & 0xFF == sqlite3.SQLITE_ERROR:
            return StoreUnreadable(f"{self.path} cannot be read: {failure}")
        return OSError(f"{self.path}: {failure}")


def default_folder() -> Path:
    """The folder in ``HBBA_MEMORY``, or ``hbba/memory`` in the user's data folder."""
    return data_folder("HBBA_MEMORY", "memory")


def _write(connection: sqlite3.Connection, update: Update) -> None:
    changes = update.changes
    connection.executemany("DELETE FROM episode WHERE id = ?", ((each,) for each in changes.episodes_gone))
    # Before what has changed: an event of the episode that was under way may be gone, and there again.
    connection.executemany("DELETE FROM event WHERE id = ?", ((each,) for each in changes.events_gone))
    for event in changes.events:
        connection.execute(
            "INSERT INTO event VALUES (?, ?, ?) ON CONFLICT (id) DO UPDATE SET learning_rate = excluded.learning_rate, "
            "used = excluded.used",
            (event.id, event.learning_rate, event.used),
        )
        connection.execute("DELETE FROM event_item WHERE event = ?", (event.id,))
        rows = [(event.id, channel, item, w) for channel, items in event.weights.items() for item, w in items.items()]
        connection.executemany("INSERT INTO event_item VALUES (?, ?, ?, ?)", rows)
    for episode in changes.episodes:
        connection.execute(
            "INSERT INTO episode VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (id) DO UPDATE SET "
            "learning_rate = excluded.learning_rate, vigilance = excluded.vigilance, times = excluded.times, "
            "last = excluded.last",
            (episode.id, episode.learning_rate, episode.vigilance, episode.times, episode.first, episode.last),
        )
        connection.execute("DELETE FROM episode_event WHERE episode = ?", (episode.id,))
        weights = [(episode.id, event, weight) for event, weight in episode.weights.items()]
        connection.executemany("INSERT INTO episode_event VALUES (?, ?, ?)", weights)
    for id_, deeds in update.deeds.items():
        connection.execute("DELETE FROM deed WHERE episode = ?", (id_,))
        kept = [(id_, each.key, each.cls, json.dumps(dict(each.params)), each.weight) for each in deeds]
        kept = [row for row in kept if len(row[3]) <= _LONGEST]
        connection.executemany("INSERT INTO deed VALUES (?, ?, ?, ?, ?)", kept)


def _read(connection: sqlite3.Connection) -> Kept:
    patterns: dict[int, dict[str, dict[str, float]]] = {}
    for event, channel, item, weight in connection.execute("SELECT * FROM event_item ORDER BY event, channel, item"):
        patterns.setdefault(event, {}).setdefault(channel, {})[item] = weight
    events = tuple(
        Event(id_, patterns.get(id_, {}), rate, used)
        for id_, rate, used in connection.execute("SELECT id, learning_rate, used FROM event ORDER BY id")
    )
    weights: dict[int, dict[int, float]] = {}
    for episode, event, weight in connection.execute("SELECT * FROM episode_event ORDER BY episode, event"):
        weights.setdefault(episode, {})[event] = weight
    rows: Iterable[tuple[Any, ...]] = connection.execute(
        "SELECT id, learning_rate, vigilance, times, first, last FROM episode ORDER BY id"
    )
    episodes = tuple(
        Episode(id_, weights.get(id_, {}), rate, vigilance, times, first=first, last=last)
        for id_, rate, vigilance, times, first, last in rows
    )
    deeds: dict[int, list[Deed]] = {}
    for episode, key, cls, params, weight in connection.execute("SELECT * FROM deed ORDER BY episode, key"):
        deeds.setdefault(episode, []).append(Deed(key, cls, _params(params), weight))
    return Kept(events, episodes, {episode: tuple(each) for episode, each in deeds.items()})


def _params(text: str) -> dict[str, Any]:
    value = json.loads(text)
    if not isinstance(value, dict):
        raise ValueError("parameters of a desire are no object")
    return value
