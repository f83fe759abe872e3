"""The page in Firefox, as it is released: what people do with the robot, done once in the other browser.

Who drives and the stop of a blocked page are tested in both browsers by ``test_wheel.py``, login and visitors by
``test_doors.py``.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, Playwright, expect

from tests.browser.browsers import NO_DISPLAY, display, launching, missing
from tests.browser.held_keys import hold, hold_by, press_until
from tests.browser.map_view import map_view
from tests.browser.running import Robot, running_robot
from tests.browser.shared_robot.test_scene import STRIKE, frame_of
from tests.browser.test_driving import moving, wait_for_rest
from tests.patience import PATIENCE_MS

#: Whether a canvas shows anything: pixels of more than one colour.
DRAWN = """(canvas) => {
    const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    return new Set(new Uint32Array(pixels.buffer)).size > 1;
}"""
LIVE = "[data-testid=connection][data-phase=live]"
IDLE = "[data-testid=guard-state][data-state=idle]"
STOPPED = "[data-testid=guard-state][data-state=e_stopped]"

pytestmark = pytest.mark.skipif(missing("firefox") is not None, reason=missing("firefox") or "")


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One for the whole file: each test leaves it standing, its stop released."""
    with running_robot(tmp_path_factory.mktemp("robot"), calm=True, light=True) as running:
        yield running


@pytest.fixture(scope="module")
def screen() -> Iterator[str | None]:
    """A display, where there can be one."""
    with display(1500, 1000) as name:
        yield name


@pytest.fixture(scope="module")
def browser(playwright: Playwright, screen: str | None) -> Iterator[Browser]:
    """One Firefox for all tests; on a display where there is one, for without it has no WebGL."""
    environment = os.environ if screen is None else os.environ | {"DISPLAY": screen}
    firefox = playwright.firefox.launch(**launching("firefox"), headless=screen is None, env=dict(environment))
    yield firefox
    firefox.close()


def release(robot: Robot, page: Page) -> None:
    """The emergency stop, by REST."""
    assert robot.request("DELETE", f"/stop?seen={robot.get('/robot')['stamp']}")[0] == 200
    page.locator(IDLE).wait_for()


def test_the_page_comes_up_live_and_no_error_is_in_its_console(browser: Browser, robot: Robot) -> None:
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    errors: list[str] = []

    def hear(message: ConsoleMessage) -> None:
        if message.type == "error":
            errors.append(message.text)

    page.on("console", hear)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{robot.url}/?scene=off")
    page.locator(LIVE).wait_for()
    # Pictures keep coming: a second one is drawn after the first.
    camera = page.locator("[data-testid=camera]:not([data-stamp=''])")
    first = camera.get_attribute("data-stamp")
    expect(camera).not_to_have_attribute("data-stamp", first or "")
    context.close()
    assert errors == []


def test_a_held_key_drives_and_its_release_stops(robot: Robot, page: Page) -> None:
    before = len(robot.wheels())
    hold(page, "KeyW")
    page.keyboard.up("KeyW")
    rows = wait_for_rest(robot, page, lasting_s=0.3)
    assert any(row.linear_mps > 0 for row in rows[before:])
    page.locator(IDLE).wait_for()


def test_the_emergency_stop_latches_by_its_button_and_by_space_twice(robot: Robot, page: Page) -> None:
    page.get_by_test_id("estop").click()
    page.locator(STOPPED).wait_for()
    page.keyboard.down("KeyW")
    page.wait_for_timeout(500)
    page.keyboard.up("KeyW")
    assert not moving(robot.wheels()[-1])
    page.get_by_test_id("estop-release").click()
    page.get_by_test_id("estop-release-confirm").click()
    page.locator(IDLE).wait_for()
    while not robot.get("/robot")["guard"]["e_stopped"]:  # on a busy computer two presses may come further apart
        page.keyboard.press("Space")
        page.keyboard.press("Space")
        page.wait_for_timeout(200)
    page.locator(STOPPED).wait_for()
    release(robot, page)


def test_a_desire_is_added_and_its_lane_is_drawn(robot: Robot, page: Page) -> None:
    before = len(robot.get("/desires")["desires"])
    page.get_by_test_id("desire-add").click()
    page.get_by_test_id("field-class").select_option("FindQRCodes")
    page.get_by_test_id("desire-submit").click()
    page.locator("[data-testid=desire-row]").nth(before).wait_for()
    posted = robot.get("/desires")["desires"][-1]
    assert (posted["class"], posted["source"]["kind"]) == ("FindQRCodes", "operator")
    assert robot.request("DELETE", f"/desires/{posted['id']}")[0] == 204
    page.locator("[data-testid=lane-FindQRCodes]:not([data-utility=''])").wait_for(state="attached")
    assert page.get_by_test_id("lane-canvas").evaluate(DRAWN)


def test_presets_lay_the_page_out(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    for preset, lanes in (("drive", 0), ("debug", 1), ("attention", 1)):
        page.get_by_test_id("layout").click()
        page.get_by_test_id(f"layout-{preset}").click()
        expect(page.get_by_test_id("layout-box")).to_have_count(0)
        expect(page.get_by_test_id("lanes")).to_have_count(lanes)


def test_a_click_on_the_map_is_a_goal_and_space_ends_the_trip(robot: Robot, page: Page) -> None:
    _, _, mapping = robot.request("POST", "/desires", {"class": "SLAM", "intensity": 8, "utility": 1})
    page.get_by_test_id("tab-map").click()
    canvas = page.locator("[data-testid=map-canvas][data-robot]:not([data-robot=''])")
    canvas.wait_for()
    page.get_by_test_id("map-toggle").click()
    page.get_by_test_id("map-fit").click()
    page.get_by_test_id("map-tool-goal").click()
    robot_x, robot_y, _ = map(float, (canvas.get_attribute("data-robot") or "").split())
    # It faces along the map's x, with a free way of two metres before where it began; it may have driven it already.
    goal_x = robot_x + (1.0 if robot.odometry()["x"] < 1.0 else -1.0)
    press_until(lambda: page.mouse.click(*map_view(page).at(goal_x, robot_y)), page.get_by_test_id("map-cancel"))
    goal = robot.get("/goal")["desire"]["params"]
    assert abs(goal["x"] - goal_x) < 0.1
    assert abs(goal["y"] - robot_y) < 0.1
    page.keyboard.press("Space")
    page.get_by_test_id("map-cancel").wait_for(state="detached")
    assert robot.get("/goal")["desire"] is None
    assert robot.request("DELETE", f"/desires/{mapping['id']}")[0] == 204


def test_the_3d_view_is_drawn_and_its_keys_choose_viewpoints_and_drive(
    robot: Robot, open_page: Callable[..., Page], screen: str | None
) -> None:
    if screen is None:
        pytest.skip(NO_DISPLAY)
    page = open_page(scene=True)
    frame = frame_of(page)
    strip = page.get_by_test_id("viewpoints")
    expect(strip).to_have_attribute("data-arrived", "behind")
    frame.evaluate(STRIKE, ["keydown", "Digit6"])
    frame.evaluate(STRIKE, ["keyup", "Digit6"])
    expect(strip).to_have_attribute("data-arrived", "top")
    hold_by(page, lambda way: frame.evaluate(STRIKE, [f"key{way}", "KeyW"]), "W over the 3D view")
    frame.evaluate(STRIKE, ["keyup", "KeyW"])
    page.locator(IDLE).wait_for()
