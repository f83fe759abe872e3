"""The map for the goals: made by the program on a scripted manual tour, then saved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.attention.desires import Source
from app.base.geometry import Pose2
from app.experiments.goals.goal_run import MAP, UNCONCERNED, body_in, seeing
from app.experiments.script import Waypoint, drive_script, load_script
from app.experiments.world_run import WorldRun, run_in_world
from app.maps.library import MapLibrary
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.runtime.filter_bank import Pin

SETTLE_S = 3.0
#: Image rate (Hz) that is enough for low obstacles; rendering takes most of the time.
_PICTURES_HZ = 5.0
#: The tour has no goal, so attention would close navigation's camera input: opened here.
_EYES = ("PlanAndFollowPath.images", "PlanAndFollowPath.scans")
_EXPERIMENT = Source("operator", "the experiment")


@dataclass(frozen=True, slots=True)
class Tour:
    """Arguments of ``make_map``, for a child process."""

    config: Path
    scenario: Path
    maps: Path
    cameras: bool


def drive(tour: Tour, give: Callable[[str], None]) -> None:
    """:func:`make_map`; ``give`` gets each leg."""
    make_map(tour.config, tour.scenario, tour.maps, give, cameras=tour.cameras)


def make_map(
    config: Path, scenario: Path, maps: Path, began: Callable[[str], None] = lambda _: None, *, cameras: bool = False
) -> Pose2:
    """Drive the tour of ``scenario`` and save the map in the folder ``maps``; returns its origin in the world.
    ``began(text)`` is called at each leg. With ``cameras``, navigation observes and learns obstacles that the laser
    does not see.

    Raises ConfigError, ScriptBlocked, MapUnavailable.
    """
    script = load_script(scenario)
    # The script steers by ground truth, as people see the robot: odometry alone would drift off the tour
    body = body_in(config, scenario).model_copy(update={"ground_truth": True})
    cameras = cameras and body.streams.kinect is not None
    body = _looking(body) if cameras else body
    return run_in_world(
        load_configuration(config),
        body,
        lambda run: _run_goals(run, script, began),
        cameras=cameras,
        without=UNCONCERNED,
        pins=dict.fromkeys(_EYES, Pin(1)) if cameras else None,
        maps=MapLibrary(maps),
    )


def _looking(body: RobotConfig) -> RobotConfig:
    body = seeing(body)
    assert body.streams.kinect is not None
    slow = body.streams.kinect.model_copy(update={"rate_hz": _PICTURES_HZ})
    return body.model_copy(update={"streams": body.streams.model_copy(update={"kinect": slow})})


async def _run_goals(run: WorldRun, script: tuple[Waypoint, ...], began: Callable[[str], None]) -> Pose2:
    origin = run.link.true_pose()
    for cls in ("SLAM", "Teleoperation"):
        run.system.workspace.add(cls, intensity=8, utility=1, source=_EXPERIMENT)
    await run.system.clock.sleep(SETTLE_S)
    await drive_script(
        run.system, script, lambda number, _: began(f"mapping on a tour, leg {number + 1} of {len(script)}")
    )
    await run.system.clock.sleep(SETTLE_S)  # loops are closed and the map is drawn
    await run.system.map.server.save(MAP)
    return origin
