"""One trial: the whole program crosses a world in lockstep, with the configured mapping, planning and driving."""

from __future__ import annotations

import asyncio
import itertools
import math
import tempfile
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from pathlib import Path

from app.attention.desires import Source
from app.base.geometry import Pose2
from app.experiments.barn.result import Outcome, WorldResult
from app.experiments.barn.worlds import BarnWorld
from app.experiments.simulated import simulated_body
from app.experiments.world_run import WorldRun, run_in_world, with_settings
from app.maps.library import MapLibrary
from app.messages import NavigationStatus
from app.program.config import load_configuration

SETTLE_S = 1.0
"""Time (s) at rest before the goal is given, for the first scans."""
LOOK_S = 0.02
TRACE_S = 0.1
_STORY = 60
_EXPERIMENT = Source("operator", "the experiment")


@dataclass(frozen=True, slots=True)
class Trial:
    """A plan: the program of ``config`` in ``world``; ``max_mps``: speed used for T*.

    ``overrides``: settings of modules, by module, in place of the configured ones.
    """

    config: Path
    world: BarnWorld
    max_mps: float
    seed: int = 1
    overrides: dict[str, dict[str, object]] = field(default_factory=dict)


Drive = Callable[[WorldRun, Pose2], Awaitable[None]]
"""Gives the robot its goal (m, on its map); runs beside the trial."""


async def desire_goal(run: WorldRun, goal: Pose2) -> None:
    """Give the goal as an operator would: by a desire."""
    run.system.workspace.add("GoTo", intensity=8, utility=1, params={"x": goal.x, "y": goal.y}, source=_EXPERIMENT)


def cross(trial: Trial, drive: Drive = desire_goal) -> WorldResult:
    """Run ``trial`` to its end. Raises ConfigError, and any programming error."""
    began = time.monotonic()
    world = trial.world
    configuration = with_settings(load_configuration(trial.config), trial.overrides)
    body = simulated_body(configuration).model_copy(
        update={"start": world.start_pose(), "scenario": None, "seed": trial.seed}
    )
    watch = _CrossingObserver(world, world.length_m / trial.max_mps)
    with tempfile.TemporaryDirectory(prefix="hbba-barn-") as folder:
        maps = MapLibrary(Path(folder))
        run_in_world(configuration, body, lambda run: watch.observe(run, drive), world=world.build(), maps=maps)
    return watch.result(time.monotonic() - began)


def goal_on_the_map(world: BarnWorld) -> Pose2:
    """The goal (m) on the map of a robot whose map begins at its start pose."""
    back = world.X_WO.inverse() @ Pose2(*world.goal)
    return Pose2(back.x, back.y)


class _CrossingObserver:
    """Observes one crossing with the ground truth."""

    def __init__(self, world: BarnWorld, optimal_s: float) -> None:
        self._world = world
        self._optimal_s = optimal_s
        self._outcome: Outcome = "failed"
        self._reason = ""
        self._time_s = 0.0
        self._trace: list[tuple[float, float, float, float]] = []
        self._said: NavigationStatus | None = None
        self._story: list[tuple[float, str]] = []
        self._began = math.inf
        self._wanted = False

    async def observe(self, run: WorldRun, drive: Drive) -> None:
        """Settle, give the goal, and observe until it is reached, an object is hit or the time is over."""
        channel = run.system.graph.channels.get("navigation")
        if channel is not None:
            channel.observe(self._take_status)
        if "SLAM" in run.system.classes:
            run.system.workspace.add("SLAM", intensity=8, utility=1, source=_EXPERIMENT)
        await run.system.clock.sleep(SETTLE_S)
        began = self._began = run.system.clock.now()
        driving = asyncio.ensure_future(drive(run, goal_on_the_map(self._world)))
        try:
            while not self._over(run, run.system.clock.now() - began):
                if driving.done() and (error := driving.exception()) is not None:
                    raise error
                await run.system.clock.sleep(LOOK_S)
        finally:
            driving.cancel()
            await asyncio.wait({driving})

    def result(self, wall_s: float) -> WorldResult:
        """The result of the crossing."""
        said, trace = self._said, self._trace
        return WorldResult(
            world=self._world.name,
            outcome=self._outcome,
            time_s=round(self._time_s, 3),
            optimal_s=round(self._optimal_s, 4),
            left_m=round(math.dist(trace[-1][1:3], self._world.goal), 3) if trace else math.inf,
            reason=self._reason,
            recoveries=said.recoveries if said is not None else 0,
            driven_m=round(sum(math.dist(a[1:3], b[1:3]) for a, b in itertools.pairwise(trace)), 3),
            wall_s=round(wall_s, 2),
            story=tuple(self._story),
            trace=tuple(trace),
        )

    def _over(self, run: WorldRun, time_s: float) -> bool:
        pose = run.link.true_pose()
        self._time_s = time_s
        if not self._trace or time_s - self._trace[-1][0] > TRACE_S - 1e-6:
            self._note(pose)
        if run.link.contacts:
            self._outcome, self._reason = "collision", f"touched {run.link.contacts[0].what}"
        elif math.dist((pose.x, pose.y), self._world.goal) <= self._world.goal_tolerance:
            self._outcome = "success"
        elif time_s >= self._world.timeout_s:
            self._outcome = "timeout"
        elif self._gave_up(run):
            self._outcome, self._reason = "failed", "the goal was given up"
        else:
            return False
        self._note(pose)
        if self._outcome != "success" and self._said is not None:
            text = _event_text(self._said)
            self._reason = f"{self._reason}; {text}" if self._reason else text
        return True

    def _gave_up(self, run: WorldRun) -> bool:
        """Whether the program has removed the goal's desire."""
        wanted = any(desire.cls == "GoTo" for desire in run.system.workspace.desires())
        self._wanted |= wanted
        return self._wanted and not wanted

    def _note(self, pose: Pose2) -> None:
        self._trace.append((round(self._time_s, 3), round(pose.x, 3), round(pose.y, 3), round(pose.theta, 3)))

    def _take_status(self, message: NavigationStatus) -> None:
        before = self._said
        if message.goal is None:
            return  # statuses before or after the goal do not count
        self._said = message
        if len(self._story) >= _STORY:
            return
        if before is None or (before.state, before.reason) != (message.state, message.reason):
            self._story.append((round(message.stamp - self._began, 2), _event_text(message)))


def _event_text(status: NavigationStatus) -> str:
    return f"{status.state}: {status.reason}".strip(": ")
