"""From an unknown place to going where the page points: mapped by hand, kept, found again, crossed from room to room.

The map is made in virtual time by a teleoperation script; what people do with it is done in the page, to the real
program. The robot's true place comes from the world, not from a module. The body has laser and wheels alone: what
cameras draw would take the time that world, program and browser need together.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
import yaml
from playwright.sync_api import Page, expect

from app.attention.desires import Source
from app.base.geometry import Pose2
from app.base.paths import config_dir
from app.experiments.script import Waypoint, drive_script
from app.experiments.world_run import WorldRun, run_in_world
from app.maps.library import MapLibrary
from app.program.config import load_configuration
from app.robots.config import load_robot_config
from tests.browser.held_keys import hold, hold_until
from tests.browser.map_view import map_view
from tests.browser.running import LOOPS_DEBUG, Robot, running_program
from tests.browser.witness import true_pose
from tests.patience import PATIENCE_S

MAP = "two-rooms"
#: Where the robot begins to map: the map's origin; from there into the living room.
MAPPED_FROM = Pose2(11.0, 4.6, math.radians(90))
DRIVE = (Waypoint(go=(11.0, 2.75)), Waypoint(go=(13.4, 2.75)))
#: Where it wakes up, in the corridor, and where in the living room it is sent (world).
FOUND_AT = Pose2(11.05, 4.2, math.radians(140))
SENT_TO = Pose2(13.7, 3.0, math.radians(90))
#: Enough to map by at this pace, and a third of the work.
MAPPING_HZ = 10
HANDS = Source("operator", "script")
REACHED_M, FACED_RAD = 0.25, 0.2


@pytest.fixture(scope="module")
def maps(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a map of corridor and living room."""
    folder = tmp_path_factory.mktemp("maps")
    program = write_program(tmp_path_factory.mktemp("mapping"), MAPPED_FROM, scans_hz=MAPPING_HZ)
    configuration = load_configuration(program)
    body = load_robot_config(program.parent / "robot.yaml")

    async def drive(run: WorldRun) -> None:
        for kind in ("SLAM", "Teleoperation"):
            run.system.workspace.add(kind, intensity=8, utility=1, source=HANDS)
        await drive_script(run.system, DRIVE)
        await run.system.map.server.save(MAP)

    # Playwright holds this thread's event loop.
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(1) as aside:
        patch.delenv(LOOPS_DEBUG, raising=False)
        aside.submit(run_in_world, configuration, body, drive, maps=MapLibrary(folder)).result()
    return folder


@pytest.fixture
def robot(maps: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robot]:
    """The same robot, started again elsewhere, with the folder of maps."""
    monkeypatch.setenv("HBBA_MAPS", str(maps))
    with running_program(write_program(tmp_path, FOUND_AT), tmp_path / "guard.log", FOUND_AT) as running:
        running.request("POST", "/desires", {"class": "Teleoperation", "intensity": 8, "utility": 1, "security": True})
        yield running


def write_program(folder: Path, start: Pose2, scans_hz: float = 40) -> Path:
    """The lab's robot with navigation by its laser, from ``start``; it writes its true pose into ``truth`` beside."""
    config = config_dir()
    body = yaml.safe_load((config / "robots" / "irl1_tr.yaml").read_text())
    body |= {
        "guard_log": str(folder / "guard.log"),
        "model": str(config / "robots" / body["model"]),
        "world": str(config / "worlds" / "lab.yaml"),
        "scenario": None,
        "ground_truth": True,
        "start": {"x": start.x, "y": start.y, "heading_deg": math.degrees(start.theta)},
    }
    body["streams"] |= {"kinect": None, "panorama": None, "microphones": None}
    body["streams"]["hokuyo"]["rate_hz"] = scans_hz
    body["loudspeaker"] = None
    (folder / "robot.yaml").write_text(yaml.safe_dump(body))
    program: dict[str, Any] = yaml.safe_load((config / "jackal.yaml").read_text())
    program |= {
        "robot": "robot.yaml",
        "channels": str(config / program["channels"]),
        "strategies": [str(config / file) for file in program["strategies"]],
    }
    program["modules"]["Witness"] = {
        "class": "tests.browser.witness:Witness",
        "settings": {"file": str(folder / "truth")},
    }
    path = folder / "program.yaml"
    path.write_text(yaml.safe_dump(program))
    return path


def drag_on_map(page: Page, X_M: Pose2) -> None:
    """Press on a place of the map, drag to its heading, let go."""
    at_x, at_y = map_view(page).at(X_M.x, X_M.y)
    page.mouse.move(at_x, at_y)
    page.mouse.down()
    page.mouse.move(at_x + 60 * math.cos(X_M.theta), at_y - 60 * math.sin(X_M.theta), steps=3)
    page.mouse.up()


def shown_pose(page: Page) -> Pose2:
    """Where the page draws the robot."""
    return Pose2(*map(float, (page.get_by_test_id("map-canvas").get_attribute("data-robot") or "").split()))


def test_a_kept_map_is_loaded_the_robot_finds_itself_and_goes_to_another_room(
    robot: Robot, page: Page, tmp_path: Path
) -> None:
    """Loaded without a word of where it is, the robot is driven until it knows; then it is sent into the next room."""
    truth = tmp_path / "truth"
    page.get_by_test_id("tab-map").click()
    row = page.locator(f"[data-testid=kept-map][data-name={MAP}]")
    # The module that keeps maps compiles what it computes with, where that has not been done on this computer.
    row.get_by_test_id("map-load").click()
    row.get_by_test_id("map-localize").check()
    row.get_by_test_id("map-load-confirm").click()
    where = page.get_by_test_id("map-where")
    expect(where).to_have_attribute("data-map", MAP)
    expect(where).to_have_attribute("data-state", "searching")

    # What it sees from one place alone it does not believe: it is turned on the spot.
    hold(page, "KeyA")
    driver = page.get_by_test_id("driver")
    expect(driver).to_have_text("You")
    page.keyboard.up("KeyA")
    # Held again and again: on a busy computer the page lets go before the robot has turned far enough.
    hold_until(page, "KeyA", page.locator("[data-testid=map-where][data-state=tracking]"), 5_000)
    expect(driver).to_have_text("Nobody")
    page.locator("[data-testid=guard-state][data-state=idle]").wait_for()
    X_MW = MAPPED_FROM.inverse()
    error = (X_MW @ true_pose(truth)).inverse() @ shown_pose(page)
    assert math.hypot(error.x, error.y) < 0.1
    assert abs(error.theta) < 0.1

    # Loaded once more while it stands, it keeps the pose that it has: it would find itself only by being turned.
    row.get_by_test_id("map-load").click()
    expect(row.get_by_test_id("map-here")).to_be_checked()
    row.get_by_test_id("map-load-confirm").click()
    expect(row.get_by_test_id("map-load-confirm")).to_have_count(0)
    expect(where).to_have_attribute("data-state", "tracking")
    again = (X_MW @ true_pose(truth)).inverse() @ shown_pose(page)
    assert math.hypot(again.x, again.y) < 0.1

    page.get_by_test_id("map-toggle").click()
    page.get_by_test_id("map-fit").click()
    # This body has no camera: no card of one lies over the map.
    expect(page.get_by_test_id("camera")).to_have_count(0)
    # A zone to keep out of, aside of the way: dragged as a rectangle from this corner.
    corner = X_MW @ Pose2(15.5, 4.0, math.radians(45))
    page.get_by_test_id("map-tool-keep_out").click()
    with page.expect_response(lambda answer: answer.url.endswith("/map/zones") and answer.request.method == "PUT"):
        drag_on_map(page, corner)
    page.locator("[data-testid=zone][data-kind=keep_out]").wait_for()
    (zone,) = robot.get("/map/zones")["zones"]
    assert min(math.dist(each, (corner.x, corner.y)) for each in zone["polygon"]) < 0.05

    # Where it is becomes a place, which is named, kept with the map, and gone to by its name.
    page.get_by_test_id("place-here").click()
    page.get_by_test_id("place-rename").click()
    page.get_by_test_id("place-name").fill("Hall")
    page.get_by_test_id("place-rename-confirm").click()
    page.locator("[data-testid=place][data-name=Hall][data-source=here]").wait_for()
    (place,) = robot.get("/places")["places"]
    off = (X_MW @ true_pose(truth)).inverse() @ Pose2(place["x"], place["y"], place["heading"])
    assert math.hypot(off.x, off.y) < 0.1
    way = page.get_by_test_id("map-way")
    page.get_by_test_id("place-go").click()
    expect(way).to_contain_text("Arrived at Hall")

    page.get_by_test_id("map-tool-goal").click()
    drag_on_map(page, X_MW @ SENT_TO)
    expect(way).to_have_attribute("data-state", "following")
    # Held keys take over for as long as they are held, and the page says what comes then; Space ends the trip.
    hold_until(page, "KeyA", page.get_by_test_id("drive-hint").filter(has_text="continue to the goal"), 5_000)
    expect(driver).not_to_have_text(re.compile("You|Nobody"))
    page.keyboard.press("Space")
    page.get_by_test_id("map-cancel").wait_for(state="detached")
    page.locator("[data-testid=guard-state][data-state=idle]").wait_for()
    assert robot.get("/goal")["desire"] is None
    drag_on_map(page, X_MW @ SENT_TO)
    expect(way).to_have_attribute("data-state", "following")
    expect(way).to_have_attribute("data-state", "arrived")
    # On a busy computer both states may still be those of the trip before: the robot itself is waited for.
    end = time.monotonic() + PATIENCE_S
    while math.hypot((reached := SENT_TO.inverse() @ true_pose(truth)).x, reached.y) >= REACHED_M:
        assert time.monotonic() < end, reached
        page.wait_for_timeout(100)
    assert abs(reached.theta) < FACED_RAD
    # Reached, it is desired no more.
    page.get_by_test_id("map-cancel").wait_for(state="detached")
