"""The 3D view's frame: in a process of its own, and its keys drive all the same.

They turn the robot, which other files share: wherever it looks, there is room to turn.
"""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Frame, Page, expect

from tests.browser.held_keys import hold, hold_by, press_until
from tests.browser.running import Robot

SHOWN = "[data-testid=scene][data-state=shown]"
#: A key of the keyboard, pressed or let go of in the frame itself: the page takes the keyboard back from it at once.
STRIKE = """([type, code]) => document.body.dispatchEvent(
    new KeyboardEvent(type, {code, key: code, bubbles: true, cancelable: true}))"""
#: The frame's process hangs, as where it draws; its key is never let go of.
HANG = "() => void setTimeout(() => { const end = performance.now() + 3000; while (performance.now() < end); })"


def frame_of(page: Page) -> Frame:
    """The frame of the 3D view, once it is shown."""
    page.locator(SHOWN).wait_for()
    (frame,) = page.frames[1:]
    return frame


def processes_apart(page: Page) -> int:
    """How many frames have a process of their own."""
    browser = page.context.browser
    assert browser is not None
    targets = browser.new_browser_cdp_session().send("Target.getTargets")["targetInfos"]
    return [target["type"] for target in targets].count("iframe")


def click_on_floor(page: Page) -> None:
    """Click beside the driving panel, below the horizon, as seen from behind the robot."""
    box = page.locator("[data-testid=scene] iframe").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.82 * box["width"], box["y"] + 0.42 * box["height"])


def wait_idle(page: Page) -> None:
    """Until the guard says that nothing drives."""
    page.locator("[data-testid=guard-state][data-state=idle]").wait_for()


def hold_in(frame: Frame, page: Page) -> None:
    """Hold the key that turns to the left in the frame until the robot drives."""
    hold_by(page, lambda way: frame.evaluate(STRIKE, [f"key{way}", "KeyA"]), "KeyA in the frame")


def test_the_view_has_its_own_process_and_its_keys_drive_until_they_are_let_go_of_or_it_hangs(
    robot: Robot, open_page: Callable[..., Page]
) -> None:
    page = open_page(scene=True)
    frame = frame_of(page)
    assert frame.url.startswith(robot.get("/scene")["url"])
    assert processes_apart(page) == 1

    picked = page.get_by_test_id("scene-picked")
    press_until(lambda: click_on_floor(page), picked, again_ms=5_000)
    page.locator("[data-testid=scene] iframe").focus()
    expect(page.locator("[data-testid=stick]")).to_be_focused()  # the keyboard is back at once
    hold(page, "KeyA")
    expect(picked).to_have_count(0)  # its place in the view is another now
    page.keyboard.up("KeyA")
    wait_idle(page)

    hold_in(frame, page)
    frame.evaluate(STRIKE, ["keyup", "KeyA"])
    wait_idle(page)
    hold_in(frame, page)
    frame.evaluate("dispatchEvent(new Event('blur'))")
    wait_idle(page)
    hold_in(frame, page)
    frame.evaluate(HANG)
    wait_idle(page)

    frame.evaluate(STRIKE, ["keydown", "Escape"])
    page.locator("[data-testid=guard-state][data-state=e_stopped]").wait_for()
    stamp = robot.get("/robot")["stamp"]
    assert robot.request("DELETE", f"/stop?seen={stamp}")[0] == 200


def test_a_port_out_of_reach_leaves_the_view_on_the_page_s_own_and_its_keys_drive_too(
    robot: Robot, open_page: Callable[..., Page]
) -> None:
    scene = robot.get("/scene")["url"]
    page = open_page()
    page.route(f"{scene}**", lambda route: route.abort())
    page.goto(robot.url)
    page.locator("[data-testid=connection][data-phase=live]").wait_for()
    frame = frame_of(page)
    assert frame.url.startswith(f"{robot.url}/viser/")
    assert processes_apart(page) == 0
    expect(page.get_by_test_id("notice")).to_have_count(0)
    hold_in(frame, page)
    page.get_by_test_id("scene-toggle").click()  # the frame is closed, and its key with it
    wait_idle(page)
