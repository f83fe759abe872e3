"""One control cycle on values: what the camera saw once stands there again when the body comes back."""

from __future__ import annotations

import numpy as np

from app.geometry import CameraModel, Pose2
from app.messages import Image
from app.modules.behaviors.navigation.motion import Motion
from app.modules.behaviors.navigation.pilot import Pilot, Senses

from ..driven_world import DrivenLink
from .boxes import CAMERA, World, looking

EYE = looking(0.0, 1.38)
#: Lower than the laser; the wall behind is not.
WORLD = World(((3.0, -0.2, 3.3, 0.2, 0.0, 0.22), (5.0, -3.0, 5.2, 3.0, 0.0, 2.5)))
X_MO = Pose2(2.0, 1.0, 0.3)


def senses(stamp: float, pose: Pose2, *, look: bool, problem: str = "") -> Senses:
    scan, image = WORLD.scan(stamp, pose), WORLD.depth(stamp, pose, EYE)
    assert image.depth is not None
    # As fine as a Kinect's, from fewer rays
    depth = np.kron(image.depth, np.ones((4, 4), dtype=np.uint16))
    lens = CameraModel(640, 480, 4 * CAMERA.fx, 4 * CAMERA.fy, 4 * CAMERA.cx + 1.5, 4 * CAMERA.cy + 1.5)
    image = Image(stamp, "kinect", image.color, depth, lens, image.X_BC)
    seen = (image, pose) if look else None
    return Senses(stamp, Motion(pose, 0.0, 0.0), X_MO, problem, None, (scan, pose, pose), seen)


def pilot() -> Pilot:
    return Pilot(DrivenLink().description, "pursuit", depth=True)


def box_cells(told_obstacles: np.ndarray) -> int:
    return int((np.abs(told_obstacles - np.array([3.1, 0.0])) < 0.3).all(axis=1).sum())


def drive_up(pilot: Pilot, problem: str = "") -> None:
    for k, x in enumerate(np.arange(-1.0, 0.2, 0.1)):
        pilot.remember(senses(0.2 * k, Pose2(float(x), 0.0, 0.0), look=True, problem=problem))


def test_a_box_seen_while_others_drove_stands_there_when_the_body_turns_beside_it_minutes_later() -> None:
    here = pilot()
    drive_up(here)
    told = here.cycle(senses(300.0, Pose2(2.2, 0.0, 1.5), look=False), 0.1)
    assert told.around is not None
    assert box_cells(told.around.obstacles) > 20
    corner, cell = told.around.origin, told.around.resolution_m
    assert told.around.distance[int((0.0 - corner[1]) / cell), int((3.05 - corner[0]) / cell)] < 0.06
    on_map = X_MO @ Pose2(3.05, 0.0)
    assert np.hypot(*(told.things - np.array([on_map.x, on_map.y])).T).min() < 0.1
    far = here.cycle(senses(300.1, Pose2(-4.0, 0.0, 3.1), look=False), 0.1)
    assert far.around is not None
    assert box_cells(far.around.obstacles) == 0
    assert len(far.things) == len(told.things), "whoever plans knows it from anywhere"


def test_nothing_is_learned_without_knowing_where() -> None:
    here = pilot()
    drive_up(here, problem="it looks for itself on the map")
    assert not len(here.cycle(senses(300.0, Pose2(2.2, 0.0, 1.5), look=False), 0.1).things)
