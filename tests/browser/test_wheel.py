"""Who drives: asking for the wheel from page to page; and the emergency stop of a page whose thread is blocked.

On a body that the test plays: the page, the console and their connections are real, and nothing else takes time.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.async_api import Browser, Page, TimeoutError, async_playwright, expect

from app.commands.doctor import find_chromium
from app.console.access.origins import Ports
from app.console.app import create_app
from app.console.server import listen
from app.messages import TeleopCommand
from app.program.system import System
from tests.browser.running import CHROMIUM_ARGUMENTS
from tests.console.program import Body, build, served
from tests.patience import PATIENCE_MS

#: Blocks the page's thread until the robot's emergency stop is latched: it asks the robot, and waits for each answer.
BLOCK_UNTIL_STOPPED = """() => void setTimeout(() => {
    WebSocket.prototype.send = () => undefined;  // as where all waits in the page's own connection
    window.dispatchEvent(new KeyboardEvent("keydown", {code: "Escape", key: "Escape"}));
    window.outcome = "not stopped";
    const end = performance.now() + 120000;
    while (window.outcome === "not stopped" && performance.now() < end) {
        const request = new XMLHttpRequest();
        request.open("GET", "./api/v1/robot", false);
        request.send();
        if (JSON.parse(request.responseText).guard.e_stopped) window.outcome = "stopped while blocked";
    }
    window.over = true;
})"""
#: Blocks it until the robot's program has counted a stop of what was held.
BLOCK_WHILE_DRIVEN = """() => void setTimeout(() => {
    const end = performance.now() + 120000;
    let holds = true;
    while (holds && performance.now() < end) {
        const request = new XMLHttpRequest();
        request.open("GET", "./api/v1/robot", false);
        request.send();
        holds = JSON.parse(request.responseText).driver !== null;
    }
    window.outcome = holds ? "drives on" : "stopped while blocked";
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

    async def open(self, operator: str | None) -> Page:
        """A page of ``operator``'s, live; None: of a browser that was given no name."""
        context = await self.browser.new_context(viewport={"width": 1000, "height": 640})
        context.set_default_timeout(PATIENCE_MS)
        if operator is not None:
            await context.add_init_script(f"localStorage.setItem('hbba.operator', {json.dumps(operator)})")
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


@pytest.fixture
async def console(tmp_path: Path) -> AsyncIterator[Console]:
    """Served with the 3D view on a port of its own."""
    system: System
    system, body = build(tmp_path)
    listener, scene = listen("127.0.0.1", 0), listen("127.0.0.1", 0)
    ports = Ports(listener.getsockname()[1], scene.getsockname()[1])

    async def report() -> None:
        while True:
            body.emit_status(system.clock.now())
            await asyncio.sleep(0.05)

    commands: list[TeleopCommand] = []
    async with system, async_playwright() as playwright:
        system.graph.channel("teleop_command").observe(commands.append)
        app = await asyncio.to_thread(create_app, system, ports=ports, early_view=False)
        browser = await playwright.chromium.launch(executable_path=find_chromium(), args=CHROMIUM_ARGUMENTS)
        async with served(app, listener, scene) as url:
            reporting = asyncio.create_task(report())
            yield Console(url, body, browser, commands)
            reporting.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await reporting
        await browser.close()


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
    for answer, given in (("wheel-keep", False), ("wheel-give", True)):
        while not await mine.is_visible():
            # On a busy computer question and answer may come too late for each other: then it is asked again.
            with contextlib.suppress(TimeoutError):
                await console.drive(ann, "Ann")
                await bob.get_by_test_id("ask-control").first.click(timeout=3000)
                await asked.get_by_text("Bob asks for the wheel.").first.wait_for(timeout=3000)
                await ann.get_by_test_id(answer).click(timeout=3000)
                if not given:
                    await bob.get_by_text("Ann keeps the wheel.").first.wait_for(timeout=3000)
                    break
                await mine.wait_for(timeout=3000)
        assert await mine.is_visible() is given
    await console.drive(bob, "Bob")
    changes = [(last, next_) for last, next_ in zip(console.commands, console.commands[1:], strict=False)]
    assert all(not last.held for last, next_ in changes if last.operator != next_.operator)
    assert {command.operator for command in console.commands} == {"Ann", "Bob"}


async def test_what_is_held_in_a_page_that_is_blocked_ends_meanwhile(console: Console) -> None:
    page = await console.open("Ann")
    await console.drive(page, "Ann")
    await page.evaluate(BLOCK_WHILE_DRIVEN)
    await over(page)
    assert await page.evaluate("window.outcome") == "stopped while blocked"
    assert any(not command.held for command in console.commands)


async def test_a_stop_arrives_though_the_page_is_blocked_right_after_and_its_own_connection_is_full(
    console: Console,
) -> None:
    page = await console.open("Ann")
    await page.evaluate(BLOCK_UNTIL_STOPPED)
    await over(page)
    assert await page.evaluate("window.outcome") == "stopped while blocked"
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
