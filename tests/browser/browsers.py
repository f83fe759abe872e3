"""The browsers that tests drive: Debian's Chromium, and Debian's Firefox by WebDriver BiDi."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.async_api import Browser, Playwright

from app.commands.doctor import find_chromium
from tests.browser.running import CHROMIUM_ARGUMENTS

FIREFOX_NAMES = ("firefox-esr", "firefox")
NO_FIREFOX = "Firefox is missing: install Debian's package `firefox-esr`"
NO_DISPLAY = "Xvfb is missing, and without a display Firefox has no WebGL: install Debian's package `xvfb`"
#: Names of browsers, as tests are given them.
BOTH = ("chromium", "firefox")


def find_firefox() -> str | None:
    """Where a Firefox is, as it is released; None: there is none."""
    return next((path for name in FIREFOX_NAMES if (path := shutil.which(name))), None)


def missing(browser: str) -> str | None:
    """Why ``browser`` cannot be driven here; None: it can."""
    return NO_FIREFOX if browser == "firefox" and find_firefox() is None else None


def launching(browser: str) -> dict[str, Any]:
    """What Playwright's ``launch`` is given to start the ``browser`` of this computer.

    Playwright's own Firefox is a patched one that it would download; the channel ``moz-firefox`` is a released one.
    """
    if browser == "chromium":
        return {"executable_path": find_chromium(), "args": CHROMIUM_ARGUMENTS}
    return {"executable_path": find_firefox(), "channel": "moz-firefox"}


def named(operator: str) -> str:
    """The script by which a page is given the ``operator``'s name before its own scripts run.

    Asked for its name, a page would lay that question over what a test clicks. An empty page has no storage.
    """
    return f"if (window.origin !== 'null') localStorage.setItem('hbba.operator', {json.dumps(operator)})"


class Browsers:
    """Browsers by name, each launched once, when it is first asked for."""

    def __init__(self, playwright: Playwright) -> None:
        self._playwright = playwright
        self._launched: dict[str, Browser] = {}

    async def get(self, name: str) -> Browser:
        """The browser ``name``, one of :data:`BOTH`; skips the test where it is missing."""
        if why := missing(name):
            pytest.skip(why)
        if name not in self._launched:
            self._launched[name] = await getattr(self._playwright, name).launch(**launching(name))
        return self._launched[name]

    async def close(self) -> None:
        """End all of them."""
        for browser in self._launched.values():
            await browser.close()


@contextmanager
def display(width: int, height: int) -> Iterator[str | None]:
    """The name of a display of ``width`` × ``height`` px that nobody sees; None where Xvfb is missing."""
    server = shutil.which("Xvfb")
    if server is None:
        yield None
        return
    command = [server, "-displayfd", "1", "-nolisten", "tcp", "-screen", "0", f"{width}x{height}x24"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        try:
            yield f":{process.stdout.readline().strip()}"
        finally:
            process.terminate()
