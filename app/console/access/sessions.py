"""Sessions of people who have logged in, under random names of which the program keeps only a hash."""

from __future__ import annotations

import hashlib
import secrets
from collections import OrderedDict
from collections.abc import Callable

from app.console.access.roles import Role

#: A session without a request for so long (s) ends; an open WebSocket counts as a request.
LASTS_S = 12 * 3600.0
#: Of more, the least recently used is ended.
MOST_SESSIONS = 200


class LoginSession:
    """One login. ``used`` is when it was last shown (``now``: the clock of :class:`Sessions`).

    ``role`` is None for one that is no operator's, as a visitor's; ``key`` differs from that of any other.
    """

    def __init__(self, now: Callable[[], float], role: Role | None = None) -> None:
        self.used = now()
        self.role = role
        self.key = secrets.token_hex(8)
        self._now = now
        self._held: dict[object, Callable[[], None]] = {}

    @property
    def held(self) -> bool:
        return bool(self._held)

    @property
    def connections(self) -> int:
        """How many are open."""
        return len(self._held)

    def hold(self, end: Callable[[], None]) -> Callable[[], None]:
        """A connection of it opens, which ``end`` closes when the session ends; returns what notes that it closed."""
        key = object()
        self._held[key] = end

        def release() -> None:
            self._held.pop(key, None)
            self.used = self._now()

        return release

    def close(self) -> None:
        held, self._held = self._held, {}
        for end in held.values():
            end()


class Sessions:
    """All sessions; ``now`` gives seconds of any steady clock."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._sessions: OrderedDict[bytes, LoginSession] = OrderedDict()

    def __len__(self) -> int:
        return len(self._sessions)

    def begin(self, role: Role | None = None) -> str:
        """A new session of ``role``; returns its name, which only the browser that logged in is given."""
        name = secrets.token_urlsafe(32)
        self._sessions[_key(name)] = LoginSession(self._now, role)
        while len(self._sessions) > MOST_SESSIONS:
            self._sessions.popitem(last=False)[1].close()
        return name

    def find(self, name: str | None) -> LoginSession | None:
        """The session of this name, which counts as used from now; None where there is none, or not any more."""
        if not name:
            return None
        key, now = _key(name), self._now()
        session = self._sessions.get(key)
        if session is None:
            return None
        if now - session.used > LASTS_S and not session.held:
            del self._sessions[key]
            return None
        session.used = now
        self._sessions.move_to_end(key)
        return session

    def end(self, name: str | None) -> None:
        """End the session of this name, and every connection of it."""
        session = self._sessions.pop(_key(name), None) if name else None
        if session is not None:
            session.close()

    def end_all(self) -> None:
        """End all sessions, and every connection of them."""
        ended, self._sessions = self._sessions, OrderedDict()
        for session in ended.values():
            session.close()


def _key(name: str) -> bytes:
    # A name has 256 random bits: a plain hash cannot be searched.
    return hashlib.sha256(name.encode("utf-8", "surrogateescape")).digest()
