"""The whole experiment: finished trials are not repeated, and results are a table, JSON and pictures."""

from __future__ import annotations

import json
from pathlib import Path

import msgspec
import pytest

from app.base.errors import ConfigError
from app.experiments.barn.experiment import done, plan, run
from app.experiments.barn.report import failures, plot, table
from app.experiments.barn.result import WorldResult
from app.experiments.barn.trial import Drive
from app.experiments.results_store import ResultsStore
from tests.experiments.barn.conftest import straight_on


def crossed(world: str, outcome: str = "success", time_s: float = 3.0, reason: str = "") -> WorldResult:
    trace = ((0.0, 0.0, 0.0, 1.57), (time_s, 0.0, 2.5, 1.57))
    return WorldResult(world, outcome, time_s, 1.5, 0.5, reason, 1, 2.5, 0.1, ((0.0, "planning: a way"),), trace)  # type: ignore[arg-type]


@pytest.mark.slow
def test_worlds_are_crossed_in_child_processes_and_kept(three: Path, tmp_path: Path) -> None:
    what = plan(three, "1-2", jobs=2)
    kept = ResultsStore(tmp_path / "out", what.of())
    events: list[tuple[str, int, int]] = []
    drive: Drive = straight_on
    results = run(what, kept, lambda result, number, total: events.append((result.world, number, total)), drive)
    assert [(result.world, result.outcome) for result in results] == [("1", "success"), ("2", "collision")]
    assert sorted(number for _, number, _ in events) == [1, 2]
    again = ResultsStore(tmp_path / "out", what.of())
    assert sorted(done(what, again), key=lambda result: result.world) == list(results)


def test_what_is_done_is_not_done_again(three: Path, tmp_path: Path) -> None:
    what = plan(three, "1,3")
    kept = ResultsStore(tmp_path, what.of())
    kept.add(crossed("1").document())
    kept.add(crossed("3", "timeout").document())
    kept.add(crossed("2").document())  # of another choice: kept, not counted
    results = run(what, ResultsStore(tmp_path, what.of()), lambda *_: pytest.fail("nothing is left to do"))
    assert [result.world for result in results] == ["1", "3"]


def test_results_of_another_program_or_other_worlds_are_not_put_beside(three: Path, tmp_path: Path) -> None:
    what = plan(three)
    assert what.of() == plan(three).of()
    assert what.of() != plan(three, seed=2).of()
    assert what.of() != plan(three, overrides={"PlanAndFollowPath": {"controller": "dwa"}}).of()
    other = tmp_path / "other.json"
    other.write_text(three.read_text().replace("8.0", "9.0"))
    assert what.of() != plan(other).of()
    with pytest.raises(ConfigError, match="there is no such file"):
        plan(three, config=tmp_path / "none.yaml")


def test_a_line_that_is_no_result_is_said(three: Path, tmp_path: Path) -> None:
    what = plan(three)
    kept = ResultsStore(tmp_path, what.of())
    kept.add({"world": "1"})
    with pytest.raises(ConfigError, match="--fresh starts again"):
        done(what, ResultsStore(tmp_path, what.of()))


def test_the_table_reports_shares_and_failures_their_reasons(three: Path, tmp_path: Path) -> None:
    results = [crossed("1"), crossed("2", "collision", 4.2, "touched cylinder0.7"), crossed("3"), crossed("4")]
    lines = table(results).splitlines()
    assert "| successes, % | 75.0 |" in lines
    assert "| collisions, % | 25.0 |" in lines
    assert any(line.endswith("| 0.3750 |") for line in lines)
    assert failures(results) == ["world 2: collision after 4.2 s, 0.5 m before the goal (touched cylinder0.7)"]
    world = plan(three).chosen[0]
    plot(world, results[1], ((0.25, 0.2), (-0.25, 0.2), (-0.25, -0.2), (0.25, -0.2)), tmp_path / "world.png")
    assert (tmp_path / "world.png").read_bytes().startswith(b"\x89PNG")
    plot(world, None, (), tmp_path / "empty.svg")
    with pytest.raises(ConfigError, match="cannot be written"):
        plot(world, None, (), tmp_path / "none" / "world.png")


def test_results_are_json(tmp_path: Path) -> None:
    document = json.loads(json.dumps(crossed("1").document(), allow_nan=False))
    assert document["score"] == 0.5
    assert msgspec.convert(document, WorldResult) == crossed("1")
