"""A person's hand on the page's keys."""

from __future__ import annotations

from playwright.sync_api import Locator, Page, TimeoutError

#: A person who sees nothing move for so long lets go and presses again (ms).
_PATIENCE_MS = 5_000
_TRIES = 6


def wait_driving(page: Page, timeout_ms: float = 30_000) -> None:
    """Until the guard says that the robot drives."""
    page.locator("[data-testid=guard-state][data-state=driving]").wait_for(timeout=timeout_ms)


def hold(page: Page, key: str) -> None:
    """Press ``key`` and keep it down; returns when the robot drives.

    On a busy computer what the page shows may be old for a moment: then it lets go of everything, and wants it pressed
    anew.
    """
    for _ in range(_TRIES):
        page.keyboard.down(key)
        try:
            wait_driving(page, _PATIENCE_MS)
        except TimeoutError:
            page.keyboard.up(key)
        else:
            return
    raise AssertionError(f"held {key} {_TRIES} times for {_PATIENCE_MS / 1e3:.0f} s, and the robot never drove")


def hold_until(page: Page, key: str, there: Locator, patience_ms: float = 25_000, tries: int = 3) -> None:
    """Hold ``key`` until ``there`` is to be seen; what the page let go on the way is pressed anew."""
    for number in range(tries):
        hold(page, key)
        try:
            there.wait_for(timeout=patience_ms)
        except TimeoutError:
            if number == tries - 1:
                raise
        else:
            return
        finally:
            page.keyboard.up(key)
