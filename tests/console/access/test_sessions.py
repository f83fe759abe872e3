"""Sessions: their beginning, use and end."""

from __future__ import annotations

from app.console.access.sessions import LASTS_S, MOST_SESSIONS, Sessions


class Now:
    """A clock that the test sets."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> float:
        return self.time


def test_a_session_lasts_while_it_is_used() -> None:
    now = Now()
    sessions = Sessions(now)
    name = sessions.begin()
    for _ in range(3):
        now.time += LASTS_S
        assert sessions.find(name) is not None
    now.time += LASTS_S + 1
    assert sessions.find(name) is None
    assert len(sessions) == 0


def test_an_open_connection_is_use() -> None:
    now = Now()
    sessions = Sessions(now)
    name = sessions.begin()
    session = sessions.find(name)
    assert session is not None
    release = session.hold(lambda: None)
    now.time += 3 * LASTS_S
    assert sessions.find(name) is session
    now.time += 3 * LASTS_S
    release()
    now.time += LASTS_S
    assert sessions.find(name) is session


def test_the_end_closes_what_is_open_once() -> None:
    sessions = Sessions(Now())
    name, closed = sessions.begin(), list[str]()
    session = sessions.find(name)
    assert session is not None
    session.hold(lambda: closed.append("one"))
    session.hold(lambda: closed.append("gone before"))()
    sessions.end(name)
    sessions.end(name)
    assert closed == ["one"]
    assert sessions.find(name) is None


def test_names_differ_and_are_not_kept() -> None:
    sessions = Sessions(Now())
    names = {sessions.begin() for _ in range(20)}
    assert len(names) == 20
    assert all(len(name) >= 40 for name in names)
    kept = repr(vars(sessions))
    assert not any(name in kept for name in names)


def test_what_is_no_name_finds_nothing() -> None:
    sessions = Sessions(Now())
    sessions.begin()
    for name in (None, "", "x", "\udcff", "é" * 10_000):
        assert sessions.find(name) is None
        sessions.end(name)


def test_there_are_so_many_and_the_one_unused_for_longest_gives_way() -> None:
    sessions = Sessions(Now())
    first, second = sessions.begin(), sessions.begin()
    closed = list[str]()
    session = sessions.find(second)
    assert session is not None
    session.hold(lambda: closed.append("second"))
    assert sessions.find(first) is not None
    for _ in range(MOST_SESSIONS - 1):
        sessions.begin()
    assert len(sessions) == MOST_SESSIONS
    assert closed == ["second"]
    assert sessions.find(first) is not None
