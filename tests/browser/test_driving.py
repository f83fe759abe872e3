"""Driving the real robot program from the real page: it moves while held, and stops for every reason there is."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, Page, TimeoutError, expect

from app.robots.simulated.guard_log import GuardRow
from tests.browser.held_keys import hold, hold_until
from tests.browser.running import Robot, running_robot
from tests.console.slow_link import slow_link_aside
from tests.patience import PATIENCE_S

#: The guard stops wheels without commands within so long, by its own clock.
GUARD_S = 0.25


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One for the whole file, which begins where the way is free for longest: test after test drives on.

    A calm one: this is about how soon the wheels stop, not about what else the computer can do beside.
    """
    with running_robot(tmp_path_factory.mktemp("robot"), calm=True, light=True) as running:
        yield running


@pytest.fixture(autouse=True)
def _free_to_drive(robot: Robot) -> None:
    """Whatever the test before left."""
    seen = robot.get("/robot")["stamp"]
    assert robot.request("DELETE", f"/stop?seen={seen}")[0] == 200


def moving(row: GuardRow) -> bool:
    """Whether the wheels are given any velocity."""
    return row.linear_mps != 0 or row.angular_radps != 0


def wheels_until(robot: Robot, page: Page, within_s: float = PATIENCE_S) -> Iterator[list[GuardRow]]:
    """What the wheels were given so far, again and again for ``within_s`` (of this computer), which between looks is
    left to the robot and to the browser of ``page``."""
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        yield robot.wheels()
        page.wait_for_timeout(20)


def wait_for_rest(robot: Robot, page: Page, lasting_s: float = 0.0) -> list[GuardRow]:
    """Until the wheels, having moved, are given nothing for ``lasting_s``; the rows up to the first still one of it.

    On a busy computer a held key's commands may come late: the robot stops for a moment, and goes on.
    """
    for rows in wheels_until(robot, page):
        driven = [index for index, row in enumerate(rows) if moving(row)]
        if driven and driven[-1] < len(rows) - 1 and rows[-1].monotonic_s - rows[driven[-1]].monotonic_s > lasting_s:
            return rows[: driven[-1] + 2]
    raise AssertionError("the wheels were never still")


def hold_fast(robot: Robot, page: Page) -> None:
    """Hold the forward key until the wheels are given some speed: a busy computer lets go of it, and it is pressed
    again."""
    for _ in range(30):
        hold(page, "KeyW")
        if any(rows and rows[-1].linear_mps > 0.1 for rows in wheels_until(robot, page, 4)):
            return
        page.keyboard.up("KeyW")
    raise AssertionError("the wheels were never fast")


def take_control(page: Page, driver: Page) -> None:
    """Take the wheel from ``driver``'s page, and wait until ``page`` shows that it has it.

    A page that is silent for a second, or holds nothing for ten, gives the wheel up: on a busy computer either may do
    so before the other has asked or shown it. Then ``driver`` drives again, and is asked again.
    """
    for _ in range(30):
        try:
            page.get_by_test_id("take-control").first.click(timeout=15_000)
            page.get_by_test_id("release-control").first.wait_for(timeout=15_000)
        except TimeoutError:
            hold_until(driver, "KeyW", page.locator("[data-testid=guard-state][data-state=driving]"))
        else:
            return
    raise AssertionError("the wheel was never taken")


def wait_odometry(robot: Robot, page: Page, there: Callable[[dict[str, float]], bool]) -> None:
    """Until odometry is as it is to be: on a busy computer the simulated world is slower than the page's time."""
    end = time.monotonic() + PATIENCE_S
    while not there(robot.odometry()):
        assert time.monotonic() < end, "the robot did not get there"
        page.wait_for_timeout(50)


def stopped_by(robot: Robot, page: Page, take_away: Callable[[], float]) -> tuple[float, list[GuardRow]]:
    """Drive by a held key, and have ``take_away`` end that, which returns when it did; then, and what the wheels were
    given until they rested.

    On a busy computer the page may have let go by itself just before, which says nothing of what stops it: then again.
    """
    for _ in range(30):
        hold_fast(robot, page)
        taken = take_away()
        rows = wait_for_rest(robot, page, lasting_s=0.3)
        if moving([row for row in rows if row.monotonic_s < taken][-1]):
            return taken, rows
        page.keyboard.up("KeyW")
    raise AssertionError("the page let go by itself each time")


def test_held_key_drives_and_release_stops(robot: Robot, page: Page) -> None:
    """Forward by a held key, then still, by odometry."""
    before = robot.odometry()

    def forward(odometry: dict[str, float]) -> float:
        return math.hypot(odometry["x"] - before["x"], odometry["y"] - before["y"])

    while forward(robot.odometry()) <= 0.3:
        hold(page, "KeyW")
        page.wait_for_timeout(1000)
        page.keyboard.up("KeyW")  # and pressed again, for a busy page may have let go of it
    wait_for_rest(robot, page)
    wait_odometry(robot, page, lambda odometry: abs(odometry["linear_mps"]) < 0.02)
    # From the page's normal speed of about 0.2 m/s at 0.4 m/s2: 0.05 m, and what is driven until the key is seen.
    assert forward(robot.odometry()) < 0.9


@pytest.mark.parametrize("how", ["blur", "pagehide", "visibilitychange"])
def test_whatever_takes_the_page_away_stops(robot: Robot, page: Page, how: str) -> None:
    """A key is still down, but the page is hidden: stop; and do not start again when people come back."""

    def take_away() -> float:
        lost = time.monotonic()
        if how == "visibilitychange":
            page.evaluate(
                "Object.defineProperty(document, 'hidden', {value: true, configurable: true});"
                "Object.defineProperty(document, 'visibilityState', {value: 'hidden', configurable: true});"
                "document.dispatchEvent(new Event('visibilitychange'))"
            )
        else:
            page.evaluate("name => window.dispatchEvent(new Event(name))", how)
        return lost

    _, stopped = stopped_by(robot, page, take_away)
    page.wait_for_timeout(300)
    assert not any(map(moving, robot.wheels()[len(stopped) :]))


def test_a_closed_tab_stops(robot: Robot, page: Page) -> None:
    """Closing the tab while a key is down stops the robot, for good."""
    hold_fast(robot, page)
    page.close(run_before_unload=False)
    onlooker = page.context.new_page()
    stopped = wait_for_rest(robot, onlooker)
    onlooker.wait_for_timeout(300)
    assert not any(map(moving, robot.wheels()[len(stopped) :]))


def test_a_frozen_page_stops(robot: Robot, page: Page) -> None:
    """A page that hangs says nothing: the robot stops by itself, while the page still hangs."""

    def freeze() -> float:
        browser = page.context.browser
        assert browser is not None
        processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
        renderers = [process["id"] for process in processes if process["type"] == "renderer"]
        frozen = time.monotonic()
        for process in renderers:
            os.kill(process, signal.SIGSTOP)
        try:
            wait_for_rest(robot, page)
        finally:
            for process in renderers:
                os.kill(process, signal.SIGCONT)
        page.keyboard.up("KeyW")  # or it would drive on
        return frozen

    stopped_by(robot, page, freeze)


def test_a_frozen_runtime_stops(robot: Robot, page: Page) -> None:
    """The whole program is stopped by a signal: the guard, in its own process, brakes within 250 ms."""
    hold_fast(robot, page)
    frozen = time.monotonic()
    robot.process.send_signal(signal.SIGSTOP)
    try:
        wait_for_rest(robot, page)
        next(rows for rows in wheels_until(robot, page) if rows[-1].monotonic_s > frozen + GUARD_S)
        assert not any(moving(row) for row in robot.wheels() if row.monotonic_s > frozen + GUARD_S)
        page.locator("[data-testid=connection]:is([data-phase=stale], [data-phase=lost])").wait_for()
    finally:
        robot.process.send_signal(signal.SIGCONT)
        page.keyboard.up("KeyW")


def test_emergency_stop_latches(robot: Robot, page: Page) -> None:
    """The button stops at once, keys do nothing until it is released on purpose, and then only when pressed again."""
    hold(page, "KeyW")
    page.get_by_test_id("estop").click()
    page.locator("[data-testid=guard-state][data-state=e_stopped]").wait_for()
    page.keyboard.up("KeyW")
    page.keyboard.down("KeyW")
    page.wait_for_timeout(700)
    assert robot.get("/robot")["guard"]["e_stopped"] is True
    assert not moving(robot.wheels()[-1])
    page.keyboard.up("KeyW")
    page.get_by_test_id("estop-release").click()
    page.get_by_test_id("estop-release-confirm").click()
    page.locator("[data-testid=guard-state][data-state=idle]").wait_for()
    assert not moving(robot.wheels()[-1])
    hold(page, "KeyW")
    page.keyboard.up("KeyW")


def test_two_pages_share_one_wheel(robot: Robot, open_page: Callable[[], Page]) -> None:
    """The second page watches and shows who drives; it takes the wheel only by asking, and the first is stopped."""
    first, second = open_page(), open_page()
    hold_until(first, "KeyW", second.locator("[data-testid=guard-state][data-state=driving]"))
    stopped = wait_for_rest(robot, first, lasting_s=0.3)
    second.keyboard.down("KeyW")
    expect(second.get_by_test_id("notice").first).to_be_visible()
    second.keyboard.up("KeyW")
    assert not any(map(moving, robot.wheels()[len(stopped) :]))
    take_control(second, first)
    hold(second, "KeyW")
    second.keyboard.up("KeyW")


def test_escape_closes_the_help_of_a_standing_robot_and_stops_a_moving_one(robot: Robot, page: Page) -> None:
    """What opens over a page closes with Escape; but a robot that moves is stopped, whatever is open."""
    for _ in range(30):  # where what the page shows is old for a moment, it cannot know that the robot is still
        page.get_by_test_id("help").click()
        page.keyboard.press("Escape")
        page.get_by_test_id("help-sheet").wait_for(state="detached")
        state = robot.get("/robot")
        if not state["guard"]["e_stopped"]:
            break
        robot.request("DELETE", f"/stop?seen={state['stamp']}")
        page.locator("[data-testid=guard-state][data-state=idle]").wait_for()
    else:
        pytest.fail("the robot was still, and Escape latched its emergency stop each time")
    latched = page.locator("[data-testid=guard-state][data-state=e_stopped]")
    for _ in range(30):  # what the page let go of in between is still, and is not latched
        hold(page, "KeyW")
        page.get_by_test_id("help").click()
        page.keyboard.press("Escape")
        page.get_by_test_id("help-sheet").wait_for(state="detached")
        page.keyboard.up("KeyW")
        try:
            latched.wait_for(timeout=5_000)
        except TimeoutError:
            continue
        return
    pytest.fail("the robot moved, and Escape did not latch its emergency stop")


def test_turning_left_is_to_the_left_and_right_is_back(robot: Robot, page: Page) -> None:
    """A turns the heading counter-clockwise, D back, and both move nowhere."""
    before = robot.odometry()

    def turned(odometry: dict[str, float]) -> float:
        return math.remainder(odometry["theta"] - before["theta"], math.tau)

    hold(page, "KeyA")
    wait_odometry(robot, page, lambda odometry: turned(odometry) > 0.3)
    page.keyboard.up("KeyA")
    wait_for_rest(robot, page, lasting_s=0.3)
    hold(page, "KeyD")
    wait_odometry(robot, page, lambda odometry: turned(odometry) < 0.15)
    page.keyboard.up("KeyD")
    wait_for_rest(robot, page, lasting_s=0.3)
    after = robot.odometry()
    assert turned(after) < 0.2
    assert math.hypot(after["x"] - before["x"], after["y"] - before["y"]) < 0.1


def test_over_a_slow_network_driving_waits_and_the_page_says_why(robot: Robot, browser: Browser) -> None:
    """Commands that take 3 s move nothing, though the key is held; on a quick network again they do."""
    with slow_link_aside(robot.url) as link:
        context = browser.new_context(viewport={"width": 1000, "height": 640})
        page = context.new_page()
        page.goto(f"{link.url}/?scene=off")
        page.locator("[data-testid=connection][data-phase=live]").wait_for()
        hold(page, "KeyW")
        link.up_s = 3.0
        hint = page.locator(".drive-hint.warn")
        expect(hint).to_contain_text("late: driving waits.")
        rested = len(wait_for_rest(robot, page, lasting_s=0.3))
        page.keyboard.up("KeyW")
        page.keyboard.down("KeyW")
        expect(page.get_by_test_id("notice").filter(has_text="driving waits")).not_to_have_count(0)
        page.keyboard.up("KeyW")
        link.up_s = 0.0
        expect(hint).to_have_count(0)
        assert not any(map(moving, robot.wheels()[rested:]))
        hold(page, "KeyW")
        page.keyboard.up("KeyW")
        wait_for_rest(robot, page)
        context.close()
