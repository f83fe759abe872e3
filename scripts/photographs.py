"""Pictures of pages in good health, written to ``docs/images``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
from playwright.sync_api import Browser, Frame, Locator, Page, ViewportSize

Image = npt.NDArray[np.uint8]

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "images"
#: The 3D view draws, or is paused: the rest of the page then has the computer to itself.
_STAND_STILL = """() => {
  window.held = [];
  window.draw = window.requestAnimationFrame;
  window.requestAnimationFrame = (callback) => window.held.push(callback);
}"""
_GO_ON = """() => {
  window.requestAnimationFrame = window.draw;
  for (const callback of window.held) window.draw(callback);
}"""
#: A picture waits for a page in good health, looked at so many times, a second apart.
HEALTH_TRIES = 90
#: The 3D view, held back while the page is looked at, has so many quarters of a second to draw what is now.
VIEW_TRIES = 20
#: A view older than this (ms) is not published, nor a world so slow that the page says it.
OLDEST_VIEW_MS = 300


def opened(browser: Browser, url: str, size: ViewportSize) -> Page:
    """A window of its own on the console, live."""
    context = browser.new_context(viewport=size, color_scheme="dark")
    context.add_init_script("localStorage.setItem('hbba.operator', 'operator')")
    page = context.new_page()
    page.set_default_timeout(300_000)
    page.goto(url)
    page.locator("[data-testid=connection][data-phase=live]").wait_for()
    return page


def shoot(page: Page, name: str, there: Locator | None = None) -> None:
    """Save the page as ``docs/images/<name>.jpg`` in good health, with what is to be ``there``.

    Raises SystemExit, in words: a picture of a page that is late, or of a world that is slow, is not written.
    """
    views = page.frames[1:]
    if there is not None:
        there.wait_for(state="attached", timeout=300_000)
    ill = "not looked at"
    for _ in range(HEALTH_TRIES):
        for view in views:
            view.evaluate(_STAND_STILL)
        page.wait_for_timeout(1_000)
        ill = illness(page) or ("what it is to show is not there" if there is not None and not there.count() else "")
        for view in views:
            view.evaluate(_GO_ON)
        if not ill and not (ill := late_view(page, views)):
            break
    else:
        raise SystemExit(f"{name}: not written, since {ill}. Take it on a computer that has nothing else to do.")
    saved(name, taken(page))


def late_view(page: Page, views: Sequence[Frame]) -> str:
    """Let the 3D view, if there is one, draw what is now; what ails the page once it has, in words."""
    for _ in range(VIEW_TRIES if views else 0):
        page.wait_for_timeout(250)
        if page.locator("[data-testid=scene-age]:not(.late)").count():
            return illness(page)
    return "the 3D view is late" if views else ""


def illness(page: Page) -> str:
    """What of the page should not be seen on a picture, in words; empty: nothing."""
    if page.locator("[data-testid=connection][data-phase=live]").count() == 0:
        return "the page does not hear the robot"
    if page.locator("[data-testid=around-age].old").count():
        return f"the panorama is old ({page.get_by_test_id('around-age').first.inner_text()})"
    if page.locator("[data-testid=camera].old").count():
        return f"the camera's picture is old ({page.get_by_test_id('camera-age').first.inner_text()})"
    if page.locator("[data-testid=camera-age].late").count():
        return f"the camera's picture is late ({page.get_by_test_id('camera-age').first.inner_text()})"
    slow = page.get_by_test_id("world-rate")
    if slow.count():
        return str(slow.inner_text())
    age = page.locator("[data-testid=view-age]")
    if age.count() and (found := age.first.inner_text().split()[0]).isdigit() and int(found) > OLDEST_VIEW_MS:
        return f"what it shows is {found} ms old"
    if page.get_by_test_id("notice").count():
        return f"it says: {page.get_by_test_id('notice').first.inner_text()}"
    return ""


def taken(page: Page) -> Image:
    """What the page shows, as BGR."""
    return np.asarray(cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_COLOR), np.uint8)


def saved(name: str, picture: Image) -> None:
    """As ``docs/images/<name>.jpg``: a tenth of the size of a PNG, for a repository that keeps every version."""
    cv2.imwrite(str(FOLDER / f"{name}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 88])
    print(json.dumps({"picture": name}))


def strip(pictures: Sequence[Image]) -> Image:
    """``pictures`` (H, W, 3) side by side with white between, and below."""
    gap = np.full((pictures[0].shape[0], 4, 3), 255, np.uint8)
    row = np.hstack([part for picture in pictures for part in (picture, gap)][:-1])
    return np.vstack([row, np.full((8, row.shape[1], 3), 255, np.uint8)])
