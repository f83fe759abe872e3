"""The parts of a task and how long each took."""

from __future__ import annotations

from types import ModuleType

import pytest


def test_parts_are_named_in_the_order_of_their_ends_and_the_same_one_adds_up(parts: ModuleType) -> None:
    task = parts.Parts()
    task.note("page", 3.4)
    task.note("kernels", 20.0)
    task.note("page", 2.0)
    assert str(task) == "page 5 s, kernels 20 s"


def test_a_part_that_fails_is_timed_too(parts: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    instants = iter([10.0, 17.0])
    monkeypatch.setattr(parts.time, "monotonic", lambda: next(instants))
    task = parts.Parts()
    with pytest.raises(OSError, match="lost"), task.timed("packages"):
        raise OSError("lost")
    monkeypatch.undo()
    assert str(task) == "packages 7 s"
