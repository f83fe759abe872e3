"""All viewers of the live stream. Frames are built once and shared; nobody's slowness delays anyone else.

While nobody watches, nothing is subscribed to or encoded; the lanes alone are sampled, slowly, so that whoever comes
sees what was.
"""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from app.attention.serialize import desire_class_to_json, desire_to_json, event_to_json, intention_to_json
from app.console import control, reports
from app.console.driving import Driving
from app.console.live.outbox import Outbox
from app.console.live.protocol import PROTOCOL, picture_frame
from app.console.live.sampler import Sampler
from app.console.playback import PERIOD_S, playback_json
from app.console.presence import Presence, Spectators
from app.console.recordings import RecorderReport
from app.console.taps import Tap
from app.console.wire import encode_text
from app.messages import EncodedImage, LinkStatus

if TYPE_CHECKING:
    from app.attention.timeline import TimelineEvent
    from app.replay.playback import Playback
    from app.system import System

Level = Literal["info", "warning", "error"]


@dataclass(slots=True, eq=False)
class Viewer:
    """One connection: its id ``session``, who sits there, what waits for it, whether it shows the camera."""

    session: str
    operator: str
    outbox: Outbox = field(default_factory=Outbox)
    camera: bool = True
    #: The last round trip that the page measured.
    rtt_ms: float | None = None


class Hub:
    """``open`` once the program runs, ``close`` at its end; in between viewers :meth:`join` and :meth:`leave`."""

    def __init__(self, system: System, playback: Playback | None = None) -> None:
        self._system = system
        self._playback = playback
        self._viewers: dict[str, Viewer] = {}
        self._presence = Presence(system.workspace) if playback is None else Spectators(system)
        self._sampler = Sampler(system, self)
        self._recorder = RecorderReport(system)
        self._stack = ExitStack()
        self._watching = ExitStack()
        self._sampling: asyncio.Task[None] | None = None
        self._camera: Tap[EncodedImage] | None = None
        self._pictures = 0
        self._stale: set[str] = set()
        self._new_events: list[str] = []
        self.link_status: LinkStatus | None = None
        self.driving = Driving(
            system.clock,
            system.link,
            system.graph.channels.get("operator_drive"),
            self.notify,
            recording=playback is not None,
        )

    # --- Life --------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Begin to heed the guard and to remember the lanes."""
        self._stack.callback(self._system.link.attach("status", self._on_status))
        self._stack.callback(asyncio.create_task(self._sampler.remember(), name="console lanes").cancel)
        if self._playback is not None:
            self._stack.callback(self._playback.observe(lambda _: self._mark_stale("playback")))
            self._stack.callback(self._playback.on_jump(self._on_jump))

    def close(self) -> None:
        """Stop whoever drives and forget everybody."""
        self.driving.close()
        self._presence.withdraw()
        self._stop_watching()
        self._stack.close()
        self._viewers.clear()

    @property
    def moving(self) -> bool:
        """Whether a recording's time is just being moved: what is said meanwhile is of no time."""
        return self._playback is not None and self._playback.moving

    def _on_jump(self, position: float) -> None:
        self.link_status = None
        assert self._playback is not None
        self._sampler.begin_anew(position, self._playback.attention, self._playback.spoke)
        self._new_events.clear()
        jump = encode_text({"type": "jump", "stamp": position})
        frames = {kind: frame for kind, frame in self._standing_frames().items() if kind != "load"}
        for viewer in self._viewers.values():
            viewer.outbox.begin_anew(jump)
            for kind, frame in frames.items():
                viewer.outbox.put(kind, frame)

    # --- Viewers -----------------------------------------------------------------------------------------------------

    @property
    def viewers(self) -> tuple[Viewer, ...]:
        """Everybody connected."""
        return tuple(self._viewers.values())

    def join(self, operator: str) -> Viewer:
        """A page connected: greet it and tell it all there is."""
        viewer = Viewer(secrets.token_hex(6), operator)
        first = not self._viewers
        self._viewers[viewer.session] = viewer
        self.driving.handle(control.Connected(viewer.session, operator))
        if first:
            self._start_watching()
        viewer.outbox.put_urgent(self._hello(viewer))
        for kind, frame in self._standing_frames().items():
            viewer.outbox.put(kind, frame)
        self._show_standing_picture(viewer)
        self._want_camera()
        return viewer

    def leave(self, viewer: Viewer) -> None:
        """Its connection ended: the robot stops at once if it drove."""
        self.driving.handle(control.Gone(viewer.session))
        self._viewers.pop(viewer.session, None)
        self._want_camera()
        if not self._viewers:
            self._stop_watching()

    def show_camera(self, viewer: Viewer, shown: bool) -> None:
        """The page shows the camera, or does not any more."""
        viewer.camera = shown
        if shown:
            viewer.outbox.picture_drawn()
            self._show_standing_picture(viewer)
        else:
            viewer.outbox.drop_picture()
        self._want_camera()

    def _show_standing_picture(self, viewer: Viewer) -> None:
        """Where time may stand, no picture may follow: whoever comes is given the last."""
        image = None if self._playback is None else reports.latest(self._system.graph, "camera_jpeg")
        if image is not None:
            viewer.outbox.put_picture(picture_frame(image, self._pictures))

    def notify(self, session: str, level: Level, text: str) -> None:
        """Tell one viewer something."""
        viewer = self._viewers.get(session)
        if viewer is not None:
            viewer.outbox.put_urgent(encode_text({"type": "notice", "level": level, "text": text}))

    def broadcast(self, kind: str, frame: str) -> None:
        """Give everybody the newest frame of ``kind``."""
        for viewer in self._viewers.values():
            viewer.outbox.put(kind, frame)

    def broadcast_status(self, status: dict[str, Any]) -> None:
        """Give everybody ``status``, which differs only in whose the wheel is: encoded at most twice."""
        driver = self.driving.lease.driver
        others = status | {"driver": None if driver is None else self._driver(mine=False)}
        frame = encode_text(others)
        for session, viewer in self._viewers.items():
            if session == driver:
                viewer.outbox.put("status", encode_text(status | {"driver": self._driver(mine=True)}))
            else:
                viewer.outbox.put("status", frame)

    def _driver(self, *, mine: bool) -> dict[str, Any]:
        return {"operator": self.driving.lease.driver_name, "mine": mine}

    # --- What is watched only while somebody watches -----------------------------------------------------------------

    def _start_watching(self) -> None:
        system = self._system
        self._presence.watched(True)
        keep = self._watching.callback
        keep(system.workspace.observe(lambda _: self._mark_stale("desires")))
        keep(system.translator.observe(lambda _: self._mark_stale("intention")))
        keep(system.timeline.observe(self._on_event))
        if self._recorder.channel is not None:
            keep(Tap(self._recorder.channel, "console.recorder", lambda _: self._on_recorder()).close)
            for source in (system.workspace, system.translator, system.supervisor):
                keep(source.observe(lambda _: self._on_recorder()))
        for channel, handler in self._sampler.channels().items():
            if channel in system.graph.channels:
                keep(Tap(system.graph.channel(channel), f"console.{channel}", handler).close)
                latest = reports.latest(system.graph, channel)
                if self._playback is not None and latest is not None:
                    handler(latest)  # where time may stand, no newer one may follow
        self._sampling = asyncio.create_task(self._sampler.run(), name="console sampler")
        if self._playback is not None:
            keep(asyncio.create_task(self._follow(self._playback), name="console playback").cancel)

    def _stop_watching(self) -> None:
        self._watching.close()
        if self._sampling is not None:
            self._sampling.cancel()
            self._sampling = None
        self._want_camera()
        self._presence.watched(False)

    async def _follow(self, playback: Playback) -> None:
        while True:
            if playback.state.playing:
                self._mark_stale("playback")
            await self._system.pace.sleep(PERIOD_S)

    def _has_pictures(self) -> bool:
        """Whether pictures may come: of a recording, if a module here makes them, or they were recorded."""
        graph = self._system.graph
        if self._playback is None or "camera_jpeg" in graph.producers:
            return "camera_jpeg" in graph.channels
        return "camera_jpeg" in graph.channels and "camera_jpeg" in self._playback.info.channels

    def _want_camera(self) -> None:
        wanted = any(viewer.camera for viewer in self._viewers.values())
        if wanted and self._camera is None and "camera_jpeg" in self._system.graph.channels:
            self._camera = Tap(self._system.graph.channel("camera_jpeg"), "console.camera_jpeg", self._on_picture)
        elif not wanted and self._camera is not None:
            self._camera.close()
            self._camera = None

    def _on_picture(self, image: EncodedImage) -> None:
        self._pictures += 1
        frame = picture_frame(image, self._pictures)
        for viewer in self._viewers.values():
            if viewer.camera:
                viewer.outbox.put_picture(frame)

    def _on_status(self, status: LinkStatus) -> None:
        self.link_status = status
        self.driving.heed(status)

    def _on_event(self, event: TimelineEvent) -> None:
        if not self.moving:
            self._new_events.append(encode_text(event_to_json(event)))
            self._mark_stale("events")

    def _on_recorder(self) -> None:
        if self._recorder.news():
            self._mark_stale("recorder")

    def _mark_stale(self, kind: str) -> None:
        """Several changes in one step of the loop make one frame."""
        if not self._stale:
            asyncio.get_running_loop().call_soon(self._refresh)
        self._stale.add(kind)

    def _refresh(self) -> None:
        stale, self._stale = self._stale, set()
        if self.moving:
            # All of it is told when it is there, but for where it goes.
            stale &= {"playback"}
        for kind, build in self._builders().items():
            if kind in stale:
                self.broadcast(kind, build())
        events, self._new_events = self._new_events, []
        if events:
            for viewer in self._viewers.values():
                viewer.outbox.put_events(events)

    # --- Frames ------------------------------------------------------------------------------------------------------

    def _builders(self) -> dict[str, Callable[[], str]]:
        builders = {"desires": self._desires, "intention": self._intention}
        if self._playback is not None:
            builders["playback"] = self._transport
        return builders if self._recorder.channel is None else builders | {"recorder": self._recording}

    def _standing_frames(self) -> dict[str, str]:
        """What a newcomer must know that is otherwise told on change only."""
        landmarks = reports.landmarks_json(reports.latest(self._system.graph, "landmarks"))
        return {
            # First, so that the page has the past before the present.
            "lanes_history": self._sampler.history_frame(),
            **{kind: build() for kind, build in self._builders().items()},
            "landmarks": encode_text({"type": "landmarks", "landmarks": landmarks}),
            "load": self._sampler.load_frame(),
        }

    def _hello(self, viewer: Viewer) -> str:
        system = self._system
        return encode_text(
            {
                "type": "hello",
                "protocol": PROTOCOL,
                "session": viewer.session,
                "stamp": system.clock.now(),
                "robot": reports.robot_json(system.link, replayed=self._playback is not None),
                "scale": reports.scale_json(),
                "classes": [desire_class_to_json(cls) for cls in system.classes.values()],
                "channels": {"camera": self._has_pictures()},
                "playback": None if self._playback is None else playback_json(self._playback),
            }
        )

    def _transport(self) -> str:
        assert self._playback is not None
        return encode_text({"type": "playback", **playback_json(self._playback)})

    def _desires(self) -> str:
        desires = [desire_to_json(desire) for desire in self._system.workspace.desires()]
        return encode_text({"type": "desires", "desires": desires})

    def _intention(self) -> str:
        current = self._system.translator.current
        return encode_text(
            {
                "type": "intention",
                "intention": None if current is None else intention_to_json(current, self._system.table),
            }
        )

    def _recording(self) -> str:
        return encode_text({"type": "recorder", **(self._recorder.json() or {})})
