"""The camera's pictures as video in a real browser: they come, show what JPEGs show, and give way to them."""

from __future__ import annotations

import re
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Page, WebSocketRoute, expect

from app.console.live.protocol import CAMERA, PICTURE_HEADER, VP9_DELTA
from tests.browser.running import Robot

CALM = True
#: A page as wide as this shows the camera narrower than it comes: then it is video, on any link.
NARROW = 390


def narrow(page: Page) -> Page:
    """``page`` as narrow as a phone."""
    page.set_viewport_size({"width": NARROW, "height": 844})
    return page


def coded(page: Page, coding: str) -> None:
    """Wait until ``page`` shows pictures that came so."""
    expect(page.get_by_test_id("camera")).to_have_attribute("data-coding", coding)


def next_picture(page: Page) -> None:
    """Wait until ``page`` shows another picture than now."""
    camera = page.get_by_test_id("camera")
    stamp = camera.get_attribute("data-stamp") or ""
    expect(camera).not_to_have_attribute("data-stamp", stamp)


def canvas(page: Page) -> NDArray[np.uint8]:
    """What ``page`` shows of the camera: (H, W, 3) BGR, without what lies over it."""
    page.evaluate(
        """() => { for (const cover of document.querySelectorAll('[data-testid=camera] > :not(canvas)'))
            cover.style.visibility = 'hidden'; }"""
    )
    box = page.locator("[data-testid=camera] canvas").bounding_box()
    assert box is not None
    picture = page.screenshot(clip=box)
    shown = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    return np.asarray(shown, np.uint8)


def test_pictures_come_as_video_and_show_what_jpegs_show(robot: Robot, open_page: Callable[..., Page]) -> None:
    video = narrow(open_page())
    coded(video, "VP9")
    next_picture(video)
    as_video = canvas(video)
    # The same page with a browser that has no decoder for pages.
    video.add_init_script("delete window.VideoDecoder")
    video.reload()
    coded(video, "JPEG")
    next_picture(video)
    as_jpeg = canvas(video)
    assert as_video.shape == as_jpeg.shape
    assert as_jpeg.std() > 20, "the camera sees something"
    # Nothing moved in between. Wrong ranges or matrices of colour would shift it by 10 and more.
    shift = as_video.reshape(-1, 3).mean(axis=0) - as_jpeg.reshape(-1, 3).mean(axis=0)
    assert np.abs(shift).max() < 4
    assert np.abs(as_video.astype(float) - as_jpeg).mean() < 10


def test_video_follows_what_the_robot_sees(robot: Robot, open_page: Callable[..., Page]) -> None:
    page = narrow(open_page())
    coded(page, "VP9")
    next_picture(page)
    before = canvas(page)
    page.keyboard.down("KeyJ")
    while np.abs(canvas(page).astype(float) - before).mean() < 12:
        next_picture(page)
    page.keyboard.up("KeyJ")
    expect(page.get_by_test_id("camera")).to_have_attribute("data-coding", "VP9")


def test_a_decoder_that_fails_gives_way_to_jpegs(robot: Robot, open_page: Callable[..., Page]) -> None:
    page = open_page()
    broken = []

    def spoil(socket: WebSocketRoute) -> None:
        server = socket.connect_to_server()

        def pass_on(message: str | bytes) -> None:
            if isinstance(message, bytes) and message[0] == CAMERA and message[1] == VP9_DELTA:
                broken.append(message)
                message = message[: PICTURE_HEADER.size] + b"no frame of VP9"
            socket.send(message)

        server.on_message(pass_on)

    page.route_web_socket(re.compile("/api/v1/live"), spoil)
    page.reload()
    narrow(page)
    while not broken:
        next_picture(page)
    coded(page, "JPEG")
    next_picture(page)
    next_picture(page)
    coded(page, "JPEG")
    page.get_by_role("tab", name="Load").click()
    expect(page.get_by_test_id("pictures")).to_contain_text("As JPEG alone: the decoder failed")
