"""From a held key in a real browser to the simulated wheels, over loopback, through the whole running program.

Presses and releases the forward key and compares the page's clock at the key's event with the guard's own log of what
the wheels are given: ``press`` to the first velocity, ``release`` to the first braking.
``python -m benchmarks.driving`` prints the table.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from statistics import quantiles

from playwright.sync_api import Page, sync_playwright

from app.commands.doctor import find_chromium
from app.robots.simulated.guard_log import GuardRow
from benchmarks.report import Row, benchmark_main, row
from tests.browser.running import CHROMIUM_ARGUMENTS, Robot, running_robot

#: A press that moves nothing for so long (s), as on a computer too busy for command and world, is tried again.
PATIENCE_S = 8.0
TRIES = 4

# The page writes down, on the computer's wall clock, when each event of the drive key came.
_LISTEN = """
window.keyTimes = [];
for (const name of ["keydown", "keyup"])
  window.addEventListener(name, (event) => {
    if (event.code === "KeyW" && !event.repeat)
      window.keyTimes.push(performance.timeOrigin + event.timeStamp);
  }, true);
"""


def measure(presses: int) -> list[Row]:
    """Latencies (ms) of ``presses`` presses and releases. Raises SystemExit, in words, if the wheels do not move."""
    offset = time.time() - time.monotonic()
    with tempfile.TemporaryDirectory() as folder, running_robot(Path(folder)) as robot, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
        page = browser.new_page(viewport={"width": 1000, "height": 640})
        page.goto(f"{robot.url}/?scene=off")
        page.locator("[data-testid=connection][data-phase=live]").wait_for()
        page.evaluate(_LISTEN)
        page.wait_for_timeout(3_000)
        samples = [_sample(robot, page, number, offset) for number in range(presses)]
        browser.close()
    rows_out = []
    for case, each in zip(("key pressed", "key released"), zip(*samples, strict=True), strict=True):
        rows_out.append(row("driving", case, "p50", "ms", each))
        rows_out.append(Row("driving", case, "p95", "ms", quantiles(each, n=20)[-1], None, "", None, 0.0, presses))
    return rows_out


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


def _sample(robot: Robot, page: Page, number: int, offset: float) -> tuple[float, float]:
    """Latencies (ms) of press ``number``."""
    for _ in range(TRIES):
        pressed, released = _hold(robot, page, number)
        if found := latencies(_settled(robot), pressed - offset, released - offset):
            return 1e3 * found[0], 1e3 * found[1]
    raise SystemExit(f"driving: {TRIES} presses did not move the wheels until the key was let go; {_why(robot, page)}")


def _hold(robot: Robot, page: Page, number: int) -> tuple[float, float]:
    """Hold the key until the wheels move and for 0.1 s more, not in step with any timer; when it went down and up (s,
    Unix time)."""
    rested = len(robot.wheels())
    page.keyboard.down("KeyW")
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end and not any(r.linear_mps != 0 for r in robot.wheels()[rested:]):
        page.wait_for_timeout(20)
    page.wait_for_timeout(100 + 7 * (number % 13))
    page.keyboard.up("KeyW")
    page.wait_for_timeout(50)
    down, up = page.evaluate("window.keyTimes.splice(0)")
    return down / 1e3, up / 1e3


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
    sys.exit(benchmark_main(__doc__, lambda quick: measure(8 if quick else 40)))
