"""The 3D view as the console sees it: its viewers, what they are sent, and how many points each can draw."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from app.base.geometry import Pose2
from app.base.joint_buffer import JointBuffer
from app.base.motion_prediction import Velocity
from app.base.pose_buffer import PoseBuffer
from app.console import reports
from app.console.playback import rate
from app.console.taps import Tap
from app.console.view.budget import measured, silent
from app.console.view.foreseen import Motions, motions
from app.console.view.instant import drawn_instant
from app.console.view.picture_watch import PictureWatch
from app.console.view.scene_state import World
from app.console.view.scene_thread import BodyModel, Painter
from app.console.view.viewer_rate import Pace
from app.console.view.viewer_session import ViewerSession
from app.console.view.viewpoints import Viewpoint
from app.messages import (
    ExternalForces,
    JointState,
    Landmarks,
    LaserScan,
    LinkStatus,
    NavigationReport,
    OccupancyGrid,
    Odometry,
    PlacedPercepts,
    PointCloud,
    TeleopCommand,
    Twist,
)
from app.runtime.half_imports import forget_half_imports

if TYPE_CHECKING:
    from app.console.view.picking import Pick
    from app.console.view.viewer_camera import CameraState
    from app.logs.replay.playback import Playback
    from app.program.system import System

log = logging.getLogger("hbba.view")

PERIOD_S = 0.04
#: Scans and percepts are taken every so many periods: 8 Hz.
SLOW_BEATS = 3
#: Joints that come no more seldom than this (s) are drawn as the last ones said, until the next.
JOINTS_LATE_S = 0.5
STOP_WITHIN_S = 0.8
COSTMAP = "local_costmap"
#: A local costmap older than this (s) does not show the present obstacles: its source has stopped.
COSTMAP_FRESH_S = 2.0
#: Forces that are older (s) are felt no longer: what estimates them has stopped.
FORCES_FRESH_S = 0.5
#: Of these the newest message is drawn; they are subscribed to while there are viewers.
STANDING = (
    "placed_percepts",
    "external_forces",
    "navigation_report",
    "path",
    "localization",
    "zones",
    "map",
    "link_status",
)
#: The goal is drawn in these states of navigation.
GOAL_STATES = ("planning", "following", "recovering", "waiting", "unreachable")


class View:
    """``open`` with the program, ``close`` at its end. viser starts with the first viewer, or at once if ``early``."""

    def __init__(
        self,
        system: System,
        costmap_asked: Callable[[], bool] = lambda: False,
        *,
        early: bool,
        playback: Playback | None = None,
    ) -> None:
        """``costmap_asked()``: whether any page shows the local costmap."""
        self._system = system
        self._costmap_asked = costmap_asked
        self._playback = playback
        self._early = early
        self._sessions: dict[str, ViewerSession] = {}
        #: Local ports of our relay's connections to viser, with whose they are. Read in viser's thread.
        self._ports: dict[int, str] = {}
        self._painter: Painter | None = None
        self._port: asyncio.Future[int] | None = None
        self._ended: asyncio.Future[None] | None = None
        self._watching = ExitStack()
        self._feeding: asyncio.Task[None] | None = None
        self._end_watch: Callable[[], None] = lambda: None
        self._poses = PoseBuffer(span_s=2.0)
        self._joints = JointBuffer(tolerance_s=JOINTS_LATE_S)
        self._odometry: Odometry | None = None
        self._scan: LaserScan | None = None
        #: The last one, in the pose of its instant.
        self._placed: tuple[LaserScan, Pose2] | None = None
        self._cloud: PointCloud | None = None
        self._landmarks: Landmarks | None = None
        self._world: World | None = None
        self._costmap: Tap[OccupancyGrid] | None = None
        self._pages_show_costmap = False
        self._pictures = PictureWatch(system.graph)

    # --- Life --------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """The program runs."""
        if self._playback is not None:
            self._end_watch = self._playback.on_jump(lambda _: self._on_jump())
        else:
            self._end_watch = self._system.body_restarter.observe(lambda problem: None if problem else self._on_jump())
        if self._early:
            self._start()

    async def close(self) -> None:
        self._end_watch()
        self._stop_feeding()
        if self._painter is not None:
            self._painter.stop()
            assert self._ended is not None
            await asyncio.wait({self._ended}, timeout=STOP_WITHIN_S)

    async def port(self) -> int | None:
        """viser's port on 127.0.0.1, once it listens; None if it failed to."""
        port = self._start()
        assert self._ended is not None
        either: set[asyncio.Future[Any]] = {port, self._ended}
        await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
        return port.result() if port.done() else None

    def _start(self) -> asyncio.Future[int]:
        if self._port is None:
            loop = asyncio.get_running_loop()
            self._port = port = loop.create_future()

            def ready(number: int) -> None:
                loop.call_soon_threadsafe(port.set_result, number)

            model = self._system.link.description.model_path
            footprint = self._system.link.description.footprint
            self._painter = Painter(
                BodyModel(model, self._pictures.eye, footprint, self._system.link.description.limits),
                self._ports.get,
                self.pace,
                ready=ready,
            )
            self._ended = self._painter.start()
            self._ended.add_done_callback(self._painter_ended)
        return self._port

    def _painter_ended(self, ended: asyncio.Future[None]) -> None:
        if not ended.cancelled() and (failure := ended.exception()) is not None:
            log.error(
                "the 3D view failed: %s: %s; a reload of the page starts it again", type(failure).__name__, failure
            )
            self._painter = self._port = None
            forget_half_imports()

    # --- Viewers -----------------------------------------------------------------------------------------------------

    @property
    def sessions(self) -> tuple[ViewerSession, ...]:
        return tuple(self._sessions.values())

    def pace(self) -> dict[str, Pace]:
        """Pace and layers by viewer. Safe in any thread."""
        return {
            session.viewer: Pace(
                int(session.budget.points),
                session.budget.period_s,
                self._pages_show_costmap if session.costmap is None else session.costmap,
                session.choice,
                lag_s=session.budget.lag_s,
            )
            for session in self.sessions
        }

    def enter(self, viewer: str) -> ViewerSession:
        """A connection of ``viewer`` opens; there may be several (scene and pulse)."""
        if not self._sessions:
            self._start_feeding()
        session = self._sessions.setdefault(viewer, ViewerSession(viewer))
        session.connections += 1
        return session

    def leave(self, session: ViewerSession) -> None:
        session.connections -= 1
        if session.connections == 0:
            del self._sessions[session.viewer]
            if not self._sessions:
                self._stop_feeding()

    def admit(self, port: int, viewer: str) -> None:
        """Our relay will connect to viser from the local ``port`` on behalf of ``viewer``."""
        self._ports[port] = viewer

    def dismiss(self, port: int) -> None:
        self._ports.pop(port, None)

    def set_layers(self, session: ViewerSession, costmap: bool | None) -> None:
        """Show the viewer the local costmap, or not; None: as the pages do."""
        session.costmap = costmap

    def choose(self, session: ViewerSession, viewpoint: Viewpoint, number: int, hold: float = 1.0) -> None:
        """Let the viewer look from ``viewpoint``, or glide there for the share ``hold`` of the time. Each choice has
        another ``number``; one said again is none, or goes on to another ``hold``."""
        if (number, hold) != (session.choice.number, session.choice.hold):
            session.choice = replace(session.choice, viewpoint=viewpoint, number=number, hold=hold)
            self._draw_soon()

    def limit(self, session: ViewerSession, soft_limit: float | None) -> None:
        """Show the viewer the fan (rad) in which the head follows its view; None: it follows none."""
        session.choice = replace(session.choice, soft_limit=soft_limit)

    def grab(self, session: ViewerSession) -> None:
        """The viewer's user takes the camera in hand: it glides no further."""
        session.choice = replace(session.choice, grabs=session.choice.grabs + 1)

    async def pick(self, viewer: str, u: float, v: float) -> Pick | None:
        """What the viewer is shown at a point of its picture: shares of its width from the left and height from the
        top. None: there is no such viewer."""
        if viewer not in self._sessions or self._painter is None:
            return None
        assert self._ended is not None
        answer = self._painter.pick(viewer, u, v)
        either: set[asyncio.Future[Any]] = {answer, self._ended}
        await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
        return answer.result() if answer.done() else None

    def _draw_soon(self) -> None:
        if self._painter is not None and self._world is not None:
            self._painter.show(self._world)

    def answered(self, session: ViewerSession, round_trip_s: float | None, frames_s: float = 0.0) -> None:
        """The viewer answered a pulse two frames on, which took it ``frames_s``, or not in time (None)."""
        if round_trip_s is None:
            session.budget = silent(session.budget)
        else:
            session.budget = measured(session.budget, round_trip_s + session.drain_s, frames_s)

    # --- Subscriptions, only while there are viewers -----------------------------------------------------------------

    def _start_feeding(self) -> None:
        graph = self._system.graph
        handlers: dict[str, Callable[[Any], None]] = {
            "odometry": self._on_odometry,
            "joints": self._on_joints,
            "scan": self._on_scan,
            "point_cloud": self._on_cloud,
            "landmarks": self._on_landmarks,
        }
        for name, handler in handlers.items():
            if name in graph.channels:
                channel = graph.channel(name)
                self._watching.callback(Tap(channel, f"console.view.{name}", handler).close)
                # Of a paused recording, nothing else may come.
                if channel.latest is not None and (name == "landmarks" or self._playback is not None):
                    handler(channel.latest)
        for name in (name for name in STANDING if name in graph.channels):
            self._watching.callback(Tap(graph.channel(name), f"console.view.{name}", lambda _: None).close)
        self._feeding = asyncio.create_task(self._feed(), name="console view")

    def _stop_feeding(self) -> None:
        self._watching.close()
        self._pictures.close()
        if self._costmap is not None:
            self._costmap.close()
            self._costmap = None
        if self._feeding is not None:
            self._feeding.cancel()
            self._feeding = None

    def _on_jump(self) -> None:
        """A recording is at another place, or the body was started again: nothing is where it was."""
        self._poses, self._joints = PoseBuffer(span_s=2.0), JointBuffer(tolerance_s=JOINTS_LATE_S)
        self._odometry = self._scan = self._placed = self._cloud = None
        self._landmarks = reports.latest(self._system.graph, "landmarks")
        self._pictures.forget()

    def _on_odometry(self, message: Odometry) -> None:
        self._poses.add(message.stamp, message.X_OB)
        self._odometry = message

    def _on_joints(self, message: JointState) -> None:
        self._joints.add(message.stamp, dict(zip(message.names, message.positions, strict=True)))

    def _on_scan(self, message: LaserScan) -> None:
        self._scan = message

    def _on_cloud(self, message: PointCloud) -> None:
        self._cloud = message

    def _on_landmarks(self, message: Landmarks) -> None:
        self._landmarks = message

    def _look_for_costmap(self) -> None:
        """Subscribe to the local costmap as long as any view shows it: its source may rest otherwise."""
        self._pages_show_costmap = self._costmap_asked()
        wanted = any(pace.costmap for pace in self.pace().values())
        if wanted and self._costmap is None and COSTMAP in self._system.graph.channels:
            self._costmap = Tap(self._system.graph.channel(COSTMAP), f"console.view.{COSTMAP}", lambda _: None)
        elif not wanted and self._costmap is not None:
            self._costmap.close()
            self._costmap = None

    def _look_at_cameras(self, cameras: Mapping[str, CameraState]) -> None:
        for session in self.sessions:
            camera = cameras.get(session.viewer)
            if camera != session.camera:
                session.camera = camera
                session.changed.set()

    def _perceived(self) -> PlacedPercepts | None:
        """What is perceived, as of now: what it was then fades."""
        percepts: PlacedPercepts | None = reports.latest(self._system.graph, "placed_percepts")
        return None if percepts is None else replace(percepts, stamp=self._system.clock.now())

    def _felt(self) -> ExternalForces | None:
        forces: ExternalForces | None = reports.latest(self._system.graph, "external_forces")
        clock = self._system.clock
        return forces if forces is not None and clock.now() - forces.stamp <= FORCES_FRESH_S * rate(clock) else None

    def _applied(self) -> Twist | None:
        """What the wheels are given now; None where the guard says nothing."""
        status: LinkStatus | None = reports.latest(self._system.graph, "link_status")
        clock = self._system.clock
        return None if status is None or clock.now() - status.stamp > FORCES_FRESH_S * rate(clock) else status.applied

    def _motions(self, applied: Twist | None) -> Motions | None:
        """How the base goes on; None where that is not known, and in a recording, where nothing can be commanded."""
        if self._odometry is None or applied is None or self._playback is not None:
            return None
        driver: TeleopCommand | None = reports.latest(self._system.graph, "teleop_command")
        given = Velocity(applied.linear_mps, applied.angular_radps, applied.lateral_mps)
        limits = self._system.link.description.limits
        return motions(self._odometry, given, driver, limits, now=self._system.clock.now())

    def _fresh_costmap(self) -> OccupancyGrid | None:
        grid: OccupancyGrid | None = reports.latest(self._system.graph, COSTMAP)
        clock = self._system.clock
        return grid if grid is not None and clock.now() - grid.stamp <= COSTMAP_FRESH_S * rate(clock) else None

    def _body_now(self) -> tuple[Pose2 | None, float | None, Mapping[str, float] | None]:
        """The robot's pose, the instant (s) that it is of, and the joints then."""
        if self._odometry is None:
            return None, None, None
        instant = drawn_instant(self._odometry.stamp, self._joints)
        return self._poses.at(instant), instant, self._joints.at(instant)

    async def _feed(self) -> None:
        beat = 0
        perceived: PlacedPercepts | None = None
        forces: ExternalForces | None = None
        while True:
            beat += 1
            if beat % SLOW_BEATS == 0:
                perceived, forces = self._perceived(), self._felt()
                # A moment after it came, when odometry has reached its stamp.
                if self._scan is not None and (pose := self._poses.at(self._scan.stamp)) is not None:
                    self._placed = (self._scan, pose)
            robot, stamp, joints = self._body_now()
            self._look_for_costmap()
            self._pictures.watch(any(session.choice.viewpoint == "first_person" for session in self.sessions))
            if self._painter is not None:
                latest = partial(reports.latest, self._system.graph)
                report: NavigationReport | None = latest("navigation_report")
                applied = self._applied()
                self._world = world = World(
                    robot,
                    joints,
                    scan=self._placed,
                    cloud=self._cloud,
                    landmarks=self._landmarks,
                    perceived=perceived,
                    forces=forces,
                    localization=latest("localization"),
                    map=latest("map"),
                    zones=latest("zones"),
                    path=latest("path") if report is not None and len(report.path) else None,
                    goal=_goal(report),
                    costmap=self._fresh_costmap(),
                    picture=self._pictures.placed(self._poses),
                    applied=applied,
                    motions=self._motions(applied),
                    stamp=stamp,
                    now=self._system.clock.now(),
                )
                self._painter.show(world)
                self._look_at_cameras(self._painter.cameras())
                for viewer, drawn in self._painter.stamps().items():
                    if viewer in self._sessions:
                        self._sessions[viewer].stamp = drawn
            await self._system.pace.sleep(PERIOD_S)


def _goal(report: NavigationReport | None) -> tuple[float, float, float | None] | None:
    """Where a behavior is going, or cannot go: x, y (m) and heading (rad, None: any) on the map."""
    if report is None or report.goal is None or report.state not in GOAL_STATES:
        return None
    return report.goal.x, report.goal.y, report.goal.theta if math.isfinite(report.goal.theta) else None
