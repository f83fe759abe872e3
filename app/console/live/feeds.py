"""Pictures and sound to the pages: each is taken only while some page wants it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from app.console import reports
from app.console.drive.telepresence_desire import Presence, Spectators
from app.console.live.grid_feed import GridFeed
from app.console.live.picture_budget import Form
from app.console.live.picture_coder import PictureCoder
from app.console.live.protocol import CAMERA, COSTMAP, MAP, PANORAMA, picture_frame, sound_frame
from app.console.live.video_encoder import can_encode
from app.console.live.video_stream import VideoStream
from app.console.live.viewer import Viewer
from app.console.taps import Tap
from app.messages import Audio, EncodedImage

if TYPE_CHECKING:
    from app.logs.replay.playback import Playback
    from app.runtime.clock import Clock
    from app.runtime.graph import Graph

_log = logging.getLogger(__name__)

#: The channel that each kind of picture comes from.
PICTURES = {CAMERA: "camera_jpeg", PANORAMA: "panorama_jpeg"}
SOUND_CHANNEL = "robot_audio"


@dataclass(frozen=True, slots=True)
class GridKind:
    """A kind of picture that is made here, of the grids on ``channel``, at most once in ``period_s``; ``info`` is the
    message that announces it."""

    channel: str
    info: str
    period_s: float


GRIDS = {
    MAP: GridKind("map", "map_info", 0.5),
    COSTMAP: GridKind("local_costmap", "costmap_info", 0.2),
}
#: So many pages get video at once, each encoded for itself: up to 10 % of a core each at 640 x 480, 15 times a second.
MOST_VIDEOS = 4
#: So many frames of sound may come while the loop does something else.
BURST = 16


def comes(graph: Graph, playback: Playback | None, channel: str) -> bool:
    """Whether anything may come on ``channel``: a module here makes it, or it is fed; of a recording, if it has it."""
    if channel in graph.producers:
        return True
    if playback is None:
        return channel in graph.channels and graph.specs[channel].external
    return channel in graph.channels and channel in playback.info.channels


class Feeds:
    """Subscribes to what the ``viewers`` ask for and sends it to them; ``listening`` attends while any listens."""

    def __init__(
        self,
        graph: Graph,
        pace: Clock,
        viewers: Callable[[], Iterable[Viewer]],
        listening: Presence | Spectators,
    ) -> None:
        self._graph = graph
        self._viewers = viewers
        self._listening = listening
        self._taps: dict[str, Tap[Any]] = {}
        self._grids = {
            kind: GridFeed(
                graph.channel(grid.channel),
                kind,
                info=grid.info,
                period_s=grid.period_s,
                pace=pace,
                deliver=partial(self._deliver, kind),
            )
            for kind, grid in GRIDS.items()
            if grid.channel in graph.channels
        }
        #: Of each kind of picture, and of sound, how many came so far.
        self._counts = dict.fromkeys((*PICTURES, SOUND_CHANNEL), 0)
        #: Of each kind of picture, how wide it comes (px).
        self._widths: dict[int, int] = {}
        self._coder = PictureCoder(self._give)
        #: By session and kind of picture.
        self._videos: dict[tuple[str, int], VideoStream] = {}
        self.encodes = can_encode()

    def update(self) -> None:
        """The viewers, or what they ask for, have changed."""
        for kind, channel in PICTURES.items():
            self._take(channel, self._is_shown(kind), partial(self._on_picture, kind), capacity=1)
        for kind, feed in self._grids.items():
            feed.take(self._is_shown(kind))
        listened = any(viewer.listens for viewer in self._viewers())
        if listened != (SOUND_CHANNEL in self._taps):
            self._take(SOUND_CHANNEL, listened, self._on_sound, capacity=BURST)
            self._listening.attend(listened)
        viewers = {viewer.session: viewer for viewer in self._viewers()}
        for session, kind in tuple(self._videos):
            if session not in viewers or kind not in viewers[session].shows:
                self._videos.pop((session, kind)).close()

    def close(self) -> None:
        """Take nothing any more, and desire nothing."""
        self._coder.close()
        for video in self._videos.values():
            video.close()
        self._videos.clear()
        for tap in self._taps.values():
            tap.close()
        self._taps.clear()
        for feed in self._grids.values():
            feed.take(False)
        self._listening.withdraw()

    def show_standing(self, viewer: Viewer, kind: int, *, of_camera: bool) -> None:
        """Send a viewer the last picture, if it stays; one ``of_camera``, too."""
        if kind in GRIDS:
            feed = self._grids.get(kind)
            if feed is not None and feed.standing is not None:
                viewer.outbox.put_picture(kind, *feed.standing)
        elif of_camera and (image := reports.latest(self._graph, PICTURES[kind])) is not None:
            viewer.outbox.put_picture(kind, picture_frame(kind, image, self._counts[kind]))

    def clear(self) -> None:
        """Time has jumped: no grid and no picture of before is to be shown."""
        for video in self._videos.values():
            video.close()
        self._videos.clear()
        for feed in self._grids.values():
            feed.clear()

    def _is_shown(self, kind: int) -> bool:
        return any(kind in viewer.shows for viewer in self._viewers())

    def _take(self, channel: str, wanted: bool, handler: Callable[[Any], None], *, capacity: int) -> None:
        if wanted and channel not in self._taps and channel in self._graph.channels:
            source = self._graph.channel(channel)
            self._taps[channel] = Tap(source, f"console.{channel}", handler, capacity=capacity)
        elif not wanted and channel in self._taps:
            self._taps.pop(channel).close()

    def _on_picture(self, kind: int, image: EncodedImage) -> None:
        self._counts[kind] += 1
        seq, self._widths[kind] = self._counts[kind], image.width
        forms = set()
        for viewer in self._viewers():
            if kind not in viewer.shows:
                continue
            form = self._form(viewer, kind)
            if form.bits is not None:
                viewer.given[kind] = seq
                self._video(viewer, kind).offer(image, seq, form)
                continue
            forms.add(form)
            if (viewer.session, kind) in self._videos:
                self._videos.pop((viewer.session, kind)).close()
        for form in forms:
            if form == Form():
                self._give(kind, form, image, seq)
            else:
                self._coder.make(kind, form, image, seq)

    def _form(self, viewer: Viewer, kind: int) -> Form:
        """The form of a viewer's pictures of ``kind``: a JPEG without an encoder, or beside too many videos."""
        may = self.encodes and ((viewer.session, kind) in self._videos or len(self._videos) < MOST_VIDEOS)
        return viewer.form(kind, self._widths[kind], video=may)

    def _video(self, viewer: Viewer, kind: int) -> VideoStream:
        key = (viewer.session, kind)
        if key not in self._videos:
            self._videos[key] = VideoStream(viewer.outbox, kind, self._on_no_encoder)
        return self._videos[key]

    def _on_no_encoder(self, reason: str) -> None:
        _log.warning("Pictures go to all pages as JPEG: %s.", reason)
        self.encodes = False

    def _give(self, kind: int, form: Form, image: EncodedImage, seq: int) -> None:
        """Give a picture to the viewers who bear this form, unless they have a newer one."""
        frame = picture_frame(kind, image, seq)
        for viewer in self._viewers():
            bears = kind in viewer.shows and self._form(viewer, kind) == form
            if bears and viewer.given.get(kind, 0) < seq:
                viewer.given[kind] = seq
                viewer.outbox.put_picture(kind, frame)

    def _deliver(self, kind: int, frame: bytes, info: str = "") -> None:
        for viewer in self._viewers():
            if kind in viewer.shows:
                viewer.outbox.put_picture(kind, frame, info)

    def _on_sound(self, audio: Audio) -> None:
        self._counts[SOUND_CHANNEL] += 1
        frame = sound_frame(audio, self._counts[SOUND_CHANNEL])
        for viewer in self._viewers():
            if viewer.listens:
                viewer.outbox.put_sound(frame)
