"""Names of recordings: safe, unique, and in the order of their time."""

from __future__ import annotations

import time
from itertools import islice
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.named_library import NAME
from app.logs.library import RecordingLibrary, default_name


def candidates(name: str, at: float = 0.0, count: int = 4) -> list[str]:
    return [path.stem for path in islice(RecordingLibrary(Path("folder")).candidates(name, at), count)]


def test_a_name_then_the_same_with_numbers() -> None:
    assert candidates("walk", count=3) == ["walk", "walk-2", "walk-3"]


def test_without_a_name_it_is_the_local_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TZ", "EST+5")
    time.tzset()
    try:
        assert candidates("", 1_790_000_000.5, 2) == ["2026-09-21_09-13-20", "2026-09-21_09-13-20-2"]
    finally:
        monkeypatch.undo()
        time.tzset()


@pytest.mark.parametrize("name", ["../walk", "a/b", ".hidden", "-x", "a b", "é", "x" * 101])
def test_a_name_that_could_leave_the_folder_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="a recording's name has"):
        candidates(name)


@given(name=st.from_regex(NAME, fullmatch=True))
def test_every_candidate_is_a_name_that_may_be_and_another(name: str) -> None:
    found = candidates(name, count=12)
    assert len(set(found)) == 12
    assert all(NAME.fullmatch(each) for each in found)


@given(first=st.integers(0, 4_000_000_000), later=st.integers(2 * 86_400, 4_000_000_000))
def test_names_made_of_the_time_sort_by_it(first: int, later: int) -> None:
    assert default_name(first) < default_name(first + later)


def test_free_room_is_known_before_the_folder_exists(tmp_path: Path) -> None:
    assert RecordingLibrary(tmp_path / "not" / "yet").free_bytes() > 0


def test_rings_are_hidden_in_the_folder() -> None:
    library = RecordingLibrary(Path("folder"))
    assert library.ring_folder.parent == library.folder
    assert not NAME.fullmatch(library.ring_folder.name)
