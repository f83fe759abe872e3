"""Answers remembered by key."""

from __future__ import annotations

import pytest

from app.console.problems import Problem
from app.console.rest.idempotency import KEPT, KEPT_FOR_S, IdempotencyStore


def test_answers_are_kept_by_key_for_a_day_and_the_last_thousand() -> None:
    now = [0.0]
    store = IdempotencyStore(lambda: now[0])
    store.remember("first", {"a": 1}, "/1", "one")
    found = store.find("first", {"a": 1})
    assert found is not None
    assert (found.location, found.body) == ("/1", "one")
    with pytest.raises(Problem, match="another request"):
        store.find("first", {"a": 2})
    now[0] = KEPT_FOR_S + 1
    assert store.find("first", {"a": 2}) is None
    for number in range(KEPT + 1):
        store.remember(str(number), number, "/", number)
    assert store.find("0", 0) is None
    assert store.find("1", 1) is not None
    assert store.find(None, 1) is None


@pytest.mark.parametrize("key", ["", "x" * 256])
def test_a_key_that_cannot_be_is_refused(key: str) -> None:
    with pytest.raises(Problem, match="1 to 255"):
        IdempotencyStore(lambda: 0.0).find(key, {})
