"""One run of the goals experiment: the robot starts on its map and gets one goal after another."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.attention.desires import Source
from app.base.geometry import Pose2, wrap_angle
from app.experiments.goals.result import GoalResult, Outcome, clearance
from app.experiments.simulated import simulated_body
from app.experiments.world_run import WorldRun, run_in_world
from app.maps.library import MapLibrary
from app.maps.map_service import MapUnavailable
from app.messages import NavigationStatus
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.simulated.scenery.people import TRUNK_RADIUS_SHARE
from app.runtime.clock import Clock

LOOK_S = 0.1
MAP = "lab"
UNCONCERNED = ("ScenarioCoordinator",)
"""Modules that are left out: they would search for codes and faces meanwhile."""
_EXPERIMENT = Source("operator", "the experiment")
_STORY = 40


@dataclass(frozen=True, slots=True)
class GoalRun:
    """A plan: ``goals`` with their numbers, in the world, one after another from ``start``.

    ``maps``: the folder of maps, where one called ``MAP`` begins at ``origin`` in the world. ``tolerance_m`` and
    ``tolerance_rad``: those of the desire; ``slack_m``: allowed in addition, for the map's error. ``patience_s``: time
    limit per goal.
    """

    config: Path
    scenario: Path
    maps: Path
    origin: Pose2
    start: Pose2
    goals: tuple[tuple[int, Pose2], ...]
    seed: int
    cameras: bool
    tolerance_m: float
    tolerance_rad: float
    slack_m: float
    patience_s: float


def body_in(config: Path, scenario: Path | None) -> RobotConfig:
    """The program's body, in ``scenario``. Raises ConfigError for a body that is not simulated."""
    return simulated_body(load_configuration(config)).model_copy(update={"scenario": scenario})


def seeing(body: RobotConfig) -> RobotConfig:
    """``body`` with only the camera that navigation uses, to save rendering."""
    return body.model_copy(update={"streams": body.streams.model_copy(update={"panorama": None})})


def work(run_spec: GoalRun, give: Callable[[GoalResult], None]) -> None:
    """Run ``run_spec``; ``give`` gets each result at once.

    Raises ConfigError, and any programming error.
    """
    body = seeing(body_in(run_spec.config, run_spec.scenario))
    start = body.start.model_copy(
        update={"x": run_spec.start.x, "y": run_spec.start.y, "heading_deg": math.degrees(run_spec.start.theta)}
    )
    body = body.model_copy(update={"start": start, "seed": run_spec.seed})
    configuration = load_configuration(run_spec.config)
    run_in_world(
        configuration,
        body,
        lambda run: _run_goals(run, run_spec, body.footprint, give),
        cameras=run_spec.cameras,
        without=UNCONCERNED,
        maps=MapLibrary(run_spec.maps),
    )


async def _run_goals(
    run: WorldRun, run_spec: GoalRun, footprint: tuple[tuple[float, float], ...], give: Callable[[GoalResult], None]
) -> None:
    workspace = run.system.workspace
    workspace.add("SLAM", intensity=8, utility=1, source=_EXPERIMENT)
    X_MB = run_spec.origin.inverse() @ run_spec.start
    await _take_map(run, X_MB)
    last = run_spec.start
    for number, goal in run_spec.goals:
        watch = _GoalObserver(run, run_spec, footprint)
        give(await watch.go(number, last, goal))
        last = run.link.true_pose()


async def _take_map(run: WorldRun, X_MB: Pose2) -> None:
    """Load the map once the map server is running, and wait until the robot is localized."""
    clock: Clock = run.system.clock
    for _ in range(100):
        if run.system.map.available:
            break
        await clock.sleep(0.1)
    await run.system.map.server.load(MAP, X_MB)
    channel = run.system.graph.channels["localization"]
    tracking = asyncio.Event()
    end = channel.observe(lambda message: tracking.set() if message.state == "tracking" else None)
    try:
        for _ in range(200):
            if tracking.is_set():
                return
            await clock.sleep(0.1)
        raise MapUnavailable("the robot does not find its place on the map")
    finally:
        end()


class _GoalObserver:
    """Gives one goal and observes it with the ground truth."""

    def __init__(self, run: WorldRun, run_spec: GoalRun, footprint: tuple[tuple[float, float], ...]) -> None:
        self._run = run
        self._run_spec = run_spec
        self._footprint = footprint
        self._said: NavigationStatus | None = None
        self._story: list[tuple[float, str]] = []
        self._began = run.system.clock.now()
        self._people_m: float | None = None
        self._driven_m = 0.0
        self._last = run.link.true_pose()
        self._touched = self._reported_contacts = len(run.link.contacts)

    async def go(self, number: int, last: Pose2, goal: Pose2) -> GoalResult:
        """Desire ``goal`` (world) and wait until the program ends the desire, or ``patience_s`` is over."""
        run_spec, system = self._run_spec, self._run.system
        on_map = run_spec.origin.inverse() @ goal
        with contextlib.ExitStack() as stack:
            for name in ("navigation", "going_toward"):
                if (channel := system.graph.channels.get(name)) is not None:
                    stack.callback(channel.observe(self._take_status))
            params = {
                "x": on_map.x, "y": on_map.y, "heading": on_map.theta,
                "tolerance_m": run_spec.tolerance_m, "tolerance_rad": run_spec.tolerance_rad,
            }  # fmt: skip
            desire = system.workspace.add("GoTo", intensity=8, utility=1, params=params, source=_EXPERIMENT)
            while self._wanted(desire.id) and system.clock.now() - self._began < run_spec.patience_s:
                self._look()
                await system.clock.sleep(LOOK_S)
            late = self._wanted(desire.id)
            if late:
                system.workspace.remove(desire.id)
        end = self._run.link.true_pose()
        error_m = math.dist((end.x, end.y), (goal.x, goal.y))
        error_rad = wrap_angle(end.theta - goal.theta)
        outcome = self._outcome(late, error_m, error_rad)
        said = self._said
        return GoalResult(
            number=number,
            goal=_rounded(goal),
            end=_rounded(end),
            outcome=outcome,
            time_s=round(system.clock.now() - self._began, 2),
            straight_m=round(math.dist((last.x, last.y), (goal.x, goal.y)), 2),
            driven_m=round(self._driven_m, 2),
            error_m=round(error_m, 3),
            error_rad=round(error_rad, 3),
            recoveries=said.recoveries if said is not None else 0,
            touched=tuple(contact.what for contact in self._run.link.contacts[self._touched :]),
            people_m=None if self._people_m is None else round(self._people_m, 3),
            reason="" if outcome == "reached" or said is None else f"{said.state}: {said.reason}".strip(": "),
            story=tuple(self._story),
        )

    def _wanted(self, desire_id: str) -> bool:
        return any(desire.id == desire_id for desire in self._run.system.workspace.desires())

    def _outcome(self, late: bool, error_m: float, error_rad: float) -> Outcome:
        if late:
            return "timeout"
        if self._said is None or self._said.state != "arrived":
            return "given up"
        run_spec = self._run_spec
        near = error_m <= run_spec.tolerance_m + run_spec.slack_m and abs(error_rad) <= run_spec.tolerance_rad + 0.05
        return "reached" if near else "missed"

    def _look(self) -> None:
        pose = self._run.link.true_pose()
        went = math.dist((pose.x, pose.y), (self._last.x, self._last.y))
        self._driven_m += went
        self._last = pose
        back = pose.inverse()
        for person in self._run.link.people:
            at = back @ Pose2(person.x, person.y)
            room = clearance(self._footprint, at.x, at.y, TRUNK_RADIUS_SHARE * person.height_m)
            if self._people_m is None or room < self._people_m:
                self._people_m = room

        for contact in self._run.link.contacts[self._reported_contacts :]:
            self._reported_contacts += 1
            x, y, _ = contact.at
            at = contact.X_WB.inverse() @ Pose2(x, y)
            where = f"at ({x:.2f}, {y:.2f}), ({at.x:.2f}, {at.y:.2f}) of the body"
            self._note(contact.stamp, f"touched {contact.what} {where}, going {went / LOOK_S:.2f} m/s")

    def _take_status(self, message: NavigationStatus) -> None:
        if message.goal is None:
            return
        before, self._said = self._said, message
        if before is None or (before.state, before.reason) != (message.state, message.reason):
            self._note(message.stamp, f"{message.state}: {message.reason}".strip(": "))

    def _note(self, stamp: float, what: str) -> None:
        if len(self._story) < _STORY:
            self._story.append((round(stamp - self._began, 1), what))


def _rounded(pose: Pose2) -> tuple[float, float, float]:
    return (round(pose.x, 3), round(pose.y, 3), round(pose.theta, 3))
