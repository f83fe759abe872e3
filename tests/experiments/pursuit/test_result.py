"""Results of the study are grouped by operator and condition, and a person's file is read beside them."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import pytest

from app.base.errors import ConfigError
from app.experiments.pursuit.report import COLUMNS, plot, table_csv, tables
from app.experiments.pursuit.result import Condition, PursuitResult, results_of, summaries

FOLLOW = Condition("follow", 2, 300.0, 50.0, prediction=True)
RUN = PursuitResult(
    FOLLOW, seed=4, course="office", ended=True, time_s=80.0, driven_m=20.0, contacts=1, monitor_stops=2, limited=0.1,
    distance_m=1.5, distance_p95_m=2.5, visible=0.9, trace=((1.0, 2.0),),
)  # fmt: skip
COURSE = replace(
    RUN, condition=replace(FOLLOW, task="course", mode=1), distance_m=None, distance_p95_m=None, visible=None
)
QUICK = replace(COURSE, condition=replace(COURSE.condition, delay_ms=0.0, jitter_ms=0.0), time_s=60.0)


def test_runs_of_a_condition_are_joined() -> None:
    (found,) = summaries([RUN, replace(RUN, seed=5, time_s=120.0, distance_m=2.5, distance_p95_m=4.0, ended=False)])
    assert (found.runs, found.ended, found.contacts, found.monitor_stops) == (2, 1, 2, 4)
    assert found.speed_mps == pytest.approx(40.0 / 200.0)
    assert (found.distance_m, found.distance_p95_m) == (2.0, 4.0)
    assert found.speed_share is None


def test_the_speed_on_a_course_is_compared_with_the_same_operators_without_delay() -> None:
    shares = {each.condition.delay_ms: each.speed_share for each in summaries([COURSE, QUICK])}
    assert shares == {0.0: 1.0, 300.0: 0.75}
    other = replace(QUICK, seed=5)
    assert {each.condition.delay_ms: each.speed_share for each in summaries([COURSE, other])}[300.0] is None
    stopped = replace(COURSE, ended=False)
    assert {each.condition.delay_ms: each.speed_share for each in summaries([stopped, QUICK])}[300.0] is None


def test_a_persons_runs_are_read_and_shown_apart(tmp_path: Path) -> None:
    file = tmp_path / "person.json"
    mine = replace(RUN, operator="first try")
    file.write_text(json.dumps({"note": "at the page", "runs": [mine.document()]}))
    assert results_of(file) == (mine,)
    text = tables([RUN, *results_of(file), COURSE, QUICK])
    assert "| first try: Mode 2, 300 ± 50 ms, predicted | 1, 1 | 1 | 2 | 1.50, 2.50 | 90 % |" in text
    assert "| Mode 2, 300 ± 50 ms, predicted | 1, 1 |" in text
    assert "| 75 % |" in text


def test_a_file_that_is_none_is_refused_in_a_sentence(tmp_path: Path) -> None:
    file = tmp_path / "person.json"
    file.write_text(json.dumps({"runs": [RUN.document() | {"seed": "four"}]}))
    with pytest.raises(ConfigError, match=r"no file of runs .*int.*seed"):
        results_of(file)
    with pytest.raises(ConfigError, match="cannot be read"):
        results_of(tmp_path / "none.json")


def test_table_and_picture_of_runs(tmp_path: Path) -> None:
    rows = list(csv.reader(io.StringIO(table_csv([RUN, COURSE]))))
    assert tuple(rows[0]) == COLUMNS
    assert dict(zip(rows[0], rows[1], strict=True))["speed_mps"] == "0.25"
    plot([RUN, COURSE, QUICK], tmp_path / "pursuit.svg")
    assert (tmp_path / "pursuit.svg").read_text("utf-8").count("<path") > 40
    with pytest.raises(ConfigError, match="cannot be written"):
        plot([RUN], tmp_path / "missing" / "pursuit.png")
