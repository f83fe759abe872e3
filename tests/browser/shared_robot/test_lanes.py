"""The lanes: an instant is pinned and let go of, and what they show is saved as a picture and as a table."""

from __future__ import annotations

import csv
from pathlib import Path
from xml.etree import ElementTree

import cv2
import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.running import Robot


@pytest.fixture
def lanes(page: Page) -> Locator:
    """Where they are drawn, once they have something to show."""
    page.set_viewport_size({"width": 1440, "height": 900})
    page.locator("[data-testid=lane-canvas][data-newest]:not([data-newest=''])").wait_for()
    return page.get_by_test_id("lane-area")


def pin_the_present(lanes: Locator) -> Locator:
    """Click the lanes near their right edge, which is the present; what is shown of it."""
    box = lanes.bounding_box()
    assert box is not None
    lanes.click(position={"x": box["width"] - 3, "y": box["height"] / 2})
    pin = lanes.page.get_by_test_id("lane-pin")
    expect(pin.get_by_role("heading")).to_be_visible()
    return pin


def test_a_pinned_instant_shows_the_intention_of_then_and_escape_or_its_button_lets_go(
    robot: Robot, page: Page, lanes: Locator
) -> None:
    pin = pin_the_present(lanes)
    expect(pin).to_contain_text("Ω")
    expect(pin.locator(".lane-pin-use")).to_contain_text("CPU")
    codes = pin.get_by_role("listitem").filter(has_text="Find QR codes")
    expect(codes).to_contain_text("intensity 8, utility")
    expect(codes.locator(".state-word")).not_to_be_empty()
    expect(codes.locator(".muted").first).to_contain_text("of one core")  # what was selected, and its cost
    pin.get_by_role("button").click()
    expect(pin).to_have_count(0)

    for _ in range(30):  # where what the page shows is old for a moment, it cannot know that the robot is still
        page.locator("[data-testid=guard-state][data-state=idle]").wait_for()
        pin_the_present(lanes)
        page.get_by_test_id("layout").click()
        page.keyboard.press("Escape")  # the newest first
        expect(page.get_by_test_id("layout-box")).to_have_count(0)
        page.keyboard.press("Escape")
        expect(pin).to_have_count(0)
        state = robot.get("/robot")
        if not state["guard"]["e_stopped"]:
            return
        robot.request("DELETE", f"/stop?seen={state['stamp']}")
    pytest.fail("the robot was still, and Escape latched its emergency stop each time")


def test_what_they_show_is_saved_as_a_drawing_a_picture_and_a_table(page: Page, lanes: Locator) -> None:
    def saved(kind: str) -> Path:
        page.get_by_test_id("lanes-save").click()
        with page.expect_download() as download:
            page.locator(".lanes-save-kinds").get_by_role("button", name=kind.upper(), exact=True).click()
        assert download.value.suggested_filename.startswith("lanes-")
        assert download.value.suggested_filename.endswith(f".{kind}")
        return Path(download.value.path())

    drawing = ElementTree.parse(saved("svg")).getroot()
    assert drawing.tag == "{http://www.w3.org/2000/svg}svg"
    assert "Find QR codes" in "".join(drawing.itertext())
    picture = cv2.imread(str(saved("png")))
    assert picture is not None
    assert picture.std() > 0
    assert picture.shape[:2] == (2 * int(drawing.attrib["height"]), 2 * int(drawing.attrib["width"]))
    with saved("csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert rows
    assert {len(row) for row in rows} == {len(header)}
    assert any("FindQRCodes" in row for row in rows)
