"""All viewers of the live stream. Frames are built once and shared; a slow viewer delays no other.

Without viewers nothing is subscribed to or encoded; the lanes alone are sampled, so that the next viewer sees their
past.
"""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Callable, Collection
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING

from app.attention.desires import SCALE
from app.attention.reports import desire_class_report
from app.console import reports
from app.console.access.identity import LOCAL, Identity, role_name
from app.console.drive import drive_lease
from app.console.drive.command_age import CommandAge
from app.console.drive.drive_controller import Driving, teleop_channel
from app.console.drive.gamepad import GamepadDriver
from app.console.drive.goals import withdraw_all
from app.console.drive.look_here import LookHere
from app.console.drive.telepresence_desire import LISTEN, WATCH, Presence, Spectators
from app.console.link_shaper import Link
from app.console.live import messages
from app.console.live.feeds import GRIDS, PICTURES, SOUND_CHANNEL, Feeds, comes
from app.console.live.lane_history import LaneHistory
from app.console.live.page_channels import PageChannels
from app.console.live.panel_feed import PanelFeed
from app.console.live.protocol import CAMERA, COSTMAP, MAP, PANORAMA, PROTOCOL
from app.console.live.sampler import Sampler
from app.console.live.speech import OperatorSpeech
from app.console.live.viewer import Viewer
from app.console.live.viewer_status import ViewerStatus
from app.console.playback import PERIOD_S, playback_report
from app.console.recordings import RecorderWatch
from app.console.taps import Tap
from app.console.wire import frame
from app.messages import Lanes, LinkStatus, Scale

if TYPE_CHECKING:
    from app.logs.replay.playback import Playback
    from app.program.system import System

REVIVED = "The body answers again. Press again to drive, and give goals again; the map begins at nothing."
SILENT = "There is nothing to listen to: no module here makes sound for people."


class Hub:
    """``open`` once the program runs, ``close`` at its end; in between viewers :meth:`join` and :meth:`leave`."""

    def __init__(
        self,
        system: System,
        playback: Playback | None = None,
        panel_channels: Collection[str] = (),
        link: Link | None = None,
    ) -> None:
        """``panel_channels``: channels whose messages panels of packages want; those that there are are sent. ``link``
        is shaped for tests, which the pages are to know."""
        self._system = system
        self._playback = playback
        self._link = link or Link()
        self._viewers: dict[str, Viewer] = {}
        self._presence = self._attention(WATCH)
        self._feeds = Feeds(system.graph, system.pace, self._viewers.values, self._attention(LISTEN))
        self._channels = PageChannels(system.graph, system.pace, self)
        self.lanes = LaneHistory(system.classes)
        self._sampler = Sampler(system, self)
        self._recorder = RecorderWatch(system)
        channels = [system.graph.channels[name] for name in panel_channels if name in system.graph.channels]
        self._panels = PanelFeed(channels, system.pace, self.broadcast)
        self._stack = ExitStack()
        self._watching = ExitStack()
        self._sampling: asyncio.Task[None] | None = None
        self._stale: set[str] = set()
        self.link_status: LinkStatus | None = None
        self.look_here = LookHere(system.graph, system.workspace, PICTURES[CAMERA])
        self.driving = Driving(
            system.clock,
            system.link,
            teleop_channel(system.graph),
            self.notify,
            partial(withdraw_all, system.workspace),
            recording=playback is not None,
            look_here=self.look_here,
        )
        self.speech = OperatorSpeech(
            system.clock,
            system.link,
            system.graph.channels.get("operator_voice"),
            self.notify,
            recording=playback is not None,
        )
        self.status = ViewerStatus(self.driving, self.speech, system.clock.now)

    def _attention(self, cls: str) -> Presence | Spectators:
        """What makes come what class ``cls`` gives."""
        if self._playback is not None:
            return Spectators(self._system, cls)
        served = any(strategy.cls == cls for strategy in self._system.table.strategies)
        return Presence(self._system.workspace, cls, served=served)

    # --- Life --------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Subscribe to the guard's reports and sample the lanes."""
        self._stack.callback(self._system.link.attach("status", self._on_status))
        self._stack.callback(self._system.body_restarter.observe(self._on_body))
        self._stack.callback(GamepadDriver(self.driving, self._system.clock.now).attach(self._system.link))
        self._stack.callback(self._link.observe(lambda _: self._mark_stale("link")))
        self._remember_lanes()
        if self._playback is not None:
            self._stack.callback(self._playback.observe(lambda _: self._mark_stale("playback")))
            self._stack.callback(self._playback.on_jump(self._on_jump))

    def _remember_lanes(self) -> None:
        for channel in self._system.graph.channels.values():
            if channel.message_type is Lanes:
                if self._playback is None:
                    self._stack.callback(channel.observe(self._on_lanes))
                else:
                    # A recording gives what is wanted alone.
                    self._stack.callback(Tap(channel, "console.history", self._on_lanes).close)
                if channel.latest is not None:
                    self._on_lanes(channel.latest)

    def _on_lanes(self, lanes: Lanes) -> None:
        if not self.moving:
            self.lanes.add(lanes)

    def close(self) -> None:
        """Stop the driver, and drop all viewers."""
        self.driving.close()
        self._presence.withdraw()
        self._feeds.close()
        self._stop_watching()
        self._stack.close()
        self._viewers.clear()

    @property
    def moving(self) -> bool:
        """Whether a recording's time is being moved: messages of that moment are of no time."""
        return self._playback is not None and self._playback.moving

    def _on_jump(self, position: float) -> None:
        self.link_status = None
        self._feeds.clear()
        self._channels.clear()
        self._sampler.clear()
        self._panels.clear()
        assert self._playback is not None
        self.lanes.clear()
        for lanes in self._playback.lanes:
            self.lanes.add(lanes)
        jump = frame("jump", messages.Jump(position))
        frames = {**self._past_and_present(), **self._channels.states(), **self._panels.frames()}
        for viewer in self._viewers.values():
            viewer.outbox.reset(jump)
            for kind, text in frames.items():
                viewer.outbox.put(kind, text)

    def _on_body(self, problem: str) -> None:
        """The body does not answer, for this reason; or ("") does again, with an odometry of its own."""
        self.driving.body(lost=problem != "")
        for session in self._viewers:
            self.notify(session, "error" if problem else "info", problem or REVIVED)
        if not problem:
            self.look_here.clear()
            self._feeds.clear()
            self._channels.clear()
            for kind, text in self._channels.standing().items():
                self.broadcast(kind, text)

    # --- Viewers -----------------------------------------------------------------------------------------------------

    @property
    def viewers(self) -> tuple[Viewer, ...]:
        """Everybody connected."""
        return tuple(self._viewers.values())

    def join(self, operator: str, identity: Identity = LOCAL) -> Viewer:
        """A page of this login connected: send it `hello` and the current state."""
        console = self._system.config.program.console
        age = CommandAge(console.command_validity_s, console.full_speed_within_s)
        viewer = Viewer(secrets.token_hex(6), operator, age, identity)
        first = not self._viewers
        self._viewers[viewer.session] = viewer
        self.driving.handle(drive_lease.Connected(viewer.session, operator))
        if first:
            self._start_watching()
        viewer.outbox.put_urgent(self._hello(viewer))
        for kind, text in self._standing_frames().items():
            viewer.outbox.put(kind, text)
        self._show_standing_picture(viewer, CAMERA)
        self._feeds.update()
        return viewer

    def leave(self, viewer: Viewer) -> None:
        """A connection ended: if it drove, the robot stops at once; if it spoke, its talk ends."""
        self.driving.handle(drive_lease.Disconnected(viewer.session))
        self.speech.gone(viewer.session)
        self._viewers.pop(viewer.session, None)
        self._feeds.update()
        if not self._viewers:
            self._stop_watching()

    def show(self, viewer: Viewer, kind: int, shown: bool | None) -> None:
        """The page shows pictures of ``kind``, or does not any more; None: as it was."""
        if shown is None:
            return
        if shown:
            viewer.shows.add(kind)
            viewer.outbox.pictures_again(kind)
            self._show_standing_picture(viewer, kind)
        else:
            viewer.shows.discard(kind)
            viewer.outbox.drop_picture(kind)
        self._feeds.update()

    def listen(self, viewer: Viewer, on: bool) -> None:
        """Begin or end to send the microphones' sound to a page."""
        if on and not self._comes(SOUND_CHANNEL):
            self.notify(viewer.session, "warning", SILENT)
            return
        viewer.listens = on
        if not on:
            viewer.outbox.drop_sound()
        self._feeds.update()

    def _show_standing_picture(self, viewer: Viewer, kind: int) -> None:
        """A map may not change, and in paused time no picture follows: a new viewer gets the last one."""
        self._feeds.show_standing(viewer, kind, of_camera=self._playback is not None)

    def is_shown(self, kind: int) -> bool:
        """Whether any page shows pictures of ``kind``."""
        return any(kind in viewer.shows for viewer in self._viewers.values())

    def notify(self, session: str, level: messages.Level, text: str) -> None:
        """Send a notice to one viewer."""
        viewer = self._viewers.get(session)
        if viewer is not None:
            viewer.outbox.put_urgent(frame("notice", messages.Notice(level, text)))

    def broadcast(self, kind: str, text: str) -> None:
        """Give everybody the newest frame of ``kind``."""
        for viewer in self._viewers.values():
            viewer.outbox.put(kind, text)

    def broadcast_each(self, kind: str, item: str) -> None:
        """Give everybody ``item`` in a list of ``kind``, after those before it."""
        for viewer in self._viewers.values():
            viewer.outbox.put_each(kind, (item,))

    def broadcast_status(self, status: messages.Status) -> None:
        """Send ``status`` to every viewer, completed for each."""
        for viewer, text in self.status.frames(status, self._viewers.values()):
            viewer.outbox.put("status", text)

    # --- What is subscribed to only while there are viewers ----------------------------------------------------------

    def _start_watching(self) -> None:
        system = self._system
        self._presence.attend(True)
        keep = self._watching.callback
        if self._playback is None:
            keep(self.look_here.open())
        if self._recorder.channel is not None:
            keep(Tap(self._recorder.channel, "console.recorder", lambda _: self._on_recorder()).close)
            for source in (system.workspace, system.translator, system.supervisor):
                keep(source.observe(lambda _: self._on_recorder()))
        keep(self._channels.open())
        for channel, handler in self._sampler.channels().items():
            if channel in system.graph.channels:
                keep(Tap(system.graph.channel(channel), f"console.{channel}", handler).close)
                latest = reports.latest(system.graph, channel)
                if self._playback is not None and latest is not None:
                    handler(latest)  # where time may stand, no newer one may follow
        keep(self._panels.open())
        self._sampling = asyncio.create_task(self._sampler.run(), name="console sampler")
        if self._playback is not None:
            keep(asyncio.create_task(self._follow(self._playback), name="console playback").cancel)

    def _stop_watching(self) -> None:
        self._watching.close()
        if self._sampling is not None:
            self._sampling.cancel()
            self._sampling = None
        self._presence.attend(False)

    async def _follow(self, playback: Playback) -> None:
        while True:
            if playback.state.playing:
                self._mark_stale("playback")
            await self._system.pace.sleep(PERIOD_S)

    def _comes(self, channel: str) -> bool:
        return comes(self._system.graph, self._playback, channel)

    def _on_status(self, status: LinkStatus) -> None:
        self.link_status = status
        self.driving.on_guard_status(status)

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
            # The rest is sent once the seek has ended; only its position changes before.
            stale &= {"playback"}
        for kind, build in self._builders().items():
            if kind in stale:
                self.broadcast(kind, build())

    # --- Frames ------------------------------------------------------------------------------------------------------

    def _builders(self) -> dict[str, Callable[[], str]]:
        builders: dict[str, Callable[[], str]] = {"link": lambda: frame("link", self._link.report())}
        if self._playback is not None:
            builders["playback"] = self._transport
        return builders if self._recorder.channel is None else builders | {"recorder": self._recording}

    def _standing_frames(self) -> dict[str, str]:
        """What a new viewer gets that is otherwise sent on change only."""
        return {
            **self._past_and_present(),
            **self._channels.standing(),
            **self._panels.frames(),
        }

    def _past_and_present(self) -> dict[str, str]:
        # The history first, so that the page has the past before the present.
        return {"lanes_history": self.lanes.frame(), **{kind: build() for kind, build in self._builders().items()}}

    def _hello(self, viewer: Viewer) -> str:
        system = self._system
        return frame(
            "hello",
            messages.Hello(
                protocol=PROTOCOL,
                session=viewer.session,
                stamp=system.clock.now(),
                robot=reports.robot_facts(system, replayed=self._playback is not None),
                scale=Scale(SCALE, SCALE),
                classes=tuple(desire_class_report(each, system.table) for each in system.classes.values()),
                channels=messages.Channels(
                    camera=self._comes(PICTURES[CAMERA]),
                    panorama=self._comes(PICTURES[PANORAMA]),
                    map=self._comes(GRIDS[MAP].channel),
                    costmap=self._comes(GRIDS[COSTMAP].channel),
                    scan=self._comes("scan"),
                    point_cloud=self._comes("point_cloud"),
                ),
                role=role_name(viewer.identity),
                drive=self.driving.drivable,
                head=self.driving.drivable and reports.turns_head(system),
                audio=messages.AudioFacts(listen=self._comes(SOUND_CHANNEL), speak=not self.speech.in_vain),
                vp9=self._feeds.encodes,
                playback=None if self._playback is None else playback_report(self._playback),
            ),
        )

    def _transport(self) -> str:
        assert self._playback is not None
        return frame("playback", playback_report(self._playback))

    def _recording(self) -> str:
        return frame("recorder", self._recorder.report())
