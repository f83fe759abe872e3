"""The page by keyboard alone: Tab comes by all that is on it, and a desire is added without a mouse."""

from __future__ import annotations

from playwright.sync_api import Page, expect

from tests.browser.running import Robot

#: What has the focus, by name; empty where nothing has it, or where nobody sees that it has.
_FOCUSED = """
() => {
  const focused = document.activeElement;
  if (!focused || focused === document.body || !focused.checkVisibility({ visibilityProperty: true })) return "";
  const box = focused.getBoundingClientRect();
  if (box.width < 2 || box.height < 2 || !focused.matches(":focus-visible")) return "";
  return focused.dataset.testid || focused.className || focused.tagName;
}
"""
#: More than there are to come by.
MOST_STOPS = 200


def test_tab_comes_by_everything_and_a_desire_is_added(robot: Robot, page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    page.locator("[data-testid=lane-canvas][data-newest]:not([data-newest=''])").wait_for()

    def press(key: str) -> str:
        page.keyboard.press(key)
        focused: str = page.evaluate(_FOCUSED)
        assert focused, f"after {key}, nothing is seen to have the focus"
        return focused

    def tab_to(wanted: str) -> list[str]:
        """Every stop on the way to ``wanted``."""
        stops: list[str] = []
        while wanted not in stops:
            stops.append(press("Tab"))
            assert len(stops) < MOST_STOPS, f"{wanted} is not reached: {stops}"
        return stops

    stops = tab_to("lane-area")
    assert stops[:3] == ["skip-map", "skip-panels", "skip-lanes"]
    order = ["layout", "help", "estop", "say", "tab-attention", "desire-add", "lane-area"]
    assert [stop for stop in stops if stop in order] == order

    page.reload()  # to the top again
    page.locator("[data-testid=connection][data-phase=live]").wait_for()
    tab_to("skip-panels")
    assert press("Enter") == "tab-attention"
    assert press("ArrowRight") != "tab-attention"
    assert press("ArrowLeft") == "tab-attention"
    tab_to("desire-add")
    page.keyboard.press("Enter")
    kind = page.get_by_test_id("field-class")
    expect(kind).to_be_focused()
    page.keyboard.type("Detect Dark")
    expect(kind).to_have_value("DetectDarkness")
    tab_to("desire-submit")
    with page.expect_response("**/api/v1/desires") as answer:
        page.keyboard.press("Enter")
    assert answer.value.status == 201
    expect(page.get_by_test_id("desire-add")).to_be_focused()
    added = answer.value.json()["id"]
    row = page.locator(f"[data-testid=desire-row][data-id='{added}']")
    expect(row).to_have_attribute("data-class", "DetectDarkness")
    while page.evaluate("id => document.activeElement.closest(`[data-id='${id}']`) === null", added):
        press("Tab")
    assert page.evaluate(_FOCUSED) == "desire-remove"
    page.keyboard.press("Enter")
    expect(row).to_have_count(0)
    assert robot.get(f"/desires/{added}")["outcome"] == "withdrawn"
