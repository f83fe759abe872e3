"""What the simulated body saves by drawing again only what moved in view, and no more images than filters let through.

The lab's body in lockstep, Kinect and panorama wanted, in one thread: CPU per simulated second, and pixels drawn. Each
view is watched by itself; the peer is one watch of the whole model for each camera (any joint that moves redraws it).
Where all filters have φ = 4, the peer draws every image.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from unittest.mock import patch

from app.robots.simulated.gl import gl_environment

os.environ.update(gl_environment())  # read when MuJoCo is imported

import numpy as np

from app.base.paths import config_dir
from app.robots.config import load_robot_config
from app.robots.factory import simulated_parts
from app.robots.simulated import link_protocol
from app.robots.simulated.camera_rendering import ChangeDetector
from app.robots.simulated.link import describe
from app.robots.simulated.lockstep_world import LockstepWorld
from app.robots.simulated.renderer import PerspectiveView, Renderer, WorldSnapshot
from benchmarks.report import Row, benchmark_main, row

TURN_S = 0.004
START_S = 1.0
SETTLE_S = 2.0
WHOLE_STILL = 1e-6


@dataclass(frozen=True)
class Case:
    """What moves: ``joint`` with set-points ``position(time)`` (rad), people, the base."""

    name: str
    people: bool = False
    joint: str = ""
    position: Callable[[float], float] = math.sin
    drives: bool = False
    divisor: int = 1


CASES = (
    Case("empty lab, head turns", joint="robot/pan_joint", position=lambda t: 0.8 * math.sin(t)),
    Case(
        "empty lab, arm swings aside",
        joint="robot/right_shoulder_pitch_joint",
        position=lambda t: 0.4 + 0.3 * math.sin(3 * t),
    ),
    Case("people, head still", people=True),
    Case("people, head turns", people=True, joint="robot/pan_joint", position=lambda t: 0.8 * math.sin(t)),
    Case("people, drives", people=True, drives=True),
    Case("people, drives, φ = 4", people=True, drives=True, divisor=4),
)


@contextmanager
def whole_watch() -> Iterator[None]:
    """Watch the whole model instead: all of a camera's views are drawn again with any of its joints."""
    last: dict[int, WorldSnapshot] = {}
    answers: dict[int, tuple[WorldSnapshot, bool]] = {}

    def changed(self: ChangeDetector, snapshot: WorldSnapshot) -> bool:
        camera = self._camera
        if camera in answers and answers[camera][0] is snapshot:
            return answers[camera][1]
        before = last.get(camera)
        moved = before is None or any(
            np.abs(a - b).max(initial=0.0) > WHOLE_STILL
            for a, b in ((snapshot.qpos, before.qpos), (snapshot.mocap, before.mocap))
        )
        if moved:
            last[camera] = snapshot
        answers[camera] = snapshot, moved
        return moved

    with patch.object(ChangeDetector, "changed", changed):
        yield


def run(case: Case, seconds: float, *, thinned: bool = True) -> tuple[float, float]:
    """CPU (s) of this process, and pixels drawn, per simulated second."""
    pixels = 0
    drawing = Renderer.draw

    def draw(self: Renderer, snapshot: WorldSnapshot, camera: int, view: PerspectiveView) -> None:
        nonlocal pixels
        pixels += view.width * view.height
        drawing(self, snapshot, camera, view)

    robot, lab, scenario = simulated_parts(load_robot_config(config_dir() / "robots" / "irl1_tr.yaml"))
    world = LockstepWorld(robot, lab, scenario if case.people else None, lambda stream, message: None)
    for stream, description in describe(robot).streams.items():
        if stream in ("kinect", "panorama", "hokuyo"):
            world.accept(link_protocol.Demand(stream, description.rate_hz / (case.divisor if thinned else 1)))
    turns = 0
    before = cpu = 0.0
    with patch.object(Renderer, "draw", draw):
        while turns * TURN_S < SETTLE_S + seconds:
            turns += 1
            now = START_S + turns * TURN_S
            if case.joint:
                data = world.physics.data
                data.ctrl[world.physics.model.actuator(case.joint).id] = case.position(now)
            if case.drives and turns % 10 == 0:
                world.accept(link_protocol.DriveRequest(now, 0.2, 0.3))
            world.lockstep(now, START_S)
            if turns == round(SETTLE_S / TURN_S):
                pixels, before = 0, time.process_time()
        cpu = time.process_time() - before
    world.close()
    return cpu / seconds, pixels / seconds


def measure(quick: bool) -> Sequence[Row]:
    """Every case, both ways, in rounds one after the other."""
    rounds, seconds = (1, 3.0) if quick else (3, 10.0)
    rows: list[Row] = []
    for case in CASES:
        ours, peers = [], []
        for _ in range(rounds):
            ours.append(run(case, seconds))
            with nullcontext() if case.divisor > 1 else whole_watch():
                peers.append(run(case, seconds, thinned=False))
        for metric, unit, at, scale in (("CPU", "% of a core", 0, 100.0), ("pixels drawn", "Mpx/s", 1, 1e-6)):
            mine, other = ([scale * figures[at] for figures in side] for side in (ours, peers))
            peer = "whole model watched" if case.divisor == 1 else "every image drawn"
            rows.append(row("redrawing", case.name, metric, unit, mine, other, peer))
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
