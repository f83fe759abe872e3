"""Checks of tokens and passwords: wrong ones are slowed, and their cost is bounded.

A password costs a fifth of a second of a core. So one is checked at a time, in a thread, and only few wait for that;
one that was right is known by a keyed hash from then on, so that a program may send it with each request.
"""

from __future__ import annotations

import asyncio
import hashlib
import math
import secrets
from collections import OrderedDict
from collections.abc import Callable

from app.console.access.credentials import Credentials
from app.console.access.login_attempts import Attempts
from app.console.access.roles import Role
from app.console.problems import Problem

MOST_WAITING = 8
MOST_KNOWN = 64


class LoginCheck:
    """The role that a secret opens; ``now`` gives seconds of any steady clock."""

    def __init__(self, credentials: Credentials, now: Callable[[], float]) -> None:
        self._credentials = credentials
        self._attempts = Attempts(now)
        self._turn = asyncio.Lock()
        self._waiting = 0
        self._key = secrets.token_bytes(32)
        #: Keyed hashes of passwords that were right, the newest last.
        self._known: OrderedDict[bytes, Role] = OrderedDict()

    async def role_of(self, secret: str, address: str) -> Role:
        """The role that ``secret``, which came from ``address``, opens. Raises Problem for a wrong one, or too many."""
        self._refuse_early(address)
        if self._credentials.is_token(secret):
            return Role.SUPERVISOR
        role = self._remembered(secret) if self._credentials.passwords else None
        if role is None and self._credentials.passwords:
            role = await self._derived(secret, address)
        if role is None:
            self._attempts.failed(address)
            if self._credentials.passwords:
                raise Problem(401, "wrong-token", "This opens nothing: it is neither the token nor a role's password.")
            raise Problem(401, "wrong-token", "This is not the token; it was printed when the console was started.")
        return role

    async def _derived(self, secret: str, address: str) -> Role | None:
        if self._waiting >= MOST_WAITING:
            detail = "Many passwords are being checked: try again in a moment."
            raise Problem(503, "busy-with-logins", detail, headers={"Retry-After": "2"})
        self._waiting += 1
        try:
            async with self._turn:
                # Others of this address may have been wrong while this one waited.
                self._refuse_early(address)
                role = self._remembered(secret) or await asyncio.to_thread(self._credentials.role_of_password, secret)
                if role is not None:
                    self._known[self._hashed(secret)] = role
                    while len(self._known) > MOST_KNOWN:
                        self._known.popitem(last=False)
                return role
        finally:
            self._waiting -= 1

    def _remembered(self, secret: str) -> Role | None:
        return self._known.get(self._hashed(secret))

    def _hashed(self, secret: str) -> bytes:
        return hashlib.blake2b(secret.encode(errors="surrogatepass"), key=self._key).digest()

    def _refuse_early(self, address: str) -> None:
        if (wait_s := self._attempts.wait_s(address)) > 0:
            seconds = math.ceil(wait_s)
            raise Problem(
                429,
                "too-many-attempts",
                f"Too many wrong tokens came from {address}: try again in {seconds} s.",
                headers={"Retry-After": str(seconds)},
            )
