"""The recordings that people name on the command line: files and folders, listened to one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from app.base.plain_file import check_plain
from app.commands.detect.outputs import Document, each_file
from app.commands.progress import Progress

if TYPE_CHECKING:
    import numpy as np
    import soundfile
    from numpy.typing import NDArray

#: Endings of recordings in folders; a file that is named is read with any ending.
SUFFIXES = frozenset({".wav", ".flac", ".ogg", ".oga", ".opus", ".mp3", ".aiff", ".aif", ".w64", ".rf64"})
FORMATS = "WAV, FLAC, Ogg, MP3"
#: A block that is read at once (samples).
BLOCK = 1 << 14
#: No sound card gives more samples a second.
MOST_RATE = 384_000


class NoRecording(Exception):
    """A file that cannot be listened to, or not to its end; the message says why."""


def open_recording(path: Path) -> soundfile.SoundFile:
    """The recording, which holds sound as far as its header says. Raises NoRecording."""
    try:
        check_plain(path)
        if not path.stat().st_size:
            raise NoRecording("holds no sound: the file is empty")
    except OSError as failure:
        raise NoRecording(f"cannot be read: {failure.strerror or failure}") from None
    import soundfile

    try:
        recording = soundfile.SoundFile(path)
    except soundfile.LibsndfileError as failure:
        reason = failure.error_string.rstrip(".")
        raise NoRecording(f"cannot be read as a recording ({FORMATS}): {reason}{_of_a_video(path)}") from None
    except OSError as failure:
        raise NoRecording(f"cannot be read: {failure.strerror or failure}") from None
    except TypeError:  # what soundfile raises for .raw: nothing in it says how it is to be read
        raise NoRecording("cannot be read as a recording: samples without a header; make it a WAV") from None
    if recording.samplerate > MOST_RATE:
        recording.close()
        raise NoRecording(f"says it has {recording.samplerate} samples a second; at most {MOST_RATE} are taken")
    if not recording.frames:
        recording.close()
        raise NoRecording("holds no sound")
    return recording


def _of_a_video(path: Path) -> str:
    from app.commands.detect.videos import is_video

    return "; of a video, write the sound by itself: ffmpeg -i VIDEO SOUND.wav" if is_video(path) else ""


def blocks_of(recording: soundfile.SoundFile, length: int, progress: Progress) -> Iterator[NDArray[np.int16]]:
    """All of it, ``length`` samples (N, C) int16 at once, fewer at the end. Raises NoRecording if it is damaged."""
    import soundfile

    done = 0
    while True:
        try:
            block: NDArray[np.int16] = recording.read(length, dtype="int16", always_2d=True)
        except soundfile.LibsndfileError as failure:
            raise NoRecording(f"cannot be read beyond {done / recording.samplerate:.1f} s: {failure}") from None
        if not len(block):
            return
        yield block
        done += len(block)
        progress(done, recording.frames)


def listen_through(
    paths: list[Path], title: str, command: str, key: str, listen: Callable[[Path, Progress], Document]
) -> list[Document]:
    """One document for each file; for an unreadable one (NoRecording), its name and the reason.

    ``key``: the list of detections in a document.
    """

    def look(path: Path, progress: Progress) -> Document:
        try:
            return listen(path, progress)
        except NoRecording as failure:
            return {"file": str(path), "error": str(failure), key: []}

    return each_file(paths, title, command, look)
