"""Goals are driven on the map of the program that is tried, also after the tour that made it was broken off."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from app.experiments.goals import experiment
from app.experiments.goals.goal_run import MAP
from app.experiments.results_store import ResultsStore


class Kept:
    """No results; those there were are of another program if ``moved``."""

    def __init__(self, folder: Path, *, moved: bool) -> None:
        self.file, self.moved = folder / "results.jsonl", "results.old.jsonl" if moved else ""
        self.found: list[dict[str, Any]] = []


class BrokenOff(Exception):
    """The tour was broken off."""


def test_a_tour_that_is_broken_off_leaves_no_map_of_another_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    toured = []

    def series(*_: object) -> Iterator[tuple[object, str]]:
        toured.append(1)
        raise BrokenOff

    monkeypatch.setattr(experiment, "TrialSeries", series)
    (tmp_path / "maps" / MAP).mkdir(parents=True)
    (tmp_path / "maps" / MAP / "map.yaml").write_text("another program's")
    for start, moved in enumerate((True, False)):
        kept = cast(ResultsStore, Kept(tmp_path, moved=moved))
        with pytest.raises(BrokenOff):
            experiment.run(experiment.plan(1), kept, lambda *_: None, lambda _: None)
        assert len(toured) == start + 1
        assert not (tmp_path / "maps" / MAP).exists()
