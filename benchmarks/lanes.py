"""What the lanes take of a page, through the whole running program and a real browser.

``tick`` is the time that the page's own thread is busy with the lanes each time that it draws what is new, four times a
second, at three windows of time. ``renderers`` and ``GPU process`` are the browser's processor time, in % of a core
(without a graphics card all drawing is in it), with the lanes shown against the same page with them hidden, in turn.
The 3D view is left out, and the robot is calm: two cores are enough for world, program and browser.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from statistics import quantiles

from playwright.sync_api import Page, ViewportSize, sync_playwright

from app.commands.doctor import find_chromium
from benchmarks.page_processes import cpu_seconds
from benchmarks.report import Row, benchmark_main, row
from tests.browser.running import CHROMIUM_ARGUMENTS, running_robot

VIEWPORT = ViewportSize(width=1440, height=900)
SETTLE_S = 10.0
#: Presses of *Show a longer time* to each window.
WINDOWS = {"30 s": 0, "10 min": 4, "1 h": 3}
#: After another window the lanes are drawn as a whole, and the past is asked for.
CHANGE_S = 5.0

# The measure that the page makes of each tick.
_LISTEN = """
window.laneTicks = [];
new PerformanceObserver((list) => {
  for (const { name, duration } of list.getEntries()) if (name === "lanes") window.laneTicks.push(duration);
}).observe({ type: "measure" });
"""
_SHOW = "shown => document.querySelector('[data-testid=lanes]').style.display = shown ? '' : 'none'"


def measure(rounds: int, seconds: float) -> list[Row]:
    """Ticks at each window, then ``rounds`` of shown and hidden, each of ``seconds``."""
    with (
        tempfile.TemporaryDirectory() as folder,
        running_robot(Path(folder), calm=True) as robot,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
        page = browser.new_page(viewport=VIEWPORT)
        page.add_init_script(_LISTEN)
        page.goto(f"{robot.url}/?scene=off")
        page.locator("[data-testid=lane-canvas][data-newest]").wait_for(state="attached")
        page.wait_for_timeout(1e3 * SETTLE_S)
        shares = _shares(page, rounds, seconds)
        return _ticks(page, seconds) + shares


def _ticks(page: Page, seconds: float) -> list[Row]:
    rows: list[Row] = []
    for window, presses in WINDOWS.items():
        for _ in range(presses):
            page.get_by_label("Show a longer time").click()
        page.wait_for_timeout(1e3 * CHANGE_S)
        page.evaluate("window.laneTicks.length = 0")
        page.wait_for_timeout(1e3 * seconds)
        ticks = page.evaluate("window.laneTicks")
        rows.append(row("lanes", window, "tick p50", "ms", ticks))
        rows.append(Row("lanes", window, "tick p95", "ms", quantiles(ticks, n=20)[-1], None, "", None, 0.0, len(ticks)))
    return rows


def _shares(page: Page, rounds: int, seconds: float) -> list[Row]:
    found: dict[tuple[bool, str], list[float]] = {}
    for _ in range(rounds):
        for shown in (True, False):
            page.evaluate(_SHOW, shown)
            page.wait_for_timeout(2_000)
            before, began = cpu_seconds(), time.monotonic()
            page.wait_for_timeout(1e3 * seconds)
            elapsed = time.monotonic() - began
            for kind, spent in cpu_seconds().items():
                share = 100 * (spent - before.get(kind, 0.0)) / elapsed
                found.setdefault((shown, kind), []).append(share)
    page.evaluate(_SHOW, True)
    names = {"renderer": "renderers", "gpu-process": "GPU process"}
    return [
        row("lanes", "30 s", name, "% of a core", found[True, kind], found[False, kind], "lanes hidden")
        for kind, name in names.items()
    ]


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(2, 5.0) if quick else measure(5, 20.0)))
