"""One viewer's pictures as VP9: the newest is made when it may go out, so that none is left out of what follows it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from app.console.live.outbox import Outbox
from app.console.live.picture_budget import Form
from app.console.live.protocol import VP9_DELTA, VP9_KEY, picture_header
from app.console.live.video_encoder import NoEncoder, VideoEncoder, VideoPicture
from app.messages import EncodedImage


class VideoStream:
    """Puts pictures of ``kind`` in ``outbox``; ``failed`` is called with the reason where no video can be made."""

    def __init__(self, outbox: Outbox, kind: int, failed: Callable[[str], None]) -> None:
        self._outbox = outbox
        self._kind = kind
        self._failed = failed
        self._encoder: VideoEncoder | None = None
        self._newest: tuple[EncodedImage, int, Form] | None = None
        self._task: asyncio.Task[None] | None = None
        self._open = True
        outbox.on_room[kind] = self._go

    def offer(self, image: EncodedImage, seq: int, form: Form) -> None:
        """Send ``image``, the picture ``seq`` of its kind, in ``form``, unless a newer comes before it may go out."""
        self._newest = image, seq, form
        self._go()

    def close(self) -> None:
        """Send nothing any more."""
        self._open = False
        self._newest = None
        self._outbox.on_room.pop(self._kind, None)

    def _go(self) -> None:
        if self._task is None and self._newest is not None and self._outbox.has_room(self._kind):
            self._task = asyncio.create_task(self._work(), name="console video")

    async def _work(self) -> None:
        try:
            while self._newest is not None and self._outbox.has_room(self._kind):
                (image, seq, form), self._newest = self._newest, None
                afresh = self._kind in self._outbox.broken
                self._outbox.broken.discard(self._kind)
                picture = await asyncio.to_thread(self._encoded, image.jpeg, form, afresh=afresh)
                if picture is None or not self._open:
                    # The encoder counts on what has not been sent.
                    self._outbox.broken.add(self._kind)
                    continue
                coding = VP9_KEY if picture.key else VP9_DELTA
                size = (picture.width, picture.height)
                header = picture_header(self._kind, seq, image.stamp, size, coding=coding)
                self._outbox.put_picture(self._kind, header + picture.data)
        except NoEncoder as reason:
            self.close()
            self._failed(str(reason))
        finally:
            self._task = None

    def _encoded(self, jpeg: bytes, form: Form, *, afresh: bool) -> VideoPicture | None:
        if self._encoder is None:
            self._encoder = VideoEncoder()
        return self._encoder.encode(jpeg, form, afresh=afresh)
