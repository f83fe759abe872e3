"""The camera's pictures as video in a real browser: they come, show what JPEGs do, and give way to them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page, expect

from app.console.live.protocol import VP9_DELTA
from tests.browser.running import Robot

#: A link on which JPEGs as they come are late.
SHORT = {"rate_mbit": 0.8}


@pytest.fixture(autouse=True)
def _on_a_short_link(robot: Robot) -> Iterator[None]:
    """The link is short for these tests alone."""
    assert robot.request("PUT", "/link", SHORT)[0] == 200
    yield
    assert robot.request("PUT", "/link", {})[0] == 200


def coded(page: Page, coding: str) -> None:
    """Wait until ``page`` shows pictures that came so."""
    expect(page.get_by_test_id("camera")).to_have_attribute("data-coding", coding)


def next_picture(page: Page) -> None:
    """Wait until ``page`` shows another picture than now."""
    camera = page.get_by_test_id("camera")
    stamp = camera.get_attribute("data-stamp") or ""
    expect(camera).not_to_have_attribute("data-stamp", stamp)


# The picture on the canvas itself: a late one is greyed by the page, and marks lie over it.
_PIXELS = """() => {
  const small = new OffscreenCanvas(64, 48).getContext("2d");
  small.imageSmoothingQuality = "high";
  small.drawImage(document.querySelector("[data-testid=camera] canvas"), 0, 0, 64, 48);
  return [...small.getImageData(0, 0, 64, 48).data];
}"""


def canvas(page: Page) -> NDArray[np.uint8]:
    """What ``page`` shows of the camera: (48, 64, 3) RGB."""
    return np.array(page.evaluate(_PIXELS), np.uint8).reshape(48, 64, 4)[..., :3]


def test_pictures_come_as_video_and_show_what_jpegs_show(open_page: Callable[..., Page]) -> None:
    page = open_page()
    coded(page, "VP9")
    next_picture(page)
    as_video = canvas(page)
    # The same page with a browser that has no decoder for pages.
    page.add_init_script("delete window.VideoDecoder")
    page.reload()
    coded(page, "JPEG")
    next_picture(page)
    as_jpeg = canvas(page)
    assert as_jpeg.std() > 20, "the camera sees something"
    # Nothing moved in between. Wrong ranges or matrices of colour would shift it by 10 and more.
    shift = as_video.reshape(-1, 3).mean(axis=0) - as_jpeg.reshape(-1, 3).mean(axis=0)
    assert np.abs(shift).max() < 4
    assert np.abs(as_video.astype(float) - as_jpeg).mean() < 6


# What the page gives its worker to decode is no VP9 from the first picture on that needs those before it.
_SPOIL = """
const post = Worker.prototype.postMessage;
Worker.prototype.postMessage = function (message, given) {
  const picture = message.picture;
  if (picture && picture.coding === CODING) new Uint8Array(picture.data, picture.offset).fill(0);
  return post.call(this, message, given);
};
"""


def test_a_decoder_that_fails_gives_way_to_jpegs(open_page: Callable[..., Page]) -> None:
    page = open_page()
    page.add_init_script(_SPOIL.replace("CODING", str(VP9_DELTA)))
    page.reload()
    page.get_by_role("tab", name="Load").click()
    expect(page.get_by_test_id("pictures")).to_contain_text("As JPEG alone: the decoder")
    coded(page, "JPEG")
    next_picture(page)
    next_picture(page)
    coded(page, "JPEG")
