"""The records that the console and the commands report, as JSON."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import msgspec

from app.attention.desires import Desire, DesireClass, Source
from app.attention.intention import Intention, divisors_of, parameters_of
from app.attention.reasons import explain
from app.attention.reports import desire_class_report, intention_report, resource_report, strategy_report
from app.attention.solver import Selection, solve
from app.attention.strategies import Location, Resource, Strategy, StrategyTable
from app.attention.timeline import Timeline
from tests.attention.thesis import CPU, TABLE_4_4, desire, problem

TABLE = StrategyTable(TABLE_4_4, {"cpu": Resource("cpu", 100, "% of one core", "The computer")})


def as_json(record: object) -> Any:
    """``record`` as a client reads it."""
    return json.loads(msgspec.json.encode(record))


def test_desire() -> None:
    one = Desire("d-1", "GoTo", 8.0, 1.0, False, {"x": 3}, Source("rest", "curl"), 10.5, 40.5)
    assert as_json(one) == {
        "id": "d-1",
        "class": "GoTo",
        "intensity": 8.0,
        "utility": 1.0,
        "security": False,
        "params": {"x": 3},
        "source": {"kind": "rest", "name": "curl", "rule": "", "event": "", "applied": None, "motive": None},
        "created": 10.5,
        "expires": 40.5,
        "modulation": None,
    }


def test_class_strategy_resource_event() -> None:
    described = desire_class_report(DesireClass("Dance", "Dance", "Move to music."), TABLE)
    assert described.schema["additionalProperties"] is False
    assert not described.served
    assert desire_class_report(DesireClass("GoTo", "Go", "Go there."), TABLE).served
    strategy = Strategy("a", "A", 4, filters={"M.x": math.inf}, costs={"cpu": 2}, location=Location("t.yaml", 7))
    document = as_json(strategy_report(strategy, replace(strategy, costs={"cpu": 1}), selected=True))
    assert (document["class"], document["filters"], document["declared"], document["selected"]) == (
        "A",
        {"M.x": None},
        "t.yaml:7",
        True,
    )
    assert (document["costs"], document["declared_costs"]) == ({"cpu": 2}, {"cpu": 1})
    report = resource_report(TABLE.resources["cpu"], 50, 80, None)
    assert (report.unit, report.capacity, report.budget, report.declared) == ("% of one core", 50, 80, 100)
    assert report.used == 0
    event = Timeline(5).add("guard", "guard", "stopped", {"why": "late"}, stamp=2.0)
    assert as_json(event) == {
        "id": 1,
        "stamp": 2.0,
        "kind": "guard",
        "subject": "guard",
        "text": "stopped",
        "data": {"why": "late"},
    }


def intention(selection: Selection, *classes: str) -> Intention:
    p = problem([desire(cls, 8) for cls in classes], TABLE_4_4, CPU)
    chosen = tuple(s for s in TABLE_4_4 if s.name in selection.strategies)
    return Intention(
        5.0,
        selection,
        chosen,
        divisors_of(chosen, TABLE.filters),
        parameters_of(chosen, p.desires),
        explain(p, selection, time_limit_s=60),
        p.desires,
        p.capacities,
    )


def test_intention() -> None:
    p = problem([desire("GoTo", 8), desire("LocateFaces", 8)], TABLE_4_4, CPU)
    found = as_json(intention_report(intention(solve(p), "GoTo", "LocateFaces"), TABLE.resources))
    assert found["stamp"] == 5.0
    assert [s["name"] for s in found["strategies"]] == ["6", "11", "13"]
    assert found["use"] == {"cpu": {"used": 80, "capacity": 100, "unit": "% of one core"}}
    assert found["filters"]["FaceDetector.images"] == 2
    assert found["filters"]["QRCodeDetector.images"] is None
    assert (found["fulfilled"], found["omega"], found["proven"], found["relaxed"]) == (
        ["LocateFaces", "GoTo"],
        28,
        True,
        [],
    )
    reason = found["reasons"]["LocateFaces"]
    assert (reason["state"], reason["utility"], reason["wanted"], reason["best"]) == ("degraded", 4, 1, 8)
    nothing = {"resource": "", "amount": 0, "unit": ""}
    assert reason["alternatives"][1] == {"kind": "without", "utility": 8, "without": "GoTo", **nothing}
    assert found["desires"] == {"GoTo": "d-GoTo", "LocateFaces": "d-LocateFaces"}


def test_an_intention_without_a_bound_is_json_too() -> None:
    safe = Selection(("12",), (), 0.0, math.inf, {"cpu": 0.0}, False)
    assert as_json(intention_report(intention(safe), TABLE.resources))["bound"] is None
