"""Pictures that are drawn again only where something in view moved are those that would be drawn anyway."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.config import load_robot_config
from app.robots.factory import simulated_parts
from app.robots.simulated import renderer as renderer_module
from app.robots.simulated.camera_rendering import (
    CameraRenderer,
    ChangeDetector,
    FisheyeRenderer,
    KinectRenderer,
    open_renderers,
)
from app.robots.simulated.lockstep_world import LockstepWorld
from app.robots.simulated.renderer import PerspectiveView, Renderer, WorldSnapshot, mocap_poses
from tests.robots.conftest import CONFIG, needs_gl

pytestmark = [needs_gl, pytest.mark.slow]
START_S = 1.0
NOISE = 2.0
"""Standard deviation of a pixel's noise in the panorama; the Kinect's is larger."""


@dataclass
class Watched:
    """A world at work with two sets of cameras: ``eyes`` draw what changed, ``always`` every picture."""

    world: LockstepWorld
    eyes: dict[str, CameraRenderer]
    always: dict[str, CameraRenderer]
    now: float = START_S

    def step(self, seconds: float, pan: float, shoulder: float) -> None:
        """Go on, with set-points (rad) of a joint of the head and one of an arm."""
        physics = self.world.physics
        physics.data.ctrl[physics.model.actuator("robot/pan_joint").id] = pan
        physics.data.ctrl[physics.model.actuator("robot/right_shoulder_pitch_joint").id] = shoulder
        self.now += seconds
        self.world.lockstep(self.now, START_S)

    def snapshot(self) -> WorldSnapshot:
        data = self.world.physics.data
        return WorldSnapshot(self.now, data.qpos.copy(), mocap_poses(data), Pose3.identity())


@pytest.fixture
def watched() -> Iterator[Watched]:
    robot, lab, scenario = simulated_parts(load_robot_config(CONFIG / "robots" / "irl1_tr.yaml"))
    world = LockstepWorld(robot, lab, scenario, lambda stream, message: None)
    model = world.physics.model
    renderers = [Renderer(model), Renderer(model)]
    eyes, always = (open_renderers(r, model, robot.streams, world.camera_rngs) for r in renderers)
    yield Watched(world, eyes, always)
    for renderer in renderers:
        renderer.close()
    world.close()


def pictures(eye: CameraRenderer) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Colour, and depth (m) where the camera has it."""
    if isinstance(eye, KinectRenderer):
        color, inverse = eye.picture
        return color.astype(float), 1 / np.maximum(inverse, 0.05)
    assert isinstance(eye, FisheyeRenderer)
    return eye.picture.astype(float), None


# With a watch a hundred times finer what is left is rounding; a shape overlooked would show either way
@pytest.mark.parametrize(
    ("still", "error_of_color", "wrong"), [(1e-6, 0.1 * NOISE, 1e-5), (None, math.sqrt(2) * NOISE, 1e-3)]
)
def test_pictures_are_those_of_a_camera_that_always_draws(
    watched: Watched, monkeypatch: pytest.MonkeyPatch, still: float | None, error_of_color: float, wrong: float
) -> None:
    if still is not None:
        monkeypatch.setattr(renderer_module, "_STILL", still)
    drawn: list[tuple[int, PerspectiveView]] = []
    drawing = Renderer.draw

    def draw(self: Renderer, snapshot: WorldSnapshot, camera: int, view: PerspectiveView) -> None:
        drawn.append((camera, view))
        drawing(self, snapshot, camera, view)

    def show(eyes: dict[str, CameraRenderer], snapshot: WorldSnapshot) -> list[tuple[int, PerspectiveView]]:
        drawn.clear()
        for eye in eyes.values():
            for _ in eye.draw(snapshot):
                pass
        return list(drawn)

    monkeypatch.setattr(Renderer, "draw", draw)
    watched.step(1.0, 0.0, 0.0)  # settles on its wheels
    needed = all_of_them = 0
    for number in range(30):
        # The head turns for a second, stands for a second, while an arm swings, then both rest
        pan = 0.5 * math.sin(0.3 * number) if number < 10 else 0.2
        shoulder = 0.3 * math.sin(number) if 10 <= number < 20 else 0.0
        watched.step(0.1, pan, shoulder)
        snapshot = watched.snapshot()
        needed += len(show(watched.eyes, snapshot))
        with monkeypatch.context() as patch:
            patch.setattr(ChangeDetector, "changed", lambda *_: True)
            all_of_them += len(show(watched.always, snapshot))
        for stream, eye in watched.eyes.items():
            color, depth = pictures(eye)
            true_color, true_depth = pictures(watched.always[stream])
            error = np.abs(color - true_color)
            assert np.sqrt((error**2).mean()) < error_of_color, (stream, number)
            assert (error > 10 * NOISE).mean() < wrong, (stream, number)
            if depth is not None and true_depth is not None:
                assert (np.abs(depth - true_depth) > 0.001 + 0.001 * true_depth**2).mean() < 1e-3, (stream, number)
    assert all_of_them == 30 * 6
    print(needed, all_of_them)
    assert 30 < needed < 0.9 * all_of_them
