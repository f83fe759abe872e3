"""Observers: order, removal, and the one policy for an observer that fails."""

from __future__ import annotations

import logging
from collections.abc import Callable

import pytest

from app.base.observers import MOST_FAILURES, Observers


def test_observers_are_called_in_order_until_they_are_removed() -> None:
    observers: Observers[[int, str]] = Observers("a test")
    seen: list[tuple[str, int, str]] = []
    remove = observers.add(lambda number, text: seen.append(("first", number, text)))
    observers.add(lambda number, text: seen.append(("second", number, text)))

    observers.notify(1, "a")
    remove()
    remove()
    observers.notify(2, "b")

    assert seen == [("first", 1, "a"), ("second", 1, "a"), ("second", 2, "b")]


def test_an_observer_that_fails_once_is_logged_and_goes_on_as_the_others_do(caplog: pytest.LogCaptureFixture) -> None:
    observers: Observers[[int]] = Observers("a test")
    taken: list[int] = []
    seen: list[int] = []

    def fails_at_one(number: int) -> None:
        if number == 1:
            raise RuntimeError(f"cannot take {number}")
        taken.append(number)

    observers.add(fails_at_one)
    observers.add(seen.append)
    with caplog.at_level(logging.ERROR):
        for number in (1, 2, 3):
            observers.notify(number)

    assert taken == [2, 3]
    assert seen == [1, 2, 3]
    [record] = caplog.records
    assert record.getMessage().startswith("an observer of a test failed and goes on")
    assert record.exc_info is not None
    assert "cannot take 1" in str(record.exc_info[1])


def test_an_observer_that_always_fails_is_removed(caplog: pytest.LogCaptureFixture) -> None:
    observers: Observers[[]] = Observers("a test")

    def fails() -> None:
        raise RuntimeError("always")

    observers.add(fails)
    with caplog.at_level(logging.ERROR):
        for _ in range(2 * MOST_FAILURES):
            observers.notify()

    assert not observers
    assert len(caplog.records) == MOST_FAILURES
    assert "is removed" in caplog.records[-1].getMessage()


def test_an_observer_that_causes_its_own_event_by_failing_ends() -> None:
    observers: Observers[[]] = Observers("log lines")

    def fails() -> None:
        raise RuntimeError("always")

    class Again(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            observers.notify()

    handler = Again()
    logging.getLogger("hbba.observers").addHandler(handler)
    try:
        observers.add(fails)
        observers.notify()
    finally:
        logging.getLogger("hbba.observers").removeHandler(handler)
    assert not observers


def test_what_an_observer_raises_on_purpose_to_end_the_program_passes() -> None:
    observers: Observers[[]] = Observers("a test")

    def interrupted() -> None:
        raise KeyboardInterrupt

    observers.add(interrupted)
    with pytest.raises(KeyboardInterrupt):
        observers.notify()


def test_the_same_callback_twice_is_two_observers() -> None:
    observers: Observers[[int]] = Observers("a test")
    seen: list[int] = []
    first, _second = observers.add(seen.append), observers.add(seen.append)

    observers.notify(1)
    first()
    observers.notify(2)

    assert seen == [1, 1, 2]


def test_observers_may_be_added_and_removed_while_they_are_called() -> None:
    observers: Observers[[]] = Observers("a test")
    called: list[str] = []
    removals: list[Callable[[], None]] = []

    def first() -> None:
        called.append("first")
        observers.add(lambda: called.append("third"))
        removals[0]()

    observers.add(first)
    removals.append(observers.add(lambda: called.append("second")))

    observers.notify()

    assert called == ["first"], "the second was removed, the third came later"


def test_they_are_true_while_there_are_any() -> None:
    observers: Observers[[]] = Observers("a test")
    assert not observers
    observers.add(lambda: None)
    assert observers
    observers.clear()
    assert not observers
