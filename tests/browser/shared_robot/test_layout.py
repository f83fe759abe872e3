"""The page at twelve sizes: nothing lies under anything, presets and separators work, and axe finds no violation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.checks import axe_script, covered_by_notices, covered_controls, keep_sockets, violations
from tests.browser.running import Robot
from tests.browser.shared_robot.test_lanes import pin_the_present

#: Phones, tablets, laptops and desks; both ways up.
SIZES = (
    (3840, 2160), (1920, 1080), (1440, 900), (1366, 768), (1280, 720), (1024, 768),
    (1024, 600), (912, 1368), (768, 1024), (844, 390), (390, 844), (360, 640),
)  # fmt: skip
#: Where notices, too, must leave each control free. Where the window has no room for that, they leave driving free.
NOTICED = {(1920, 1080), (1440, 900), (768, 1024), (844, 390), (390, 844)}


#: Of what a selector finds, what is in dark letters: over a canvas, and over what changes colour, axe decides nothing.
_DARK = """
(selector) => [...document.querySelectorAll(selector)].filter((each) => {
  const [red, green, blue] = getComputedStyle(each).color.match(/[0-9.]+/g).map(Number);
  return each.checkVisibility() && 0.2126 * red + 0.7152 * green + 0.0722 * blue < 128;
}).map((each) => each.dataset.testid || each.className || each.tagName)
"""
#: What lies over the map, which is dark in every theme.
_OVER_MAP = ".map-where, .map-empty, .map-view-buttons .icon-button"
#: What lies over the dark red of a stopped robot.
_OVER_RED = ".top-bar :is(h1, .chip, .metric dd, .record), .dock :is(.drive-speed, .drive-speed b, .icon-button)"


#: Whether the view's middle is the 3D view itself, and no picture that lies over it.
_MIDDLE_FREE = """
() => {
  const frame = document.querySelector("[data-testid=scene] iframe");
  const box = frame.getBoundingClientRect();
  return document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2) === frame;
}
"""


@pytest.mark.parametrize("scene", [False, True], ids=["camera", "3D"])
def test_at_every_size_each_control_can_be_pressed(open_page: Callable[..., Page], scene: bool) -> None:
    page = open_page(scene=scene)
    keep_sockets(page)
    if scene:
        page.get_by_test_id("viewpoints").wait_for()
    covered: dict[tuple[int, int], Any] = {}
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        # Which layout it is follows the window in the next frame.
        page.locator(f"[data-testid=page].{'narrow' if width < 760 else 'wide'}").wait_for()
        page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        covered[width, height] = covered_controls(page)
        if (width, height) in NOTICED:
            covered[width, height] += covered_by_notices(page)
        if scene and (width, height) == (1440, 900):
            for picture in ("camera", "around"):
                expect(page.locator(f"[data-testid={picture}].inset")).to_be_visible()
            assert page.evaluate(_MIDDLE_FREE)
    assert {size: found for size, found in covered.items() if found} == {}


@pytest.mark.parametrize("scaled", ["text", "page"])
@pytest.mark.parametrize("size", [(1440, 900), (390, 844)], ids=["desk", "phone"])
def test_at_twice_the_size_of_text_or_page_each_control_can_be_pressed(
    page: Page, scaled: str, size: tuple[int, int]
) -> None:
    """As people set them in the browser: a default text of 32 px instead of 16; a zoom of 200 %, which leaves half the
    pixels to the page each way."""
    width, height = size
    if scaled == "page":
        width, height = width // 2, height // 2
    else:
        page.context.new_cdp_session(page).send("Page.setFontSizes", {"fontSizes": {"standard": 32, "fixed": 26}})
    page.set_viewport_size({"width": width, "height": height})
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    if scaled == "text":
        assert page.evaluate("getComputedStyle(document.documentElement).fontSize") == "32px"
    assert covered_controls(page) == []


def test_presets_show_what_they_are_for(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    lanes = page.get_by_test_id("lanes")

    def choose(preset: str) -> None:
        page.get_by_test_id("layout").click()
        page.get_by_test_id(f"layout-{preset}").click()
        expect(page.get_by_test_id("layout-box")).to_have_count(0)

    choose("drive")
    expect(lanes).to_have_count(0)
    expect(page.get_by_test_id("tab-map")).to_have_attribute("aria-selected", "true")
    choose("tour")
    expect(page.locator("[data-testid=page].mapped")).to_have_count(1)
    choose("debug")
    expect(page.get_by_test_id("tab-load")).to_have_attribute("aria-selected", "true")
    expect(lanes).to_be_visible()
    choose("attention")
    expect(page.locator("[data-testid=page].mapped")).to_have_count(0)


def test_a_separator_is_dragged_and_moved_by_keys_and_kept_over_a_reload(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    separator, side = page.get_by_test_id("side-splitter"), page.locator("aside.tabs")
    before = side.bounding_box()
    assert before is not None
    box = separator.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, 400)
    page.mouse.down()
    page.mouse.move(720, 400, steps=4)
    page.mouse.up()
    expect(separator).to_have_attribute("aria-valuenow", "49")
    box = separator.bounding_box()
    assert box is not None
    assert box["x"] + box["width"] / 2 == pytest.approx(720, abs=2), "it is where the pointer let go of it"
    separator.press("ArrowLeft")
    expect(separator).to_have_attribute("aria-valuenow", "51")
    after = side.bounding_box()
    assert after is not None
    assert after["width"] > before["width"] + 200
    page.reload()
    expect(separator).to_have_attribute("aria-valuenow", "51")
    separator.dblclick()
    expect(separator).to_have_attribute("aria-valuenow", "28")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing(page: Page, theme: str) -> None:
    axe = axe_script()
    page.set_viewport_size({"width": 1440, "height": 900})
    page.emulate_media(color_scheme="light" if theme == "light" else "dark")
    expect(page.locator(f"html[data-theme={theme}]")).to_have_count(1)
    found = {"page": violations(page, axe)}
    page.get_by_test_id("tab-map").click()
    page.locator(".map-stage .icon-button").first.wait_for()
    assert page.evaluate(_DARK, _OVER_MAP) == []
    for tab in ("map", "tour", "found", "load", "graph", "events", "recordings"):
        page.get_by_test_id(f"tab-{tab}").click()
        if tab == "graph":
            page.get_by_test_id("graph-Kinect").click()
        found[tab] = violations(page, axe)
    page.get_by_test_id("tab-attention").click()
    page.get_by_test_id("desire-add").click()
    found["form"] = violations(page, axe)
    page.get_by_test_id("what-if-open").click()
    page.get_by_test_id("what-if-capacity-cpu").press("Home")
    page.locator("[data-testid=what-if-answer] h3").wait_for()
    found["what if"] = violations(page, axe)
    page.get_by_test_id("layout").click()
    found["layout"] = violations(page, axe)
    page.get_by_test_id("lanes-large").click()
    page.locator("[data-testid=lanes].large").wait_for()
    pin_the_present(page.get_by_test_id("lane-area"))
    found["large lanes, and an instant pinned"] = violations(page, axe)
    page.get_by_test_id("lanes-large").click()
    page.set_viewport_size({"width": 390, "height": 844})
    page.locator("[data-testid=page].narrow").wait_for()
    found["phone"] = violations(page, axe)
    assert {state: problems for state, problems in found.items() if problems} == {}


def test_where_the_processor_draws_nothing_moves_by_itself(page: Page) -> None:
    """What moves makes 60 frames a second: here all changes come at the page's turns."""
    assert page.locator("html").get_attribute("data-drawn") == "processor"
    page.locator("[data-testid=lane-canvas][data-newest]:not([data-newest=''])").wait_for()
    moved = page.locator("[data-testid=lane-canvas]").get_attribute("style")
    expect(page.locator("[data-testid=lane-canvas]")).not_to_have_attribute("style", moved or "")
    assert page.evaluate("document.getAnimations().map((each) => each.constructor.name)") == []


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (390, 844)])
def test_all_is_legible_while_the_robot_is_stopped(robot: Robot, page: Page, width: int, height: int) -> None:
    page.set_viewport_size({"width": width, "height": height})
    page.emulate_media(color_scheme="light")
    page.locator("html[data-theme=light]").wait_for()
    assert page.evaluate(_DARK, _OVER_RED) != [], "over white they are dark"
    page.get_by_test_id("estop").first.click()
    page.locator("[data-testid=guard-state][data-state=e_stopped]").wait_for()
    try:
        assert page.evaluate(_DARK, _OVER_RED) == []
    finally:
        state = robot.get("/robot")
        assert robot.request("DELETE", f"/stop?seen={state['stamp']}")[0] in (200, 204)
    page.locator("[data-testid=guard-state][data-state=idle]").wait_for()
