"""One run of the pursuit study, on the kinematic body, in virtual time."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.attention.desires import Source
from app.base.geometry import wrap_angle
from app.base.motion_prediction import Velocity
from app.base.network_link import LinkSettings
from app.experiments.pursuit.courses import Course, start_of, walker
from app.experiments.pursuit.operator import PERIOD_S, Operator, Style
from app.experiments.pursuit.remote_console import RemoteConsole, Shown
from app.experiments.pursuit.result import Condition, PursuitResult
from app.maps.grid_rays import GridRays
from app.maps.library import MapLibrary
from app.messages import Exploitation, JointState, LaserScan, Odometry, PersonTruth
from app.program.config import Configuration, load_configuration
from app.rehearsal.play import RehearsalRun, Stage, play
from app.runtime.graph import load_class

MAP = "pursuit"
#: Noise of the laser's distances (m).
NOISE_M = 0.02
#: The camera's field of view (rad), how far a person can be made out in it, and by the laser's points (m).
FOV_RAD, CAMERA_M, LASER_M = math.radians(57.0), 8.0, 6.0
#: A run ends so long after the person's walk (s), and at the latest after this many times the way at full speed.
AFTER_S, PATIENCE = 4.0, 5.0
#: The modules that drive, and know where the robot is.
DRIVING = ("Teleop", "HeadTeleop", "MobileBaseControl", "HeadControl", "SLAM2D")
HEAD_PAN = "pan_joint"
#: The desire class of driving by hand.
DRIVE = "Teleoperation"
_EXPERIMENT = Source("operator", "the experiment")
#: What is at rest, however it is commanded (m/s, rad/s).
_STANDS = 0.01
_KEPT = round(0.5 / PERIOD_S)


@dataclass(frozen=True, slots=True)
class PursuitRun:
    """A plan: ``condition`` on ``course``, with the program of ``config``, on the map kept in the folder ``maps``."""

    config: Path
    maps: Path
    condition: Condition
    course: Course
    seed: int


def work(spec: PursuitRun, give: Callable[[PursuitResult], None]) -> None:
    """Run ``spec``, and give its result. Raises ConfigError, and any programming error."""
    configuration = load_configuration(spec.config)
    maps = MapLibrary(spec.maps)
    course = spec.course
    stage = Stage(
        configuration,
        maps,
        MAP,
        start_of(course, spec.seed),
        scenario=walker(course, spec.seed) if spec.condition.task == "follow" else None,
        without=_unconcerned(configuration),
        noise_m=NOISE_M,
    )
    rays = GridRays(maps.grid(MAP))
    give(play(stage, lambda run: _Trial(run, spec, rays).run()))


def _unconcerned(configuration: Configuration) -> tuple[str, ...]:
    """The modules that neither sense nor are on the way of a command: they only cost time."""
    modules = configuration.program.modules
    kinds = {name: load_class(spec.class_path) for name, spec in modules.items()}
    return tuple(
        name for name, kind in kinds.items() if name not in DRIVING and not (kind is not None and kind.streams)
    )


class _Trial:
    """A run under way."""

    def __init__(self, run: RehearsalRun, spec: PursuitRun, rays: GridRays) -> None:
        self._system, self._link, self._rays = run.system, run.link, rays
        self._spec = spec
        self._course = spec.course
        condition = spec.condition
        settings = LinkSettings(1e-3 * condition.delay_ms, 1e-3 * condition.jitter_ms)
        self._console = RemoteConsole(run.system, settings, spec.seed)
        limits = run.link.description.limits
        points = self._course.points if condition.task == "course" else ()
        self._operator = Operator(Style(condition.mode, condition.prediction), limits, points)
        self._patience_s = PATIENCE * self._course.length_m / limits.linear_mps
        self._odometry: Odometry | None = None
        self._scan: LaserScan | None = None
        self._pan = 0.0
        self._stopped = False
        self._stops = self._limited = self._beats = 0
        self._distances: list[float] = []
        self._visible: list[bool] = []
        self._trace: list[tuple[float, float]] = []

    async def run(self) -> PursuitResult:
        clock = self._system.clock
        with ExitStack() as stack:
            stack.callback(self._console.close)
            channels = self._system.graph.channels
            stack.callback(channels["exploitation"].observe(self._take_exploitation))
            stack.callback(channels["scan"].observe(self._take_scan))
            stack.callback(channels["joints"].observe(self._take_joints))
            stack.callback(channels["odometry"].observe(self._take_odometry))
            await self._ready()
            began, ended_at, driven_m = clock.now(), math.inf, self._link.base.driven_m
            touches, beats = self._link.base.touches, 0
            while clock.now() - began < self._patience_s and clock.now() < ended_at:
                self._look(beats)
                if (shown := self._console.shown) is not None:
                    self._console.command(self._operator.act(clock.now(), shown, self._console.round_trip_s))
                if ended_at == math.inf and self._has_ended():
                    ended_at = clock.now() + (AFTER_S if self._spec.condition.task == "follow" else 0.0)
                beats += 1
                await clock.sleep(PERIOD_S)
            return self._result(clock.now() - began, driven_m, touches, ended=ended_at < math.inf)

    async def _ready(self) -> None:
        """Wait until attention lets the operator drive, and everything is measured."""
        workspace = self._system.workspace
        if not any(desire.cls == DRIVE for desire in workspace.desires()):
            workspace.add(DRIVE, intensity=8, utility=1, source=_EXPERIMENT)
        await self._system.translator.settled()
        while self._odometry is None or self._scan is None:
            await self._system.clock.sleep(PERIOD_S)

    def _result(self, seconds: float, driven_m: float, touches: int, *, ended: bool) -> PursuitResult:
        shares = self._console.shares
        moved = [share for share in shares if share > 0.0]
        distances = self._distances
        return PursuitResult(
            condition=self._spec.condition,
            seed=self._spec.seed,
            course=self._course.name,
            ended=ended,
            time_s=round(seconds, 2),
            driven_m=round(self._link.base.driven_m - driven_m, 2),
            contacts=self._link.base.touches - touches,
            monitor_stops=self._stops,
            limited=round(self._limited / max(self._beats, 1), 4),
            distance_m=round(float(np.mean(distances)), 3) if distances else None,
            distance_p95_m=round(float(np.percentile(distances, 95)), 3) if distances else None,
            visible=round(float(np.mean(self._visible)), 4) if self._visible else None,
            late_share=round(float(np.mean(moved)), 4) if moved else 0.0,
            late=len(shares) - len(moved),
            trace=tuple(self._trace),
        )

    def _has_ended(self) -> bool:
        if self._spec.condition.task == "course":
            return self._operator.arrived
        (person,) = self._link.people
        return math.dist((person.x, person.y), self._course.points[-1]) < 0.1

    def _look(self, beat: int) -> None:
        """Note the truth, and show the operator what the robot measures."""
        odometry = self._odometry
        assert odometry is not None
        X_WB = self._link.true_pose()
        people = self._link.people
        if beat % _KEPT == 0:
            self._trace.append((round(X_WB.x, 2), round(X_WB.y, 2)))
        in_picture = by_laser = False
        if people:
            in_picture, by_laser = self._seen(people[0])
            self._distances.append(math.dist((X_WB.x, X_WB.y), (people[0].x, people[0].y)))
            self._visible.append(in_picture)
        self._console.show(
            Shown(
                odometry.stamp,
                self._link.start_pose @ odometry.X_OB,
                Velocity(odometry.linear_mps, odometry.angular_radps),
                pan=self._pan,
                scan=self._scan,
                person=(people[0].x, people[0].y) if in_picture or by_laser else None,
            )
        )

    def _seen(self, person: PersonTruth) -> tuple[bool, bool]:
        """Whether the person is in the camera's picture, and among the laser's points."""
        X_WB = self._link.true_pose()
        here, there = (X_WB.x, X_WB.y), (person.x, person.y)
        bearing = wrap_angle(math.atan2(there[1] - here[1], there[0] - here[0]) - X_WB.theta)
        away = math.dist(here, there)
        if away > CAMERA_M or not self._rays.sees(here, there):
            return False, False
        aside = abs(wrap_angle(bearing - self._pan))
        return aside <= FOV_RAD / 2, abs(bearing) <= math.pi / 2 and away <= LASER_M

    def _take_exploitation(self, message: Exploitation) -> None:
        self._beats += 1
        self._limited += bool(message.limited)
        twist = message.twist
        stopped = bool(message.limited) and max(abs(twist.linear_mps), abs(twist.angular_radps)) < _STANDS
        self._stops += stopped and not self._stopped
        self._stopped = stopped

    def _take_scan(self, scan: LaserScan) -> None:
        self._scan = scan

    def _take_joints(self, joints: JointState) -> None:
        self._pan = dict(zip(joints.names, joints.positions, strict=True)).get(HEAD_PAN, 0.0)

    def _take_odometry(self, odometry: Odometry) -> None:
        self._odometry = odometry
