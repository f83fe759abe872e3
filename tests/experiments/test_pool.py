"""Trials in child processes: all results, the trial's own mistakes, and a child that dies."""

from __future__ import annotations

import os

import pytest

from app.experiments.pool import TrialLost, TrialSeries
from tests.experiments.tripling import multiples, tripled

pytestmark = pytest.mark.slow


def test_every_trial_comes_with_its_result_from_other_processes() -> None:
    results = dict(TrialSeries(tripled, [1, 2, 3, 4, 5], 2))
    assert {number: result for number, (result, _) in results.items()} == {n: 3 * n for n in (1, 2, 3, 4, 5)}
    assert os.getpid() not in {process for _, process in results.values()}
    assert list(TrialSeries(tripled, [], 2)) == []


def test_a_trials_mistake_is_raised_and_a_dead_child_said() -> None:
    with pytest.raises(ValueError, match="thirteen"):
        list(TrialSeries(tripled, [13], 1))
    with pytest.raises(TrialLost, match="start it again to go on"):
        list(TrialSeries(tripled, [99], 1))


def test_a_series_gives_each_result_when_it_is_there_also_those_before_a_mistake() -> None:
    series = iter(TrialSeries(multiples, [2, 13], 1))
    assert [next(series) for _ in range(6)] == [(2, 2), (2, 4), (2, 6), (13, 13), (13, 26), (13, 39)]
    with pytest.raises(ValueError, match="thirteen") as mistake:
        next(series)
    assert any("in multiples" in note for note in mistake.value.__notes__)
