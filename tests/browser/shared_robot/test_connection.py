"""The page and its connection: it comes back by itself as it was, and asks nobody but the robot's own host."""

from __future__ import annotations

from collections.abc import Callable
from urllib.parse import urlsplit

from playwright.sync_api import Page, WebSocketRoute, expect

from tests.browser.running import Robot
from tests.browser.shared_robot.test_scene import frame_of

#: Keeps what the page says of its connection, however shortly.
PHASES = """() => {
  window.phases = [];
  new MutationObserver(() => {
    const shown = document.querySelector("[data-testid=connection]");
    if (shown) window.phases.push(shown.dataset.phase);
  }).observe(document, { subtree: true, attributes: true, attributeFilter: ["data-phase"] });
}"""


def test_after_a_loss_the_page_is_back_by_itself_as_it_was(page: Page) -> None:
    streams: list[WebSocketRoute] = []

    def relay(stream: WebSocketRoute) -> None:
        streams.append(stream)
        stream.connect_to_server()

    page.route_web_socket("**/api/v1/live*", relay)
    page.reload()
    live = page.locator("[data-testid=connection][data-phase=live]")
    live.wait_for()
    page.get_by_test_id("layout").click()
    page.get_by_test_id("theme").select_option("light")
    page.get_by_test_id("layout").click()
    page.get_by_test_id("tab-load").click()
    page.evaluate(PHASES)
    streams[-1].close()
    page.wait_for_function("window.phases.includes('lost')")
    live.wait_for()
    assert len(streams) >= 2
    expect(page.get_by_test_id("tab-load")).to_have_attribute("aria-selected", "true")
    expect(page.locator("html")).to_have_attribute("data-theme", "light")
    lanes = page.get_by_test_id("lane-canvas")
    newest = lanes.get_attribute("data-newest") or ""
    expect(lanes).not_to_have_attribute("data-newest", newest)  # what the robot says comes in again
    assert page.evaluate("window.phases.length") > 0, "the page was not loaded again"


def test_all_that_the_page_asks_for_comes_from_the_robot_s_host(robot: Robot, open_page: Callable[..., Page]) -> None:
    """With the 3D view, which has a port of its own; no tab asks the internet for anything."""
    asked: list[str] = []
    page = open_page()
    page.set_viewport_size({"width": 1440, "height": 900})
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda stream: asked.append(stream.url))
    page.goto(robot.url)
    page.locator("[data-testid=connection][data-phase=live]").wait_for()
    frame_of(page)
    for tab in page.get_by_role("tab").all():
        tab.click()
        expect(tab).to_have_attribute("aria-selected", "true")
    page.get_by_test_id("help").click()
    host = urlsplit(robot.url).hostname
    assert any("/viser" in url or urlsplit(url).port != urlsplit(robot.url).port for url in asked)
    foreign = [url for url in asked if urlsplit(url).scheme not in ("data", "blob") and urlsplit(url).hostname != host]
    assert foreign == []
