"""SLAM2D: mapping and localization with a laser (thesis 4.2, 4.3: SLAM 2D).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ SLAM2D    in   scans         LaserScan, 40 Hz / φ, in X_BL; the newest alone              │
    │           in   odometry      Odometry, 100 Hz, X_OB in odom; never filtered              │
    │           in   landmark_poses LandmarkPose, X_MO by a landmark; may be absent            │
    │           out  localization  Localization, one for each scan taken: X_MO, X_MB           │
    │           out  map           OccupancyGrid in map, when it changed, every 1 s at most    │
    │           out  zones         Zones in map, when they change                              │
    │           out  keyframes     Keyframes in map, with each localization                    │
    │           out  confidence    Confidence, by how many of the laser's rays return          │
    │           is the MapServer: save, load, begin, place, search, mark                       │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Each scan is matched in the module's thread (slam/mapper.py), with odometry since the last one as prior: at any φ, and
after a pause of the scans. Loop closure, drawing and relocalization run in a second thread, so that these delay no
pose::

    X_MO = X_MB @ X_OB(stamp)^-1

On a loaded map that does not grow, the pose is tracked (``tracking``). After a time of misfitting scans the robot is
``lost`` and relocalizes (``searching``), which accepts a pose only after motion (slam/relocalization.py), or where a
landmark suggested it and scans bear it out. On a growing map, odometry bridges misfitting scans; the map does not grow
while the robot is ``lost``: it may have been carried, and is placed where a landmark says it is. While scans fit, the
pose is theirs alone.
``rays`` (every n-th ray is used) and ``mapping`` (false: the map does not grow) are parameters of the strategies.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from pydantic import Field

from app.attention.desires import DesireClass
from app.base import compiled
from app.base.geometry import Pose2
from app.maps.library import MapLibrary
from app.maps.map_service import MapService
from app.messages import (
    Confidence,
    Keyframes,
    LandmarkPose,
    LaserScan,
    Localization,
    Message,
    OccupancyGrid,
    Odometry,
    Zone,
    Zones,
    read_only,
)
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.slam.initial_map import LastPublished, RestartState, choose_initial_map
from app.modules.perception.slam.keyframe_view import KeyframePublisher
from app.modules.perception.slam.localization_quality import empty_grid
from app.modules.perception.slam.map_server import SlamMapServer
from app.modules.perception.slam.optimizer import OptimizerProcess
from app.modules.perception.slam.relocalizer import Relocalizer
from app.modules.perception.slam.types import MOST_SUGGESTED
from app.modules.perception.working_conditions import ConfidenceReporter, returns_confidence
from app.runtime.module import Module, ModuleContext, Settings
from app.runtime.ports import Output

if TYPE_CHECKING:  # kernels are compiled or loaded on import, in the module's thread
    from app.modules.perception.slam.map_rendering import ExtraView
    from app.modules.perception.slam.map_session import MapSession, ScanResult, StoredMap
    from app.modules.perception.slam.types import Match

M = TypeVar("M", bound=Message)

#: Number of edges from which the correction runs in another process: it holds the interpreter's lock for about 0.05 ms
#: per edge.
_LEAST_EDGES = 400
#: Time (s) between two places of a lost robot on a growing map by landmarks: scans must have time to fit.
_PLACE_AGAIN_S = 5.0
#: Time (s) a scan waits for odometry of its stamp.
_PATIENCE_S = 0.2


class SLAM2DSettings(Settings):
    map: str = Field("", description="map in use at the start; none: an empty one")
    extend: bool = Field(False, description="whether that map grows")
    cell_m: float = Field(0.05, ge=0.01, le=1, description="side of a cell of the map")
    side_m: float = Field(50.0, ge=1, le=500, description="initial side of an empty map")
    publish_s: float = Field(1.0, ge=0.1, description="least period of published maps")
    lost_after_s: float = Field(1.0, gt=0, description="time of misfitting scans after which the robot is lost")
    search_after_s: float = Field(2.0, gt=0, description="the same for relocalization, on a map that does not grow")
    sure_after_s: float = Field(1.0, gt=0, description="time of fitting scans after which relocalization ends")


MAP_AND_LOCALIZE = DesireClass(
    name="SLAM",
    title="Map and know where it is",
    description="Map the place with the laser, close loops, and report where the robot is on the map (m).",
)


class SLAM2D(Module):
    title = "SLAM 2D"
    desire_classes = (MAP_AND_LOCALIZE,)
    auxiliary_inputs = frozenset({"landmark_poses"})
    Settings = SLAM2DSettings
    settings: SLAM2DSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._poses = PoseAt(self.clock, self.log, "scans are of no use", "the stamps of scans")
        self._odometry: Odometry | None = None
        self._mapping = True
        self._rays = 1
        self._session: MapSession | None = None
        #: Of the map in use: its name ("" while it has none) and its zones.
        self.map_name = ""
        self.known_zones: tuple[Zone, ...] = ()
        self._published: Localization | None = None
        self._relocalizer = Relocalizer(
            lost_after_s=self.settings.lost_after_s,
            search_after_s=self.settings.search_after_s,
            sure_after_s=self.settings.sure_after_s,
        )
        #: Stamp at which a lost robot was placed by a landmark last.
        self._placed_at = -math.inf
        #: For the second thread: loops to close, views to draw, the drawn version.
        self._followed: ScanResult | None = None
        self._extra_views: list[ExtraView] = []
        self._drawn = -1
        self._draw_due = False
        self._version = 0
        self._wake = asyncio.Event()
        #: The timer and the saving of a map draw in turn.
        self._drawing = asyncio.Lock()
        self._optimizer = OptimizerProcess(_LEAST_EDGES)
        self._working: asyncio.Task[None] | None = None
        self._detach: Callable[[], None] = lambda: None
        self.scans = self.input("scans", LaserScan)
        self.odometry = self.input("odometry", Odometry, capacity=200, always_open=True)
        self.localization = self.output("localization", Localization)
        self.map = self.output("map", OccupancyGrid)
        self.zones = self.output("zones", Zones)
        self.landmark_poses = self.input("landmark_poses", LandmarkPose, capacity=MOST_SUGGESTED, wants="never")
        self.keyframes = self.output("keyframes", Keyframes)
        self.confidence = self.output("confidence", Confidence)
        self._works = ConfidenceReporter(self.confidence)
        self._keyframes = KeyframePublisher(self.keyframes)
        self.on(self.landmark_poses, self._take_landmark_pose)
        self.on(self.scans, self._see)
        self.on(self.odometry, self._take_odometry)
        self.every(self.settings.publish_s, self._let_draw)

    async def start(self) -> None:
        """Load the kernels, and the initial map: the one in use before a restart, or as configured."""
        await self.compute(self._load_kernels)
        map_server = SlamMapServer(self, self.service(MapLibrary))
        control = self.service(MapService)
        same = await self._take_first()
        await control.resume(self.map_name, same=same)
        self._working = asyncio.create_task(self._metered(self._work()), name=f"{self.name}, behind")
        self._working.add_done_callback(self._ended)
        self._detach = control.attach(map_server)

    async def stop(self) -> None:
        """Detach from the map control and end the second thread's work."""
        self._detach()
        if self._working is not None:
            self._working.cancel()
            await asyncio.wait({self._working})
        await asyncio.to_thread(self._optimizer.close)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._mapping = bool(parameters.get("mapping", True))
        self._rays = max(1, int(parameters.get("rays", 1)))

    # --- Localization -----------------------------------------------------------------------------------------

    async def _take_odometry(self, odometry: Odometry) -> None:
        self._odometry = odometry
        self._poses.add(odometry)

    async def _see(self, scan: LaserScan) -> None:
        if self._works.due(scan.stamp):
            value = returns_confidence(scan.ranges, scan.range_min)
            self._works.say(scan.stamp, value, "few of the laser's rays return")
        X_OB = await self._poses.logged_at(scan.stamp, _PATIENCE_S)
        session = self._session
        if X_OB is None or session is None:
            return
        if self._relocalizer.running:
            self._relocalizer.offer(scan, X_OB)
            self._wake.set()
        odometry = self._odometry
        twist = (0.0, 0.0, 0.0)
        if odometry is not None:
            twist = (odometry.linear_mps, odometry.angular_radps, odometry.lateral_mps)
        maps = self._mapping and not self._relocalizer.doubtful
        followed = await self.compute(session.follow, scan, X_OB, twist, maps, self._rays)
        if session is not self._session:
            return
        if followed is not None:
            self._take(session, followed)
        if followed is None or self._relocalizer.running:
            self._publish_search(scan.stamp, X_OB)
        else:
            match, state = followed.match, self._state(session, followed.match)
            self._publish(
                Localization(
                    scan.stamp,
                    match.X_MO,
                    X_MB=match.X_MB,
                    covariance=match.covariance,
                    state=state,
                    overlap=match.overlap,
                    map="",
                )
            )

    def _take(self, session: MapSession, followed: ScanResult) -> None:
        """Take a matched scan: schedule its job and views, and update the fit monitor."""
        if followed.job is not None:
            self._followed = followed
            self._wake.set()
        if followed.extra_view is not None:
            self._extra_views.append(followed.extra_view)
        match = followed.match
        self._keyframes.take(followed.keyframes, match.keyframe, followed.removed)
        if self._relocalizer.see(match, session.grows):
            self.log.info("the robot is where it was thought to be, after all")

    def _state(self, session: MapSession, match: Match) -> str:
        if not session.grows and self._relocalizer.search_needed(match.stamp):
            self.log.warning("scans do not fit the map where the robot should be: relocalization starts")
            self._relocalizer.request()
            self._wake.set()
        if self._relocalizer.lost:
            return "lost"
        return "mapping" if session.grows and self._mapping else "tracking"

    def _publish_search(self, stamp: float, X_OB: Pose2) -> None:
        grid = None if self._session is None else self._session.grid
        last = Pose2() if self._published is None else self._published.X_MO
        self._publish(self._relocalizer.localization(stamp, X_OB, last, grid))

    def _publish(self, place: Localization) -> None:
        covariance = read_only(np.array(place.covariance, np.float64))
        self._published = replace(place, covariance=covariance, map=self.map_name)
        self._keyframes.publish(self._published)
        self.localization.publish(self._published)

    async def _take_landmark_pose(self, by: LandmarkPose) -> None:
        """Take a pose by a landmark for a hypothesis; while scans fit, for nothing."""
        session = self._session
        if session is None or not self._relocalizer.doubtful:
            return
        if not session.grows:
            self._relocalizer.suggest(by.X_MO)
        elif by.stamp - self._placed_at >= _PLACE_AGAIN_S:
            self._placed_at = by.stamp
            self.log.info("the robot is lost, and placed by the landmark %r: scans have to bear it out", by.text)
            await self.compute(session.place, by.X_MO)
            if session is self._session:
                self.placed()

    # --- Behind ----------------------------------------------------------------------------------------------------

    async def _let_draw(self) -> None:
        self._draw_due = True
        self._wake.set()

    async def _work(self) -> None:
        """The loop of the second thread: one task after the other."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            session = self._session
            if session is None:
                continue
            await self._look(session)
            await self._close_loops(session)
            if self._draw_due:
                self._draw_due = False
                await self._draw(session)

    async def _look(self, session: MapSession) -> None:
        """Start relocalization, or continue it with the newest scan."""
        relocalizer = self._relocalizer
        if relocalizer.due:
            search = await self.compute_background(session.begin_search)
            if session is self._session and relocalizer.due:
                relocalizer.begin(search)
        step = relocalizer.next_step()
        if step is None:
            return
        X_MO, hypotheses = await self.compute_background(step.run)
        if not relocalizer.belongs(step):
            return
        relocalizer.take(hypotheses)
        if X_MO is not None:
            at = X_MO @ step.X_OB
            self.log.info("the robot found itself at x %.2f m, y %.2f m on the map", at.x, at.y)
            await self.compute(session.place, X_MO)
            if relocalizer.belongs(step):
                relocalizer.end()

    async def _close_loops(self, session: MapSession) -> None:
        followed, self._followed = self._followed, None
        if followed is not None and followed.job is not None:
            outcome = await self.compute_background(followed.job.run)
            await self.compute(session.take, followed.slam, outcome)

    async def _draw(self, session: MapSession) -> None:
        """Draw changes, and publish the map if its cells changed."""
        if not session.grows:
            return
        async with self._drawing:
            snapshot, state = await self.compute(session.snapshot), await self.compute(session.state)
            while await self.compute_background(session.draw, snapshot):
                await self._close_loops(session)
            glances, self._extra_views = self._extra_views, []
            grid = await self.compute_background(session.drawn, glances, self.clock.now(), self._version + 1)
            if session is not self._session:
                return
            self._restart_state.grown = state
            if grid is not None:
                self._version = grid.version
                self.map.publish(grid)

    def _ended(self, working: asyncio.Task[None]) -> None:
        error = None if working.cancelled() else working.exception()
        if isinstance(error, Exception):
            self.fail(error)

    # --- The map in use: interface of the map server ------------------------------------------------------------------

    @property
    def _restart_state(self) -> RestartState:
        state: RestartState = self.persistent.setdefault("map", RestartState())
        return state

    @property
    def session(self) -> MapSession:
        assert self._session is not None
        return self._session

    @property
    def X_OB(self) -> Pose2:
        """Current pose of the robot by odometry."""
        return Pose2() if self._odometry is None else self._odometry.X_OB

    def call(self, name: str) -> None:
        self.map_name = name
        self._restart_state.name, self._restart_state.known = name, True

    def new_session(self, kept: StoredMap | None, X_MO: Pose2 | None, grows: bool) -> MapSession:
        """*Behind.* A session on a saved map, or an empty one."""
        from app.modules.perception.slam.map_session import MapSession

        settings = self.settings
        grid, state = (None, None) if kept is None else (kept.grid, kept.state)
        return MapSession(
            grid, state, grows=grows, X_MO=X_MO, cell_m=settings.cell_m, side_m=settings.side_m,
            optimize=self._optimizer,
        )  # fmt: skip

    def use(self, session: MapSession, name: str, zones: tuple[Zone, ...]) -> None:
        """Take a map into use, and publish it with its zones and the localization."""
        self._session = session
        self._followed, self._extra_views = None, []
        self.call(name)
        self._restart_state.use(grows=session.grows)
        now, settings = self.clock.now(), self.settings
        grid = session.grid or empty_grid(settings.cell_m, settings.side_m)
        self._version += 1
        self.map.publish(replace(grid, stamp=now, version=self._version))
        self._keyframes.begin(session.keyframes())
        last = Pose2() if self._published is None else self._published.X_MO
        self._keyframes.publish(
            Localization(now, last, last @ self.X_OB, np.zeros((3, 3)), state="searching", overlap=0.0, map=name)
        )
        self.mark(zones)
        self._relocalizer.end()
        if session.lost:
            self.search()
            self._publish_search(now, self.X_OB)

    def mark(self, zones: tuple[Zone, ...]) -> None:
        self.known_zones = zones
        self.zones.publish(Zones(self.clock.now(), zones))

    def placed(self) -> None:
        """The pose was set: end the relocalization."""
        # A person's pose may be wrong: the map does not grow and the pose is not used for driving until scans fit.
        self._relocalizer.end(doubted=True)

    def search(self) -> None:
        self._relocalizer.end()
        self._relocalizer.request()
        self._wake.set()

    async def finish(self, session: MapSession) -> None:
        """Correct and draw the map completely."""
        settling = await self.compute(session.settling)
        if settling is not None:
            slam, job = settling
            await self.compute(session.take, slam, await self.compute_background(job.run))
        await self._draw(session)

    # --- Start ---------------------------------------------------------------------------------------------

    def _load_kernels(self) -> None:
        if not compiled.is_ready():
            self.log.info("compiles what it computes with, once on this computer: that takes a minute or two")
            compiled.make_ready()
        import app.modules.perception.slam.map_session  # noqa: F401

    async def _take_first(self) -> bool:
        """Take the initial map into use; returns whether the earlier instance used the same."""
        last_published, self._published, zones = _last(self.map), _last(self.localization), _last(self.zones)
        self._version = 0 if last_published is None else last_published.version
        self._keyframes.resume()
        last = LastPublished(last_published, self._published, () if zones is None else zones.zones)
        library, settings = self.service(MapLibrary), self.settings
        first = await self.compute_background(
            choose_initial_map, self._restart_state, last, library, self.new_session, settings.map, settings.extend
        )
        if first.refused:
            self.log.error("the map cannot be taken into use, an empty one starts: %s", first.refused)
        if first.stopped:
            self.log.warning("the map grows no more: it failed too soon again; begin another, or load one")
        self.use(first.session, first.name, first.zones)
        return first.same


def _last(output: Output[M]) -> M | None:
    return None if output.channel is None else output.channel.latest
