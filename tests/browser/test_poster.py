"""What the robot finds is shown where it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page, WebSocket

from tests.browser.held_keys import hold_until
from tests.browser.running import Robot
from tests.console.view.viser_frames import viser_messages

REACH_M = 0.15


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
