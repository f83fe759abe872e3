"""The report of a calibration: relations, and the costs of strategies by them."""

from __future__ import annotations

from app.attention.calibration import CostCalibration
from app.attention.strategies import CLOSED, Strategy, StrategyTable
from app.commands.calibrate_report import relations_table, strategies_table
from app.logs.replay.calibration_runs import Measurement, Run, relations
from app.runtime.graph import ModuleSpec

MODULES = {
    "Eye": ModuleSpec.model_validate(
        {"class": "a:B", "inputs": {"left": "l", "right": "r"}, "outputs": {"twist": "t"}}
    ),
    "Ear": ModuleSpec.model_validate({"class": "a:C", "inputs": {"sound": "s"}}),
}
TABLE = StrategyTable(
    (
        Strategy("see", "See", 8, filters={"Eye.left": 1, "Eye.right": 2, "Eye.twist": 1}, costs={"cpu": 6.0}),
        Strategy("peep", "See", 2, filters={"Eye.left": 4, "Eye.right": CLOSED}, costs={"cpu": 1.5}),
        Strategy("hear", "Hear", 2, filters={"Ear.sound": 1}, parameters={"Ear": {"microphones": 2}}, costs={"cpu": 3}),
    ),
    {},
)
RESULTS = {
    Run("Eye", "left", 1): Measurement(2.4, 60, 60),
    Run("Eye", "left", 4): Measurement(0.6, 15, 60),
    Run("Ear", "sound", 1, parameters='{"microphones": 2}'): Measurement(3.0, 0, 60),
}
FOUND = CostCalibration(host="here", made="now", relations=relations(RESULTS))


def test_each_strategy_with_a_measured_cost_is_reported_with_its_declared_one() -> None:
    said = strategies_table(TABLE, FOUND, {"Eye.left", "Ear.sound with microphones=2"}, MODULES).splitlines()
    assert said[2:] == [
        "see           6.00      4.00   (without Eye.right)",
        "peep          1.50      1.00",
        "hear          3.00      5.00",
    ]
    assert strategies_table(TABLE, FOUND, {"Eye.left"}, MODULES).splitlines()[-1].startswith("peep")
    assert strategies_table(TABLE, FOUND, {"Nose.smell"}, MODULES) == ""


def test_relations_report_what_is_kept_and_what_finds_nothing() -> None:
    said = relations_table(FOUND, {"Eye.left"})
    assert "Ear.sound with microphones=2 (measured before, kept)" in said
    assert "Eye.left\n" in said
    assert said.count("holds nothing that this module finds") == 1
    assert "    4     1.00     0.00       0.25      1" in said
    assert "CPU % = 0 + 4/φ" in said
