"""The Intention Translator: newest desires win, and an intention is applied in one step of the loop."""

from __future__ import annotations

import asyncio
import math
import random
import threading
from itertools import count
from typing import Any

import pytest

from app.attention.hysteresis import SelectionHysteresis
from app.attention.intention import Intention, divisors_of
from app.attention.reasons import explain
from app.attention.solver import solve
from app.attention.strategies import Strategy, StrategyTable
from app.messages import Reason
from app.runtime.clock import in_virtual_time
from tests.attention.setting import CLASSES, RIVALS, TABLE, HeldSolver, Setting


@in_virtual_time
async def test_desires_become_filters_and_parameters() -> None:
    s = Setting()
    async with s.running():
        s.add("GoTo", params={"x": 3})
        s.add("LocateFaces")
        await s.translator.settled()
        assert s.selected == ("6", "11", "13")
        open_ones = {name: phi for name, phi in s.bank.phi.items() if phi < math.inf}
        assert open_ones == {
            "FaceDetector.images": 2,
            "SLAM2D.scans": 40,
            "PlanAndFollowPath.scans": 1,
            "PlanAndFollowPath.twist": 1,
        }
        assert dict(s.sink.calls) == {"PlanAndFollowPath": {"x": 3.0}, "FaceDetector": {"x": 0.0}}
        assert s.events("desire") == ["GoTo", "LocateFaces"]
        assert s.events("intention") == ["intention"]
        assert set(s.events("filter")) == set(open_ones)


@in_virtual_time
async def test_only_what_changed_is_touched_in_one_call() -> None:
    s = Setting()
    async with s.running():
        codes = s.add("FindQRCodes", utility=4)
        s.add("DetectNoises")
        await s.translator.settled()
        s.bank.calls.clear()
        s.add("LocateFaces", utility=8)
        await s.translator.settled()
        assert s.selected == ("2", "5", "9")
        assert s.bank.calls == [{"FaceDetector.images": 1, "QRCodeDetector.images": 2}]
        s.bank.calls.clear()
        s.workspace.change(codes, intensity=7.5)
        await s.translator.settled()
        assert s.bank.calls == [], "the same strategies: no filter is touched"
        s.workspace.remove(codes)
        await s.translator.settled()
        assert s.bank.calls == [{"QRCodeDetector.images": math.inf}]


@in_virtual_time
async def test_parameters_change_in_place_and_go_with_the_strategy() -> None:
    s = Setting()
    async with s.running():
        goal = s.add("GoTo", params={"x": 1})
        await s.translator.settled()
        s.workspace.change(goal, params={"x": 2})
        await s.translator.settled()
        s.workspace.remove(goal)
        await s.translator.settled()
        assert s.sink.calls == [
            ("PlanAndFollowPath", {"x": 1.0}),
            ("PlanAndFollowPath", {"x": 2.0}),
            ("PlanAndFollowPath", {}),
        ]
        assert len(s.bank.calls) == 2


@in_virtual_time
async def test_the_more_intense_desire_has_the_last_word_on_a_shared_module_and_the_fastest_filter_wins() -> None:
    shared = (
        Strategy("a", "FindQRCodes", 8, filters={"Eye.images": 4}, parameters={"Eye": {"gain": 1, "only": "a"}}),
        Strategy("b", "LocateFaces", 8, filters={"Eye.images": 2}, parameters={"Eye": {"gain": 2}}),
    )
    s = Setting(StrategyTable(shared, {}))
    async with s.running():
        s.add("FindQRCodes", 8, params={"x": 8})
        s.add("LocateFaces", 4, params={"x": 4})
        await s.translator.settled()
        assert s.selected == ("a", "b"), "sharing a filter drops no desire"
        assert s.bank.phi["Eye.images"] == 2
        assert s.sink.calls[-1] == ("Eye", {"gain": 1, "only": "a", "x": 8.0})


@in_virtual_time
async def test_a_stale_result_is_discarded() -> None:
    solver = HeldSolver()
    s = Setting(solver=solver, offload=solver.offload)
    async with s.running():
        s.add("DetectNoises")
        _, first = await solver.next()
        s.add("LocateVoices")
        first.set_result(None)
        problem, second = await solver.next()
        assert s.bank.calls == [], "what answered the older desires was not applied"
        assert set(problem.desires) == {"DetectNoises", "LocateVoices"}
        second.set_result(None)
        await s.translator.settled()
        assert s.selected == ("9", "10")
        assert s.translator.statistics().discarded == 1


@in_virtual_time
async def test_desires_that_never_rest_do_not_starve_attention() -> None:
    solver = HeldSolver()
    s = Setting(solver=solver, offload=solver.offload)
    async with s.running():
        voices = s.add("LocateVoices", 8)
        for n in range(4):
            _, future = await solver.next()
            s.workspace.change(voices, intensity=7 - n)
            future.set_result(None)
        _, future = await solver.next()
        assert s.selected == ("10",), "late, but it breaks nothing"
        s.workspace.change(voices, utility=0)
        future.set_result(None)
        _, future = await solver.next()
        future.set_result(None)
        await s.translator.settled()
        assert s.selected == ()


@in_virtual_time
async def test_a_late_result_that_breaks_a_newer_constraint_is_never_applied() -> None:
    solver = HeldSolver()
    s = Setting(solver=solver, offload=solver.offload)
    async with s.running():
        voices = s.add("LocateVoices", 8)
        for n in range(6):
            _, future = await solver.next()
            s.workspace.change(voices, utility=0, intensity=7 - n)
            future.set_result(None)
            if n == 0:
                assert s.translator.current is None
        await solver.next()
        assert s.bank.phi["VoiceLocalizer.audio"] == math.inf
        assert s.selected == ()


@in_virtual_time
async def test_an_intention_is_applied_in_one_step_of_the_loop() -> None:
    """A task that runs at every step of the loop never sees half an intention."""
    s = Setting()
    seen: set[tuple[float, float]] = set()

    async def watch() -> None:
        while True:
            seen.add((s.bank.phi["QRCodeDetector.images"], s.bank.phi["FaceDetector.images"]))
            await asyncio.sleep(0)

    watcher = asyncio.create_task(watch())
    async with s.running():
        with s.workspace.transaction():
            s.add("FindQRCodes")
            s.add("LocateFaces")
        await s.translator.settled()
        await asyncio.sleep(0)
    watcher.cancel()
    assert seen == {(math.inf, math.inf), (2, 1)}


@in_virtual_time
async def test_desires_expire_on_time() -> None:
    s = Setting()
    async with s.running():
        s.add("DetectNoises")
        s.add("LocateVoices", ttl=5)
        await s.translator.settled()
        assert s.selected == ("9", "10")
        start = s.clock.now()
        applied = asyncio.Event()
        s.translator.observe(lambda intention: applied.set())
        await applied.wait()
        assert s.selected == ("9",)
        assert s.clock.now() - start == pytest.approx(5, abs=0.01)
        assert "expired" in [e.data["change"] for e in s.timeline.query(kinds={"desire"})]


@in_virtual_time
async def test_a_renewed_life_is_no_event_and_no_new_problem() -> None:
    s = Setting()
    async with s.running():
        voices = s.add("LocateVoices", ttl=5)
        await s.translator.settled()
        solved = s.translator.statistics().solved
        await s.clock.sleep(4)
        s.workspace.change(voices, ttl=5)
        await s.clock.sleep(4)
        assert s.translator.statistics().solved == solved
        assert s.selected == ("10",)
        assert len(s.events("desire")) == 1
        await s.clock.sleep(2)
        await s.translator.settled()
        assert s.selected == ()


@in_virtual_time
async def test_budgets_move_filters() -> None:
    s = Setting()
    async with s.running():
        s.add("FindQRCodes")
        await s.translator.settled()
        assert s.selected == ("1",)
        s.translator.set_capacity("cpu", 50, "the computer is hot")
        await s.translator.settled()
        assert s.selected == ("2",)
        s.translator.set_capacity("cpu", 100, "it cooled down")
        await s.translator.settled()
        assert s.selected == ("1",)
        assert [e.data["reason"] for e in s.timeline.query(kinds={"capacity"})] == [
            "the computer is hot",
            "it cooled down",
        ]
        for resource, value in (("gpu", 1), ("cpu", -1), ("cpu", math.nan)):
            with pytest.raises(ValueError, match=r"no resource|from 0 to"):
                s.translator.set_capacity(resource, value, "")


@in_virtual_time
async def test_costs_that_were_measured_move_filters() -> None:
    s = Setting()
    async with s.running():
        s.add("FindQRCodes")
        await s.translator.settled()
        before = s.translator.table
        (chosen,) = s.selected
        s.translator.set_costs({chosen: {"cpu": 1000.0}}, "it takes more than was thought")
        await s.translator.settled()
        assert s.selected != (chosen,)
        assert s.translator.table[chosen].costs == {"cpu": 1000.0}
        s.translator.set_costs({chosen: before[chosen].costs}, "or not")
        await s.translator.settled()
        assert s.selected == (chosen,)
        for costs in ({"no such": {"cpu": 1.0}}, {chosen: {"gpu": 1.0}}):
            with pytest.raises(ValueError, match=r"costs of what does not exist: (no such|gpu)"):
                s.translator.set_costs(costs, "")


@in_virtual_time
async def test_a_budget_stays_set_while_others_press() -> None:
    s = Setting()
    async with s.running():
        s.add("FindQRCodes")
        await s.translator.settled()
        assert s.selected == ("1",)
        s.translator.set_share("cpu", 0.5, "others press")
        await s.translator.settled()
        assert (s.selected, s.translator.capacities["cpu"], s.translator.budgets["cpu"]) == (("2",), 50, 100)
        s.translator.set_capacity("cpu", 200, "asked for")
        await s.translator.settled()
        assert (s.selected, s.translator.capacities["cpu"], s.translator.budgets["cpu"]) == (("1",), 100, 200)
        assert [e.text for e in s.timeline.query(kinds={"capacity"})] == [
            "cpu may now use 50 of its 100: others press",
            "cpu may now use 200 instead of 100: asked for",
        ]
        for resource, share in (("gpu", 1.0), ("cpu", 1.5), ("cpu", math.nan)):
            with pytest.raises(ValueError, match=r"no resource|from 0 to 1"):
                s.translator.set_share(resource, share, "")


@in_virtual_time
async def test_a_perception_that_works_badly_produces_less_and_the_reason_says_so() -> None:
    s = Setting(explain_limit_s=5.0)
    async with s.running():
        s.add("FindQRCodes", utility=4)
        s.add("LocateFaces", utility=1)
        await s.translator.settled()
        s.translator.set_utilities({"1": 0.25, "2": 0.25, "3": 0.25, "4": 0.25}, {"FindQRCodes": "it is dark"})
        await s.translator.settled()
        await s.translator.explained()
        current = s.translator.current
        assert current is not None
        assert s.translator.table["1"].utility == 2, "a quarter of 8"
        assert not {"1", "2", "3", "4"} & set(s.selected), "four are wanted"
        assert current.reasons["FindQRCodes"].remark == "it is dark"
        assert current.reasons["LocateFaces"].remark == ""
        assert {each.name: each.utility for each in current.changed} == {"1": 2, "2": 1, "3": 0.5, "4": 0.25}
        s.translator.set_costs({"1": {"cpu": 7.0}}, "measured")
        s.translator.set_utilities({}, {})
        await s.translator.settled()
        assert (s.translator.table["1"].utility, s.translator.table["1"].costs) == (8, {"cpu": 7.0})
        assert s.translator.current is not None
        assert [(each.name, each.costs) for each in s.translator.current.changed] == [("1", {"cpu": 7.0})]
        for factors in ({"no such": 0.5}, {"1": 0.0}, {"1": 1.5}):
            with pytest.raises(ValueError, match=r"does not exist|over 0 and at most 1"):
                s.translator.set_utilities(factors, {})


@in_virtual_time
async def test_equal_problems_are_recalled() -> None:
    s = Setting()
    async with s.running():
        for _ in range(3):
            desire = s.add("LocateVoices")
            await s.translator.settled()
            s.workspace.remove(desire)
            await s.translator.settled()
        statistics = s.translator.statistics()
        # The first two problems of each kind differ in what was selected before.
        assert statistics.solved == 6
        assert statistics.recalled >= 3


@in_virtual_time
async def test_reasons_come_with_the_intention_and_are_completed_after_it() -> None:
    s = Setting(explain_limit_s=5.0)
    intentions: list[Intention] = []
    s.translator.observe(intentions.append)
    async with s.running():
        with s.workspace.transaction():
            s.add("FindQRCodes", 1, 8)
            s.add("LocateFaces", 1)
        await s.translator.explained()
        assert [i.reasons["LocateFaces"].state for i in intentions] == ["degraded", "degraded"]
        assert intentions[0].reasons["LocateFaces"].alternatives == ()
        offers = intentions[1].reasons["LocateFaces"].alternatives
        assert [(a.kind, a.amount, a.without) for a in offers] == [("capacity", 40, ""), ("without", 0, "FindQRCodes")]
        assert s.translator.current is intentions[1]


@in_virtual_time
async def test_nothing_is_explained_on_the_event_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    threads: list[int] = []

    def noted(*arguments: Any, **options: Any) -> dict[str, Reason]:
        threads.append(threading.get_ident())
        return explain(*arguments, **options)

    for module in ("cached_solver", "explaining"):
        monkeypatch.setattr(f"app.attention.{module}.explain", noted)
    s = Setting(safe=["12"], explain_limit_s=5.0, hysteresis=SelectionHysteresis(dwell_s=1))
    async with s.running():
        for cls in ("DetectNoises", "LocateFaces", "GoTo"):
            s.add(cls)
            await s.translator.explained()
    assert len(threads) >= 6
    assert threading.get_ident() not in threads


@in_virtual_time
async def test_refresh_sets_every_controlled_filter_again() -> None:
    s = Setting()
    async with s.running():
        s.add("SLAM")
        await s.translator.settled()
        s.bank.phi["SLAM2D.scans"] = 1
        s.translator.refresh()
        assert s.bank.phi["SLAM2D.scans"] == 40
        assert "Kinect.images" not in s.bank.calls[-1], "no strategy sets it: it is none of attention's"


# --- Hysteresis ----------------------------------------------------------------------------------------------


async def rivalry(hysteresis: SelectionHysteresis | None, swings: int = 20, each_s: float = 1.0) -> tuple[int, Setting]:
    """A rival's intensity goes 1 above and 1 below; how often the strategies switch after the first choice."""
    s = Setting(RIVALS, hysteresis=hysteresis)
    async with s.running():
        s.add("GoTo", 4)
        rival = s.add("Teleoperation", 3)
        await s.translator.settled()
        first = len(s.events("intention"))
        for n in range(swings):
            s.workspace.change(rival, intensity=5 if n % 2 == 0 else 3)
            await s.translator.settled()
            await s.clock.sleep(each_s)
    return len(s.events("intention")) - first, s


@in_virtual_time
async def test_hysteresis_by_gain() -> None:
    assert (await rivalry(None))[0] == 20
    switches, s = await rivalry(SelectionHysteresis(gain=1.5))
    assert switches == 0
    assert s.selected == ("goto",)
    assert s.translator.statistics().held == 10
    assert (await rivalry(SelectionHysteresis(gain=0.5)))[0] == 20


@in_virtual_time
async def test_hysteresis_by_time() -> None:
    assert (await rivalry(SelectionHysteresis(dwell_s=3)))[0] == 0
    switches, s = await rivalry(SelectionHysteresis(dwell_s=3), swings=1, each_s=2.9)
    assert switches == 0
    switches, s = await rivalry(SelectionHysteresis(dwell_s=3), swings=1, each_s=3.5)
    assert switches == 1
    assert s.selected == ("teleop",), "the better one for long enough"


@in_virtual_time
async def test_hysteresis_holds_back_no_desire_that_takes_from_no_other() -> None:
    s = Setting(hysteresis=SelectionHysteresis(gain=8, dwell_s=100))
    async with s.running():
        noises = s.add("DetectNoises", 1)
        await s.translator.settled()
        s.add("SLAM", 1)
        await s.translator.settled()
        assert s.selected == ("9", "11")
        s.workspace.remove(noises)
        await s.translator.settled()
        assert s.selected == ("11",), "nor does it keep on what serves nothing"


@pytest.mark.slow
@in_virtual_time
async def test_a_thousand_random_edits_leave_the_filters_of_a_fresh_solve() -> None:
    s = Setting(explain_limit_s=0)
    rng = random.Random(4)
    checked = 0
    async with s.running():
        for n in count():
            desires = s.workspace.desires()
            action = rng.random()
            if len(desires) < 3 or (action < 0.4 and len(desires) < 14):
                s.add(
                    rng.choice(list(CLASSES)),
                    rng.choice([1, 2.5, 4, 8]),
                    rng.choice([0, 1, 1, 2, 4, 8]),
                    security=rng.random() < 0.1,
                    ttl=rng.choice([None, None, 0.5]),
                    params={"x": n},
                )
            elif action < 0.7:
                s.workspace.change(
                    rng.choice(desires).id, intensity=rng.choice([1, 3, 8]), utility=rng.choice([0, 1, 4])
                )
            elif action < 0.75:
                s.translator.set_capacity("cpu", rng.choice([60, 80, 100, 120]), "for the test")
            else:
                s.workspace.remove(rng.choice(desires).id)
            if rng.random() < 0.3:
                await s.clock.sleep(rng.random() * 0.2)
            if n == 1000:
                break
            if rng.random() < 0.1:
                checked += 1
                await s.translator.settled()
                assert_as_solved_afresh(s)
        await s.translator.settled()
        assert_as_solved_afresh(s)
        assert checked > 50


def assert_as_solved_afresh(s: Setting) -> None:
    """The filters are those of a fresh solve of the desires as they are; nothing would move."""
    selection = solve(s.translator.problem(), time_limit_s=5.0)
    strategies = [TABLE[name] for name in selection.strategies]
    assert s.bank.phi == {"Kinect.images": math.inf, **divisors_of(strategies, TABLE.filters)}
    assert s.translator.current is not None
    assert s.translator.current.selection.omega == selection.omega
