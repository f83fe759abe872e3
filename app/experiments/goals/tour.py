"""The map that goals are given on: made by the program itself on a tour that is driven by hand, then kept."""

from __future__ import annotations

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


def make_map(config: Path, scenario: Path, maps: Path) -> Pose2:
    """Drive the tour of ``scenario`` and keep the map in the folder ``maps``; returns its origin in the world.

    Raises ConfigError, ScriptBlocked, MapUnavailable.
    """
    script = load_script(scenario)
    body = simulated_body(config, scenario)
    return run_in_world(
        load_configuration(config), body, lambda run: _live(run, script), without=UNCONCERNED, maps=MapLibrary(maps)
    )


async def _live(run: WorldRun, script: tuple[Waypoint, ...]) -> Pose2:
    origin = run.link.true_pose()
    run.system.workspace.add("SLAM", intensity=8, utility=1, source=_EXPERIMENT)
    await run.system.clock.sleep(SETTLE_S)
    await drive_script(run.system, script)
    await run.system.clock.sleep(SETTLE_S)  # loops are closed and the map is drawn
    await run.system.map.keeper.save(MAP)
    return origin
