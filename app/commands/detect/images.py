"""The photographs and videos that people name on the command line: files and folders; photographs read upright."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from app.base.plain_file import read_plain
from app.commands.detect.videos import VIDEOS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Endings of photographs in folders; a file that is named is read with any ending.
SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff", ".gif", ".ppm", ".pgm"})

#: Endings of copies with drawn detections: searches of folders skip them.
DRAWN = (".faces.jpg", ".codes.jpg", ".faces.mp4", ".codes.mp4")


class NoImage(Exception):
    """A file that cannot be read as an image; the message names it and says why."""


def read_image(path: Path) -> NDArray[np.uint8]:
    """The image (H, W, 3) uint8 RGB, turned upright as its EXIF orientation says. Raises NoImage."""
    import cv2
    import numpy as np

    from app.base.image_source import BEGINNINGS, MOST_BYTES, TooLarge, decoded, kind_of

    try:
        raw = read_plain(path, MOST_BYTES)
        image = decoded(raw, cv2.IMREAD_COLOR)
    except OSError as failure:
        raise NoImage(f"{path}: cannot be read: {failure.strerror or failure}") from None
    except TooLarge as failure:
        raise NoImage(f"{path}: {failure}") from None
    if image is None:
        kind = kind_of(raw)
        if kind is not None:
            raise NoImage(f"{path}: is damaged: it begins as a {kind} file and cannot be read to its end")
        raise NoImage(f"{path}: is no image that can be read here ({', '.join(BEGINNINGS)}), nor a video ({VIDEOS})")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)
