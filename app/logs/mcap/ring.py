"""The last minutes on disk: short complete files, the oldest deleted as new ones come; saved by joining them raw."""

from __future__ import annotations

import shutil
import threading
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.logs.log import LogError
from app.logs.manifest import Manifest
from app.logs.mcap.open_file import FileTopic, McapFile, OpenFile, create
from app.logs.mcap.ring_folder import SEGMENT, STATE, make_home, save
from app.logs.output_file import Progress, unwatched
from app.logs.ros.encoder import Encoder

SEGMENT_S = 10.0

#: Returns the key of the state that a message replaces, by channel; None for a message that is no state.
StateKey = Callable[[str, Any], str | None]


@dataclass(frozen=True, slots=True)
class Segment:
    """A closed segment: ``state`` has the state at its begin, ``path`` the messages; ``begin``, ``end`` in s."""

    state: Path
    path: Path
    begin: float
    end: float
    bytes: int
    messages: int


class Ring:
    """A sink that keeps the last ``keep_s`` seconds (and up to one segment more)."""

    name = ""

    def __init__(
        self,
        folder: Path,
        new_encoder: Callable[[], Encoder],
        manifest: Manifest,
        at: float,
        keep_s: float,
        *,
        state_key: StateKey = lambda channel, message: None,
        segment_s: float = SEGMENT_S,
        open_file: OpenFile = create,
    ) -> None:
        """Create a new folder below ``folder``. Raises OSError."""
        self.folder = folder
        self.keep_s = keep_s
        self._new_encoder = new_encoder
        self._topics: dict[str, FileTopic] = {}
        self._manifest = manifest
        self._state_key = state_key
        self._segment_s = segment_s
        self._open_file = open_file
        self._home, self._lock_file = make_home(folder, at)
        #: Begin of the oldest segment (robot's clock, s).
        self.begin = at
        self._begin = self._end = at
        self._state_path: Path
        self._file: McapFile
        self._standing: dict[str, tuple[str, Any]] = {}
        self._number = 0
        self._segments: deque[Segment] = deque()
        # Counted along: other threads read them while segments come and go.
        self._closed_bytes = self._closed_messages = 0
        self._discarded = False
        # The loop's threads hold segments while they copy them and look through them when they are done; the writer's
        # thread adds and deletes.
        self._held: dict[Path, int] = {}
        self._guard = threading.Lock()
        try:
            self._begin_segment(at)
        except OSError:
            self._lock_file.close()
            raise

    @property
    def bytes(self) -> int:
        """Bytes on disk."""
        return self._closed_bytes + self._file.bytes

    @property
    def messages(self) -> int:
        """Messages kept."""
        return self._closed_messages + self._file.messages

    def write(self, at: float, channel: str, message: Any) -> None:
        """Take a message that arrived ``at``. Raises UnrecordableMessage, OSError."""
        if at - self._begin >= self._segment_s:
            self._rotate(at)
        self._file.write(at, channel, message)
        self._end = at
        if (key := self._state_key(channel, message)) is not None:
            self._standing[key] = (channel, message)

    def flush(self) -> None:
        """End the chunk, and delete expired segments. Raises OSError."""
        self._file.flush()
        self._forget(self._end - self.keep_s)

    def close(self, discard: bool) -> None:
        """Close it; ``discard``: delete the segments. Otherwise they stay, and are found as leftovers."""
        try:
            self._file.close()
        finally:
            if discard:
                self._delete_all()
            self._lock_file.close()

    def abandon(self) -> None:
        """After a failed write: segments on disk stay, and are found as leftovers."""
        with suppress(OSError):
            self._file.abandon()
        self._lock_file.close()

    def hold(self, at: float, seconds: float | None) -> HeldSegments:
        """Close the segment in progress and keep those of the last ``seconds`` (None: all) from being deleted.

        Called in the writer's thread; the hold is used and released in any other. Raises OSError.
        """
        if self._file.messages:
            self._rotate(at)
        chosen = [s for s in self._segments if seconds is None or s.end >= at - seconds]
        with self._guard:
            for segment in chosen:
                self._held[segment.path] = self._held.get(segment.path, 0) + 1
        return HeldSegments(chosen, self._release)

    def _release(self, segments: Iterable[Segment]) -> None:
        with self._guard:
            for segment in segments:
                self._held[segment.path] -= 1
                if not self._held[segment.path]:
                    del self._held[segment.path]
                    if segment not in self._segments:
                        _delete(segment)
            if self._discarded and not self._held:
                shutil.rmtree(self._home, ignore_errors=True)

    def _begin_segment(self, at: float) -> None:
        self._number += 1
        self._begin = self._end = at
        self._state_path = self._home / f"{self._number:06}{STATE}"
        # Each segment has an encoder of its own: an encoder leaves out data that its file holds already.
        state = self._create(self._state_path, self._manifest, at)
        try:
            for channel, message in self._standing.values():
                state.write(at, channel, message)
            state.close()
        except OSError:
            state.abandon()
            raise
        self._file = self._create(self._home / f"{self._number:06}{SEGMENT}", Manifest(), at)

    def _create(self, path: Path, manifest: Manifest, at: float) -> McapFile:
        return McapFile(
            path, self._new_encoder(), manifest=manifest, at=at, topics=self._topics, open_file=self._open_file
        )

    def _rotate(self, at: float) -> None:
        file = self._file
        file.close()
        closed = Segment(
            self._state_path, file.path, begin=self._begin, end=self._end, bytes=file.bytes, messages=file.messages
        )
        with self._guard:
            self._segments.append(closed)
        self._begin_segment(at)
        self._closed_bytes += file.bytes
        self._closed_messages += file.messages

    def _forget(self, before: float) -> None:
        while self._segments and self._segments[0].end < before:
            with self._guard:
                old = self._segments.popleft()
                if old.path not in self._held:
                    _delete(old)
            self._closed_bytes -= old.bytes
            self._closed_messages -= old.messages
            self.begin = self._segments[0].begin if self._segments else self._begin

    def _delete_all(self) -> None:
        with self._guard:
            held = set(self._held)
            for segment in self._segments:
                if segment.path not in held:
                    _delete(segment)
            self._segments.clear()
            self._discarded = True
            if not held:
                shutil.rmtree(self._home, ignore_errors=True)


class HeldSegments:
    """Segments that stay until they are copied; release it by leaving the ``with`` block."""

    def __init__(self, segments: list[Segment], release: Callable[[Iterable[Segment]], None]) -> None:
        self.segments = segments
        self._release = release

    def __enter__(self) -> HeldSegments:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """Hold them no longer; once."""
        self._release(self.segments)

    @property
    def bytes(self) -> int:
        """About how many bytes a copy takes."""
        return sum(segment.bytes for segment in self.segments)

    @property
    def duration_s(self) -> float:
        """Seconds from the first of them to the last."""
        return self.segments[-1].end - self.segments[0].begin if self.segments else 0.0

    def save(self, targets: Iterable[Path], progress: Progress = unwatched) -> Path:
        """Join them into the first of ``targets`` that does not exist yet, and return it. Raises LogError, OSError."""
        if not self.segments:
            raise LogError("the ring holds nothing yet")
        return save(self.segments[0].state, [s.path for s in self.segments], targets, progress)


def _delete(segment: Segment) -> None:
    segment.path.unlink(missing_ok=True)
    segment.state.unlink(missing_ok=True)
