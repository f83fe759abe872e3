"""Images as PNG: colour, and depth as 16 bit millimetres."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.image_source import TooLarge, decoded
from app.log_tools.export.target import Format, Target, Write, stamp_name
from app.logs.log import LogError, LoggedChannel
from app.messages import EncodedImage, Image

#: Half the time of the usual level, files a few percent larger.
_LEVEL = [cv2.IMWRITE_PNG_COMPRESSION, 1]


class Png(Format):
    """``<channel>/<stamp>.png`` and ``<channel>-depth/<stamp>.png``."""

    def accepts(self, message_type: type[Any]) -> bool:
        return message_type in (Image, EncodedImage)

    @contextmanager
    def writer(self, channel: LoggedChannel, target: Target) -> Iterator[Write]:
        colors = target.subfolder(channel.name)
        depths: Target | None = None
        count, deep = 0, 0

        def write(message: Any) -> None:
            nonlocal depths, count, deep
            name = f"{stamp_name(message.stamp)}.png"
            colors.put(name, _encoded(cv2.cvtColor(rgb_of(message), cv2.COLOR_RGB2BGR)))
            count += 1
            if isinstance(message, Image) and message.depth is not None:
                depths = depths or target.subfolder(f"{channel.name}-depth")
                depths.put(name, _encoded(message.depth))
                deep += 1

        yield write
        target.written.append(f"{colors.folder}: {count} images")
        if depths is not None:
            target.written.append(f"{depths.folder}: {deep} depth images, 16 bit, millimetres, 0 = no measurement")


def rgb_of(message: Image | EncodedImage) -> NDArray[np.uint8]:
    """Colours (H, W, 3) uint8 RGB of an image. Raises LogError for a JPEG that is damaged."""
    if isinstance(message, Image):
        return message.color
    try:
        color = decoded(message.jpeg, cv2.IMREAD_COLOR_RGB)
    except TooLarge as failure:
        raise LogError(f"the image of {message.frame} at {message.stamp:.6f} s {failure}") from None
    if color is None:
        raise LogError(f"the image of {message.frame} at {message.stamp:.6f} s is no JPEG")
    return color.astype(np.uint8, copy=False)


def _encoded(image: NDArray[Any]) -> bytes:
    done, data = cv2.imencode(".png", image, _LEVEL)
    if not done:
        raise LogError(f"an image of {image.shape[1]} x {image.shape[0]} px cannot be written as PNG")
    return data.tobytes()
