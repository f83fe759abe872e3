"""Undo and redo, as a list of versions with a mark in it."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from app.tours.history import MOST_VERSIONS, History, Version
from tests.tours.tours import tour

VERSIONS = [None, *(tour(title={"en": str(number)}) for number in range(4))]


class Editing(RuleBasedStateMachine):
    """Against two stacks."""

    def __init__(self) -> None:
        super().__init__()
        self.history = History((VERSIONS[0],))
        self.now: Version = VERSIONS[0]
        self.older: list[Version] = []
        self.newer: list[Version] = []

    @rule(version=st.sampled_from(VERSIONS))
    def change(self, version: Version) -> None:
        self.history = self.history.changed(version)
        if version != self.now:
            self.older.append(self.now)
            self.newer.clear()
            self.now = version

    @precondition(lambda self: self.older)
    @rule()
    def undo(self) -> None:
        self.history = self.history.undone()
        self.newer.append(self.now)
        self.now = self.older.pop()

    @precondition(lambda self: self.newer)
    @rule()
    def redo(self) -> None:
        self.history = self.history.redone()
        self.older.append(self.now)
        self.now = self.newer.pop()

    @invariant()
    def is_the_same(self) -> None:
        assert self.history.current == self.now
        assert (self.history.can_undo, self.history.can_redo) == (bool(self.older), bool(self.newer))


Editing.TestCase.settings = settings(max_examples=25)
TestEditing = Editing.TestCase


def test_there_is_an_end_in_both_directions() -> None:
    history = History((None,))
    with pytest.raises(IndexError):
        history.undone()
    with pytest.raises(IndexError):
        history.redone()


def test_the_first_version_is_never_forgotten() -> None:
    first, other = tour(), tour(title={"en": "Other"})
    history = History((first,))
    for number in range(MOST_VERSIONS):
        history = history.changed(other if number % 2 else tour(title={"en": str(number)}))
    assert len(history.versions) == MOST_VERSIONS
    assert history.current == other
    begin = history.at_first()
    assert begin.current == first
    assert begin.can_redo
    assert not begin.can_undo
