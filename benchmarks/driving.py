"""From a held key in a real browser to the simulated wheels, over loopback, through the whole running program.

Presses and releases the forward key and compares the page's clock at the key's event with the guard's own log of what
the wheels are given: ``press`` to the first velocity, ``release`` to the first braking.
``python -m benchmarks.driving`` prints the table.
"""

from __future__ import annotations

import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from statistics import quantiles

from playwright.sync_api import Page, sync_playwright

from app.commands.doctor import find_chromium
from app.robots.simulated.guard_log import GuardRow
from benchmarks.report import Row, benchmark_main, row
from tests.browser.running import CHROMIUM_ARGUMENTS, Robot, running_robot

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
    """Latencies (ms) of ``presses`` presses and releases."""
    offset = time.time() - time.monotonic()
    with tempfile.TemporaryDirectory() as folder, running_robot(Path(folder)) as robot, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
        page = browser.new_page(viewport={"width": 1000, "height": 640})
        page.goto(f"{robot.url}/?scene=off")
        page.locator("[data-testid=connection][data-phase=live]").wait_for()
        page.evaluate(_LISTEN)
        page.wait_for_timeout(3_000)
        press, release = [], []
        for number in range(presses):
            pressed, released = _hold(page, number)
            rows = _settled(robot)
            press.append(1e3 * (_first_moving(rows, pressed - offset) - (pressed - offset)))
            release.append(1e3 * (_first_braking(rows, released - offset) - (released - offset)))
        browser.close()
    rows_out = []
    for case, samples in (("key pressed", press), ("key released", release)):
        rows_out.append(row("driving", case, "p50", "ms", samples))
        rows_out.append(Row("driving", case, "p95", "ms", quantiles(samples, n=20)[-1], None, "", None, 0.0, presses))
    return rows_out


def _hold(page: Page, number: int) -> tuple[float, float]:
    """Hold the key for about 0.3 s, not in step with any timer; when it went down and up (s, Unix time)."""
    page.keyboard.down("KeyW")
    page.wait_for_timeout(300 + 7 * (number % 13))
    page.keyboard.up("KeyW")
    page.wait_for_timeout(50)
    down, up = page.evaluate("window.keyTimes.splice(0)")
    return down / 1e3, up / 1e3


def _settled(robot: Robot) -> list[GuardRow]:
    while (rows := robot.wheels())[-1].linear_mps != 0:
        time.sleep(0.05)
    return rows


def _first_moving(rows: list[GuardRow], after: float) -> float:
    return next(r.monotonic_s for r in rows if r.monotonic_s >= after and r.linear_mps != 0)


def _first_braking(rows: list[GuardRow], after: float) -> float:
    return next(b.monotonic_s for a, b in pairwise(rows) if b.monotonic_s >= after and b.linear_mps < a.linear_mps)


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(8 if quick else 40)))
