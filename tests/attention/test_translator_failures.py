"""Attention goes on with the last intention, whatever fails: solver, reasons, observers, modules."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import pytest

from app.attention.cached_solver import CachedSolver
from app.attention.hysteresis import SelectionHysteresis
from app.attention.intention import Intention
from app.attention.problem import Selection, SelectionProblem
from app.attention.solver import SolverFailed
from app.attention.timeline import Timeline
from app.attention.translator import IntentionTranslator
from app.attention.workspace import IntentionWorkspace
from app.runtime.clock import VirtualClock, in_virtual_time, run_virtual
from tests.attention.setting import CLASSES, RIVALS, TABLE, Bank, HeldSolver, Setting, Sink


class FailingSolver(CachedSolver):
    def __init__(self) -> None:
        super().__init__()
        self.failure: Exception | None = None
        self.silent = False

    def recall(self, problem: SelectionProblem) -> Selection | None:
        return None

    def solve(self, problem: SelectionProblem) -> Selection:
        if self.silent:
            return None  # type: ignore[return-value]
        if self.failure is not None:
            raise self.failure
        return super().solve(problem)


@in_virtual_time
async def test_a_solver_failure_keeps_the_last_intention() -> None:
    solver = FailingSolver()
    s = Setting(solver=solver)
    async with s.running():
        s.add("DetectNoises")
        await s.translator.settled()
        before = dict(s.bank.phi)
        for failure in (SolverFailed("no time"), MemoryError()):
            solver.failure = failure
            s.add("LocateVoices")
            await s.translator.settled()
            assert s.bank.phi == before
            assert s.selected == ("9",)
        solver.silent = True
        s.add("SLAM")
        await s.translator.settled()
        assert s.selected == ("9",)
        assert s.translator.statistics().failures == 3
        solver.failure, solver.silent = None, False
        s.add("Teleoperation")
        await s.translator.settled()
        assert s.selected == ("9", "10", "11", "12")
        assert [e.text for e in s.timeline.query(kinds={"solver"})][-1] == "the solver answers again"


@in_virtual_time
async def test_a_solver_that_failed_is_asked_again_ever_more_seldom() -> None:
    """A desire is answered after a failure, without another change of the workspace."""
    solver = FailingSolver()
    s = Setting(solver=solver)
    async with s.running():
        await s.translator.settled()
        solver.failure = SolverFailed("no time")
        s.add("DetectNoises")
        await s.translator.settled()
        assert s.selected == ()
        solver.failure = None
        await s.clock.sleep(0.9)
        assert s.selected == ()
        await s.clock.sleep(0.2)
        assert s.selected == ("9",)
        assert s.translator.statistics().failures == 1

        solver.failure = SolverFailed("no time")
        s.add("SLAM")
        await s.clock.sleep(100)
        assert s.translator.statistics().failures == 1 + 8, "at 0, 1, 3, 7, 15, 31, 61 and 91 s"
        solver.failure = None
        await s.clock.sleep(30)
        assert s.selected == ("9", "11")


@in_virtual_time
async def test_a_switch_is_not_held_back_where_that_cannot_be_judged_in_time() -> None:
    async def judged_too_late(function: Callable[..., Any], *arguments: Any) -> Any:
        if function == s.translator._solver.among:
            raise SolverFailed("no time")
        return function(*arguments)

    s = Setting(offload=judged_too_late, hysteresis=SelectionHysteresis(dwell_s=5.0))
    async with s.running():
        s.add("DetectNoises")
        await s.translator.settled()
        s.add("SLAM")
        await s.translator.settled()
        assert s.selected == ("9", "11")


@in_virtual_time
async def test_whatever_else_fails_where_a_switch_is_judged_leaves_the_last_intention() -> None:
    async def broken(function: Callable[..., Any], *arguments: Any) -> Any:
        if function == s.translator._solver.among:
            raise ZeroDivisionError
        return function(*arguments)

    s = Setting(offload=broken, hysteresis=SelectionHysteresis(dwell_s=5.0))
    async with s.running():
        await s.translator.settled()
        s.add("DetectNoises")
        await s.translator.settled()
        assert s.translator.statistics().failures == 1
        assert s.selected == ()
        assert "ZeroDivisionError" in s.timeline.query(kinds={"solver"})[-1].text


@in_virtual_time
async def test_a_part_of_the_solver_that_cannot_be_loaded_does_not_stop_attention(
    caplog: pytest.LogCaptureFixture,
) -> None:
    solver = FailingSolver()

    def missing(problem: SelectionProblem) -> None:
        raise ImportError("No module named 'ortools'")

    solver.prepare = missing
    s = Setting(solver=solver)
    async with s.running():
        s.add("DetectNoises")
        await s.translator.settled()
        assert s.selected == ("9",)
    assert "part of the solver cannot be loaded: No module named 'ortools'" in caplog.text


@in_virtual_time
async def test_a_switch_whose_moment_comes_while_the_solver_fails_is_not_asked_for_at_every_turn() -> None:
    solver = FailingSolver()
    s = Setting(RIVALS, solver=solver, hysteresis=SelectionHysteresis(dwell_s=2.0))
    async with s.running():
        s.add("GoTo", 4)
        await s.translator.settled()
        s.add("Teleoperation", 5)
        await s.translator.settled()
        assert s.selected == ("goto",), "held back"
        solver.failure = SolverFailed("no time")
        await s.clock.sleep(10)
        assert s.translator.statistics().failures == 4, "at 2, 3, 5 and 9 s"


@in_virtual_time
async def test_the_safe_strategies_hold_until_the_first_answer() -> None:
    solver = HeldSolver()
    s = Setting(solver=solver, offload=solver.offload, safe=["12"])
    async with s.running():
        _, first = await solver.next()
        assert s.selected == ("12",)
        assert s.bank.phi["Teleop.twist"] == 1
        first.set_result(None)
        await s.translator.settled()
        assert s.selected == ()


@in_virtual_time
async def test_the_safe_strategies_stay_while_there_is_no_answer() -> None:
    solver = FailingSolver()
    solver.failure = SolverFailed("no time")
    s = Setting(solver=solver, safe=["12"])
    async with s.running():
        await s.translator.settled()
        assert s.selected == ("12",)
        assert s.bank.phi["Teleop.twist"] == 1


def test_names_are_checked() -> None:
    with pytest.raises(ValueError, match="safe strategies that do not exist: 99"):
        Setting(safe=["99"])
    workspace = IntentionWorkspace(CLASSES, lambda: 0.0)
    with pytest.raises(ValueError, match=r"filters that do not exist: FaceDetector\.images"):
        IntentionTranslator(workspace, TABLE, Bank(["QRCodeDetector.images"]), Sink(), Timeline(9), VirtualClock())


@in_virtual_time
async def test_observers_and_modules_that_fail_do_not_stop_attention(caplog: pytest.LogCaptureFixture) -> None:
    s = Setting()

    def broken(intention: Intention) -> None:
        raise ZeroDivisionError

    def refuse(module: str, parameters: Mapping[str, Any]) -> None:
        raise ValueError("no such thing")

    s.translator.observe(broken)
    s.sink.configure = refuse
    async with s.running():
        s.add("LocateVoices", params={"x": 1})
        await s.translator.settled()
        assert s.bank.phi["VoiceLocalizer.audio"] == 1
        s.add("DetectNoises")
        await s.translator.settled()
        assert s.selected == ("9", "10")
    assert "an observer of the intention failed and goes on" in caplog.text
    assert "refused its parameters" in caplog.text
    assert s.events("module") == ["VoiceLocalizer", "LoudNoiseDetector"]


@in_virtual_time
async def test_a_solver_that_cannot_even_remember_does_not_stop_attention() -> None:
    solver = FailingSolver()
    s = Setting(solver=solver)
    async with s.running():
        s.add("DetectNoises")
        await s.translator.settled()

        def forget(problem: SelectionProblem) -> Selection | None:
            raise ZeroDivisionError

        solver.recall = forget
        s.add("SLAM", ttl=5)
        await s.translator.settled()
        assert s.selected == ("9",)
        await s.clock.sleep(6)
        assert [d.cls for d in s.workspace.desires()] == ["DetectNoises"], "desires still expire"
        del solver.recall
        s.add("Teleoperation")
        await s.translator.settled()
        assert s.selected == ("9", "12")


@in_virtual_time
async def test_reasons_that_cannot_be_found_do_not_stop_attention(monkeypatch: pytest.MonkeyPatch) -> None:
    s = Setting()
    async with s.running():
        s.add("DetectNoises")
        await s.translator.explained()

        def lost(*_: object, **options: Any) -> dict[str, Any]:
            raise ZeroDivisionError

        monkeypatch.setattr("app.attention.explaining.explain", lost)
        s.add("SLAM")
        await s.translator.explained()
        assert s.selected == ("9", "11")
        s.add("Teleoperation")
        await s.translator.settled()
        assert s.selected == ("9", "11", "12")


@pytest.mark.parametrize("capacity", [math.inf, math.nan, -1, 1e18, 1e300])
def test_a_capacity_that_cannot_be_is_refused_at_the_door(capacity: float) -> None:
    async def refused() -> None:
        with pytest.raises(ValueError, match="capacity of cpu must be from 0 to 1,000,000,000"):
            Setting().translator.set_capacity("cpu", capacity, "a test")

    run_virtual(refused())
