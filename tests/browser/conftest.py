"""The whole running program, and a real browser in front of it.

Each test, where its file says nothing else, gets a robot of its own (``hbba run`` as a process) in the simulated lab,
with the guard's log turned on: what the wheels were really given, on the clock of this computer.
"""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import async_playwright
from playwright.async_api import expect as expect_in_coroutines
from playwright.sync_api import Browser, Page, Playwright, expect, sync_playwright

from app.commands.doctor import find_chromium
from app.robots.simulated.gl import check_gl
from tests.browser.browsers import Browsers, launching, named
from tests.browser.running import LOOPS_DEBUG, Robot, running_robot
from tests.patience import PATIENCE_MS

expect.set_options(timeout=PATIENCE_MS)
expect_in_coroutines.set_options(timeout=PATIENCE_MS)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Every test of this folder is a browser test, blocks while it waits for the page, and needs what it drives."""
    here = Path(__file__).parent
    ours = [item for item in items if here in item.path.parents]
    # One after another, so that they share a browser, and those of a folder a robot. First those that are coroutines:
    # they need this thread's event loop, which Playwright holds from the first of the others on.
    ours.sort(key=lambda item: (not is_coroutine(item), item.path.parent))
    items[:] = [item for item in items if here not in item.path.parents] + ours
    missing = None if find_chromium() else "Chromium is missing: install Debian's package `chromium`"
    missing = missing or check_gl()
    for item in ours:
        item.add_marker(pytest.mark.browser)
        item.add_marker(pytest.mark.blocking("waits for another process"))
        if missing:
            item.add_marker(pytest.mark.skip(reason=missing))


def is_coroutine(item: pytest.Item) -> bool:
    """Whether the test is run by an event loop of the tests."""
    return isinstance(item, pytest.Function) and inspect.iscoroutinefunction(item.function)


@pytest.fixture
def robot(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Robot]:
    """A robot of its own for each test; a calm and light one for the tests of a file that says ``CALM = True``."""
    calm = getattr(request.module, "CALM", False)
    with running_robot(tmp_path, calm=calm, light=calm) as running:
        yield running


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browsers() -> AsyncIterator[Browsers]:
    """Browsers for a file's coroutines, which run on the file's event loop."""
    async with async_playwright() as playwright:
        launched = Browsers(playwright)
        yield launched
        await launched.close()


@pytest.fixture(scope="package")
def playwright() -> Iterator[Playwright]:
    """Playwright, driving the system's browsers: for this folder alone, as it holds this thread's event loop."""
    with pytest.MonkeyPatch.context() as patch, contextlib.ExitStack() as stack:
        # Its loop runs Playwright's code alone: debugged, each call takes more than twice the processor time.
        patch.setenv(LOOPS_DEBUG, "")
        running = stack.enter_context(sync_playwright())
        patch.undo()
        yield running


@pytest.fixture(scope="package")
def browser(playwright: Playwright) -> Iterator[Browser]:
    """One Chromium for all tests: what a page keeps is of its context."""
    chromium = playwright.chromium.launch(**launching("chromium"))
    yield chromium
    chromium.close()


@pytest.fixture
def open_page(browser: Browser, robot: Robot) -> Iterator[Callable[..., Page]]:
    """Open the console in a window of its own and wait until it is live; in the end no error may have come up in it."""
    contexts = []
    errors: list[str] = []

    def open_one(*, scene: bool = False, operator: str = "operator", locale: str = "en-US") -> Page:
        context = browser.new_context(viewport={"width": 1000, "height": 640}, locale=locale)
        context.set_default_timeout(PATIENCE_MS)
        contexts.append(context)
        context.add_init_script(named(operator))
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(str(error)))
        # Drawn by the processor, as here, the 3D view starves all else: only tests that look at it open it.
        page.goto(robot.url if scene else f"{robot.url}/?scene=off")
        page.locator("[data-testid=connection][data-phase=live]").wait_for()
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert errors == []


@pytest.fixture
def page(open_page: Callable[..., Page]) -> Page:
    """The console, open and live."""
    return open_page()
