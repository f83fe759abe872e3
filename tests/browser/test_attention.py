"""What people ask for moves the lanes and the filters, and what the robot finds is shown where it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page, WebSocket

from tests.browser.held_keys import hold_until
from tests.browser.running import Robot
from tests.console.view.viser_frames import viser_messages

REACH_M = 0.15


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
    for desire in robot.get("/desires")["desires"]:
        if desire["class"] == "FindQRCodes":
            assert robot.request("PATCH", f"/desires/{desire['id']}", {"intensity": 2})[0] == 200
    robot.request("POST", "/desires", {"class": "FindQRCodes", "intensity": 8, "utility": 0})
    page.locator("[data-testid=lane-FindQRCodes][data-state=inhibited]").wait_for(state="attached")
    assert robot.get("/intention")["filters"]["QRCodeDetector.images"] is None


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


def test_a_poster_driven_up_to_is_found_where_it_hangs(robot: Robot, open_page: Callable[..., Page]) -> None:
    """Its code is decoded from the rendered picture, listed, and drawn in the scene within 0.15 m of its true place.

    One page drives; a second one then looks at the scene, and what viser's client is sent there is read on its way.
    """
    page = open_page()
    # The robot starts facing one of the posters, a few metres off.
    text = min(robot.posters, key=lambda text: abs(robot.true_place(text)[1]))
    page.get_by_test_id("tab-found").click()
    row = page.locator(f"[data-testid=landmark][data-text='{text}']")
    hold_until(page, "KeyW", row)
    seen = [float(row.get_attribute(f"data-{axis}") or "nan") for axis in "xyz"]
    assert math.dist(seen, robot.true_place(text)) < REACH_M
    onlooker = open_page(scene=True)
    drawn: list[dict[str, Any]] = []
    onlooker.on("websocket", lambda socket: _collect(socket, drawn))
    onlooker.reload()
    # Below the map's node, once the robot is localized on it.
    nodes = ("/odom/landmark_0", "/odom/map/landmark_0")
    places = [m["position"] for m in drawn if m["type"] == "SetPositionMessage" and m["name"] in nodes]
    while not places:
        onlooker.wait_for_timeout(100)
        places = [m["position"] for m in drawn if m["type"] == "SetPositionMessage" and m["name"] in nodes]
    assert math.dist(places[-1], robot.true_place(text)) < REACH_M
    assert any(m["type"] == "LabelMessage" and text in str(m) for m in drawn)


def _collect(socket: WebSocket, drawn: list[dict[str, Any]]) -> None:
    """Keep what is said of landmarks on viser's connection."""
    if "/viser?" not in socket.url:
        return

    def take(frame: bytes | str) -> None:
        if isinstance(frame, bytes):
            drawn.extend(m for m in viser_messages(frame) if "/landmark_" in str(m.get("name")))

    socket.on("framereceived", take)
