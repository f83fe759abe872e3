"""From a held key in a real browser to the simulated wheels, over loopback, through the whole running program.

Presses and releases the forward key, with the 3D view hidden and shown, and compares the page's clock at the event with
the guard's own log of what the wheels are given: ``pressed`` to the first velocity, ``released`` to the first braking.
``handler`` is from the key's event to the page's own code; ``renderers`` and ``GPU process`` are the browser's
processor time while nobody drives, in % of a core (without a graphics card all drawing is in it); ``world`` is how fast
the simulated world runs meanwhile (1: in time). ``python -m benchmarks.driving`` prints the table.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from statistics import quantiles
from typing import NamedTuple

from playwright.sync_api import Page, ViewportSize, sync_playwright

from app.commands.doctor import find_chromium
from app.robots.simulated.guard_log import GuardRow
from benchmarks.page_processes import cpu_seconds
from benchmarks.report import Row, benchmark_main, row
from tests.browser.running import CHROMIUM_ARGUMENTS, Robot, running_robot

#: A press that moves nothing for so long (s), as on a computer too busy for command and world, is tried again.
PATIENCE_S = 8.0
TRIES = 4
#: A page is measured (s) once it has loaded and settled for so long (s).
REST_S = 15.0
SETTLE_S = 10.0
VIEWPORT = ViewportSize(width=1440, height=900)

# The page writes down, on the computer's wall clock, when each event of the drive key came and when it was handled.
_LISTEN = """
window.keyTimes = [];
for (const name of ["keydown", "keyup"])
  window.addEventListener(name, (event) => {
    if (event.code === "KeyW" && !event.repeat)
      window.keyTimes.push([performance.timeOrigin + event.timeStamp, performance.now() - event.timeStamp]);
  }, true);
"""


class Press(NamedTuple):
    """Latencies (ms) of one press: to the page's handler, to the first velocity, and of its release to braking."""

    handler: float
    pressed: float
    released: float


def measure(presses: int, rest_s: float = REST_S) -> list[Row]:
    """Both pages, ``presses`` each. Raises SystemExit, in words, if the wheels do not move."""
    rows_out: list[Row] = []
    with tempfile.TemporaryDirectory() as folder, running_robot(Path(folder)) as robot, sync_playwright() as playwright:
        for case, query in (("3D hidden", "?scene=off"), ("3D shown", "")):
            browser = playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
            page = browser.new_page(viewport=VIEWPORT)
            page.goto(f"{robot.url}/{query}")
            page.locator("[data-testid=connection][data-phase=live]").wait_for()
            if not query:
                page.locator("[data-testid=scene][data-state=shown]").wait_for()
            rows_out += _page_rows(case, robot, page, presses, rest_s)
            browser.close()
    return rows_out


def _page_rows(case: str, robot: Robot, page: Page, presses: int, rest_s: float) -> list[Row]:
    offset = time.time() - time.monotonic()
    page.evaluate(_LISTEN)
    page.wait_for_timeout(1e3 * SETTLE_S)
    before, began, world = cpu_seconds(), time.monotonic(), []
    while time.monotonic() < began + rest_s:
        page.wait_for_timeout(1_000)
        world.append(robot.get("/robot")["world_rate"])
    after, elapsed = cpu_seconds(), time.monotonic() - began
    share = {kind: 100 * (spent - before.get(kind, 0.0)) / elapsed for kind, spent in after.items()}
    samples = [_sample(robot, page, number, offset) for number in range(presses)]
    return [
        row("driving", case, "renderers", "% of a core", [share["renderer"]]),
        row("driving", case, "GPU process", "% of a core", [share["gpu-process"]]),
        row("driving", case, "world", "", world),
        *(
            line
            for name, each in zip(Press._fields, zip(*samples, strict=True), strict=True)
            for line in (
                row("driving", case, f"{name} p50", "ms", each),
                Row("driving", case, f"{name} p95", "ms", quantiles(each, n=20)[-1], None, "", None, 0.0, presses),
            )
        ),
    ]


def latencies(rows: Sequence[GuardRow], pressed: float, released: float) -> tuple[float, float] | None:
    """From ``pressed`` to the first velocity and from ``released`` to the first braking (s), by what the wheels were
    given (``rows``, oldest first; times monotonic); None: they did not move, or no more when the key was released."""
    moving = next((r.monotonic_s for r in rows if r.monotonic_s >= pressed and r.linear_mps != 0), None)
    before = [r for r in rows if r.monotonic_s < released]
    if moving is None or moving >= released or before[-1].linear_mps == 0:
        return None
    after = [before[-1], *(r for r in rows if r.monotonic_s >= released)]
    braking = next((b.monotonic_s for a, b in pairwise(after) if abs(b.linear_mps) < abs(a.linear_mps)), None)
    return None if braking is None else (moving - pressed, braking - released)


def _sample(robot: Robot, page: Page, number: int, offset: float) -> Press:
    """Press ``number``."""
    for _ in range(TRIES):
        pressed, released, handler_ms = _hold(robot, page, number)
        if found := latencies(_settled(robot), pressed - offset, released - offset):
            return Press(handler_ms, 1e3 * found[0], 1e3 * found[1])
    raise SystemExit(f"driving: {TRIES} presses did not move the wheels until the key was let go; {_why(robot, page)}")


def _hold(robot: Robot, page: Page, number: int) -> tuple[float, float, float]:
    """Hold the key until the wheels move and for 0.1 s more, not in step with any timer; when it went down and up (s,
    Unix time), and how long the page's handler waited (ms)."""
    rested = len(robot.wheels())
    page.keyboard.down("KeyW")
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end and not any(r.linear_mps != 0 for r in robot.wheels()[rested:]):
        page.wait_for_timeout(20)
    page.wait_for_timeout(100 + 7 * (number % 13))
    page.keyboard.up("KeyW")
    page.wait_for_timeout(50)
    (down, handler_ms), (up, _) = page.evaluate("window.keyTimes.splice(0)")
    return down / 1e3, up / 1e3, handler_ms


def _settled(robot: Robot) -> list[GuardRow]:
    while not (rows := robot.wheels()) or rows[-1].linear_mps != 0:
        time.sleep(0.05)
    return rows


def _why(robot: Robot, page: Page) -> str:
    """The reasons that robot and page give for wheels that do not move."""
    guard = robot.get("/robot")["guard"]
    hints = [text.strip() for text in page.locator(".drive-hint, .notice p, [data-testid=limited]").all_inner_texts()]
    return f"the guard says {guard['state']}: {guard['reason'] or 'nothing more'}; the page says: {' | '.join(hints)}"


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(8, 5.0) if quick else measure(40)))
