"""Pictures of README and docs/, from real pages: ``.venv/bin/python -m scripts.screenshots [SERIES ...]``.

Drives the simulated robot through the tour's steps in Chromium. The 3D view is drawn at full resolution whatever the
computer, so on one without a graphics card this takes a few minutes.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))

import cv2
import numpy as np
from photographs import FOLDER, Image, illness, opened, saved, shoot, strip, taken
from playwright.sync_api import Browser, Page, TimeoutError, ViewportSize, sync_playwright

from app.base.paths import config_dir
from app.commands.doctor import find_chromium
from app.console.view.viewpoints import VIEWPOINTS
from app.modules.behaviors.face.expression import EXPRESSIONS
from tests.browser.running import CHROMIUM_ARGUMENTS, Robot, running_robot

DESKTOP: ViewportSize = {"width": 1440, "height": 900}
PHONE: ViewportSize = {"width": 390, "height": 844}
#: Before the door of the room across, as seen on the map from where the robot starts.
ZONE = {"name": "Deliveries", "kind": "keep_out", "polygon": [[2.5, 2.4], [3.3, 2.4], [3.3, 3.6], [2.5, 3.6]]}
#: To stop a replay so many seconds after its beginning, in JavaScript.
_STAND_AT = """async (seconds) => {
  const url = "api/v1/playback", { begin } = await (await fetch(url)).json();
  const body = JSON.stringify({ playing: false, position: begin + seconds });
  await fetch(url, { method: "PATCH", headers: { "Content-Type": "application/json" }, body });
}"""
#: Of a glide between two viewpoints so many pictures, at equal times from its beginning to its end, each so large (px).
GLIDE_PICTURES = 6
GLIDE_SIZE: ViewportSize = {"width": 320, "height": 200}
#: Time (ms) for the 3D view to come, and to draw itself from elsewhere.
SCENE_MS, REDRAWN_MS = 20_000, 3_000
#: The 3D view's page by itself is its own parent, and hears from itself what the operator page says to it.
_LOOK = """([viewpoint, number, hold]) =>
  window.postMessage({ type: "viewpoint", viewpoint, number, hold }, location.origin)"""
#: The tour that is configured by driving.
TOUR = "A walk through the lab"
#: A way takes so long at most (s), or this computer is too slow for a robot that goes.
GOING_S = 300


def main() -> None:
    """Take every picture, or those of the series that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    series = {
        "faces": faces,
        "tour": tour,
        "what-if": what_if,
        "guided": guided,
        "people": people,
        "glides": glides,
    }
    parser.add_argument("series", nargs="*", metavar="SERIES", help=f"{', '.join(series)} (default: all)")
    wanted = parser.parse_args().series or list(series)
    if unknown := set(wanted) - set(series):
        parser.error(f"there is no series {', '.join(sorted(unknown))}; there are: {', '.join(series)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in wanted:
        with tempfile.TemporaryDirectory() as data:
            for kind in ("recordings", "maps", "tours", "tour_runs", "memory", "webhooks"):
                os.environ[f"HBBA_{kind.upper()}"] = f"{data}/{kind}"
            take(series[name], config_dir() / "scenarios" / "lab.yaml" if name == "people" else None)


def take(series: Callable[[Browser, Robot], None], scenario: Path | None) -> None:
    """Start the robot and a browser for one series."""
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
        with running_robot(Path(folder), scenario) as robot:
            series(browser, robot)
        browser.close()


def faces(browser: Browser, robot: Robot) -> None:
    """The calm face and the expressions, side by side."""
    page = browser.new_context(viewport={"width": 420, "height": 380}).new_page()
    page.goto(f"{robot.url}/face")
    page.locator("body[data-link=live]").wait_for()
    pictures = []
    for name in ("calm", *EXPRESSIONS):
        wish = {"class": "Express", "intensity": 8, "utility": 8, "params": {"expression": name}}
        desire = robot.request("POST", "/desires", wish)[2]["id"]
        page.wait_for_timeout(3_000)
        # Not in the middle of a blink.
        page.wait_for_function("Number(document.querySelector('.face').dataset.pose.split(' ')[4]) < 0.7")
        pictures.append(taken(page))
        robot.request("DELETE", f"/desires/{desire}")
    saved("face", np.hstack(pictures))
    page.context.close()


def tour(browser: Browser, robot: Robot) -> None:
    """The steps of docs/tour.md, a picture each."""
    # Without the 3D view, which a computer without a graphics card draws too late for a picture; in the replay it is.
    page = opened(browser, f"{robot.url}/?scene=off", DESKTOP)
    page.wait_for_timeout(20_000)
    shoot(page, "tour-first-look")
    robot.request("POST", "/recordings", {"name": "corridor"})

    page.get_by_test_id("speed-full").click()
    found = page.locator("[data-testid=landmark]").first
    page.keyboard.down("KeyW")
    page.get_by_test_id("guard-state").and_(page.locator("[data-state=driving]")).wait_for()
    shoot(page, "tour-driving")
    page.get_by_test_id("tab-found").click()
    found.wait_for(timeout=300_000)
    page.wait_for_timeout(2_500)
    page.keyboard.up("KeyW")
    page.wait_for_timeout(8_000)
    shoot(page, "tour-found")

    page.get_by_test_id("tab-attention").click()
    wish = {"class": "LocateVoices", "intensity": 8, "utility": 1, "ttl": 20}
    robot.request("POST", "/desires", wish)
    page.wait_for_timeout(9_000)
    shoot(page, "tour-desire")

    why(page)
    page.get_by_test_id("tab-load").click()
    page.wait_for_timeout(3_000)
    shoot(page, "tour-load")

    page.get_by_test_id("estop").click()
    page.get_by_test_id("estop-release").wait_for()
    page.wait_for_timeout(2_000)
    shoot(page, "tour-stopped")
    page.get_by_test_id("estop-release").click()
    page.get_by_test_id("estop-release-confirm").click()
    robot.request("POST", "/recordings/stop")
    page.get_by_test_id("tab-recordings").click()
    page.locator("[data-testid=recording][data-state=complete]").wait_for()
    page.wait_for_timeout(2_000)
    shoot(page, "tour-recordings")
    page.context.close()
    replay(browser, robot)

    phone = opened(browser, f"{robot.url}/?scene=off", PHONE)
    phone.wait_for_timeout(20_000)
    shoot(phone, "phone")


def glides(browser: Browser, robot: Robot) -> None:
    """How the 3D view's camera goes from each viewpoint to the next, in the order of their keys: a strip for each."""
    page = browser.new_context(viewport=GLIDE_SIZE, color_scheme="dark").new_page()
    page.goto(f"{robot.url}/viser/")
    page.wait_for_timeout(SCENE_MS)
    strips: list[Image] = []
    for number, viewpoint in enumerate((*VIEWPOINTS[1:], VIEWPOINTS[0]), 1):
        pictures: list[Image] = []
        for step in range(GLIDE_PICTURES):
            page.evaluate(_LOOK, [viewpoint, number, step / (GLIDE_PICTURES - 1)])
            page.wait_for_timeout(REDRAWN_MS)
            pictures.append(taken(page))
        strips.append(strip(pictures))
    saved("viewpoint-glides", np.vstack(strips))
    page.context.close()


def replay(browser: Browser, robot: Robot) -> None:
    """Replay the recording of the tour up to the moment when the code was found."""
    _, _, answer = robot.request("POST", "/recordings/corridor/replay")
    page = opened(browser, f"{answer['url']}/?scene=full", DESKTOP)
    page.wait_for_timeout(15_000)
    page.evaluate(_STAND_AT, 31.0)
    page.wait_for_timeout(12_000)
    shoot(page, "replay")
    page.context.close()
    robot.request("DELETE", "/recordings/corridor/replay")


def going(browser: Browser, robot: Robot) -> None:
    """On the way along the corridor, past a zone to keep out of, on the map that grows meanwhile; and back."""
    page = opened(browser, f"{robot.url}/?scene=off", DESKTOP)
    page.get_by_test_id("tab-map").click()
    page.get_by_test_id("map-enlarge").click()
    # Its text over the map shows that there is a map to mark zones on.
    page.get_by_test_id("map-where").wait_for()
    asked(robot, "/map/zones", {"zones": [ZONE]})
    asked(robot, "/goal", {"x": 3.4, "y": 5.0, "heading": 1.57})
    gone(robot, page, 0.4)
    page.get_by_test_id("map-fit").click()
    shoot(page, "tour-map", page.locator("[data-testid=map-way][data-state=following]"))
    # People are met where the robot starts.
    asked(robot, "/goal", {"x": 0.0, "y": 0.0, "heading": 0.0})
    gone(robot, page, 1.0)
    page.context.close()


def guided(browser: Browser, robot: Robot) -> None:
    """A guided tour is configured by driving past three posters, edited, and led."""
    page = opened(browser, f"{robot.url}/?scene=off", DESKTOP)
    page.get_by_test_id("tour-toggle").click()
    page.get_by_test_id("tour-new-title").fill(TOUR)
    page.get_by_test_id("tour-drive").click()
    met = page.get_by_test_id("tour-driving")
    # On the map, whose origin is where the robot starts: each within sight of a poster.
    for number, (x, y, heading_deg) in enumerate(((2.2, 0.0, 0.0), (3.6, 2.8, 180.0), (3.0, 5.5, 0.0)), 1):
        asked(robot, "/goal", {"x": x, "y": y, "heading": math.radians(heading_deg)})
        page.locator(f"[data-testid=tour-driving][data-met='{number}']").wait_for(timeout=GOING_S * 1000)
        if number == 2:
            shoot(page, "guided-driving")
        gone(robot, page, 1.0)
    page.get_by_test_id("tour-drive-map").fill("lab")
    page.get_by_test_id("tour-drive-finish").click()
    met.wait_for(state="detached")
    page.get_by_test_id("tour-stop").nth(2).wait_for()
    page.get_by_test_id("map-fit").click()
    page.get_by_test_id("notice").first.wait_for(state="detached")
    shoot(page, "guided-editor")
    page.get_by_test_id("stop-open").first.click()
    page.get_by_test_id("stop-form").wait_for()
    shoot(page, "guided-stop")
    page.get_by_test_id("tour-close").click()
    written(robot)
    rehearsed(page)
    led(browser, page, robot)
    page.context.close()


def written(robot: Robot) -> None:
    """What the tour says and shows; one stop has no French, which a rehearsal in French finds."""
    media = Path(os.environ["HBBA_TOURS"]) / "media"
    media.mkdir(parents=True, exist_ok=True)
    views = np.asarray(cv2.imread(str(FOLDER / "simulated-lab.jpg")))
    cv2.imwrite(str(media / "robot.jpg"), views[: views.shape[0] // 2, : views.shape[1] // 2])
    (listed,) = (each for each in robot.get("/tours")["tours"] if not each["shipped"])
    tour = robot.get(f"/tours/{listed['id']}")["tour"]
    tour |= {"languages": ["en", "fr"], "pace": {"look_back_m": 100}}
    texts = (
        {"en": "Here students build robots.", "fr": "Ici, les étudiants construisent des robots."},
        {"en": "Here is where programs are written."},
        {
            "en": "The parts of my body were made in this workshop. Four motors carry my arms. They yield to a push.",
            "fr": "Les pièces de mon corps viennent de cet atelier. Quatre moteurs portent mes bras. Ils cèdent.",
        },
    )
    tour["title"]["fr"] = "Une visite du laboratoire"
    for stop, title in zip(tour["stops"], ("Le laboratoire", "Le bureau", "L'atelier"), strict=True):
        stop["title"]["fr"] = title
    for stop, text in zip(tour["stops"], texts, strict=True):
        stop["do"] = [{"say": text, "look": "visitors"}]
    last = tour["stops"][-1]
    last["do"][0]["show"] = {"file": "media/robot.jpg", "alt": {"en": "The robot", "fr": "Le robot"}}
    last["do"].append({"wait": {"at_most_s": 60, "press": {"en": "Go on", "fr": "Continuer"}}})
    answer = {"say": {"en": "About four kilograms each.", "fr": "Environ quatre kilos chacun."}}
    question = {"en": "How heavy are your arms?", "fr": "Combien pèsent tes bras ?"}
    last["questions"] = [{"id": "weight", "question": question, "answer": answer}]
    asked(robot, f"/tours/{listed['id']}", tour)


def rehearsed(page: Page) -> None:
    """The tour played without the robot, and what would go wrong in French."""
    page.locator("[data-testid=tour]", has_text=TOUR).get_by_test_id("tour-open").click()
    page.get_by_test_id("rehearsal-language").select_option("fr")
    page.get_by_test_id("rehearse").click()
    page.get_by_test_id("rehearsal-result").wait_for(timeout=2 * GOING_S * 1000)
    page.get_by_test_id("rehearsal-play").click()
    moment = page.get_by_test_id("rehearsal-at")
    # As the browser itself would write it, or it is malformed: "31", not "31.0".
    moment.fill(f"{round(0.6 * float(moment.get_attribute('max') or 0), 1):g}")
    shoot(page, "guided-rehearsal")
    page.get_by_test_id("rehearsal-close").click()
    page.get_by_test_id("tour-close").click()


def led(browser: Browser, page: Page, robot: Robot) -> None:
    """The last stop is presented: the operator's page, the operator's phone and a visitor's."""
    phone = opened(browser, f"{robot.url}/?scene=off", PHONE)
    phone.get_by_test_id("tab-tour").click()
    visitor = browser.new_context(viewport=PHONE).new_page()
    visitor.goto(f"{robot.url}/visitor")
    page.get_by_test_id("tour-run-start").click()
    page.get_by_test_id("tour-run-go").select_option(index=3)
    said = page.get_by_test_id("tour-run-said").filter(has_text="parts of my body")
    said.wait_for()
    while ill := illness(page):
        print(json.dumps({"again": ill}))
        page.locator("[data-testid=tour-run][data-state=listening]").wait_for()
        robot.request("POST", "/tour-run/press", {"button": "repeat"})
        said.wait_for()
    saved("guided-led", taken(page))
    visitor.get_by_test_id("visitor-question").wait_for()
    visitor.wait_for_function("document.querySelector('[data-testid=visitor-media]').complete")
    page.locator("[data-testid=tour-run][data-state=listening]").wait_for()
    visitor.get_by_test_id("visitor-question").click()
    phone.locator("[data-testid=tour-run][data-state=answering]").wait_for()
    for each in (visitor, phone.get_by_test_id("tour-run")):
        each.get_by_text("About four").first.wait_for()
    phones = [taken(visitor), taken(phone)]
    saved("guided-phones", np.hstack([phones[0], np.full((phones[0].shape[0], 24, 3), 255, np.uint8), phones[1]]))
    robot.request("DELETE", "/tour-run")
    for each in (phone, visitor):
        each.context.close()


def gone(robot: Robot, page: Page, share: float) -> None:
    """Wait until this share of the path is driven; all of it: until the desire is removed."""
    whole = 0.0
    for _ in range(2 * GOING_S):
        goal = robot.get("/goal")
        left = goal["navigation"]["remaining_m"]
        whole = max(whole, left or 0.0)
        if goal["desire"] is None or (left is not None and left < (1.0 - share) * whole):
            return
        page.wait_for_timeout(500)
    raise RuntimeError(f"the robot is still on its way after {GOING_S} s: {goal['navigation']['reason']}")


def asked(robot: Robot, path: str, body: dict[str, Any]) -> None:
    """PUT it, and hear that it was taken."""
    status, _, answer = robot.request("PUT", path, body)
    if status != 200:
        raise RuntimeError(f"{path} was refused: {answer}")


def people(browser: Browser, robot: Robot) -> None:
    """A person near the start looks at the robot, and speaks now and then: a scene for every perception, with the
    selection that attention makes for it."""
    going(browser, robot)
    capacity = robot.get("/resources")["resources"][0]["capacity"]
    robot.request("PATCH", "/resources/cpu", {"capacity": 100})
    wishes = [
        robot.request("POST", "/desires", {"class": kind, "intensity": 8, "utility": 4, "security": True})[2]["id"]
        for kind in ("LocateFaces", "LocateVoices")
    ]
    page = opened(browser, f"{robot.url}/?scene=off", DESKTOP)
    page.get_by_test_id("tab-found").click()
    page.get_by_test_id("listen").click()
    spoken_to(page)
    shoot(page, "tour-people")
    page.context.close()

    for wish in wishes:
        robot.request("DELETE", f"/desires/{wish}")
    robot.request("PATCH", "/resources/cpu", {"capacity": capacity})
    page = opened(browser, f"{robot.url}/?scene=full", DESKTOP)
    page.wait_for_timeout(30_000)
    spoken_to(page)
    shoot(page, "console", page.get_by_test_id("around-face").first)
    page.context.close()


def spoken_to(page: Page) -> None:
    """Wait for a face, and for a voice as far as there is one: none on a computer too slow for the world's sound."""
    with contextlib.suppress(TimeoutError):
        page.locator("[data-testid=around-sound][data-active=true][data-kind=voice]").first.wait_for(
            state="attached", timeout=300_000
        )
    page.get_by_test_id("around-face").first.wait_for(state="attached")


def why(page: Page) -> None:
    """Hover over the lane that gave way, and show the reason."""
    box = page.get_by_test_id("lane-area").bounding_box()
    assert box is not None
    lane = page.locator(".lane-name", has_text="Locate faces").first.bounding_box()
    assert lane is not None
    page.mouse.move(box["x"] + 0.9 * box["width"], lane["y"] + lane["height"] / 2)
    page.get_by_test_id("lane-tooltip").wait_for()
    shoot(page, "tour-why")
    page.mouse.move(5, 5)


def what_if(browser: Browser, robot: Robot) -> None:
    """Less CPU is supposed: what would be given up."""
    page = opened(browser, f"{robot.url}/?scene=off", DESKTOP)
    page.wait_for_timeout(30_000)
    page.get_by_test_id("what-if-open").click()
    cpu = page.get_by_test_id("what-if-capacity-cpu")
    cpu.fill(f"{float(cpu.get_attribute('max') or 0) / 4:g}")
    page.get_by_test_id("what-if-headline").wait_for()
    page.get_by_test_id("what-if").evaluate("(card) => card.scrollIntoView()")
    shoot(page, "what-if")
    page.context.close()


if __name__ == "__main__":
    main()
