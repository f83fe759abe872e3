"""What waits for one viewer: of each kind only the newest, of events at most a thousand, of sound a moment.

Of each kind of picture one is on the way.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from app.console.live.messages import Notice
from app.console.wire import frame

#: A viewer that falls this many events behind is told to fetch them over REST instead.
MOST_EVENTS = 1000
MOST_NOTICES = 32
#: Frames of sound, 0.3 s of them: who is further behind would hear what was, and nobody waits for that.
MOST_SOUND = 14

_EVENTS = "events"
_SOUND = "sound"

Frame = str | bytes


@dataclass(frozen=True, slots=True)
class OutboxStatistics:
    """``waiting`` frames and ``events`` now; frames ``taken`` and ``replaced`` by a newer one since the start."""

    waiting: int
    events: int
    taken: int
    replaced: int


class Outbox:
    """Frames are put in at any rate; one task takes them out at the viewer's pace with :meth:`take`.

    Kinds take turns, so that a frequent one (``status``) never starves a rare one on a slow link.
    """

    def __init__(self) -> None:
        self._urgent: deque[str] = deque(maxlen=MOST_NOTICES)
        #: By kind, in the order in which they became due; a newer frame keeps its kind's place.
        self._newest: dict[str, Frame] = {}
        self._events: deque[str] = deque()
        #: By kind: the newest picture that waits; and those of which one is on the way to the page.
        self._pictures: dict[int, tuple[bytes, str]] = {}
        self._under_way: set[int] = set()
        #: A picture whose info has just gone out.
        self._announced: bytes | None = None
        self._sound: deque[bytes] = deque()
        self._overrun = False
        self._due = asyncio.Event()
        self._taken = self._replaced = 0

    def put_urgent(self, frame: str) -> None:
        """Queue a frame that goes out before all others (a notice)."""
        self._urgent.append(frame)
        self._due.set()

    def put(self, kind: str, frame: str) -> None:
        """Queue the newest frame of ``kind``, instead of the last if that still waits."""
        if kind in self._newest:
            self._replaced += 1
        self._newest[kind] = frame
        self._due.set()

    def begin_anew(self, frame: str) -> None:
        """Drop everything of before that waits, notices excepted, and let ``frame``, which says so, go out first."""
        self._newest.clear()
        self._events.clear()
        self._overrun = False
        self._pictures.clear()
        self._sound.clear()
        self.put_urgent(frame)

    def put_events(self, events: Iterable[str]) -> None:
        """Queue timeline events, each encoded as JSON."""
        self._events.extend(events)
        if len(self._events) > MOST_EVENTS:
            self._events.clear()
            self._overrun = True
        self._newest.setdefault(_EVENTS, "")
        self._due.set()

    def put_picture(self, kind: int, frame: bytes, info: str = "") -> None:
        """Queue the newest picture of ``kind``, and the text frame that announces it, if any; it goes out once the one
        before has been drawn."""
        if kind in self._pictures:
            self._replaced += 1
        self._pictures[kind] = (frame, info)
        self._offer_picture(kind)

    def picture_drawn(self, kind: int) -> None:
        """The page has drawn the last picture of ``kind``, or shows such pictures anew: the next may go out."""
        self._under_way.discard(kind)
        self._offer_picture(kind)

    def drop_picture(self, kind: int) -> None:
        """The page shows no pictures of ``kind`` any more."""
        self._pictures.pop(kind, None)
        self._newest.pop(_picture(kind), None)

    def _offer_picture(self, kind: int) -> None:
        if kind not in self._under_way and kind in self._pictures:
            self._newest.setdefault(_picture(kind), b"")
            self._due.set()

    def put_sound(self, frame: bytes) -> None:
        """Queue a frame of sound after those that wait; of too many, the oldest is dropped."""
        if len(self._sound) == MOST_SOUND:
            self._sound.popleft()
            self._replaced += 1
        self._sound.append(frame)
        self._newest.setdefault(_SOUND, b"")
        self._due.set()

    def drop_sound(self) -> None:
        """The page does not listen any more."""
        self._sound.clear()
        self._newest.pop(_SOUND, None)

    async def take(self) -> Frame:
        """Wait for the next frame to send."""
        while not self._urgent and not self._newest and self._announced is None:
            self._due.clear()
            await self._due.wait()
        self._taken += 1
        if self._announced is not None:
            announced, self._announced = self._announced, None
            return announced
        if self._urgent:
            return self._urgent.popleft()
        kind = next(iter(self._newest))
        frame = self._newest.pop(kind)
        if kind == _EVENTS:
            return self._take_events()
        if kind == _SOUND:
            return self._take_sound()
        for picture in tuple(self._pictures):
            if kind == _picture(picture):
                self._under_way.add(picture)
                return self._take_picture(*self._pictures.pop(picture))
        return frame

    def _take_picture(self, frame: bytes, info: str) -> Frame:
        if not info:
            return frame
        self._announced = frame
        return info

    def _take_sound(self) -> bytes:
        frame = self._sound.popleft()
        if self._sound:
            # The rest waits for its turn again, behind whatever else is due.
            self._newest[_SOUND] = b""
        return frame

    def statistics(self) -> OutboxStatistics:
        """The counters now."""
        waiting = len(self._urgent) + len(self._newest) + (self._announced is not None)
        return OutboxStatistics(waiting, len(self._events), self._taken, self._replaced)

    def _take_events(self) -> str:
        if self._overrun:
            self._overrun = False
            text = f"More than {MOST_EVENTS} events were missed; reload them: GET /api/v1/timeline."
            # Events that came since are part of what is reloaded.
            self._events.clear()
            return frame("notice", Notice("warning", text))
        events = '{"type":"events","events":[' + ",".join(self._events) + "]}"
        self._events.clear()
        return events


def _picture(kind: int) -> str:
    return f"picture {kind}"
