"""A wall in the robot's way, on the real page: it stops before it, says why, and crawls on while O is held."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Locator, Page, TimeoutError, expect

from tests.browser.held_keys import hold, hold_until
from tests.browser.running import Robot

CALM = True
CRAWL_MPS = 0.1
#: After which time a person tries again.
SOON_MS = 5_000


def test_a_wall_stops_the_robot_and_the_override_crawls(robot: Robot, page: Page) -> None:
    page.locator("[data-testid=speed-full]").click()
    hold(page, "KeyA")
    while robot.odometry()["theta"] < 1.2:
        page.keyboard.up("KeyA")
        hold(page, "KeyA")  # pressed again where a busy page let go
        page.wait_for_timeout(500)
    page.keyboard.up("KeyA")
    limited = page.locator("[data-testid=limited]")
    stopped = limited.filter(has_text=re.compile(r"Stopped: something 0\.\d m"))
    hold_until(page, "KeyW", stopped)
    assert robot.get("/robot")["guard"]["state"] in ("idle", "driving")
    while robot.wheels()[-1].linear_mps != 0.0:
        page.wait_for_timeout(50)

    before = len(robot.wheels())
    crawl(page, stopped, lambda: page.keyboard.down("KeyO"), lambda: page.keyboard.up("KeyO"))
    page.wait_for_timeout(400)
    page.keyboard.up("KeyO")
    page.keyboard.up("KeyW")
    crawled = [row.linear_mps for row in robot.wheels()[before:]]
    assert 0.0 < max(crawled) <= CRAWL_MPS + 1e-6

    # The hold on screen, by the mouse, while the key goes on driving.
    before = len(robot.wheels())

    def press() -> None:
        page.locator("[data-testid=override]").hover(timeout=SOON_MS)
        page.mouse.down()

    crawl(page, stopped, press, page.mouse.up)
    page.mouse.up()
    expect(limited).not_to_have_attribute("data-override", "true")
    page.keyboard.up("KeyW")
    crawled = [row.linear_mps for row in robot.wheels()[before:]]
    assert max(crawled) <= CRAWL_MPS + 1e-6
    expect(limited).to_have_count(0)


def crawl(page: Page, stopped: Locator, press: Callable[[], None], release: Callable[[], None]) -> None:
    """Drive against what is in the way, and ``press`` the override until the page says that it crawls.

    A busy page lets go of what is held: then all is held again.
    """
    crawling = page.locator("[data-testid=limited][data-override=true]").filter(has_text="Override")
    for _ in range(30):
        page.keyboard.up("KeyW")
        page.keyboard.down("KeyW")
        try:
            stopped.wait_for(timeout=SOON_MS)
            press()
            crawling.wait_for(timeout=SOON_MS)
        except TimeoutError:
            release()
        else:
            return
    raise AssertionError("the override was held again and again, and never taken")
