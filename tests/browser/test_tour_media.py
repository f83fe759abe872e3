"""A picture of a stop: handed in on the page, with what is refused, and seen on a visitor's phone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.test_tour import opened, running
from tests.browser.tour_room import prepare
from tests.tours.media_files import picture

WIDTH = 64
TOUR: dict[str, Any] = {
    "format": 1,
    "id": "pictures",
    "title": {"en": "Pictures"},
    "languages": ["en"],
    "map": "room",
    "stops": [
        {
            "id": "arm",
            "place": "here",
            "title": {"en": "The arm"},
            "do": [{"say": {"en": "Here."}}, {"wait": {"at_most_s": 600, "press": {"en": "Go on"}}}],
        }
    ],
}


def hand_in(page: Page) -> None:
    page.get_by_test_id("tour-toggle").click()
    page.locator("[data-testid=tour][data-id=pictures]").get_by_test_id("tour-open").click()
    page.get_by_test_id("stop-open").click()
    page.get_by_test_id("step-add-show").first.click()
    page.get_by_test_id("media-upload").set_input_files(
        {"name": "The page.png", "mimeType": "image/png", "buffer": b"<script>alert(1)</script>"}
    )
    expect(page.get_by_test_id("media-refusal")).to_contain_text("The page.png is no picture")
    page.get_by_test_id("media-upload").set_input_files(
        {"name": "The arm.png", "mimeType": "image/png", "buffer": picture(width=WIDTH)}
    )
    shown = page.get_by_test_id("media-shown")
    shown.wait_for()
    assert shown.evaluate("image => image.decode().then(() => image.naturalWidth)") == WIDTH
    expect(page.get_by_test_id("media-refusal")).to_have_count(0)
    expect(page.get_by_test_id("tour-state")).to_have_text("Kept")
    page.get_by_test_id("media-choose").click()
    (row,) = page.get_by_test_id("media-row").all()
    assert row.get_attribute("data-file") == "media/The-arm.png"
    expect(row.get_by_test_id("media-delete")).to_be_disabled()


def test_a_picture_from_the_page_is_seen_by_visitors(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    with running(tmp_path / "program", visitors=False) as robot, opened(browser, robot) as page:
        prepare(robot, TOUR, {"id": "here", "name": "Here", "here": True})
        hand_in(page)
        tour = robot.get("/tours/pictures")
        assert tour["tour"]["stops"][0]["do"][0]["show"]["file"] == "media/The-arm.png"
        assert not [each for each in tour["problems"] if each["field"].endswith("show.file")]
        status, _, answer = robot.request("POST", "/tours/pictures/run", {"begin": "now"})
        assert status == 200, answer
        phone = browser.new_context(viewport={"width": 390, "height": 844}).new_page()
        phone.goto(f"{robot.url}/visitor")
        seen = phone.get_by_test_id("visitor-media")
        seen.wait_for()
        assert seen.evaluate("image => image.decode().then(() => image.naturalWidth)") == WIDTH
        phone.context.close()
