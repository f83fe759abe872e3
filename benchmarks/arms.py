"""What two compliant arms cost the simulated body: the world's steps, its guards and servos, and what it sends.

The lab without people, no camera and no sound wanted, in lockstep, in one thread: CPU per simulated second. The peer is
the same body whose file has no groups for arms and grippers. A pair of worlds takes turns, a second at a time.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import yaml

from app.base.paths import config_dir
from app.messages import JointCommand
from app.robots.config import RobotConfig, load_robot_config
from app.robots.factory import simulated_parts
from app.robots.simulated import link_protocol
from app.robots.simulated.lockstep import without_threads
from app.robots.simulated.lockstep_world import LockstepWorld
from benchmarks.report import Row, benchmark_main, row

TURN_S = 0.004
START_S = 1.0
SETTLE_S = 2.0
COMMAND_TURNS = 25
"""A command every 0.1 s, as an arbiter gives them."""


class ArmWorld:
    """A body in the lab, whose arms are commanded to ``position(time)`` (rad, all joints), if there are groups."""

    def __init__(self, robot: RobotConfig, position: Callable[[float], float] | None, e_stop: str | None) -> None:
        robot, lab, _ = simulated_parts(robot.model_copy(update={"scenario": None}))
        self._world = LockstepWorld(robot, lab, None, lambda stream, message: None)
        if e_stop is not None:
            self._world.accept(link_protocol.EStopRequest(e_stop))
        self._groups = [group for name, group in robot.groups.items() if name.endswith(("arm", "gripper"))]
        self._position = position
        self._turns = 0

    def run(self, seconds: float) -> float:
        """CPU (s) of this thread while so many simulated seconds pass."""
        before = time.thread_time()
        for _ in range(round(seconds / TURN_S)):
            self._turns += 1
            now = START_S + self._turns * TURN_S
            if self._position is not None and self._turns % COMMAND_TURNS == 0:
                for group in self._groups:
                    names = tuple(joint.name for joint in group.joints)
                    positions = (self._position(now),) * len(names)
                    self._world.accept(JointCommand(now, group.name, names, positions))
            self._world.lockstep(now, START_S)
        return time.thread_time() - before

    def close(self) -> None:
        """End the world."""
        self._world.close()


def bodies() -> tuple[RobotConfig, RobotConfig]:
    """IRL-1/TR as shipped, and without groups for arms and grippers."""
    path = config_dir() / "robots" / "irl1_tr.yaml"
    robot = load_robot_config(path)
    document = yaml.safe_load(path.read_text())
    document |= {"model": str(robot.model), "world": str(robot.world), "scenario": None}
    document["actuators"] = {"head": document["actuators"]["head"]}
    del document["arms"]
    with tempfile.TemporaryDirectory() as folder:
        cut = Path(folder) / path.name
        cut.write_text(yaml.safe_dump(document))
        bare = load_robot_config(cut)
    return without_threads(robot, cameras=False), without_threads(bare, cameras=False)


def measure(quick: bool) -> Sequence[Row]:
    """Arms held without commands, yielding, and moving, each beside the body without them."""
    pairs, seconds = (5, 1.0) if quick else (20, 1.0)
    cases: dict[str, tuple[Callable[[float], float] | None, str | None]] = {
        "arms held": (None, None),
        "arms yield": (None, "a benchmark"),
        "arms and grippers move": (lambda now: 0.02 + 0.3 * math.sin(3 * now), None),
    }
    rows: list[Row] = []
    for name, (position, e_stop) in cases.items():
        armed, bare = bodies()
        worlds = ArmWorld(armed, position, e_stop), ArmWorld(bare, position, e_stop)
        figures: tuple[list[float], list[float]] = [], []
        for world in worlds:
            world.run(SETTLE_S)
        for _ in range(pairs):
            for world, found in zip(worlds, figures, strict=True):
                found.append(100.0 * world.run(seconds) / seconds)
        for world in worlds:
            world.close()
        rows.append(row("arms", name, "CPU", "% of a core", figures[0], figures[1], "no groups of arms"))
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
