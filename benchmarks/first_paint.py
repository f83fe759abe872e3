"""How soon the operator page is of use: from the navigation to the robot's state and picture on the screen.

Each load has an empty cache, over loopback, through the whole running program and a real browser, on a desk's screen
as it opens (with the 3D view, which loads beside it), there without the 3D view, and on a phone's. ``code``: the page's
own program runs; ``state``: the connection is live and the bar shows what the robot does; ``picture``: the camera's
first picture is drawn; ``useful``: both are on the screen, by the first frame after them. ``transferred`` is what came
by HTTP until then and for a moment longer, headers included, without viser: the goals are 1 s and 200 kB.
``browser`` and ``program`` are processor time until ``useful``, which other work on the computer does not change.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import Browser, ViewportSize, sync_playwright

from app.commands.doctor import find_chromium
from benchmarks.page_processes import cpu_seconds
from benchmarks.report import Row, benchmark_main, row
from tests.browser.running import CHROMIUM_ARGUMENTS, Robot, running_robot

GOAL_MS = 1000.0
GOAL_KB = 200.0
#: What comes so long after (ms) counts as transferred, too.
LONGER_MS = 2000
#: Page, viewport, and what the address says.
CASES = (
    ("desk", ViewportSize(width=1440, height=900), ""),
    ("desk, 3D off", ViewportSize(width=1440, height=900), "?scene=off"),
    ("phone", ViewportSize(width=390, height=844), ""),
)

# The page writes down when each thing is there, and when the next frame has been drawn with it: a task that is queued
# in an animation frame runs after that frame's painting.
_NOTE = """
window.paint = {};
const there = {
  code: () => document.querySelector("#app")?.firstElementChild,
  state: () => document.querySelector("[data-testid=connection][data-phase=live]")
    && document.querySelector("[data-testid=guard-state]:not([data-state=''])"),
  picture: () => document.querySelector("[data-testid=camera]:not(.empty):not([data-stamp=''])"),
};
new MutationObserver((_, observer) => {
  for (const [name, found] of Object.entries(there)) {
    if (!found()) continue;
    delete there[name];
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => { window.paint[name] = performance.now(); };
    requestAnimationFrame(() => port2.postMessage(null));
  }
  if (!Object.keys(there).length) observer.disconnect();
}).observe(document, { subtree: true, childList: true, attributes: true });
"""
_PAINTED = """() => new Promise((resolve) => {
  const look = () => ["code", "state", "picture"].every((name) => name in window.paint)
    ? resolve(window.paint) : setTimeout(look, 5);
  look();
})"""
_CAME = """() => [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")]
  .map(({ name, transferSize }) => [name, transferSize])"""


@dataclass(frozen=True, slots=True)
class Load:
    """One load: when each thing was on the screen (ms since the navigation), bytes by HTTP, processor seconds."""

    painted: Mapping[str, float]
    transferred: int
    browser: float
    program: float

    @property
    def useful(self) -> float:
        """When the robot's state and picture were both there, ms."""
        return max(self.painted["state"], self.painted["picture"])


def own_bytes(came: Sequence[tuple[str, int]]) -> int:
    """The bytes of what came (address, bytes), without viser's 3D view."""
    return sum(size for address, size in came if "/viser" not in address)


def case_rows(case: str, loads: Sequence[Load]) -> list[Row]:
    """The rows of one case."""
    goal = [GOAL_MS] * len(loads)
    return [
        *(row("first_paint", case, name, "ms", [each.painted[name] for each in loads]) for name in loads[0].painted),
        row("first_paint", case, "useful", "ms", [each.useful for each in loads], goal, "the goal"),
        row(
            "first_paint", case, "transferred", "kB", [1e-3 * each.transferred for each in loads],
            [GOAL_KB] * len(loads), "the goal",
        ),
        row("first_paint", case, "browser", "CPU ms", [1e3 * each.browser for each in loads]),
        row("first_paint", case, "program", "CPU ms", [1e3 * each.program for each in loads]),
    ]  # fmt: skip


def measure(loads: int) -> list[Row]:
    """Each page ``loads`` times, in turn. One load before counts for nothing: it warms up program and browser."""
    taken: dict[str, list[Load]] = {case: [] for case, _, _ in CASES}
    with (
        tempfile.TemporaryDirectory() as folder,
        running_robot(Path(folder), calm=True) as robot,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
        _load(robot, browser, CASES[0][1], CASES[0][2])
        for _ in range(loads):
            for case, viewport, query in CASES:
                taken[case].append(_load(robot, browser, viewport, query))
        browser.close()
    return [line for case, found in taken.items() for line in case_rows(case, found)]


def _load(robot: Robot, browser: Browser, viewport: ViewportSize, query: str) -> Load:
    context = browser.new_context(viewport=viewport)
    context.set_default_timeout(60_000)
    context.add_init_script("localStorage.setItem('hbba.operator', 'benchmark')")
    context.add_init_script(_NOTE)
    page = context.new_page()
    program = psutil.Process(robot.process.pid)
    own, before = program.cpu_times(), cpu_seconds()
    page.goto(f"{robot.url}/{query}", wait_until="commit")
    painted: Any = page.evaluate(_PAINTED)
    after, now = cpu_seconds(), program.cpu_times()
    page.wait_for_timeout(LONGER_MS)
    came: Any = page.evaluate(_CAME)
    context.close()
    return Load(
        painted,
        own_bytes(came),
        browser=sum(after.values()) - sum(before.values()),
        program=now.user + now.system - own.user - own.system,
    )


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(2 if quick else 12)))
