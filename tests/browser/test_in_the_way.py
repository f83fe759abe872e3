"""A wall in the robot's way, on the real page: it stops before it, says why, and crawls on while O is held."""

from __future__ import annotations

import re

from playwright.sync_api import Page, expect

from tests.browser.hands import hold, hold_until
from tests.browser.running import Robot

CALM = True
CRAWL_MPS = 0.1


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
    page.keyboard.down("KeyW")
    stopped.wait_for()
    assert robot.get("/robot")["guard"]["state"] in ("idle", "driving")
    assert robot.wheels()[-1].linear_mps == 0.0

    before = len(robot.wheels())
    page.keyboard.down("KeyO")
    expect(limited).to_have_attribute("data-override", "true")
    expect(limited).to_contain_text("Override")
    page.wait_for_timeout(400)
    page.keyboard.up("KeyO")
    expect(limited).to_have_text(re.compile("Stopped"))
    crawled = [row.linear_mps for row in robot.wheels()[before:]]
    assert 0.0 < max(crawled) <= CRAWL_MPS + 1e-6

    # The hold on screen, by the mouse, while the key goes on driving.
    before = len(robot.wheels())
    page.locator("[data-testid=override]").hover()
    page.mouse.down()
    expect(limited).to_have_attribute("data-override", "true")
    expect(limited).to_contain_text("Override")
    page.mouse.up()
    expect(limited).to_have_attribute("data-override", "false")
    page.keyboard.up("KeyW")
    crawled = [row.linear_mps for row in robot.wheels()[before:]]
    assert max(crawled) <= CRAWL_MPS + 1e-6
    expect(limited).to_have_count(0)
