"""Tables, CSV and the picture of the tour experiment."""

from __future__ import annotations

import csv
from pathlib import Path

import cv2
import pytest

from app.base.errors import ConfigError
from app.experiments.tour.report import COLUMNS, plot, problems, runs_table, summary_table, table_csv
from app.messages import Place
from tests.experiments.tour.runs import good
from tests.maps.grids import room


def test_each_run_has_a_line_and_each_problem() -> None:
    results = [good(), good(seed=2, touched=1)]
    assert "| 2 | 2.0 | 12 | 2/2 | 0.20 | 0.10 | 1/1 | 3.5 | 6.0 | 5.0 | 1 |" in runs_table(results)
    assert "| runs without a problem | 1 |" in summary_table(results)
    assert problems(results) == ["seed 2: touched something 1 times"]
    lines = list(csv.reader(table_csv(results).splitlines()))
    assert tuple(lines[0]) == COLUMNS
    assert [line[0] for line in lines[1:]] == ["1", "2"]


def test_the_ways_are_drawn(tmp_path: Path) -> None:
    file = tmp_path / "ways.png"
    plot(good(), room(), [Place("one", "One", 0.5, 0.5, 0.0)], file)
    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.std() > 5
    with pytest.raises(ConfigError, match="cannot be written"):
        plot(good(), room(), [], tmp_path / "no-folder" / "ways.png")
