"""The map that goals are given on: made by the program itself on a tour that is driven by hand, then kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.attention.desires import Source
from app.base.geometry import Pose2
from app.experiments.goals.goal_run import MAP, UNCONCERNED, seeing, simulated_body
from app.experiments.script import Waypoint, drive_script, load_script
from app.experiments.world_run import WorldRun, run_in_world
from app.maps.library import MapLibrary
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.runtime.graph import Pin

SETTLE_S = 3.0
#: What stands low is seen well enough at so many pictures a second, and drawing them takes most of the time.
_PICTURES_HZ = 5.0
#: Nobody wants to go anywhere on the tour, so attention would leave the eyes of navigation shut.
_EYES = ("PlanAndFollowPath.images", "PlanAndFollowPath.scans")
_EXPERIMENT = Source("operator", "the experiment")


@dataclass(frozen=True, slots=True)
class Tour:
    """What ``make_map`` is given, for a child process."""

    config: Path
    scenario: Path
    maps: Path
    cameras: bool


def drive(tour: Tour, give: Callable[[str], None]) -> None:
    """:func:`make_map`; each leg is given."""
    make_map(tour.config, tour.scenario, tour.maps, give, cameras=tour.cameras)


def make_map(
    config: Path, scenario: Path, maps: Path, began: Callable[[str], None] = lambda _: None, *, cameras: bool = False
) -> Pose2:
    """Drive the tour of ``scenario`` and keep the map in the folder ``maps``; returns its origin in the world.

    ``began`` is told each leg. With ``cameras``, navigation looks on and learns what stands where the laser does not
    see it.

    Raises ConfigError, ScriptBlocked, MapUnavailable.
    """
    script = load_script(scenario)
    # Hands see where the robot is, as people do: odometry alone would drift from the tour
    body = simulated_body(config, scenario).model_copy(update={"ground_truth": True})
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
    await run.system.map.keeper.save(MAP)
    return origin
