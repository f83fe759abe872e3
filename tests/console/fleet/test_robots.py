"""Robots by what their consoles answer, and their names."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.console.fleet.robots import robot_of, unreachable, with_unique_names
from app.console.records.fleet import FleetRobot


def robot(name: str, state: str = "well") -> FleetRobot:
    return FleetRobot(name=name, body="IRL-1", url=f"http://{name}", state=state, detail="")  # type: ignore[arg-type]


def test_a_robot_of_an_earlier_version_is_called_by_its_body() -> None:
    answer = b'{"robot": {"name": "IRL-1", "new": 1}, "guard": {"state": "idle"}, "battery": {"charge": 0.5}}'
    found = robot_of(answer, "http://there")
    assert (found.name, found.state, found.charge, found.driver) == ("IRL-1", "well", 0.5, None)


def test_what_is_no_robot_is_said() -> None:
    for answer in (b"<!doctype html>", b"{}", b'{"robot": 1, "guard": {}}'):
        found = robot_of(answer, "http://there")
        assert found.state == "unreachable"
        assert "no robot's console" in found.detail


def test_a_guard_that_does_not_report_is_a_problem_and_a_latched_stop_is_a_stop() -> None:
    silent = b'{"robot": {"name": "a"}, "guard": {"state": "silent", "reason": "The body is gone."}}'
    assert (robot_of(silent, "u").state, robot_of(silent, "u").detail) == ("problem", "The body is gone.")
    stopped = b'{"robot": {"name": "a"}, "guard": {"state": "e_stopped", "reason": "Ada", "e_stopped": true}}'
    assert robot_of(stopped, "u").state == "stopped"


@given(st.lists(st.sampled_from(["", "a", "b", "c"]), max_size=6))
def test_each_of_one_name_is_a_problem_and_no_other(names: list[str]) -> None:
    robots = with_unique_names([robot(name) if name else unreachable("u", "") for name in names])
    for name, found in zip(names, robots, strict=True):
        assert (found.state == "problem") == (name != "" and names.count(name) > 1)


def test_a_stop_is_shown_whatever_its_robot_is_called() -> None:
    first, second = with_unique_names([robot("a", "stopped"), robot("a")])
    assert (first.state, second.state) == ("stopped", "problem")
    assert "another name" in first.detail
