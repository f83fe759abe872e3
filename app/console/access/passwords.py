"""Passwords at rest: Argon2id (RFC 9106) in its usual form, ``$argon2id$v=19$m=65536,t=3,p=4$SALT$HASH``.

A try costs 64 MB and some 0.1 s, so that a stolen file is slow to search. Checking blocks: for a worker thread.
"""

from __future__ import annotations

from dataclasses import dataclass

from argon2 import PasswordHasher, Type, extract_parameters
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.profiles import RFC_9106_LOW_MEMORY

SHORTEST = 8
LONGEST = 512
#: What RFC 9106 advises where memory is short: 64 MB, 3 passes, 4 lanes.
COST = PasswordHasher.from_parameters(RFC_9106_LOW_MEMORY)
#: More would take the computer's memory (KiB) and time at each login.
MOST_MEMORY_KIB, MOST_PASSES, MOST_LANES = 1_048_576, 16, 16
_PREFIX = "$argon2id$"


@dataclass(frozen=True, slots=True)
class PasswordHash:
    """The hash of one password, as its ``line``, which has its salt and cost."""

    line: str

    def __str__(self) -> str:
        return self.line

    def matches(self, password: str) -> bool:
        """Whether it is of ``password``. Blocks for as long as its cost says."""
        try:
            # Of what no password can be, as of a wrong one, there is a hash.
            return COST.verify(self.line, password.encode(errors="surrogatepass"))
        except VerificationError:
            return False


def hash_of(password: str, hasher: PasswordHasher = COST) -> PasswordHash:
    """The hash of ``password`` with a new salt. Blocks. Raises ValueError for one that is too short or too long."""
    if not SHORTEST <= len(password) <= LONGEST or not password.isprintable():
        raise ValueError(f"a password has {SHORTEST} to {LONGEST} characters, in one line")
    return PasswordHash(hasher.hash(password))


def parsed(text: str) -> PasswordHash:
    """The hash that ``text`` writes. Raises ValueError saying what is wrong."""
    line = text.strip()
    if not line.startswith(_PREFIX):
        raise ValueError("is no hash of a password: write the line that `hbba password` prints")
    try:
        cost = extract_parameters(line)
    except (InvalidHashError, ValueError):
        raise ValueError("is cut off: write the whole line that `hbba password` prints") from None
    if cost.type is not Type.ID or cost.salt_len < 8 or cost.hash_len < 16:
        raise ValueError("is cut off: write the whole line that `hbba password` prints")
    if cost.memory_cost > MOST_MEMORY_KIB or cost.time_cost > MOST_PASSES or cost.parallelism > MOST_LANES:
        raise ValueError(f"costs too much to check: m is at most {MOST_MEMORY_KIB}, t {MOST_PASSES} and p {MOST_LANES}")
    return PasswordHash(line)
