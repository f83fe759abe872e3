"""The key by which phones of a tour's visitors get in: another with each run, good for nothing but their own page."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable

from app.console.access.rate_limit import RateLimit
from app.console.access.sessions import LoginSession, Sessions
from app.console.problems import Problem

#: A name in front of a console may hide the phones of a whole school class behind one address.
ENTRIES_AT_ONCE, ENTRIES_PER_S = 40, 1.0


class VisitorKeys:
    """The key of this run, and the sessions of those who came with it; ``now`` gives seconds of any steady clock."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._sessions = Sessions(now)
        self._entries = RateLimit(now, burst=ENTRIES_AT_ONCE, per_s=ENTRIES_PER_S)
        self._key: str | None = None

    @property
    def key(self) -> str | None:
        """128 random bits; None: no visitor gets in now."""
        return self._key

    def renew(self) -> None:
        """Another run: the former key opens nothing any more, and its sessions end with their connections."""
        self.revoke()
        self._key = secrets.token_urlsafe(16)

    def revoke(self) -> None:
        """No visitor gets in before :meth:`renew`."""
        self._key = None
        self._sessions.end_all()

    def enter(self, key: str, origin: str) -> str:
        """Begin a session from the network address ``origin``; returns its name, for a cookie. Raises Problem."""
        # All addresses guess at the same 128 bits: only the cost of a try has to be bounded.
        self._entries.take(origin)
        known = self._key
        if known is None or not hmac.compare_digest(known.encode(), key.encode(errors="surrogatepass")):
            detail = "This link is of a tour that is over: scan the code on the robot once more."
            raise Problem(401, "wrong-key", detail)
        return self._sessions.begin()

    def find(self, name: str | None) -> LoginSession | None:
        """The session of this name, which counts as used from now; None where there is none, or not any more."""
        return self._sessions.find(name)
