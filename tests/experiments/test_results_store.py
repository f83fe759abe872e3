"""Results kept line by line: a broken run goes on, results of something else are moved aside, never lost."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.experiments.results_store import ResultsStore, default_folder

OF = {"experiment": "a test", "seed": 1}


def test_what_was_added_is_found_again(tmp_path: Path) -> None:
    kept = ResultsStore(tmp_path / "deep" / "er", OF)
    assert kept.found == []
    kept.add({"world": "1"})
    kept.add({"world": "2"})
    again = ResultsStore(tmp_path / "deep" / "er", OF)
    assert again.found == [{"world": "1"}, {"world": "2"}]
    assert not again.moved


def test_a_line_cut_off_by_a_crash_is_dropped_and_the_next_one_whole(tmp_path: Path) -> None:
    kept = ResultsStore(tmp_path, OF)
    kept.add({"world": "1"})
    with kept.file.open("a") as lines:
        lines.write('{"world": "2", "outc')
    again = ResultsStore(tmp_path, OF)
    assert again.found == [{"world": "1"}]
    again.add({"world": "3"})
    assert ResultsStore(tmp_path, OF).found == [{"world": "1"}, {"world": "3"}]


@pytest.mark.parametrize("how", ["of something else", "fresh", "damaged"])
def test_other_results_are_moved_aside(tmp_path: Path, how: str) -> None:
    kept = ResultsStore(tmp_path, OF)
    kept.add({"world": "1"})
    if how == "damaged":
        kept.file.write_text("no json\n")
    before = kept.file.read_text()
    again = ResultsStore(tmp_path, OF | {"seed": 2} if how == "of something else" else OF, fresh=how == "fresh")
    assert again.found == []
    assert Path(again.moved).read_text() == before
    assert json.loads(again.file.read_text())["of"] == OF | {"seed": 2 if how == "of something else" else 1}


def test_a_folder_that_cannot_be_is_said_in_words(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be used for results"):
        ResultsStore(tmp_path / "file", OF)


def test_the_folder_is_the_users_or_the_one_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HBBA_EXPERIMENTS", str(tmp_path))
    assert default_folder("barn") == tmp_path / "barn"
    monkeypatch.delenv("HBBA_EXPERIMENTS")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert default_folder("barn") == tmp_path / "hbba" / "experiments" / "barn"
