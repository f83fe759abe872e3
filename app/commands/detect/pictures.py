"""Photographs and videos looked through one after the other: what faces and codes have in common."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from app.base.errors import ConfigError
from app.commands.arguments import file_named
from app.commands.detect.images import DRAWN, SUFFIXES, NoImage, read_image
from app.commands.detect.outputs import each_file, find_files, make_folder, unused
from app.commands.detect.videos import VIDEO_SUFFIXES, Copy, NoVideo, VideoFile, add_pace, is_video
from app.commands.output import add_json
from app.commands.progress import Progress

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Picture = NDArray[np.uint8]

#: Detections in a picture, as JSON shows them.
Found = dict[str, Any]


class Seeker(Protocol):
    """A detector for pictures. ``key``: the name in JSON of its list; ``drawn``: ending of the names of drawn
    copies."""

    key: str
    drawn: str

    def seek(self, picture: Picture) -> list[Found]:
        """Detections in a photograph (H, W, 3) uint8 RGB."""
        ...

    def begin(self) -> None:
        """The next frames are of another video."""
        ...

    def follow(self, picture: Picture, time_s: float) -> list[Found]:
        """Detections in the next frame of a video."""
        ...

    def summary(self) -> tuple[str, list[Found]]:
        """The video's list in JSON of tracks, and its name."""
        ...

    def draw(self, picture: Picture, found: list[Found]) -> None:
        """Draw frames around the detections in ``picture``, which may be written to."""
        ...


def add_pictures(parser: argparse.ArgumentParser, json_text: str, draw_text: str) -> None:
    """Declare the arguments that all have."""
    parser.add_argument(
        "files",
        nargs="+",
        type=file_named,
        metavar="FILE",
        help="an image, a video, or a folder of them (no copies of --draw)",
    )
    add_json(parser, json_text)
    add_pace(parser)
    parser.add_argument("--draw", type=Path, metavar="FOLDER", help=draw_text)


def look_through(args: argparse.Namespace, seeker: Seeker, title: str, command: str) -> list[Found]:
    """One document for each file; unreadable files are reported on standard error too. Raises ConfigError."""
    paths = find_files(args.files, SUFFIXES | VIDEO_SUFFIXES, "image or video", DRAWN)
    if args.draw is not None:
        make_folder(args.draw, "--draw")
    look = _PictureSearch(args, seeker)

    def document(path: Path, progress: Progress) -> Found:
        return look.through(path, progress) if is_video(path) else look.at(path)

    return each_file(paths, title, command, document)


def counted(files: list[Found]) -> str:
    """ "2 images and 1 video", of the documents of those that could be read, in whole or in part."""
    videos = sum("duration_s" in file for file in files)
    images = len(files) - videos
    words = [
        f"{number} {word}{'s' * (number != 1)}" for number, word in ((images, "image"), (videos, "video")) if number
    ]
    return " and ".join(words) or "0 images"


def for_json(documents: list[Found]) -> list[Found]:
    """The documents without values that only serve counting."""
    return [{name: value for name, value in document.items() if name != "found"} for document in documents]


class _PictureSearch:
    def __init__(self, args: argparse.Namespace, seeker: Seeker) -> None:
        self._args, self._seeker = args, seeker
        self._names: set[str] = set()

    def at(self, path: Path) -> Found:
        key = self._seeker.key
        try:
            color = read_image(path)
        except NoImage as failure:
            return {"file": str(path), "error": str(failure).removeprefix(f"{path}: "), key: [], "found": 0}
        found = self._seeker.seek(color)
        if self._args.draw is not None:
            picture = color.copy()
            self._seeker.draw(picture, found)
            _write_jpeg(self._copy_of(path, ".jpg"), picture)
        return {
            "file": str(path),
            "width": color.shape[1],
            "height": color.shape[0],
            key: found,
            "found": len(found),
        }

    def through(self, path: Path, progress: Progress) -> Found:
        try:
            video = VideoFile(path)
        except NoVideo as failure:
            return {"file": str(path), "error": str(failure), "frames": [], "found": 0}
        frames: list[Found] = []
        copy = None if self._args.draw is None else Copy(self._copy_of(path, ".mp4"), self._pace(video))
        self._seeker.begin()
        looked_at, trouble = 0, ""
        try:
            for time_s, color in video.frames(self._args.every, self._args.fps, progress):
                found = self._seeker.follow(color, time_s)
                looked_at += 1
                if self._args.json:
                    frames.append({"time_s": round(time_s, 3), self._seeker.key: found})
                if copy is not None:
                    picture = color.copy()
                    self._seeker.draw(picture, found)
                    copy.add(picture, time_s)
        except NoVideo as failure:
            trouble = str(failure)
        finally:
            video.close()
            if copy is not None:
                copy.close()
        name, followed = self._seeker.summary()
        document: Found = {"file": str(path)}
        if trouble:
            document["error"] = trouble
        document |= {"width": video.width, "height": video.height, "duration_s": round(video.end_s, 3)}
        document |= {"frames_looked_at": looked_at, name: followed, "found": len(followed)}
        return document | ({"frames": frames} if self._args.json else {})

    def _pace(self, video: VideoFile) -> float:
        """About how many frames a second are looked at."""
        if self._args.fps is not None:
            return min(video.rate_hz, float(self._args.fps))
        return video.rate_hz / (self._args.every or 1)

    def _copy_of(self, path: Path, suffix: str) -> Path:
        folder: Path = self._args.draw
        return folder / f"{unused(path.stem, self._names)}{self._seeker.drawn}{suffix}"


def _write_jpeg(file: Path, picture: Picture) -> None:
    import cv2

    _, jpeg = cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), (cv2.IMWRITE_JPEG_QUALITY, 92))
    try:
        file.write_bytes(jpeg.tobytes())
    except OSError as failure:
        raise ConfigError(f"--draw: {file} cannot be written: {failure.strerror or failure}") from None
