"""A guided tour, whole: configured by driving past posters, kept over a restart, and led among two visitors."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from app.base.geometry import Pose2
from tests.browser.held_keys import hold_until
from tests.browser.running import Robot, running_program
from tests.browser.tour_room import POSTERS, SIDE_M, VISITORS, write_program
from tests.patience import PATIENCE_MS, PATIENCE_S

MIDDLE = Pose2(SIDE_M / 2, SIDE_M / 2, 0.0)
#: A stop is a place before its poster (m).
BEFORE_M = 1.2
#: How near it comes to that (m) where a slow computer reads the poster once or twice while the robot turns past it.
SEEN_IN_PASSING_M = 0.3


@contextmanager
def running(folder: Path, *, visitors: bool) -> Iterator[Robot]:
    folder.mkdir()
    program = write_program(folder, visitors=visitors)
    with running_program(program, folder / "guard.log", MIDDLE, folder / "room.yaml") as robot:
        yield robot


@contextmanager
def opened(browser: Browser, robot: Robot, **window: Any) -> Iterator[Page]:
    context = browser.new_context(**{"viewport": {"width": 1280, "height": 800}} | window)
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{robot.url}/?scene=off")
    page.locator("[data-testid=connection][data-phase=live]").wait_for()
    yield page
    context.close()
    assert errors == []


def configure(page: Page) -> None:
    """Three stops, by turning the robot to the left past the posters on the walls."""
    page.get_by_test_id("tour-toggle").click()
    page.get_by_test_id("tour-new-title").fill("The room")
    page.get_by_test_id("tour-drive").click()
    for number in range(1, len(POSTERS) + 1):
        hold_until(page, "KeyA", page.locator(f"[data-testid=tour-driving][data-met='{number}']"))
    page.get_by_test_id("tour-drive-finish").click()
    page.get_by_test_id("tour-stop").nth(len(POSTERS) - 1).wait_for()


def begin(page: Page, tour: str) -> None:
    """Load the map that the tour is on, at whose start the robot is again, and lead the tour."""
    page.get_by_test_id("tab-tour").click()
    page.get_by_test_id("tour-run-tour").select_option(tour)
    another = page.get_by_test_id("tour-run-map")
    another.get_by_test_id("tour-run-load").click()
    another.get_by_test_id("map-at-start").check()
    another.get_by_test_id("map-load-confirm").click()
    another.wait_for(state="detached")
    page.get_by_test_id("tour-run-start").click()


def reported(robot: Robot) -> dict[str, Any]:
    """The tour's report, once the robot has said goodbye."""
    given_up = time.monotonic() + 3 * PATIENCE_S  # a busy computer's world is slow
    while time.monotonic() < given_up:
        reports = robot.get("/tour-reports")["reports"]
        if reports and reports[0]["ended"] is not None:
            report: dict[str, Any] = reports[0]
            return report
        time.sleep(0.5)
    raise AssertionError(f"the tour goes on and on: {robot.get('/tour-run')}")


@pytest.mark.timeout(1740)  # below what ends a run that hangs
def test_a_tour_configured_by_driving_is_led_after_a_restart(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    with running(tmp_path / "first", visitors=False) as robot, opened(browser, robot) as page:
        configure(page)
        (tour,) = (each for each in robot.get("/tours")["tours"] if not each["shipped"])
        assert (tour["stops"], tour["errors"], tour["map"]) == (len(POSTERS), 0, "the-room"), (
            "the map is called as the tour"
        )
        for place, (text, hangs) in zip(robot.get("/places")["places"], POSTERS.items(), strict=True):
            assert place["poster"] == text
            x, y, _ = robot.true_place(text)
            facing = math.radians(hangs["facing_deg"])
            before = x + BEFORE_M * math.cos(facing), y + BEFORE_M * math.sin(facing)
            assert math.dist((place["x"], place["y"]), before) < SEEN_IN_PASSING_M
    with running(tmp_path / "second", visitors=True) as robot:
        with opened(browser, robot) as page:
            begin(page, tour["id"])
            page.locator("[data-testid=tour-run][data-stop=arm]").wait_for()
        # The page is closed: it would take as much of the computer as the robot itself.
        report = reported(robot)
        assert [stop["presented"] for stop in report["stops"]] == [True] * len(POSTERS)
        assert 1 <= report["people_most"] <= len(VISITORS)
        assert report["failures"] == []
