"""The robot's face on its own page: blinks, expresses what is desired, speaks, and comes back after a loss."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, WebSocketRoute, expect

from app.modules.behaviors.face.expression import JOINTS
from tests.browser.running import Robot
from tests.patience import PATIENCE_MS

#: Waits, in the page's own frames, until a joint as drawn is above or below a position (rad).
UNTIL = """([joint, position, above]) => {
  const pose = document.querySelector("[data-testid=face]").dataset.pose;
  const drawn = Number(pose.split(" ")[joint]);
  return above ? drawn > position : drawn < position;
}"""
#: Waits until the sound that the page plays is louder, or softer, than a level (dB of full scale).
HEARD = """([level, above]) => {
  const { levelDb } = document.querySelector("[data-testid=listen]").dataset;
  return levelDb !== "" && (above ? +levelDb > level : +levelDb < level);
}"""
#: The fans alone are softer than the one, the robot's own voice is louder than the other.
FANS_DB, VOICE_DB = -50, -40
#: Keeps what the page says of its link, however shortly.
LINKS = """window.links = [];
new MutationObserver(() => window.links.push(document.body.dataset.link)).observe(
  document, { subtree: true, attributes: true, attributeFilter: ["data-link"] });"""


def until(page: Page, joint: str, position: float, *, above: bool) -> None:
    page.wait_for_function(UNTIL, arg=[JOINTS.index(joint), position, above], timeout=PATIENCE_MS)


def watched(robot: Robot) -> bool:
    """Whether a page desires pictures."""
    return any(desire["class"] == "Telepresence" for desire in robot.get("/desires")["desires"])


def test_it_blinks_expresses_speaks_and_comes_back(browser: Browser, robot: Robot) -> None:
    errors: list[str] = []
    asked: set[str] = set()
    streams: list[WebSocketRoute] = []

    def hear(message: ConsoleMessage) -> None:
        if message.type == "error":
            errors.append(message.text)

    def relay(stream: WebSocketRoute) -> None:
        stream.connect_to_server()
        streams.append(stream)

    context = browser.new_context(viewport={"width": 844, "height": 390})
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.on("console", hear)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: asked.add(request.url))
    page.add_init_script(LINKS)
    page.route_web_socket("**/api/v1/face", relay)
    while watched(robot):  # by another test's page, for a moment yet
        page.wait_for_timeout(100)
    page.goto(f"{robot.url}/face")
    page.locator("body[data-link=live]").wait_for()
    assert page.locator("button, input, a, select").count() == 0, "no controls"
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight"), "nothing to scroll"
    until(page, "eyelids_joint", 0.8, above=True)
    until(page, "eyelids_joint", 0.4, above=False)

    wish = {"class": "Express", "intensity": 8, "utility": 4, "params": {"expression": "happy"}}
    status, _, desire = robot.request("POST", "/desires", wish)
    assert status == 201
    until(page, "left_mouth_corner_joint", 0.5, above=True)
    assert robot.request("DELETE", f"/desires/{desire['id']}")[0] == 204
    until(page, "left_mouth_corner_joint", 0.25, above=False)

    text = 60 * "Aha, I am a robot. "  # until it has been seen, however seldom a busy computer draws
    said = {"class": "Say", "intensity": 8, "utility": 4, "params": {"text": text}}
    status, _, desire = robot.request("POST", "/desires", said)
    assert status == 201
    expect(page.get_by_test_id("subtitles").locator("mark")).not_to_be_empty()
    until(page, "lower_lip_joint", 0.15, above=True)
    assert robot.request("DELETE", f"/desires/{desire['id']}")[0] == 204
    until(page, "lower_lip_joint", 0.05, above=False)
    expect(page.get_by_test_id("subtitles")).to_be_empty()

    page.evaluate("window.links = []")
    streams[0].close()
    page.wait_for_function("window.links.includes('lost')")
    page.locator("body[data-link=live]").wait_for()
    assert len(streams) >= 2
    assert errors == []
    assert all(url.startswith((robot.url, "data:")) for url in asked), asked
    assert not watched(robot), "a face is no viewer"

    console = context.new_page()
    console.set_viewport_size({"width": 1000, "height": 640})  # a phone has no sheet of shortcuts
    console.goto(f"{robot.url}/?scene=off")
    console.locator("[data-testid=connection][data-phase=live]").wait_for()
    console.get_by_test_id("help").click()
    with context.expect_page() as opened:
        console.get_by_test_id("face-link").click()
    opened.value.locator("body[data-link=live]").wait_for()
    context.close()


def test_a_sentence_is_heard_on_the_page(robot: Robot, page: Page) -> None:
    """What the loudspeaker says comes through the room and the microphones to who listens, with subtitles."""
    pytest.importorskip("espeakng_loader", reason="the extra `speech` is not installed: nothing speaks")
    page.get_by_test_id("listen").click()
    page.wait_for_function(HEARD, arg=[FANS_DB, False])
    said = {"class": "Say", "intensity": 8, "utility": 4, "params": {"text": 60 * "Aha, I am a robot. "}}
    status, _, desire = robot.request("POST", "/desires", said)
    assert status == 201
    page.wait_for_function(HEARD, arg=[VOICE_DB, True])
    expect(page.get_by_test_id("subtitles")).to_contain_text("I am a robot")
    assert robot.request("DELETE", f"/desires/{desire['id']}")[0] == 204
    page.wait_for_function(HEARD, arg=[FANS_DB, False])
    page.get_by_test_id("listen").click()
    page.locator("[data-testid=listen][aria-pressed=false]").wait_for()
