"""Pictures in the forms that viewers bear: each made once, in a thread, of the newest picture."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np

from app.console.live.picture_budget import Form
from app.messages import EncodedImage

_REDUCED = ((8, cv2.IMREAD_REDUCED_COLOR_8), (4, cv2.IMREAD_REDUCED_COLOR_4), (2, cv2.IMREAD_REDUCED_COLOR_2))


def recoded(image: EncodedImage, form: Form) -> EncodedImage:
    """``image`` in ``form``, never larger than it is; itself, where its JPEG is damaged. For a worker thread."""
    width = min(form.width or image.width, image.width)
    # JPEG decodes to an eighth, a quarter or a half for a fraction of the time.
    flag = next((flag for part, flag in _REDUCED if image.width >= width * part), cv2.IMREAD_COLOR)
    pixels = cv2.imdecode(np.frombuffer(image.jpeg, np.uint8), flag)
    if pixels is None:
        return image
    height = max(1, round(image.height * width / image.width))
    if pixels.shape[1] != width:
        pixels = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
    height = pixels.shape[0]
    options = [] if form.quality is None else [cv2.IMWRITE_JPEG_QUALITY, form.quality]
    made, jpeg = cv2.imencode(".jpg", pixels, options)
    return replace(image, jpeg=jpeg.tobytes(), width=width, height=height) if made else image


class PictureCoder:
    """``deliver(kind, form, image, seq)`` gets each picture made; of a form that is slow to make, the newest."""

    def __init__(self, deliver: Callable[[int, Form, EncodedImage, int], None]) -> None:
        self._deliver = deliver
        self._waiting: dict[tuple[int, Form], tuple[EncodedImage, int]] = {}
        self._tasks: dict[tuple[int, Form], asyncio.Task[None]] = {}

    def make(self, kind: int, form: Form, image: EncodedImage, seq: int) -> None:
        """Make ``image``, the picture ``seq`` of its ``kind``, in ``form``, and deliver it."""
        key = (kind, form)
        self._waiting[key] = (image, seq)
        if key not in self._tasks:
            self._tasks[key] = asyncio.create_task(self._make(key), name="console picture")

    async def _make(self, key: tuple[int, Form]) -> None:
        kind, form = key
        try:
            while key in self._waiting:
                image, seq = self._waiting.pop(key)
                self._deliver(kind, form, await asyncio.to_thread(recoded, image, form), seq)
        finally:
            del self._tasks[key]

    def close(self) -> None:
        """Make nothing any more."""
        self._waiting.clear()
        for task in self._tasks.values():
            task.cancel()
