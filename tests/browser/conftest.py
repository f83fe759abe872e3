"""The whole running program, and a real browser in front of it.

Each test, where its file says nothing else, gets a robot of its own (``hbba run`` as a process) in the simulated lab,
with the guard's log turned on: what the wheels were really given, on the clock of this computer.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, Playwright, expect, sync_playwright

from app.commands.doctor import find_chromium
from app.robots.simulated.gl import check_gl
from tests.browser.browsers import launching, named
from tests.browser.running import LOOPS_DEBUG, Robot, running_robot
from tests.patience import PATIENCE_MS

expect.set_options(timeout=PATIENCE_MS)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Every test of this folder is a browser test, blocks while it waits for the page, and needs what it drives."""
    here = Path(__file__).parent
    missing = None if find_chromium() else "Chromium is missing: install Debian's package `chromium`"
    missing = missing or check_gl()
    for item in items:
        if here in item.path.parents:
            item.add_marker(pytest.mark.browser)
            item.add_marker(pytest.mark.blocking("waits for another process"))
            if missing:
                item.add_marker(pytest.mark.skip(reason=missing))


@pytest.fixture
def robot(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Robot]:
    """A robot of its own for each test; a calm one for the tests of a file that says ``CALM = True``."""
    with running_robot(tmp_path, calm=getattr(request.module, "CALM", False)) as running:
        yield running


@pytest.fixture(scope="module")
def playwright() -> Iterator[Playwright]:
    """Playwright, driving the system's Chromium.

    For one file at a time: while it runs it holds this thread's event loop, which other files' tests need.
    """
    with pytest.MonkeyPatch.context() as patch, contextlib.ExitStack() as stack:
        # Its loop runs Playwright's code alone: debugged, each call takes more than twice the processor time.
        patch.setenv(LOOPS_DEBUG, "")
        running = stack.enter_context(sync_playwright())
        patch.undo()
        yield running


@pytest.fixture(scope="module")
def browser(playwright: Playwright) -> Iterator[Browser]:
    """One Chromium for a file's tests."""
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
