"""The map that goals are given on: made by the program itself on a tour that is driven by hand, then kept."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from app.attention.desires import Source
from app.config import load_configuration
from app.experiments.goals.shift import MAP, UNCONCERNED, simulated_body
from app.experiments.lockstep import WorldRun, run_in_world
from app.experiments.script import Waypoint, drive_script, load_script
from app.geometry import Pose2
from app.maps.library import MapLibrary

SETTLE_S = 3.0
_EXPERIMENT = Source("operator", "the experiment")


def make_map(config: Path, scenario: Path, maps: Path, began: Callable[[str], None] = lambda _: None) -> Pose2:
    """Drive the tour of ``scenario`` and keep the map in the folder ``maps``; returns its origin in the world.

    ``began`` is told each leg.

    Raises ConfigError, ScriptBlocked, MapUnavailable.
    """
    script = load_script(scenario)
    # Hands see where the robot is, as people do: odometry alone would drift from the tour
    body = simulated_body(config, scenario).model_copy(update={"ground_truth": True})
    return run_in_world(
        load_configuration(config),
        body,
        lambda run: _live(run, script, began),
        without=UNCONCERNED,
        maps=MapLibrary(maps),
    )


async def _live(run: WorldRun, script: tuple[Waypoint, ...], began: Callable[[str], None]) -> Pose2:
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
