"""The key of a run: who has it gets in, until another run has another."""

from __future__ import annotations

import pytest

from app.console.access.visitor_keys import ENTRIES_AT_ONCE, VisitorKeys
from app.console.problems import Problem


def refused(keys: VisitorKeys, key: str) -> int:
    """The status of the refusal."""
    with pytest.raises(Problem) as refusal:
        keys.enter(key, "192.0.2.1")
    return refusal.value.status


def test_without_a_run_nobody_gets_in() -> None:
    keys = VisitorKeys(lambda: 0.0)
    assert keys.key is None
    assert refused(keys, "") == 401
    assert refused(keys, "None") == 401


def test_another_run_has_another_key_and_ends_the_sessions_of_the_former() -> None:
    keys = VisitorKeys(lambda: 0.0)
    keys.renew()
    first = keys.key
    assert first is not None
    assert len(first) >= 22, "128 random bits"
    name = keys.enter(first, "192.0.2.1")
    session = keys.find(name)
    assert session is not None
    closed: list[str] = []
    session.hold(lambda: closed.append("closed"))
    keys.renew()
    assert closed == ["closed"]
    assert keys.find(name) is None
    assert keys.key not in (None, first)
    assert refused(keys, first) == 401
    assert refused(keys, "ü\ud800") == 401


def test_entering_is_bounded_by_address() -> None:
    keys = VisitorKeys(lambda: 0.0)
    keys.renew()
    assert keys.key is not None
    for _ in range(ENTRIES_AT_ONCE):
        keys.enter(keys.key, "192.0.2.1")
    assert refused(keys, keys.key) == 429
    assert keys.enter(keys.key, "192.0.2.2")
