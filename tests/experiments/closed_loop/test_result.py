"""What the closed-loop experiment makes of its samples."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from app.attention.strategy_file import load_strategies
from app.experiments.closed_loop.dear_module import DearMeter
from app.experiments.closed_loop.experiment import WRONG, phases_of, plan, program_of, scaled
from app.experiments.closed_loop.report import doubts, table
from app.experiments.closed_loop.result import RunResult, Sample, back_s, judge, period_p99_ms
from app.experiments.simulated import SimulatedProgram
from app.program.desire_classes import desire_classes
from app.runtime.load import CpuMeter


def sample(t: float, used: float = 40, budget: float = 44, phi: Mapping[str, float] | None = None) -> Sample:
    return Sample(t, used, budget, share=1.0, waiting=0.1, divisors=phi or {"Eye.images": 2})


def result(samples: list[Sample], *, closed: bool = True, kind: str = "load", others: float = 12.5) -> RunResult:
    return RunResult(
        kind,
        closed,
        phases=phases_of(kind, 10),
        samples=tuple(samples),
        periods=(0.1,) * 99 + (0.2,),
        restarts=0,
        others=others,
        world_rate=1.0,
    )


def test_a_phase_is_settled_when_the_budget_is_kept_for_good() -> None:
    samples = [sample(t / 2, 60 if t < 5 else 40) for t in range(21)]
    found = judge(result(samples), phases_of("load", 10)[0])
    assert (found.settled_s, found.left) == (2.0, 0), "of two seconds from then on, a quarter is over it"
    assert found.over == pytest.approx(40 / 44)
    never = judge(result([sample(t, 60) for t in range(10)]), phases_of("load", 10)[0])
    assert never.settled_s == math.inf
    once = judge(result([sample(t / 2, 60 if t == 15 else 40) for t in range(21)]), phases_of("load", 10)[0])
    assert once.settled_s == 0, "one picture that takes longer is no trouble"


def test_what_swings_is_counted() -> None:
    samples = [sample(t, phi={"Eye.images": 1 + t % 2}) for t in range(11)]
    assert judge(result(samples), phases_of("load", 10)[0]).left == 5


def test_phi_is_back_when_no_perception_gets_less_than_before() -> None:
    samples = [sample(t, phi={"Eye.images": 8 if 20 <= t < 33 else 2}) for t in range(40)]
    assert back_s(result(samples), phases_of("load", 10)[1], 30) == 3
    samples = [sample(t, phi={"Eye.images": 8 if t >= 20 else 2}) for t in range(40)]
    assert back_s(result(samples), phases_of("load", 10)[1], 30) == math.inf


def test_the_table_has_both_loops_and_doubts_are_said() -> None:
    samples = [sample(t) for t in range(40)]
    both = [result(samples, closed=closed) for closed in (False, True)]
    text = table(both)
    assert "| half taken | 0.0 | 0.91 | 0 | 0.0 | 0.91 | 0 |" in text
    assert period_p99_ms(both[0]) == pytest.approx(101)
    assert doubts(both) == [], "the competitor is none of the others"
    assert len(doubts([result(samples, others=90)])) == 1


def test_declared_costs_are_wrong_everywhere() -> None:
    data = {
        "strategies": [{"costs": {"cpu": {"calibrated_or": 6}, "power": 2}}, {"costs": {"cpu": 3}}, {}],
        "families": [{"costs": {"cpu": {"calibrated_or": {"base": 0, "slope": 9}}}}],
    }
    assert scaled(data, 1 / 3) == {
        "strategies": [{"costs": {"cpu": {"calibrated_or": 2}, "power": 2}}, {"costs": {"cpu": 1}}, {}],
        "families": [{"costs": {"cpu": {"calibrated_or": {"base": 0, "slope": 3}}}}],
    }


def test_the_program_of_each_run_is_the_shipped_one_with_wrong_costs(tmp_path: Path) -> None:
    def costs(program: SimulatedProgram) -> dict[str, float]:
        configuration = program.configuration
        files = map(configuration.path, configuration.program.strategies)
        table = load_strategies(files, classes=desire_classes(configuration))
        return {each.name: each.costs.get("cpu", 0.0) for each in table.strategies}

    program = plan(None, None, 1.0).program
    declared = costs(program)
    for kind, factor in (("too low", 1 / WRONG), ("too high", WRONG), ("load", 1.0)):
        changed = program_of(program, kind, True, tmp_path)
        assert changed.configuration.program.attention.closed_loop is not None
        assert costs(changed) == pytest.approx({name: factor * cost for name, cost in declared.items()}, abs=0.01)


def test_a_dear_module_takes_a_multiple_of_its_cpu() -> None:
    def work() -> str:
        until = time.thread_time() + 0.01
        while time.thread_time() < until:
            pass
        return "done"

    plain = CpuMeter()
    dear = DearMeter(plain)
    assert dear.call(work) == "done"
    once = plain.cpu_ns
    dear.factor = 3.0
    dear.call(work)
    assert plain.cpu_ns - once >= 0.03e9
    assert dear.cpu_ns == plain.cpu_ns
