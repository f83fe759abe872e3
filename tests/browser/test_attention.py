"""What people ask for moves the lanes and the filters."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import Page, Position, Route, expect

from tests.browser.running import Robot, running_robot
from tests.patience import PATIENCE_S

#: Where the page asks for the budgets.
BUDGETS = "**/api/v1/resources"


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One robot for all tests: each leaves the desires as it found them."""
    with running_robot(tmp_path_factory.mktemp("robot")) as running:
        yield running


def lane(page: Page, desire_class: str) -> dict[str, str]:
    """The present values of one lane, as the page shows them."""
    row = page.get_by_test_id(f"lane-{desire_class}")
    return {
        name: row.get_attribute(f"data-{name}") or "" for name in ("intensity", "utility", "rate", "divisor", "state")
    }


def test_a_desire_over_rest_moves_lanes_and_filters(robot: Robot, page: Page) -> None:
    """Perceptions compete for one budget: asking for one more takes from another, until the desire expires."""
    lane_at = "[data-testid=lane-{}][data-divisor='{}']"
    # At its full rate is the camera, its main input: every second panorama is enough to look on.
    page.locator(lane_at.format("Telepresence", 1)).wait_for(state="attached")
    page.locator(lane_at.format("LocateFaces", 1)).wait_for(state="attached")
    before = robot.get("/intention")["filters"]
    assert before["FaceDetector.images"] == 1
    assert before["VoiceLocalizer.audio"] is None
    status, _, desire = robot.request(
        "POST",
        "/desires",
        {"class": "LocateVoices", "intensity": 8, "utility": 4, "security": False, "params": {}, "ttl": 600},
    )
    assert status == 201
    page.locator("[data-testid=desire-row]").filter(has_text="rest").first.wait_for(state="attached")
    page.locator(lane_at.format("LocateVoices", 1) + "[data-utility='4']").wait_for(state="attached")
    page.locator(lane_at.format("LocateFaces", 2)).wait_for(state="attached")
    during = robot.get("/intention")["filters"]
    assert (during["FaceDetector.images"], during["VoiceLocalizer.audio"]) == (2, 1)
    assert desire["expires"] is not None
    assert robot.request("PATCH", f"/desires/{desire['id']}", {"ttl": 1})[0] == 200
    page.locator(lane_at.format("LocateFaces", 1)).wait_for(state="attached")
    page.locator("[data-testid=lane-LocateVoices]:not([data-divisor='1'])").wait_for(state="attached")
    assert robot.get("/intention")["filters"] == before


def test_inhibiting_a_class_closes_its_filter(robot: Robot, page: Page) -> None:
    """Utility 0 at a higher intensity silences the class; its module gets nothing more."""
    # The scenario's own desire is as intense as can be: make room first.
    found = [desire for desire in robot.get("/desires")["desires"] if desire["class"] == "FindQRCodes"]
    for desire in found:
        assert robot.request("PATCH", f"/desires/{desire['id']}", {"intensity": 2})[0] == 200
    _, _, silencing = robot.request("POST", "/desires", {"class": "FindQRCodes", "intensity": 8, "utility": 0})
    page.locator("[data-testid=lane-FindQRCodes][data-state=inhibited]").wait_for(state="attached")
    assert robot.get("/intention")["filters"]["QRCodeDetector.images"] is None
    assert robot.request("DELETE", f"/desires/{silencing['id']}")[0] == 204
    for desire in found:
        assert robot.request("PATCH", f"/desires/{desire['id']}", {"intensity": desire["intensity"]})[0] == 200
    page.locator("[data-testid=lane-FindQRCodes]:not([data-state=inhibited])").wait_for(state="attached")


def test_what_if_shows_what_would_be_chosen_and_applies_it_only_when_confirmed(robot: Robot, page: Page) -> None:
    """A slider for the budget of CPU is pulled to its end: desires lose, on the page alone until it is confirmed."""
    before = robot.get("/intention")
    declared = before["use"]["cpu"]["capacity"]
    page.get_by_test_id("what-if-open").click()
    page.get_by_test_id("what-if-capacity-cpu").press("Home")
    answer = page.get_by_test_id("what-if-answer")
    expect(page.get_by_test_id("what-if-headline")).to_contain_text("would give up")
    expect(answer.get_by_test_id("what-if-LocateFaces")).to_contain_text("unfulfilled")
    assert robot.get("/intention")["use"]["cpu"]["capacity"] == declared
    page.get_by_test_id("what-if-reset").click()
    expect(answer).to_be_empty()
    page.get_by_test_id("what-if-capacity-cpu").press("End")
    page.get_by_test_id("what-if-apply").click()
    expect(page.get_by_test_id("what-if-deeds")).to_contain_text("CPU promised: at most")
    assert robot.get("/intention")["use"]["cpu"]["capacity"] == declared
    page.get_by_test_id("what-if-confirm").click()
    page.locator(f"[data-testid=budget-cpu][data-capacity='{2 * declared:g}']").wait_for(state="attached")
    expect(page.get_by_test_id("what-if-apply")).to_have_count(0)
    assert robot.get("/resources")["resources"][0]["capacity"] == 2 * declared
    assert robot.request("PATCH", "/resources/cpu", {"capacity": declared})[0] == 200
    page.get_by_test_id("what-if-open").click()


def test_a_desire_from_the_page(robot: Robot, page: Page) -> None:
    """The form made from the class's schema posts a desire, and its row can be removed again."""
    before = len(robot.get("/desires")["desires"])
    page.get_by_test_id("desire-add").click()
    page.get_by_test_id("field-class").select_option("FindQRCodes")
    page.get_by_test_id("desire-submit").click()
    page.locator("[data-testid=desire-row]").nth(before).wait_for()
    posted = robot.get("/desires")["desires"][-1]
    assert posted["class"] == "FindQRCodes"
    assert posted["source"]["kind"] == "operator"
    assert robot.request("DELETE", f"/desires/{posted['id']}")[0] == 204


def test_one_press_adds_a_desire_and_the_panel_says_what_gives_way(robot: Robot, page: Page) -> None:
    """A voice more, a face less: the panel's first sentence names what has less now."""
    page.get_by_test_id("quick-LocateVoices").click()
    page.locator("[data-testid=lane-LocateVoices][data-divisor='1']").wait_for(state="attached")
    expect(page.get_by_test_id("attention-headline")).to_contain_text("Locate faces")
    posted = next(desire for desire in robot.get("/desires")["desires"] if desire["class"] == "LocateVoices")
    assert posted["source"]["kind"] == "operator"
    assert posted["expires"] is not None
    assert robot.request("DELETE", f"/desires/{posted['id']}")[0] == 204


def test_what_is_felt_is_over_the_lanes(page: Page) -> None:
    """Joy of what is exploited: its name, how strong it is, and, once pressed, which classes it comes from."""
    joy = page.locator("[data-testid=emotions] [data-emotion=joy]")
    expect(joy).to_have_attribute("aria-description", re.compile(r"^(.*\n)*Find QR codes 0\.\d+"))
    for part, says in (("name", re.compile(r"^joy$")), ("figure", re.compile(r"^[01](\.\d+)?$"))):
        expect(joy.locator(f".feeling-{part}")).to_have_text(says)
        expect(joy.locator(f".feeling-{part}")).to_be_visible()
    why = joy.locator(".feeling-why")
    expect(why).to_be_hidden()
    joy.dispatch_event("click")  # as a finger presses, which nothing hovers over
    expect(why).to_be_visible()
    expect(why).to_contain_text("Find QR codes")


def test_a_budget_is_set_on_the_page_and_set_back(robot: Robot, page: Page) -> None:
    """With more to give everything is at its best, and the page knows what the budget was."""
    declared = robot.get("/resources")["resources"][0]
    assert declared["name"] == "cpu"
    late: list[Route] = []

    def hold_back(route: Route) -> None:
        late.append(route)

    page.route(BUDGETS, hold_back)
    with page.expect_request(BUDGETS):
        page.get_by_test_id("budget-edit-cpu").click()
    page.get_by_test_id("budget-field-cpu").fill("many")
    with page.expect_response(BUDGETS):
        late[0].continue_()
    page.unroute(BUDGETS)
    expect(page.get_by_test_id("budget-field-cpu")).to_have_value("many")  # what the robot says late changes nothing
    page.get_by_test_id("budget-set-cpu").click()
    expect(page.get_by_test_id("budget-cpu").get_by_role("alert")).to_contain_text("A number from 0 on")
    page.get_by_test_id("budget-field-cpu").fill("150")
    page.get_by_test_id("budget-set-cpu").click()
    expect(page.get_by_test_id("budget-cpu")).to_have_attribute("data-capacity", "150")
    expect(page.get_by_test_id("attention-headline")).to_contain_text("all it can use")
    page.get_by_test_id("budget-edit-cpu").click()
    page.get_by_test_id("budget-cpu").get_by_text("Back to").click()
    expect(page.get_by_test_id("budget-cpu")).to_have_attribute("data-capacity", f"{declared['declared']:g}")


def test_a_click_in_the_picture_is_a_goal(robot: Robot, page: Page) -> None:
    """A desire GoTo, to before what the camera sees ahead."""
    page.set_viewport_size({"width": 1440, "height": 900})  # in a low view, the driving controls are over its middle
    picture = page.locator("[data-testid=camera] canvas")
    page.get_by_test_id("camera-go").click()
    box = picture.bounding_box()
    assert box is not None
    middle: Position = {"x": box["width"] / 2, "y": box["height"] / 2}
    picture.click(position=middle)
    goal = page.locator("[data-testid=desire-row][data-class=GoTo]")
    given_up = time.monotonic() + PATIENCE_S
    while not robot.get("/goal")["desire"] and time.monotonic() < given_up:
        # On a busy computer the picture may be too old for a goal, which the page says.
        if page.get_by_test_id("notice").count():
            picture.click(position=middle, modifiers=["Shift"])
    goal.wait_for(state="attached")
    params = next(desire for desire in robot.get("/desires")["desires"] if desire["class"] == "GoTo")["params"]
    pose = robot.get("/robot")["odometry"]
    assert 0.3 < math.dist((params["x"], params["y"]), (pose["x"], pose["y"])) < 12
    assert robot.request("DELETE", "/goal")[0] in (200, 204)
    expect(goal).to_have_count(0)


def asked_s(url: str) -> float:
    """Length (s) of the past that the request ``url`` asks for; 0 of any other request."""
    parts = urlsplit(url)
    asked = parse_qs(parts.query)
    return float(asked["to"][0]) - float(asked["from"][0]) if parts.path == "/api/v1/lanes" else 0.0


def test_two_ranges_of_time_and_a_past_that_the_page_has_not_heard(robot: Robot, page: Page) -> None:
    given_up = time.monotonic() + PATIENCE_S
    while not robot.get("/lanes")["stamps"]:
        assert time.monotonic() < given_up, "a robot that has just started has lanes soon"
    page.goto(f"{robot.url}/?scene=off")
    page.get_by_test_id("lanes-large").click()
    page.get_by_test_id("lanes-compare").click()
    expect(page.get_by_test_id("lane-area-2")).to_be_visible()
    longer = page.get_by_label("Show a longer time").first
    with page.expect_response(lambda response: asked_s(response.url) > 1200) as answer:
        for window in ("1 min", "2 min", "5 min", "10 min", "20 min"):
            longer.click()
            expect(page.get_by_test_id("lanes-window")).to_have_text(window)
    assert answer.value.ok
    assert answer.value.json()["stamps"]
    # Each has its own window, and the lower edge of time in view.
    expect(page.get_by_test_id("lanes-window-2")).to_have_text("30 s")
    expect(page.get_by_test_id("lane-axis-2")).to_contain_text("now")
    expect(page.get_by_test_id("lane-axis")).not_to_contain_text("now")
    page.get_by_test_id("lanes-compare").click()
    expect(page.get_by_test_id("lane-area-2")).to_have_count(0)
