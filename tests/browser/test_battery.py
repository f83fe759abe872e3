"""The battery in the bar at the top of the real page, and where programs read it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.browser.running import Robot, running_robot


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    """A robot whose battery is very low."""
    with running_robot(tmp_path, calm=True, light=True, charge=0.12) as running:
        yield running


def test_a_very_low_battery_is_red_and_an_event_and_the_robot_desires_its_dock(
    robot: Robot, open_page: Callable[..., Page]
) -> None:
    page = open_page()
    battery = page.get_by_test_id("battery")
    expect(battery).to_contain_text(re.compile(r"1[12] %"))
    expect(battery).to_have_attribute("data-tone", "poor")
    expect(battery).to_have_attribute("data-charging", "false")
    state = robot.get("/robot")["battery"]
    assert 0.1 < state["charge"] <= 0.12
    assert state["current_a"] < 0
    (event,) = robot.get("/timeline?kinds=battery")["events"]
    assert event["subject"] == "very low"
    docks = [desire for desire in robot.get("/desires")["desires"] if desire["class"] == "Dock"]
    assert [desire["source"]["name"] for desire in docks] == ["Recharge"]
