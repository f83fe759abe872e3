"""The viewpoints of the 3D view: each key brings the browser's camera there, from the page and from the frame alike."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Page, expect

from tests.browser.running import Robot
from tests.browser.shared_robot.test_scene import STRIKE, frame_of

KEYS = {
    "Digit2": "aligned",
    "Digit3": "free",
    "Digit4": "head",
    "Digit5": "first_person",
    "Digit6": "top",
    "Digit7": "map",
    "Digit1": "behind",
}


def test_each_key_brings_the_camera_to_its_viewpoint_wherever_the_keyboard_is(
    robot: Robot, open_page: Callable[..., Page]
) -> None:
    page = open_page(scene=True)
    frame = frame_of(page)
    strip = page.get_by_test_id("viewpoints")
    expect(strip).to_have_attribute("data-arrived", "behind")
    expect(page.get_by_test_id("scene-age")).to_have_text(re.compile(r"^\d+ ms$|^\d+(\.\d)? s$"))
    for number, (code, name) in enumerate(KEYS.items()):
        if number % 2:
            frame.evaluate(STRIKE, ["keydown", code])
            frame.evaluate(STRIKE, ["keyup", code])
        else:
            page.keyboard.press(code)
        # The console says so once the browser has said that its camera is there.
        expect(strip).to_have_attribute("data-arrived", name)
        expect(page.get_by_test_id(f"viewpoint-{name}")).to_have_attribute("aria-pressed", "true")
    page.get_by_test_id("viewpoint-top").click()
    expect(strip).to_have_attribute("data-arrived", "top")
    assert robot.get("/robot")["odometry"]["linear_mps"] == 0.0
