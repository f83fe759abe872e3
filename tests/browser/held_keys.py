"""A person's hand on the page: keys that are held, and presses that a busy page may have missed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Literal

from playwright.sync_api import Locator, Page, TimeoutError

from tests.patience import PATIENCE_S

#: A person who sees nothing move for so long lets go and presses again (ms).
_PRESS_AGAIN_MS = 5_000


def wait_driving(page: Page, timeout_ms: float | None = None) -> None:
    """Until the guard says that the robot drives."""
    page.locator("[data-testid=guard-state][data-state=driving]").wait_for(timeout=timeout_ms)


def press_until(
    press: Callable[[], object],
    there: Locator,
    state: Literal["visible", "detached"] = "visible",
    again_ms: float = 15_000,
) -> None:
    """Press until ``there`` is in ``state``, again after ``again_ms``: on a busy computer a press may come too late, or
    something may lie over what is pressed."""
    end = time.monotonic() + PATIENCE_S
    while True:
        press()
        try:
            there.wait_for(state=state, timeout=again_ms)
        except TimeoutError:
            if time.monotonic() > end:
                raise
        else:
            return


def hold(page: Page, key: str) -> None:
    """Press ``key`` and keep it down; returns when the robot drives."""
    strike = {"down": page.keyboard.down, "up": page.keyboard.up}
    hold_by(page, lambda way: strike[way](key), key)


def hold_by(page: Page, strike: Callable[[str], object], name: str) -> None:
    """Keep down the key called ``name`` by ``strike("down")`` until the robot drives; ``strike("up")`` lets go.

    On a busy computer what the page shows may be old for a moment: the page lets go of everything then, and the key
    is pressed again.
    """
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        strike("down")
        try:
            wait_driving(page, _PRESS_AGAIN_MS)
        except TimeoutError:
            strike("up")
        else:
            return
    raise AssertionError(f"{name} was held again and again for {PATIENCE_S:.0f} s, and the robot never drove")


def hold_until(page: Page, key: str, there: Locator, again_ms: float = 15_000) -> None:
    """Hold ``key`` until ``there`` is to be seen; pressed again after ``again_ms``, for the page may have let go."""
    end = time.monotonic() + PATIENCE_S
    while True:
        hold(page, key)
        try:
            there.wait_for(timeout=again_ms)
        except TimeoutError:
            if time.monotonic() > end:
                raise
        else:
            return
        finally:
            page.keyboard.up(key)
