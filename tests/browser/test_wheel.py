"""Who drives: asking for the wheel from page to page; and the emergency stop of a page whose thread is blocked.

On a body that the test plays: the page, the console and their connections are real, and nothing else takes time.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Page, TimeoutError, expect

from app.console.access.origins import Ports
from app.console.app import create_app
from app.console.server import listen
from app.messages import TeleopCommand
from app.program.system import System
from tests.browser.browsers import BOTH, Browsers, named
from tests.console.program import Body, build, served
from tests.patience import PATIENCE_MS

#: What a page does last before its thread is blocked: as where all waits in its own connection, Escape is pressed.
PRESS_ESCAPE = """
    WebSocket.prototype.send = () => undefined;
    window.dispatchEvent(new KeyboardEvent("keydown", {code: "Escape", key: "Escape"}));
"""
#: Blocks the page's thread until the robot is as it is waited for; asks it, and waits for each answer.
BLOCK_UNTIL = """() => void setTimeout(() => {
    FIRST
    window.outcome = "not stopped";
    const end = performance.now() + 120000;
    while (window.outcome === "not stopped" && performance.now() < end) {
        const request = new XMLHttpRequest();
        request.open("GET", "./api/v1/robot", false);
        request.send();
        if (((robot) => WANTED)(JSON.parse(request.responseText))) window.outcome = "stopped while blocked";
    }
    window.over = true;
})"""
#: Blocks it for so long; on a busy computer once more, for longer. Firefox goes on with its timers while it waits for
#: an answer: there it must not wait.
BLOCK_FOR_S = (3, 20)
BLOCK_FOR = """() => void setTimeout(() => {
    FIRST
    for (const end = performance.now() + 1000 * SECONDS; performance.now() < end; );
    window.over = true;
})"""


async def over(page: Page) -> None:
    """Until the page's thread is free again. Its content policy forbids Playwright to wait by a function."""
    while not await page.evaluate("window.over"):
        await page.wait_for_timeout(100)


@dataclass
class Console:
    """The console of a body that the test plays, and a browser."""

    url: str
    body: Body
    browser: Browser
    #: What came on the channel of the wheel, in its order.
    commands: list[TeleopCommand]
    in_firefox: bool

    async def open(self, operator: str | None) -> Page:
        """A page of ``operator``'s, live; None: of a browser that was given no name."""
        context = await self.browser.new_context(viewport={"width": 1000, "height": 640})
        context.set_default_timeout(PATIENCE_MS)
        if operator is not None:
            await context.add_init_script(named(operator))
        page = await context.new_page()
        await page.goto(f"{self.url}/?scene=off")
        await page.locator("[data-testid=connection][data-phase=live]").wait_for()
        return page

    async def drive(self, page: Page, operator: str) -> None:
        """Hold a key of ``page`` until its command has come; a busy page lets go, and it is pressed again."""
        before = len(self.commands)
        while not any(command.held and command.operator == operator for command in self.commands[before:]):
            await page.keyboard.up("KeyW")
            await page.keyboard.down("KeyW")
            await page.wait_for_timeout(500)


# One event loop for the file, as for its browsers. Playwright's code, debugged, would take twice as long.
pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.slow]


@pytest_asyncio.fixture(loop_scope="module", params=BOTH)
async def console(tmp_path: Path, request: pytest.FixtureRequest, browsers: Browsers) -> AsyncIterator[Console]:
    """Served with the 3D view on a port of its own."""
    browser = await browsers.get(request.param)
    system: System
    system, body = build(tmp_path)
    listener, scene = listen("127.0.0.1", 0), listen("127.0.0.1", 0)
    ports = Ports(listener.getsockname()[1], scene.getsockname()[1])

    async def report() -> None:
        while True:
            body.emit_status(system.clock.now())
            await asyncio.sleep(0.05)

    commands: list[TeleopCommand] = []
    async with system:
        system.graph.channel("teleop_command").observe(commands.append)
        app = await asyncio.to_thread(create_app, system, ports=ports, early_view=False)
        async with served(app, listener, scene) as url:
            reporting = asyncio.create_task(report())
            yield Console(url, body, browser, commands, in_firefox=request.param == "firefox")
            reporting.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await reporting
        for context in browser.contexts:
            await context.close()


async def test_a_page_asks_for_the_wheel_and_it_is_kept_then_given_and_the_name_is_asked_for_once(
    console: Console,
) -> None:
    ann, bob = await console.open("Ann"), await console.open(None)
    await bob.get_by_test_id("name-ask-input").fill("Bob")
    await bob.get_by_test_id("name-ask-done").click()
    await expect(bob.get_by_test_id("name-ask")).to_have_count(0)
    await expect(bob.get_by_test_id("operator")).to_have_text("Bob")
    asked = ann.get_by_test_id("wheel-asked")
    mine = bob.get_by_test_id("release-control")
    for answer, reply in (("wheel-keep", bob.get_by_text("Ann keeps the wheel.").first), ("wheel-give", mine)):
        while True:
            # On a busy computer question and answer may come too late for each other: then it is asked again.
            with contextlib.suppress(TimeoutError):
                if await mine.is_visible():  # it was not answered in time, and given by itself
                    await mine.click(timeout=3000)
                await console.drive(ann, "Ann")
                await bob.get_by_test_id("ask-control").first.click(timeout=3000)
                await asked.get_by_text("Bob asks for the wheel.").first.wait_for(timeout=3000)
                await ann.get_by_test_id(answer).click(timeout=3000)
                await reply.wait_for(timeout=3000)
                break
    await console.drive(bob, "Bob")
    changes = [(last, next_) for last, next_ in zip(console.commands, console.commands[1:], strict=False)]
    assert all(not last.held for last, next_ in changes if last.operator != next_.operator)
    assert {command.operator for command in console.commands} == {"Ann", "Bob"}


async def stopped_while_blocked(
    console: Console, page: Page, wanted: str, stopped: Callable[[], bool], *, seconds: float, first: str = ""
) -> bool:
    """Block the thread of ``page``, once it has done what ``first`` says; whether the robot stops meanwhile: ``wanted``
    says so of the answer to GET /robot, ``stopped`` of what came to the robot. ``seconds``: how long, in Firefox."""
    if not console.in_firefox:
        await page.evaluate(BLOCK_UNTIL.replace("FIRST", first).replace("WANTED", wanted))
        await over(page)
        return bool(await page.evaluate("window.outcome") == "stopped while blocked")
    blocked = time.monotonic()
    await page.evaluate(BLOCK_FOR.replace("FIRST", first).replace("SECONDS", str(seconds)))
    while not (meanwhile := stopped()):
        if time.monotonic() > blocked + seconds:
            break
        await asyncio.sleep(0.05)
    await over(page)
    return meanwhile


async def test_what_is_held_in_a_page_that_is_blocked_ends_meanwhile(console: Console) -> None:
    page = await console.open("Ann")

    def let_go() -> bool:
        return not console.commands[-1].held

    for seconds in BLOCK_FOR_S:
        await console.drive(page, "Ann")
        if await stopped_while_blocked(console, page, "robot.driver === null", let_go, seconds=seconds):
            return
    pytest.fail("what was held went on while the page was blocked")


async def test_a_stop_arrives_though_the_page_is_blocked_right_after_and_its_own_connection_is_full(
    console: Console,
) -> None:
    for seconds in BLOCK_FOR_S:
        page = await console.open("Ann")
        if await stopped_while_blocked(
            console, page, "robot.guard.e_stopped", lambda: console.body.e_stopped, seconds=seconds, first=PRESS_ESCAPE
        ):
            break
        await page.context.close()
        console.body.clear_e_stop()
        console.body.stops.clear()
    assert console.body.stops == ["pressed by operator Ann"]


async def test_space_twice_stops_but_not_while_typing(console: Console) -> None:
    page = await console.open("Ann")
    await page.set_viewport_size({"width": 1440, "height": 900})  # a narrower bar has no room for the name
    await page.get_by_test_id("operator").click()
    for _ in range(2):
        await page.keyboard.press("Space")
    await page.keyboard.press("Enter")
    await page.keyboard.press("Space")
    await page.wait_for_timeout(700)
    assert not console.body.e_stopped
    while not console.body.e_stopped:  # on a busy computer two presses may come further apart
        await page.keyboard.press("Space")
        await page.keyboard.press("Space")
    await page.locator("[data-testid=guard-state][data-state=e_stopped]").wait_for()
