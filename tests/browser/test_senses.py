"""What the robot sees and hears of people is on the page where it really is, and can be listened to and answered.

The talking person's place comes from the world's own stage, not from a module.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, Playwright, expect

from app.base.geometry import FloatArray
from app.base.kinematic_model import load_model
from app.base.paths import config_dir
from app.commands.doctor import find_chromium
from app.robots.simulated.scenery.scenario_config import load_scenario
from app.robots.simulated.scenery.scenario_state import ScenarioState
from tests.browser.running import CHROMIUM_ARGUMENTS, Robot, running_robot

#: Chromium's own tone in place of a microphone, granted without a question.
FAKE_MICROPHONE = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]
TALKER = """
name: one who talks
people:
  - {name: talker, face: visitor, at: [10.4, 7.0], heading_deg: -76, height_m: 1.7, script: [{wait: 60, look: robot}]}
sounds:
  - {name: talk, kind: speech, clip: story, person: talker, begin_s: 0.5, loop: true}
"""
FACE_M = 0.2
#: Whether a mark lies within ``far`` (rad) of where it should be, in JavaScript; it keeps the last for the message.
MARK_NEAR = """([selector, azimuth, elevation, far]) => {
  const marks = [...document.querySelectorAll(selector)].map(({ dataset }) => [+dataset.azimuth, +dataset.elevation]);
  if (marks.length > 0) window.lastMarks = marks;
  return marks.some(([a, e]) => Math.abs(a - azimuth) <= far && (elevation === null || Math.abs(e - elevation) <= far));
}"""
#: Pixels of a ring's own colour around the place of the first salient region on the strip, in JavaScript; it keeps the
#: place, at which to look while no region is marked.
RING_PIXELS = """() => {
  const canvas = document.querySelector('[data-testid=around] canvas');
  const mark = document.querySelector('[data-testid=around-region][data-rank="1"]');
  const turn = 2 * Math.PI, pixel = canvas.width / canvas.clientWidth;
  if (mark) window.lastRing = [0.5 - mark.dataset.azimuth / turn, mark.dataset.elevation / turn];
  const [across, up] = window.lastRing ?? [0, 0];
  const [x, y] = [across * canvas.width, canvas.height / 2 - up * canvas.width];
  const reach = 11 * pixel;
  const { data } = canvas.getContext('2d').getImageData(x - reach, y - reach, 2 * reach, 2 * reach);
  let ring = 0;
  for (let i = 0; i < data.length; i += 4)
    ring += Math.abs(data[i] - 255) < 12 && Math.abs(data[i + 1] - 150) < 12 && Math.abs(data[i + 2] - 60) < 12;
  return ring;
}"""
#: Of the 113 of a ring of 9 px, those that no smoothing has changed.
RING = 25


@dataclass(frozen=True)
class Direction:
    """Azimuth and elevation (rad) and distance (m), as the panorama's camera has it."""

    azimuth: float
    elevation: float
    distance: float


@pytest.fixture(scope="module")
def browser(playwright: Playwright) -> Iterator[Browser]:
    """A Chromium with a microphone."""
    arguments = CHROMIUM_ARGUMENTS + FAKE_MICROPHONE
    chromium = playwright.chromium.launch(executable_path=find_chromium(), args=arguments)
    yield chromium
    chromium.close()


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One person, 2.5 m ahead on the left, who talks all the time."""
    path = tmp_path_factory.mktemp("scenario") / "scenario.yaml"
    path.write_text(TALKER)
    return path


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory, scenario: Path) -> Iterator[Robot]:
    """A robot in front of the talking person, that wants to see and to hear them and may spend what that takes."""
    with running_robot(tmp_path_factory.mktemp("robot"), scenario) as running:
        assert running.request("PATCH", "/resources/cpu", {"capacity": 200})[0] == 200
        for kind in ("LocateFaces", "LocateVoices"):
            wish = {"class": kind, "intensity": 8, "utility": 4, "security": True}
            assert running.request("POST", "/desires", wish)[0] == 201
        yield running


def mouth_and_face(robot: Robot, scenario: Path) -> tuple[Direction, Direction]:
    """Where the mouth and the middle of the face of the talking person really are."""
    stage = ScenarioState(load_scenario(scenario))
    stage.advance(5.0, robot.start)
    (person,) = stage.people
    # From the mouth half way up to the eyes, 4 % of the height above it, is the middle of the face.
    x, y, z = person.mouth
    face = seen_from_the_panorama(robot, (x, y, z + 0.02 * person.height_m))
    return seen_from_the_panorama(robot, person.mouth), face


def seen_from_the_panorama(robot: Robot, p_W: tuple[float, float, float]) -> Direction:
    """The direction of a point of the world for the robot where it starts and stays."""
    X_BC = load_model(config_dir() / "robots" / "irl1_tr.urdf").pose("panorama_optical_frame")
    p_B: FloatArray = robot.start.to_pose3().inverse().transform(np.array(p_W)) - X_BC.translation
    x, y, z = (float(value) for value in p_B)
    return Direction(math.atan2(y, x), math.atan2(z, math.hypot(x, y)), math.hypot(x, y, z))


def wait_for_mark(page: Page, selector: str, azimuth: float, elevation: float | None, far: float) -> None:
    """Until a mark of ``selector`` is within ``far`` (rad) of a direction."""
    try:
        page.wait_for_function(MARK_NEAR, arg=[selector, azimuth, elevation, far])
    except Exception as error:
        marks = page.evaluate("window.lastMarks")
        raise AssertionError(f"{selector}: none near {azimuth:.3f}, {elevation}; the last were at {marks}") from error


def test_a_talking_person_is_marked_and_heard_and_can_be_answered(robot: Robot, page: Page, scenario: Path) -> None:
    """The disc within 10 degrees of the mouth, the frame on the face; samples to hear, and the voice the other way."""
    mouth, face = mouth_and_face(robot, scenario)

    # Without the 3D view the camera fills its place.
    page.get_by_test_id("listen").click()
    wait_for_mark(page, "[data-testid=around-sound]", mouth.azimuth, None, math.radians(10))
    wait_for_mark(page, "[data-testid=around-face]", face.azimuth, face.elevation, FACE_M / face.distance)
    frame = page.get_by_test_id("face-frame").first
    frame.wait_for()
    assert "Person" in frame.inner_text()
    page.locator("[data-testid=around]:not([data-stamp=''])").wait_for()

    # Louder than the fans, and not later than one waits for an answer.
    page.wait_for_function("""() => {
      const { latencyMs, levelDb } = document.querySelector('[data-testid=listen]').dataset;
      return latencyMs !== '' && +latencyMs < 3000 && levelDb !== '' && +levelDb > -60;
    }""")

    page.keyboard.down("KeyV")
    page.locator("[data-testid=talk][data-state=talking][data-taken=true]").wait_for()
    page.wait_for_function("() => +(document.querySelector('[data-testid=talk]').dataset.levelDb || -100) > -60")
    page.keyboard.up("KeyV")
    page.locator("[data-testid=talk][data-state=idle]").wait_for()
    page.get_by_test_id("listen").click()
    page.locator("[data-testid=listen][aria-pressed=false]").wait_for()


def test_what_stands_out_is_ringed_on_the_strip_and_can_be_hidden(robot: Robot, page: Page, scenario: Path) -> None:
    """The talking person is salient: a ring is drawn there, with words, until that is switched off."""
    _, face = mouth_and_face(robot, scenario)
    wish = {"class": "WatchSurroundings", "intensity": 8, "utility": 1}
    status, _, desire = robot.request("POST", "/desires", wish)
    assert status == 201
    wait_for_mark(page, "[data-testid=around-region]", face.azimuth, None, math.radians(15))
    page.wait_for_function(f"() => ({RING_PIXELS})() > {RING}")
    summary = page.get_by_test_id("around-text")
    expect(summary).to_contain_text("most salient")
    page.get_by_test_id("around-salient").click()
    expect(page.get_by_test_id("around-region")).to_have_count(0)
    page.wait_for_function(f"() => ({RING_PIXELS})() < {RING}")
    expect(summary).not_to_contain_text("most salient")
    page.get_by_test_id("around-salient").click()
    page.wait_for_function(f"() => ({RING_PIXELS})() > {RING}")
    assert robot.request("DELETE", f"/desires/{desire['id']}")[0] == 204


def test_the_words_that_are_listened_for_are_on_the_page_while_they_are(robot: Robot, page: Page) -> None:
    wish = {"class": "ListenForWords", "intensity": 8, "utility": 1, "params": {"words": "left, come here"}}
    status, _, desire = robot.request("POST", "/desires", wish)
    assert status == 201
    page.get_by_test_id("tab-found").click()
    expect(page.get_by_test_id("listening")).to_have_text("Listening for left, come here")
    assert robot.request("DELETE", f"/desires/{desire['id']}")[0] == 204
    expect(page.get_by_test_id("listening")).to_have_count(0)
