"""What waits for one viewer: of each kind only the newest, of a list at most a thousand items, of sound a moment.

Of each kind of picture one is on the way, or on a long link some.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from app.console.live.messages import Notice
from app.console.wire import frame

#: Of a list of which each item counts (events), so many may wait; a viewer further behind gets a notice instead.
MOST_ITEMS = 1000
MOST_NOTICES = 32
#: Frames of sound, 0.3 s of them: older ones are dropped, since late sound is of no use.
MOST_SOUND = 14

_SOUND = "sound"

Frame = str | bytes


@dataclass(frozen=True, slots=True)
class OutboxStatistics:
    """``waiting`` frames and ``items`` of lists now; frames ``taken`` and ``replaced`` by newer since the start."""

    waiting: int
    items: int
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
        #: By kind, the items of which each counts.
        self._items: dict[str, deque[str]] = {}
        #: By kind: the newest picture that waits; and those of which one is on the way to the page.
        self._pictures: dict[int, tuple[bytes, str]] = {}
        #: When each was taken, by the loop's clock.
        self._under_way: dict[int, deque[float]] = {}
        #: How many may be on the way; one where nothing is said.
        self.most_under_way: dict[int, int] = {}
        #: Kinds of pictures of which one was not sent: a video must begin afresh.
        self.broken: set[int] = set()
        #: By kind of picture, what is to be called when one more may be put in without replacing any.
        self.on_room: dict[int, Callable[[], None]] = {}
        #: A picture whose info has just gone out.
        self._announced: bytes | None = None
        self._sound: deque[bytes] = deque()
        #: Kinds of which items were missed.
        self._overrun: set[str] = set()
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

    def reset(self, frame: str) -> None:
        """Drop all waiting frames but notices; ``frame``, which says so, goes out first."""
        self._newest.clear()
        self._items.clear()
        self._overrun.clear()
        self.broken.update(self._pictures)
        self._pictures.clear()
        self._sound.clear()
        self.put_urgent(frame)

    def put_each(self, kind: str, items: Iterable[str]) -> None:
        """Queue ``items`` of the list ``kind``, each encoded as JSON, after those that wait."""
        waiting = self._items.setdefault(kind, deque())
        waiting.extend(items)
        if len(waiting) > MOST_ITEMS:
            waiting.clear()
            self._overrun.add(kind)
        self._newest.setdefault(kind, "")
        self._due.set()

    def put_picture(self, kind: int, frame: bytes, info: str = "") -> None:
        """Queue the newest picture of ``kind``, and the text frame that announces it, if any; it goes out once the one
        before has been drawn, or as many as may be on the way are."""
        if kind in self._pictures:
            self._replaced += 1
            self.broken.add(kind)
        self._pictures[kind] = (frame, info)
        self._offer_picture(kind)

    def has_room(self, kind: int) -> bool:
        """Whether a picture of ``kind`` that is put in now goes out next, and replaces none."""
        return kind not in self._pictures and self._may_leave(kind)

    def picture_drawn(self, kind: int) -> float | None:
        """The page has drawn a picture of ``kind``: the next may go out. Returns when that was taken, by the loop's
        clock; None: none was."""
        under_way = self._under_way.get(kind)
        taken = under_way.popleft() if under_way else None
        self._offer_picture(kind)
        return taken

    def pictures_again(self, kind: int) -> None:
        """The page shows pictures of ``kind`` again: nothing that it got before will be said to be drawn."""
        self._under_way.pop(kind, None)
        self.broken.add(kind)
        self._offer_picture(kind)

    def drop_picture(self, kind: int) -> None:
        """The page shows no pictures of ``kind`` any more."""
        self._pictures.pop(kind, None)
        self._newest.pop(_picture(kind), None)
        self.broken.add(kind)

    def _may_leave(self, kind: int) -> bool:
        return len(self._under_way.get(kind, ())) < self.most_under_way.get(kind, 1)

    def _offer_picture(self, kind: int) -> None:
        if not self._may_leave(kind):
            return
        if kind in self._pictures:
            self._newest.setdefault(_picture(kind), b"")
            self._due.set()
        elif kind in self.on_room:
            self.on_room[kind]()

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
        if kind in self._items:
            return self._take_items(kind)
        if kind == _SOUND:
            return self._take_sound()
        for picture in tuple(self._pictures):
            if kind == _picture(picture):
                self._under_way.setdefault(picture, deque()).append(asyncio.get_running_loop().time())
                taken = self._take_picture(*self._pictures.pop(picture))
                self._offer_picture(picture)
                return taken
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
        return OutboxStatistics(waiting, sum(map(len, self._items.values())), self._taken, self._replaced)

    def _take_items(self, kind: str) -> str:
        items = self._items.pop(kind)
        if kind in self._overrun:
            self._overrun.remove(kind)
            text = f"More than {MOST_ITEMS} {kind} were missed; load the page again to see them."
            # Those that came since are part of what is loaded again.
            return frame("notice", Notice("warning", text))
        return f'{{"type":"{kind}","{kind}":[{",".join(items)}]}}'


def _picture(kind: int) -> str:
    return f"picture {kind}"
