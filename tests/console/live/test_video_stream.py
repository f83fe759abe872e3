"""One viewer's pictures as VP9: all that is made is sent, in order, and nothing is made that does not go out."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from unittest.mock import patch

import av
import pytest

from app.base.geometry import Pose3
from app.console.live.outbox import Outbox
from app.console.live.picture_budget import Form
from app.console.live.protocol import CAMERA, PICTURE_HEADER, VP9_DELTA, VP9_KEY
from app.console.live.video_encoder import NoEncoder, VideoEncoder, VideoPicture
from app.console.live.video_stream import VideoStream
from app.messages import EncodedImage
from tests.console.live.test_video_encoder import jpeg_of, scene
from tests.patience import PATIENCE_S

FORM = Form(160, bits=0.2)


def image(step: int) -> EncodedImage:
    """The picture ``step``, stamped so."""
    return EncodedImage(float(step), "camera", jpeg_of(scene(step, 160, 120)), 160, 120, Pose3.identity())


class Page:
    """The other end of an outbox: takes pictures, decodes them and says that they are drawn."""

    def __init__(self, outbox: Outbox) -> None:
        self.outbox = outbox
        self.decoder = av.VideoCodecContext.create("vp9", "r")
        self.decoder.thread_count = 1

    async def picture(self) -> tuple[int, int, float]:
        """Coding, seq and stamp of the next one."""
        async with asyncio.timeout(PATIENCE_S):
            frame = await self.outbox.take()
        assert isinstance(frame, bytes)
        kind, coding, seq, stamp, width, height = PICTURE_HEADER.unpack_from(frame)
        assert (kind, width, height) == (CAMERA, 160, 120)
        assert len(self.decoder.decode(av.Packet(frame[PICTURE_HEADER.size :]))) == 1
        return coding, seq, stamp

    def drew(self) -> None:
        """It has drawn the picture."""
        self.outbox.picture_drawn(CAMERA)


@pytest.fixture
def made() -> Iterator[list[VideoPicture | None]]:
    """What was encoded."""
    pictures: list[VideoPicture | None] = []
    encode = VideoEncoder.encode

    def noted(self: VideoEncoder, jpeg: bytes, form: Form, *, afresh: bool = False) -> VideoPicture | None:
        pictures.append(encode(self, jpeg, form, afresh=afresh))
        return pictures[-1]

    with patch.object(VideoEncoder, "encode", noted):
        yield pictures


def stream(outbox: Outbox) -> VideoStream:
    """Into ``outbox``; that it cannot be made fails the test."""

    def failed(reason: str) -> None:
        raise AssertionError(reason)

    return VideoStream(outbox, CAMERA, failed)


async def test_only_what_goes_out_is_made_and_it_is_the_newest(made: list[VideoPicture | None]) -> None:
    outbox = Outbox()
    page, video = Page(outbox), stream(outbox)
    video.offer(image(0), 10, FORM)
    assert await page.picture() == (VP9_KEY, 10, 0.0)
    for step in range(1, 6):
        video.offer(image(step), 10 + step, FORM)
    assert len(made) == 1  # the first is on the way: nothing is due
    page.drew()
    assert await page.picture() == (VP9_DELTA, 15, 5.0)
    page.drew()
    video.offer(image(6), 16, FORM)
    assert await page.picture() == (VP9_DELTA, 16, 6.0)
    assert len(made) == 3


async def test_more_than_one_may_be_on_a_long_link() -> None:
    outbox = Outbox()
    outbox.most_under_way[CAMERA] = 3
    page, video = Page(outbox), stream(outbox)
    for step in range(3):
        video.offer(image(step), step, FORM)
        assert (await page.picture())[1] == step
    video.offer(image(3), 3, FORM)
    assert not outbox.has_room(CAMERA)
    page.drew()
    assert await page.picture() == (VP9_DELTA, 3, 3.0)


async def at_rest(video: VideoStream) -> None:
    """Wait until what could be made is made."""
    assert video._task is not None
    await asyncio.wait_for(video._task, PATIENCE_S)


@pytest.mark.parametrize("lost", ["shown again", "hidden", "replaced", "jumped"])
async def test_it_begins_afresh_after_a_picture_that_did_not_come(lost: str) -> None:
    outbox = Outbox()
    page, video = Page(outbox), stream(outbox)
    video.offer(image(0), 0, FORM)
    await page.picture()
    page.drew()
    video.offer(image(1), 1, FORM)
    await at_rest(video)
    assert not outbox.has_room(CAMERA)
    if lost == "shown again":
        await page.picture()
        outbox.pictures_again(CAMERA)
        page.decoder = av.VideoCodecContext.create("vp9", "r")
    elif lost == "hidden":
        outbox.drop_picture(CAMERA)
    elif lost == "replaced":
        outbox.put_picture(CAMERA, b"a JPEG")
        assert await outbox.take() == b"a JPEG"
        page.drew()
    else:
        outbox.reset("jump")
        assert await outbox.take() == "jump"
    video.offer(image(2), 2, FORM)
    assert await page.picture() == (VP9_KEY, 2, 2.0)


async def test_a_damaged_picture_is_passed_over_for_the_next(made: list[VideoPicture | None]) -> None:
    outbox = Outbox()
    page, video = Page(outbox), stream(outbox)
    video.offer(EncodedImage(0.0, "camera", b"no JPEG", 160, 120, Pose3.identity()), 0, FORM)
    await at_rest(video)
    assert made == [None]
    video.offer(image(1), 1, FORM)
    assert await page.picture() == (VP9_KEY, 1, 1.0)


async def test_a_closed_stream_sends_nothing() -> None:
    outbox = Outbox()
    video = stream(outbox)
    video.offer(image(0), 0, FORM)
    video.close()
    video.offer(image(1), 1, FORM)
    await at_rest(video)
    assert outbox.statistics().waiting == 0
    assert CAMERA not in outbox.on_room


async def test_why_there_is_no_video_is_said_once() -> None:
    reasons: list[str] = []
    outbox = Outbox()
    video = VideoStream(outbox, CAMERA, reasons.append)
    with patch.object(VideoEncoder, "__init__", side_effect=NoEncoder("this PyAV has no libvpx-vp9")):
        video.offer(image(0), 0, FORM)
        await at_rest(video)
    assert reasons == ["this PyAV has no libvpx-vp9"]
    assert outbox.statistics().waiting == 0
