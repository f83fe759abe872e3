"""Turning the head from the real page: by key, by stick, by a click on the picture; whatever ends it, it stays."""

from __future__ import annotations

import time
from collections.abc import Callable

from playwright.sync_api import Page, Position, expect

from tests.browser.running import Robot
from tests.patience import PATIENCE_S

#: A person who sees the head stand for so long lets go and presses again (s).
PRESS_AGAIN_S = 5.0


def pan(robot: Robot) -> float:
    """The set-point of the pan joint at the guard (rad, left positive): the first of the file's first group."""
    rows = robot.wheels()
    return rows[-1].setpoints[0] if rows else 0.0


def wait_for(page: Page, there: Callable[[], bool], within_s: float = PATIENCE_S) -> bool:
    """Whether ``there()`` becomes true."""
    end = time.monotonic() + within_s
    while not there():
        if time.monotonic() > end:
            return False
        page.wait_for_timeout(50)
    return True


def at_rest(robot: Robot, page: Page) -> float:
    """Where the head comes to rest (rad)."""
    before = pan(robot)
    while True:
        page.wait_for_timeout(700)
        now = pan(robot)
        if abs(now - before) < 1e-6:
            return now
        before = now


def hold_until(page: Page, press: Callable[[], None], let_go: Callable[[], None], there: Callable[[], bool]) -> None:
    """Press until ``there()``, and again for as long as a busy page lets go by itself; the hold is left on."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        press()
        if wait_for(page, there, PRESS_AGAIN_S):
            return
        let_go()
    raise AssertionError("the head never got there")


def test_a_held_key_turns_the_head_and_not_the_base_and_a_release_holds_it(robot: Robot, page: Page) -> None:
    begin = at_rest(robot, page)
    driven = len([row for row in robot.wheels() if row.linear_mps or row.angular_radps])
    hold_until(
        page, lambda: page.keyboard.down("KeyJ"), lambda: page.keyboard.up("KeyJ"), lambda: pan(robot) > begin + 0.4
    )
    page.keyboard.up("KeyJ")
    rested = at_rest(robot, page)
    assert rested > begin + 0.3, "it comes back by no more than the joint was behind its set-point"
    assert len([row for row in robot.wheels() if row.linear_mps or row.angular_radps]) == driven
    hold_until(
        page, lambda: page.keyboard.down("KeyL"), lambda: page.keyboard.up("KeyL"), lambda: pan(robot) < rested - 0.3
    )
    page.keyboard.up("KeyL")


def test_the_stick_turns_it_and_a_page_that_is_hidden_lets_go(robot: Robot, page: Page) -> None:
    begin = at_rest(robot, page)
    page.set_viewport_size({"width": 1280, "height": 800})  # in a narrow view, the picture is clicked instead
    box = page.get_by_test_id("head-stick").bounding_box()
    assert box is not None
    middle, edge = box["x"] + box["width"] / 2, box["x"] + box["width"] - 4
    side = 1 if begin < 0 else -1  # to the left or to the right: it need not be at its limit

    def press() -> None:
        page.mouse.move(middle, box["y"] + box["height"] / 2)
        page.mouse.down()
        page.mouse.move(edge if side < 0 else 2 * middle - edge, box["y"] + box["height"] / 2)

    hold_until(page, press, page.mouse.up, lambda: side * (pan(robot) - begin) > 0.3)
    page.evaluate("window.dispatchEvent(new Event('blur'))")
    rested = at_rest(robot, page)
    page.wait_for_timeout(500)
    assert pan(robot) == rested, "still pressed, but lost: it must be pressed again"
    page.mouse.up()


def test_a_closed_tab_lets_go(robot: Robot, page: Page) -> None:
    begin = at_rest(robot, page)
    key, side = ("KeyJ", 1) if begin < 0 else ("KeyL", -1)
    hold_until(
        page,
        lambda: page.keyboard.down(key),
        lambda: page.keyboard.up(key),
        lambda: side * (pan(robot) - begin) > 0.3,
    )
    page.close(run_before_unload=False)
    onlooker = page.context.new_page()
    assert abs(at_rest(robot, onlooker) - begin) < 2.0


def test_a_click_on_the_picture_turns_the_head_there(robot: Robot, page: Page) -> None:
    picture = page.locator("[data-testid=camera] canvas.looks")
    picture.wait_for()
    begin = at_rest(robot, page)
    left = begin < 0
    box = picture.bounding_box()
    assert box is not None
    # The picture is in the middle of a wider canvas.
    at: Position = {"x": box["width"] * (0.3 if left else 0.7), "y": box["height"] * 0.5}

    def clicked() -> bool:
        picture.click(position=at)
        return wait_for(page, lambda: (pan(robot) - begin if left else begin - pan(robot)) > 0.1, 20)

    assert wait_for(page, clicked), "the head did not turn to where the picture was clicked"
    desires = robot.get("/desires")["desires"]
    assert [d["params"]["frame"] for d in desires if d["class"] == "LookAt"] == ["odom"]
    expect(page.get_by_test_id("head-state")).to_have_text("LookAt turns the head.")
    for desire in desires:
        if desire["class"] == "LookAt":
            assert robot.request("DELETE", f"/desires/{desire['id']}")[0] == 204
