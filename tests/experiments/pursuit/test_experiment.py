"""A plan of the study goes on where it was interrupted, and refuses a program that it cannot drive."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.experiments.pursuit.experiment import conditions_of, done, plan, run
from app.experiments.pursuit.result import PursuitResult
from app.experiments.results_store import ResultsStore

ANY = PursuitResult(
    conditions_of()[0], seed=4, course="living room", ended=True, time_s=60.0, driven_m=20.0, contacts=0,
    monitor_stops=0, limited=0.0,
)  # fmt: skip


def test_what_is_done_is_not_run_again(tmp_path: Path) -> None:
    what = plan(1, 4, tasks=["course"])
    kept = ResultsStore(tmp_path, what.of())
    for condition in what.conditions:
        kept.add(replace(ANY, condition=condition).document())
    again = ResultsStore(tmp_path, what.of())
    assert {each.condition for each in done(what, again)} == set(what.conditions)
    found = run(what, again, lambda *_: pytest.fail("nothing is left to run"))
    assert [each.condition for each in found] == list(what.conditions)
    assert done(replace(what, seed=5), again) == ()
    assert done(replace(what, conditions=conditions_of(["follow"])), again) == ()


def test_a_program_without_a_head_to_turn_is_refused() -> None:
    with pytest.raises(ConfigError, match="needs a program with Teleop, HeadTeleop"):
        plan(config=paths.config_dir() / "jackal.yaml")
