"""The photographs and videos that people name on the command line: files and folders; photographs read upright."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from app.commands.detect.videos import VIDEO_SUFFIXES, VIDEOS
from app.errors import ConfigError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Endings under which photographs are looked for in folders; a file that is named is read whatever its ending.
SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff", ".gif", ".ppm", ".pgm"})

#: How copies end on which what was found is drawn: folders are searched without them.
_DRAWN = (".faces.jpg", ".codes.jpg", ".faces.mp4", ".codes.mp4")

#: How files of each kind begin: one that begins so and cannot be read is damaged.
_BEGINNINGS: dict[str, re.Pattern[bytes]] = {
    "JPEG": re.compile(rb"\xff\xd8\xff"),
    "PNG": re.compile(rb"\x89PNG\r\n\x1a\n"),
    "WebP": re.compile(rb"RIFF....WEBP", re.DOTALL),
    "BMP": re.compile(rb"BM"),
    "TIFF": re.compile(rb"II\*\0|MM\0\*"),
    "GIF": re.compile(rb"GIF8[79]a"),
    "PNM": re.compile(rb"P[56]\s"),
}
_HEAD = 16


class NoImage(Exception):
    """A file that cannot be read as an image; the message names it and says why."""


def find_images(paths: Iterable[Path]) -> list[Path]:
    """The files among ``paths``, and all photographs and videos in the folders and below, in the order of their names.

    Copies that were drawn on are read only where they are named themselves. Raises ConfigError where there is no such
    file or folder, or neither photograph nor video in a folder.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = sorted(p for p in path.rglob("*") if _is_picture(p) and p.is_file())
            if not inside:
                endings = ", ".join(sorted(SUFFIXES | VIDEO_SUFFIXES))
                raise ConfigError(f"{path}: there is no image or video in this folder or below (looked for {endings})")
            found += inside
        elif path.exists():
            found.append(path)
        else:
            raise ConfigError(f"there is no file or folder {path}")
    return list(dict.fromkeys(found))


def _is_picture(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES | VIDEO_SUFFIXES and not path.name.endswith(_DRAWN)


def read_image(path: Path) -> NDArray[np.uint8]:
    """The image (H, W, 3) uint8 RGB, turned upright as its EXIF orientation says. Raises NoImage."""
    import cv2
    import numpy as np

    try:
        raw = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as failure:
        raise NoImage(f"{path}: cannot be read: {failure.strerror or failure}") from None
    try:
        image = cv2.imdecode(raw, cv2.IMREAD_COLOR) if raw.size else None
    except cv2.error as failure:
        raise NoImage(f"{path}: cannot be read as an image: {failure.err}") from None
    if image is None:
        head = raw[:_HEAD].tobytes()
        begun = next((kind for kind, beginning in _BEGINNINGS.items() if beginning.match(head)), None)
        if begun is not None:
            raise NoImage(f"{path}: is damaged: it begins as a {begun} file and cannot be read to its end")
        raise NoImage(f"{path}: is no image that can be read here ({', '.join(_BEGINNINGS)}), nor a video ({VIDEOS})")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)
