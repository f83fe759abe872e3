"""What people ask for moves the lanes and the filters."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page

from tests.browser.running import Robot, running_robot


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One robot for all tests: each leaves the desires as it found them."""
    with running_robot(tmp_path_factory.mktemp("robot")) as running:
        yield running


def lane(page: Page, desire_class: str) -> dict[str, str]:
    """The present values of one lane, as the page shows them."""
    row = page.get_by_test_id(f"lane-{desire_class}")
    return {
        name: row.get_attribute(f"data-{name}") or "" for name in ("intensity", "utility", "rate", "divisor", "state")
    }


def test_a_desire_over_rest_moves_lanes_and_filters(robot: Robot, page: Page) -> None:
    """Perceptions compete for one budget: asking for one more takes from another, until the desire expires."""
    lane_at = "[data-testid=lane-{}][data-divisor='{}']"
    # At its full rate is the camera, its main input: every second panorama is enough to look on.
    page.locator(lane_at.format("Telepresence", 1)).wait_for(state="attached")
    page.locator(lane_at.format("LocateFaces", 1)).wait_for(state="attached")
    before = robot.get("/intention")["filters"]
    assert before["FaceDetector.images"] == 1
    assert before["VoiceLocalizer.audio"] is None
    status, _, desire = robot.request(
        "POST",
        "/desires",
        {"class": "LocateVoices", "intensity": 8, "utility": 4, "security": False, "params": {}, "ttl": 600},
    )
    assert status == 201
    page.locator("[data-testid=desire-row]").filter(has_text="rest").first.wait_for(state="attached")
    page.locator(lane_at.format("LocateVoices", 1) + "[data-utility='4']").wait_for(state="attached")
    page.locator(lane_at.format("LocateFaces", 2)).wait_for(state="attached")
    during = robot.get("/intention")["filters"]
    assert (during["FaceDetector.images"], during["VoiceLocalizer.audio"]) == (2, 1)
    assert desire["expires"] is not None
    assert robot.request("PATCH", f"/desires/{desire['id']}", {"ttl": 1})[0] == 200
    page.locator(lane_at.format("LocateFaces", 1)).wait_for(state="attached")
    page.locator("[data-testid=lane-LocateVoices]:not([data-divisor='1'])").wait_for(state="attached")
    assert robot.get("/intention")["filters"] == before


def test_inhibiting_a_class_closes_its_filter(robot: Robot, page: Page) -> None:
    """Utility 0 at a higher intensity silences the class; its module gets nothing more."""
    # The scenario's own desire is as intense as can be: make room first.
    found = [desire for desire in robot.get("/desires")["desires"] if desire["class"] == "FindQRCodes"]
    for desire in found:
        assert robot.request("PATCH", f"/desires/{desire['id']}", {"intensity": 2})[0] == 200
    _, _, silencing = robot.request("POST", "/desires", {"class": "FindQRCodes", "intensity": 8, "utility": 0})
    page.locator("[data-testid=lane-FindQRCodes][data-state=inhibited]").wait_for(state="attached")
    assert robot.get("/intention")["filters"]["QRCodeDetector.images"] is None
    assert robot.request("DELETE", f"/desires/{silencing['id']}")[0] == 204
    for desire in found:
        assert robot.request("PATCH", f"/desires/{desire['id']}", {"intensity": desire["intensity"]})[0] == 200
    page.locator("[data-testid=lane-FindQRCodes]:not([data-state=inhibited])").wait_for(state="attached")


def test_a_desire_from_the_page(robot: Robot, page: Page) -> None:
    """The form made from the class's schema posts a desire, and its row can be removed again."""
    before = len(robot.get("/desires")["desires"])
    page.get_by_test_id("desire-add").click()
    page.get_by_test_id("field-class").select_option("FindQRCodes")
    page.get_by_test_id("desire-submit").click()
    page.locator("[data-testid=desire-row]").nth(before).wait_for()
    posted = robot.get("/desires")["desires"][-1]
    assert posted["class"] == "FindQRCodes"
    assert posted["source"]["kind"] == "operator"
    assert robot.request("DELETE", f"/desires/{posted['id']}")[0] == 204
