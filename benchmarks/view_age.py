"""How old the camera's picture is when a page has drawn it, through the whole program and a real browser.

Two pages in turn, by which the robot is turned on the spot all the time (each picture is another): one that decodes
VP9, and one that cannot (the peer: JPEG, scaled on the server), as large as a desk's screen and as a phone's, with the
link as it is and shaped. ``age``, glass to glass, is from the picture's stamp, which is its capture, until the page
acknowledges that it is drawn, by the computer's one clock. ``pictures``, ``bytes`` and ``width`` are the camera's;
``program`` and ``renderers`` are processor time, of the program's own process and of the browser's. ``turned`` is how
fast the robot did turn. The 3D view is left out. It ends within 14 minutes (``--quick``: 5) whatever the computer: what
takes longer is left out, and said.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, quantiles
from typing import Any, TypeAlias

import psutil
from playwright.sync_api import Browser, BrowserContext, Page, TimeoutError, ViewportSize, sync_playwright

from app.commands.doctor import find_chromium
from app.console.live.protocol import PICTURE_HEADER, VP9_DELTA, VP9_KEY
from app.robots.simulated.guard_log import GuardRow
from benchmarks.page_processes import cpu_seconds
from benchmarks.report import Row, benchmark_main, row
from tests.browser.running import CHROMIUM_ARGUMENTS, Robot, running_robot

VIEWPORTS = {"desk": ViewportSize(width=1440, height=900), "phone": ViewportSize(width=390, height=844)}
#: Until a page has loaded, and after the link has changed until pictures have found their size.
SETTLE_S = 8.0
#: A page that is not there by then is left out; no round begins that would end later than this.
LOAD_S = 30.0
LIMIT_S, QUICK_LIMIT_S = 13 * 60.0, 4 * 60.0
#: The screen, and the link's rate (Mbit/s; None: not shaped).
Case: TypeAlias = tuple[str, float | None]
CASES: tuple[Case, ...] = (("desk", None), ("phone", None), ("desk", 4.0), ("desk", 1.0))

# The page writes down the header and size of each picture of the camera, and when it says that it has drawn it, on the
# computer's wall clock.
_LISTEN = """
window.pictures = [];
const came = new Map(), Plain = window.WebSocket, send = Plain.prototype.send;
window.WebSocket = class extends Plain {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => {
      if (!(data instanceof ArrayBuffer) || new DataView(data).getUint8(0) !== 1) return;
      came.set(new DataView(data).getUint32(4, true), [[...new Uint8Array(data, 0, 24)], data.byteLength]);
    });
  }
};
Plain.prototype.send = function (data) {
  if (typeof data === "string" && data.startsWith('{"type":"ack","kind":1,')) {
    const { seq } = JSON.parse(data);
    if (came.has(seq)) window.pictures.push([...came.get(seq), (performance.timeOrigin + performance.now()) / 1e3]);
    came.delete(seq);
  }
  return send.call(this, data);
};
"""
_NO_VP9 = "delete window.VideoDecoder;"


@dataclass(frozen=True, slots=True)
class Drawn:
    """A picture that a page has drawn: its ``age`` then (s), its whole frame's ``size`` (bytes), its ``width`` (px)."""

    age: float
    size: int
    width: int
    vp9: bool


def pictures_of(noted: Sequence[tuple[Sequence[int], int, float]]) -> list[Drawn]:
    """What a page noted: of each picture header, size and when it was drawn (Unix time, s)."""
    found = []
    for header, size, at in noted:
        _, coding, _, stamp, width, _ = PICTURE_HEADER.unpack(bytes(header))
        found.append(Drawn(at - stamp, size, width, coding in (VP9_KEY, VP9_DELTA)))
    return found


@dataclass(frozen=True, slots=True)
class Watched:
    """A page watched for ``seconds``: what it drew, processor seconds, and the robot's mean speed (°/s)."""

    seconds: float
    drawn: Sequence[Drawn]
    program: float
    renderers: float
    turned: float


#: With VP9, and without.
Round: TypeAlias = tuple[Watched, Watched]


def case_rows(case: str, vp9: Sequence[Watched], jpeg: Sequence[Watched]) -> list[Row]:
    """The rows of one case, of equally many rounds of both, each with a picture at least."""
    figures: tuple[tuple[str, str, Callable[[Watched], float]], ...] = (
        ("age p50", "ms", lambda watched: 1e3 * _quantile(watched.drawn, 2)),
        ("age p95", "ms", lambda watched: 1e3 * _quantile(watched.drawn, 20)),
        ("pictures", "1/s", lambda watched: len(watched.drawn) / watched.seconds),
        ("bytes", "kB/s", lambda watched: 1e-3 * sum(each.size for each in watched.drawn) / watched.seconds),
        ("width", "px", lambda watched: mean(each.width for each in watched.drawn)),
        ("as VP9", "%", lambda watched: 100 * mean(each.vp9 for each in watched.drawn)),
        ("program", "% of a core", lambda watched: 100 * watched.program / watched.seconds),
        ("program", "ms/picture", lambda watched: 1e3 * watched.program / len(watched.drawn)),
        ("renderers", "% of a core", lambda watched: 100 * watched.renderers / watched.seconds),
        ("renderers", "ms/picture", lambda watched: 1e3 * watched.renderers / len(watched.drawn)),
        ("turned", "°/s", lambda watched: watched.turned),
    )
    return [
        row("view_age", case, name, unit, [figure(each) for each in vp9], [figure(each) for each in jpeg], "JPEG")
        for name, unit, figure in figures
    ]


def _quantile(drawn: Sequence[Drawn], parts: int) -> float:
    """The last of the values that cut the ages into ``parts`` (s)."""
    ages = [each.age for each in drawn]
    return quantiles(ages, n=parts)[-1] if len(ages) > 1 else ages[0]


def mean_turn(rows: Sequence[GuardRow], began: float, ended: float) -> float:
    """How fast the robot turned either way from ``began`` to ``ended`` (monotonic, s), by what its wheels were given
    (``rows``, oldest first, each until the next): rad/s, 0 where nothing was."""
    ends = [*(each.monotonic_s for each in rows[1:]), ended]
    spans = [min(end, ended) - max(each.monotonic_s, began) for each, end in zip(rows, ends, strict=False)]
    turned = sum(abs(each.angular_radps) * max(0.0, span) for each, span in zip(rows, spans, strict=True))
    return turned / (ended - began)


def measure(rounds: int, seconds: float, limit_s: float) -> list[Row]:
    """Both pages at each link and size, ``rounds`` of ``seconds`` each, in turn; all cases once before any again.

    Ends after ``limit_s`` (s) with the rounds that were whole by then; what is left out is said on the standard error.
    Raises SystemExit, in words, where no case has a whole round.
    """
    ends = time.monotonic() + limit_s
    watched: dict[Case, list[Round]] = {case: [] for case in CASES}
    with (
        tempfile.TemporaryDirectory() as folder,
        running_robot(Path(folder), calm=True) as robot,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
        for case in CASES * rounds:
            if time.monotonic() > ends - 2 * (SETTLE_S + seconds):
                print(f"view_age: no more rounds, it has run for {limit_s:.0f} s", file=sys.stderr)
                break
            began = time.monotonic()
            if (found := _round(robot, browser, case, seconds)) is not None:
                watched[case].append(found)
                print(f"view_age: {words(case)}, {time.monotonic() - began:.0f} s", file=sys.stderr)
        browser.close()
    return rows_of(watched)


def words(case: Case) -> str:
    """What the table calls a case."""
    screen, rate = case
    return f"{screen}, {'not shaped' if rate is None else f'{rate:g} Mbit/s'}"


def rows_of(watched: Mapping[Case, Sequence[Round]]) -> list[Row]:
    """The rows of each case that has a round. Raises SystemExit, in words, where none has."""
    if not any(watched.values()):
        raise SystemExit("view_age: no page was whole; this computer is too busy for program, world and browser")
    return [
        line
        for case, rounds in watched.items()
        if rounds
        for line in case_rows(words(case), [vp9 for vp9, _ in rounds], [jpeg for _, jpeg in rounds])
    ]


def _round(robot: Robot, browser: Browser, case: Case, seconds: float) -> Round | None:
    """One round of ``case``; None, said in words, where a page did not come or drew nothing."""
    screen, rate = case
    robot.request("PUT", "/link", {} if rate is None else {"rate_mbit": rate})
    found = []
    for vp9 in (True, False):
        try:
            one = _watch(robot, browser, VIEWPORTS[screen], seconds, vp9=vp9)
        except TimeoutError as late:
            print(f"view_age: {words(case)}, left out: {str(late).splitlines()[0]}", file=sys.stderr)
            return None
        if not one.drawn:
            print(f"view_age: {words(case)}, left out: no picture in {one.seconds:.0f} s", file=sys.stderr)
            return None
        found.append(one)
    return found[0], found[1]


def _watch(robot: Robot, browser: Browser, viewport: ViewportSize, seconds: float, *, vp9: bool) -> Watched:
    with closing(browser.new_context(viewport=viewport)) as context:
        return _watched(robot, context, seconds, vp9=vp9)


def _watched(robot: Robot, context: BrowserContext, seconds: float, *, vp9: bool) -> Watched:
    context.set_default_timeout(1e3 * LOAD_S)
    context.add_init_script("localStorage.setItem('hbba.operator', 'benchmark')")
    context.add_init_script(_LISTEN if vp9 else _NO_VP9 + _LISTEN)
    page = context.new_page()
    page.goto(f"{robot.url}/?scene=off")
    page.locator("[data-testid=connection][data-phase=live]").wait_for()
    page.keyboard.down("KeyA")
    page.wait_for_timeout(1e3 * SETTLE_S)
    program = psutil.Process(robot.process.pid)
    _taken(page)
    before, own, began = cpu_seconds(), program.cpu_times(), time.monotonic()
    page.wait_for_timeout(1e3 * seconds)
    drawn, after, now, elapsed = _taken(page), cpu_seconds(), program.cpu_times(), time.monotonic() - began
    turned = mean_turn(robot.wheels(), began, began + elapsed)
    page.keyboard.up("KeyA")
    return Watched(
        elapsed,
        drawn,
        program=now.user + now.system - own.user - own.system,
        renderers=after.get("renderer", 0.0) - before.get("renderer", 0.0),
        turned=math.degrees(turned),
    )


def _taken(page: Page) -> list[Drawn]:
    noted: Any = page.evaluate("window.pictures.splice(0)")
    return pictures_of(noted)


if __name__ == "__main__":
    sys.exit(
        benchmark_main(__doc__, lambda quick: measure(1, 5.0, QUICK_LIMIT_S) if quick else measure(3, 15.0, LIMIT_S))
    )
