"""Tours on the disk: kept wholly or not at all, those of the program unharmed, every change undone."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.tours.library import MOST_TOURS, NoVersion, ShippedTour, TooManyTours, TourLibrary, TourTaken, UnknownTour
from app.tours.model import Tour
from app.tours.store import TourStore
from app.tours.tour_file import tour_text
from tests.tours.tours import tour

A, B = tour(title={"en": "A"}), tour(title={"en": "B"})


class Unwanted(Exception):
    """Another version was expected."""


def only(expected: Tour) -> Callable[[Tour], None]:
    """Lets that version alone be changed."""

    def before(version: Tour) -> None:
        if version != expected:
            raise Unwanted

    return before


def anything(version: Tour) -> None:
    """Lets any version be changed."""


@pytest.fixture
def store(tmp_path: Path) -> TourStore:
    return TourStore(TourLibrary(tmp_path / "own", tmp_path / "shipped"))


@pytest.fixture
def shipped(tmp_path: Path) -> Tour:
    """A tour that comes with the program."""
    (tmp_path / "shipped").mkdir()
    (tmp_path / "shipped" / "lab-tour.yaml").write_text(tour_text(tour()), encoding="utf-8")
    return tour()


def test_a_tour_from_its_making_to_its_deletion(store: TourStore, tmp_path: Path) -> None:
    assert store.names() == []
    made = store.create(A)
    assert (made.tour, made.shipped, made.can_undo, made.can_redo) == (A, False, True, False)
    assert (tmp_path / "own" / "lab-tour.yaml").read_text(encoding="utf-8") == tour_text(A)
    with pytest.raises(TourTaken, match="there is a tour 'lab-tour' already"):
        store.create(B)
    assert store.replace(B, anything).tour == B
    assert store.edit("lab-tour", lambda found: found.model_copy(update={"title": {"en": "C"}})).tour.title["en"] == "C"
    assert store.names() == ["lab-tour"]
    store.delete("lab-tour", anything)
    assert store.names() == []
    assert os.listdir(tmp_path / "own") == []
    with pytest.raises(UnknownTour, match="there is no tour 'lab-tour'; there are: none"):
        store.get("lab-tour")


def test_what_does_not_exist_is_not_changed(store: TourStore) -> None:
    for change in (
        lambda: store.get("x"),
        lambda: store.replace(A, anything),
        lambda: store.edit("x", lambda found: found),
        lambda: store.delete("x", anything),
        lambda: store.undo("x", anything),
        lambda: store.redo("x", anything),
    ):
        with pytest.raises(UnknownTour):
            change()
    with pytest.raises(ValueError, match="a tour's name has"):
        store.get("../x")


def test_the_second_of_two_editors_is_refused(store: TourStore) -> None:
    store.create(A)
    store.replace(B, only(A))
    for change in (
        lambda: store.replace(A, only(A)),
        lambda: store.delete("lab-tour", only(A)),
        lambda: store.undo("lab-tour", only(A)),
    ):
        with pytest.raises(Unwanted):
            change()
        assert store.get("lab-tour").tour == B


def test_every_change_is_undone_to_the_begin_of_the_session(store: TourStore) -> None:
    store.library.write(A)
    first = store.get("lab-tour")
    assert not first.can_undo
    store.replace(B, anything)
    store.delete("lab-tour", anything)
    back = store.undo("lab-tour", anything)
    assert back is not None
    assert (back.tour, back.can_undo, back.can_redo) == (B, True, True)
    assert store.undo("lab-tour", only(B), to_begin=True) == type(first)(A, False, False, True)
    with pytest.raises(NoVersion, match="nothing to undo"):
        store.undo("lab-tour", anything)
    redone = store.redo("lab-tour", anything)
    assert redone is not None
    assert redone.tour == B
    assert store.redo("lab-tour", anything) is None, "it was deleted"
    assert store.names() == []
    with pytest.raises(NoVersion, match="nothing to redo"):
        store.redo("lab-tour", anything)


def test_to_undo_the_making_of_a_tour_is_to_delete_it(store: TourStore) -> None:
    store.create(A)
    assert store.undo("lab-tour", anything) is None
    assert store.names() == []
    redone = store.redo("lab-tour", anything)
    assert redone is not None
    assert redone.tour == A


def test_a_change_in_a_text_editor_is_a_version_too(store: TourStore) -> None:
    store.create(A)
    store.library.write(B)
    with pytest.raises(Unwanted):
        store.replace(tour(), only(A))
    assert store.get("lab-tour").tour == B
    undone = store.undo("lab-tour", anything)
    assert undone is not None
    assert undone.tour == A


def test_the_programs_own_tour_is_copied_when_it_is_changed(store: TourStore, shipped: Tour, tmp_path: Path) -> None:
    assert store.names() == ["lab-tour"]
    assert store.get("lab-tour").shipped
    with pytest.raises(ShippedTour):
        store.delete("lab-tour", anything)
    with pytest.raises(TourTaken):
        store.create(A)
    assert not store.replace(A, only(shipped)).shipped
    assert (tmp_path / "shipped" / "lab-tour.yaml").read_text(encoding="utf-8") == tour_text(shipped)
    undone = store.undo("lab-tour", anything)
    assert undone is not None
    assert (undone.tour, undone.shipped) == (shipped, True)
    store.replace(A, anything)
    store.delete("lab-tour", anything)
    again = store.get("lab-tour")
    assert (again.tour, again.shipped, again.can_undo) == (shipped, True, True)


def test_a_damaged_file_is_named_and_may_be_replaced(store: TourStore, tmp_path: Path) -> None:
    store.create(A)
    (tmp_path / "own" / "lab-tour.yaml").write_text("format: 1\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"lab-tour.yaml:1: id: is missing"):
        store.get("lab-tour")
    assert store.replace(B, only(A)).tour == B
    (tmp_path / "own" / "lab-tour.yaml").write_text(tour_text(A).replace("lab-tour", "other"), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"id: should be 'lab-tour', as the file is called, not 'other'"):
        store.get("lab-tour")
    store.delete("lab-tour", anything)
    assert store.names() == []


def test_a_file_is_written_wholly_or_not_at_all(
    store: TourStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store.create(A)

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="No space"):
            store.replace(B, anything)
    assert os.listdir(tmp_path / "own") == ["lab-tour.yaml"]
    assert (store.get("lab-tour").tour, store.get("lab-tour").can_redo) == (A, False)


def test_there_is_an_end_to_the_number_of_tours(store: TourStore, tmp_path: Path) -> None:
    (tmp_path / "own").mkdir()
    for number in range(MOST_TOURS):
        (tmp_path / "own" / f"{number}.yaml").touch()
    with pytest.raises(TooManyTours, match=f"there are {MOST_TOURS} tours"):
        store.create(A)
