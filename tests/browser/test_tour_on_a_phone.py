"""A tour on a page as large as a phone: opened and edited, begun, watched and steered to its end, by touch alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.running import Robot
from tests.browser.test_tour import opened, reported, running
from tests.browser.tour_room import prepare

PHONE = {"width": 390, "height": 844}
#: The places are before the robot, where its first scan finds nothing, and so near that it stays where it is: on its
#: way with nobody behind it, it would wait for visitors.
STAND = {"face": "place", "tolerance_m": 2}
#: Longer than the test lasts: a stop ends when it is pressed.
WAIT = {"wait": {"at_most_s": 600, "press": {"en": "Go on"}}}
TITLES = {"arm": "Arm", "desk": "Desk"}
PLACES: list[dict[str, Any]] = [
    {"id": place, "name": place, "pose": {"x": 0.5, "y": y, "heading": 0.0}} for place, y in (("arm", 0), ("desk", 0.2))
]
TOUR: dict[str, Any] = {
    "format": 1,
    "id": "near",
    "title": {"en": "Near"},
    "languages": ["en"],
    "map": "room",
    "stops": [
        {"id": stop, "place": stop, "title": {"en": title}, "stand": STAND, "do": [WAIT]}
        for stop, title in TITLES.items()
    ],
}
WAITS = "Waits for visitors to go on"


def edit(page: Page, robot: Robot) -> None:
    """Another title for the first stop."""
    page.locator("[data-testid=tour][data-id=near]").get_by_test_id("tour-open").tap()
    page.locator("[data-testid=tour-stop][data-stop=arm]").get_by_test_id("stop-open").tap()
    title = page.get_by_test_id("stop-title-en")
    expect(title).to_have_value("Arm")
    title.fill("The arm")
    title.press("Enter")
    expect(page.locator("[data-stop=arm] .tour-stop-title")).to_have_text("The arm")
    expect(page.get_by_test_id("tour-state")).to_have_text("Kept")
    kept = robot.get("/tours/near")
    assert [stop["title"]["en"] for stop in kept["tour"]["stops"]] == ["The arm", "Desk"]
    page.get_by_test_id("tour-close").tap()


def lead(page: Page) -> None:
    """From the beginning to the end, by the page's buttons."""
    run = page.get_by_test_id("tour-run")
    state, stop = page.get_by_test_id("tour-run-state"), page.get_by_test_id("tour-run-stop")
    expect(page.get_by_test_id("tour-run-tour")).to_have_value("near")  # what was edited is what is led next
    page.get_by_test_id("tour-run-start").tap()
    expect(stop).to_have_text("Stop 1 of 2: The arm")
    expect(state).to_have_text(WAITS)
    page.get_by_test_id("tour-press-pause").tap()
    expect(state).to_have_text("Paused")
    expect(page.get_by_test_id("tour-run-held")).to_contain_text("until you press Resume")
    page.get_by_test_id("tour-press-resume").tap()
    expect(state).to_have_text(WAITS)
    page.get_by_test_id("tour-press-skip").tap()
    expect(stop).to_have_text("Stop 2 of 2: Desk")
    expect(state).to_have_text(WAITS)
    page.get_by_test_id("tour-press-end").tap()
    page.get_by_test_id("map-keep").tap()
    expect(run).to_have_attribute("data-state", "listening")
    page.get_by_test_id("tour-press-end").tap()
    page.get_by_test_id("map-confirm").tap()
    expect(run).to_have_attribute("data-state", "none")


def explore(page: Page, robot: Robot) -> None:
    """What its laser did not see behind it is mapped by a press."""
    page.get_by_test_id("tab-map").tap()
    tool = page.get_by_test_id("map-explore")
    tool.tap()
    expect(tool).to_have_attribute("aria-pressed", "true")
    expect(tool).to_have_attribute("aria-pressed", "false")
    (ended,) = [each for each in robot.get("/desires")["ended"] if each["class"] == "Explore"]
    assert ended["outcome"] == "done", ended
    assert "all that it can reach is mapped" in ended["reason"]


def test_on_a_phone_a_tour_is_edited_and_led(browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    with (
        running(tmp_path / "program", visitors=False) as robot,
        opened(browser, robot, viewport=PHONE, has_touch=True) as page,
    ):
        page.locator("[data-testid=page].narrow").wait_for()
        prepare(robot, TOUR, *PLACES)
        page.get_by_test_id("tab-tour").tap()
        edit(page, robot)
        lead(page)
        report = reported(robot)
        assert [stop["presented"] for stop in report["stops"]] == [False, False]
        assert report["failures"] == []
        explore(page, robot)
