"""Driving by steps and by clicks, and a gamepad whose sticks and buttons are assigned by hand."""

from __future__ import annotations

import time

from playwright.sync_api import Page, expect

from tests.browser.held_keys import hold_by, press_until
from tests.browser.running import Robot
from tests.patience import PATIENCE_S

#: What the browser says of a pad: a real one cannot be plugged into a test.
_PAD = """
() => {
  const pad = { id: "Test pad (STANDARD)", index: 0, connected: true, mapping: "standard", axes: [0, 0, 0, 0],
                buttons: Array.from({ length: 16 }, () => ({ pressed: false, value: 0 })) };
  window.pad = pad;
  navigator.getGamepads = () => [pad];
  window.dispatchEvent(new Event("gamepadconnected"));
}
"""
_DRIVES = "[data-testid=guard-state][data-state=driving]"
_STANDS = "[data-testid=guard-state]:not([data-state=driving])"


def choose(page: Page, style: str) -> None:
    page.get_by_test_id("drive-settings").click()
    page.get_by_test_id(f"style-{style}").click()
    expect(page.get_by_test_id(f"style-{style}")).to_have_attribute("aria-checked", "true")
    page.get_by_test_id("drive-settings").click()


def test_one_press_goes_and_the_next_stops(page: Page) -> None:
    choose(page, "click")
    press_until(lambda: page.keyboard.press("KeyW"), page.locator(_DRIVES), again_ms=5_000)
    page.keyboard.press("KeyS")
    page.locator(_STANDS).wait_for()
    choose(page, "hold")


def test_a_step_ends_by_itself_while_the_key_stays_down(robot: Robot, page: Page) -> None:
    choose(page, "step")
    before = len(robot.wheels())

    def turned() -> bool:
        return any(row.angular_radps < 0 for row in robot.wheels()[before:])

    # A command that a busy computer gives too late moves nothing: then the key is pressed again.
    end = time.monotonic() + PATIENCE_S
    while not turned() and time.monotonic() < end:
        page.keyboard.up("KeyD")
        page.keyboard.down("KeyD")
        page.wait_for_timeout(2_000)
    assert turned()
    while robot.wheels()[-1].angular_radps != 0 and time.monotonic() < end:
        page.wait_for_timeout(50)
    assert robot.wheels()[-1].angular_radps == 0
    page.keyboard.up("KeyD")
    choose(page, "hold")


def test_a_pad_s_button_is_assigned_by_pressing_it_and_then_drives(page: Page) -> None:
    page.evaluate(_PAD)
    page.get_by_test_id("drive-settings").click()
    expect(page.get_by_test_id("pad-editor")).to_contain_text("Test pad")
    page.get_by_test_id("pad-deadMan").click()
    page.evaluate("() => (window.pad.buttons[9].pressed = true)")
    expect(page.get_by_test_id("pad-deadMan")).to_have_text("button 9")
    page.evaluate("() => (window.pad.buttons[9].pressed = false)")
    page.get_by_test_id("drive-settings").click()
    page.evaluate("() => (window.pad.axes[2] = 1)")

    def strike(way: str) -> None:
        page.evaluate("(down) => (window.pad.buttons[9].pressed = down)", way == "down")
        page.wait_for_timeout(500)  # a pad is looked at now and then: what is let go of for less is held on

    hold_by(page, strike, "the pad's button")
    strike("up")
    page.locator(_STANDS).wait_for()
