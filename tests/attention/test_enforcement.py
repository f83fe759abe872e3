"""Parameters before filters, what changed alone, and a refusal that stops nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from app.attention.enforcement import enforce
from app.attention.intention import Intention
from app.attention.problem import Selection
from app.attention.timeline import Timeline
from tests.attention.setting import Bank, Sink

NONE = Selection((), (), omega=0.0, bound=0.0, use={}, proven=True)


def intention(divisors: Mapping[str, float], **parameters: Mapping[str, Any]) -> Intention:
    return Intention(0.0, NONE, (), divisors, parameters, reasons={}, desires={}, capacities={})


class Robot:
    """Filters and parameters, with the order in which they were set."""

    def __init__(self, refuses: str = "") -> None:
        self.bank, self.sink, self.timeline = Bank(["Face.images", "Voice.audio"]), Sink(), Timeline(9, lambda: 0.0)
        self.order: list[str] = []
        self.refuses = refuses

    def names(self) -> list[str]:
        return list(self.bank.names())

    def apply(self, divisors: Mapping[str, float]) -> None:
        self.order.append("filters")
        self.bank.apply(divisors)

    def configure(self, module: str, parameters: Mapping[str, Any]) -> None:
        self.order.append(module)
        if module == self.refuses:
            raise ValueError("no such thing")
        self.sink.configure(module, parameters)

    def enforce(self, before: Intention | None, after: Intention) -> dict[str, float]:
        return enforce(before, after, filters=self, parameters=self, timeline=self.timeline)


def test_parameters_are_there_before_filters_open() -> None:
    robot = Robot()
    after = intention({"Face.images": 2.0, "Voice.audio": math.inf}, Voice={"x": 1}, Face={"y": 2})
    assert robot.enforce(None, after) == {"Face.images": 2.0, "Voice.audio": math.inf}
    assert robot.order == ["Face", "Voice", "filters"]


def test_what_stays_is_not_touched() -> None:
    robot = Robot()
    before = intention({"Face.images": 2.0, "Voice.audio": 1.0}, Voice={"x": 1}, Face={"y": 2})
    assert robot.enforce(before, before) == {}
    assert robot.order == []
    after = intention({"Face.images": 4.0, "Voice.audio": 1.0}, Voice={"x": 1})
    assert robot.enforce(before, after) == {"Face.images": 4.0}
    assert robot.bank.calls == [{"Face.images": 4.0}]
    assert robot.sink.calls == [("Face", {})], "back to its own settings"


def test_a_refusal_is_noted_and_stops_nothing_else() -> None:
    robot = Robot(refuses="Face")
    robot.enforce(None, intention({"Voice.audio": 1.0}, Voice={"x": 1}, Face={"y": 2}))
    assert robot.sink.calls == [("Voice", {"x": 1})]
    assert robot.bank.phi["Voice.audio"] == 1.0
    (event,) = robot.timeline.query(kinds={"module"})
    assert event.text == "Face refused its parameters: ValueError: no such thing"
    assert event.data == {"parameters": {"y": 2}}
