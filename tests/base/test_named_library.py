"""A folder of named entries: valid names, paths, what is listed, and where the folder is by default."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.named_library import NAME, NamedLibrary, data_folder


class Notes(NamedLibrary):
    kind = "note"
    suffix = ".txt"


@given(name=st.from_regex(NAME, fullmatch=True))
def test_a_valid_name_stays_in_the_folder(name: str) -> None:
    path = Notes(Path("folder")).path(name)
    assert path.parent == Path("folder")
    assert path.name == f"{name}.txt"


@pytest.mark.parametrize("name", ["", "../walk", "a/b", ".hidden", "-x", "a b", "é", "x" * 101])
def test_another_name_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="a note's name has 1 to 100 letters"):
        Notes(Path("folder")).path(name)


def test_entries_are_those_with_a_valid_name_and_the_ending(tmp_path: Path) -> None:
    for name in ("a.txt", "b.txt", ".hidden.txt", "c.md", "d e.txt"):
        (tmp_path / name).touch()
    assert sorted(Notes(tmp_path).entries()) == [("a", tmp_path / "a.txt"), ("b", tmp_path / "b.txt")]


def test_a_folder_that_is_not_there_has_no_entries(tmp_path: Path) -> None:
    assert list(Notes(tmp_path / "not" / "yet").entries()) == []


def test_the_folder_is_the_one_of_the_variable_or_in_the_user_s_data(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", "/data")
    monkeypatch.setenv("HBBA_NOTES", "/somewhere")
    assert data_folder("HBBA_NOTES", "notes") == Path("/somewhere")
    monkeypatch.delenv("HBBA_NOTES")
    assert data_folder("HBBA_NOTES", "notes") == Path("/data/hbba/notes")
