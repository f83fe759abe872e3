"""``Idempotency-Key``: a POST repeated with the same key and body is answered as the first time, and done once."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from app.console.problems import Problem
from app.console.wire import encode

LONGEST_KEY = 255
#: The rule for keys as JSON Schema, for the OpenAPI description.
KEY_LIMITS = {"minLength": 1, "maxLength": LONGEST_KEY}
KEPT = 1000
KEPT_FOR_S = 24 * 3600.0


@dataclass(frozen=True, slots=True)
class Remembered:
    """The answer to a request: a hash of its body, its Location and body, and when it was given."""

    fingerprint: bytes
    location: str
    body: Any
    stamp: float


class IdempotencyStore:
    """The last thousand answers by key, each for a day."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._answers: OrderedDict[str, Remembered] = OrderedDict()

    def find(self, key: str | None, body: Any) -> Remembered | None:
        """The earlier answer, if there is one. Raises Problem for a bad key, or one used for another body."""
        if key is None:
            return None
        if not 0 < len(key) <= LONGEST_KEY:
            raise Problem(
                422,
                "invalid-idempotency-key",
                f"An Idempotency-Key has 1 to {LONGEST_KEY} characters.",
                errors=[("header.Idempotency-Key", f"must have 1 to {LONGEST_KEY} characters")],
            )
        found = self._answers.get(key)
        if found is None or self._now() - found.stamp > KEPT_FOR_S:
            return None
        if found.fingerprint != _fingerprint(body):
            raise Problem(
                422,
                "idempotency-key-reused",
                "This Idempotency-Key was used for another request; take a fresh one for each thing to be done.",
                errors=[("header.Idempotency-Key", "was used for another body")],
            )
        return found

    def remember(self, key: str | None, body: Any, location: str, answer: Any) -> None:
        """Keep ``answer`` for repetitions of ``body`` under ``key``."""
        if key is None:
            return
        self._answers[key] = Remembered(_fingerprint(body), location, answer, self._now())
        self._answers.move_to_end(key)
        while len(self._answers) > KEPT:
            self._answers.popitem(last=False)


def _fingerprint(body: Any) -> bytes:
    return hashlib.sha256(encode(body)).digest()
