"""PlanAndFollowPath with an arm stretched to the side: beside what it would hit, through no door too narrow."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from app.base.collision_shapes import load_collision_shapes
from app.base.geometry import Pose2
from app.base.moving_shapes import BodyOutline, MovingShapes
from app.messages import JointState, LaserScan
from app.modules.actuation.collision_monitor import MonitorRules
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.kernel_loading import load_kernels
from app.runtime.clock import in_virtual_time
from tests.modules.behaviors.driven_world import FOOTPRINT, DrivenWorld, Living, Segment, box, until
from tests.modules.behaviors.test_plan_and_follow_path import HOUSE, IRL1, IRL1_MODEL, Drive

JOINTS = [joint.name for arm in IRL1.arms.values() for joint in IRL1.groups[arm.group].joints]
OUTLINE = BodyOutline(FOOTPRINT, MovingShapes(IRL1_MODEL, load_collision_shapes(IRL1.model), JOINTS))
AT_REST = dict(zip(JOINTS, [position for arm in IRL1.arms.values() for position in arm.rest], strict=True))
ASIDE = AT_REST | {"left_shoulder_roll_joint": math.pi / 2, "left_elbow_joint": 0.0}
ROOM = box(0.1, 0.1, 5.9, 4.9)


@pytest.fixture(scope="module", autouse=True)
def _kernels() -> None:
    """Virtual time does not wait for long while they are loaded on a busy computer."""
    load_kernels()


class ArmedWorld(DrivenWorld):
    """Its body has arms, whose ``joints`` the module under test gets with each scan, and which count for clearances."""

    def __init__(self, segments: list[Segment], pose: Pose2, joints: dict[str, float]) -> None:
        super().__init__(segments, pose)
        self.joints = joints
        self.drive: Drive | None = None

    def clearance_m(self) -> float:
        edges = Footprint.polygon(np.array(OUTLINE.at(self.joints))).edges()
        begins, ends = np.array(self.segments)[:, None, :2], np.array(self.segments)[:, None, 2:]
        points = (begins + np.linspace(0.0, 1.0, 300)[:, None] * (ends - begins)).reshape(-1, 2)
        points_B = self.pose.inverse().transform(points)
        return float((points_B @ edges[:, :2].T - edges[:, 2]).max(axis=1).min())

    def scan(self, stamp: float, fov: float = math.pi, rays: int = 181) -> LaserScan:
        assert self.drive is not None
        self.drive.bench.feed("joints", JointState(stamp, tuple(self.joints), tuple(self.joints.values())))
        return super().scan(stamp, fov, rays)


def sent(world: ArmedWorld, known: list[Segment], **goal: Any) -> Drive:
    world.drive = Drive(world, known=known, arms=True, **goal)
    return world.drive


@in_virtual_time
async def test_it_keeps_off_the_side_of_a_passage_that_its_arm_would_hit() -> None:
    walls = [*ROOM, *box(2.2, 0.1, 2.8, 1.9), *box(2.2, 3.1, 2.8, 4.9)]
    world = ArmedWorld(walls, Pose2(1.0, 2.5, 0.0), ASIDE)
    async with sent(world, walls, x=4.0, y=2.5) as drive:
        assert await drive.until("arrived", 60)
    assert world.nearest_m > MonitorRules().margin_m, "the collision monitor has no reason to slow it"
    assert ArmedWorld(walls, Pose2(2.5, 2.5, 0.0), ASIDE).clearance_m() < -0.05, "in its middle it would hit the wall"


@in_virtual_time
async def test_it_waits_before_a_door_that_is_too_narrow_for_its_arm_until_the_arm_rests() -> None:
    world = ArmedWorld(HOUSE, Pose2(2.8, 2.45, 0.0), ASIDE)
    async with sent(world, HOUSE, x=5.0, y=2.45) as drive:
        assert await drive.until("waiting", 30)
        async with Living(world, drive.bench):
            waited = await until(drive.bench, lambda: "with them at rest there is a way" in drive.status.reason, 30)
        assert waited, drive.status
        assert (drive.status.state, drive.status.recoveries, world.driven_m) == ("waiting", 0, 0.0)
        world.joints = AT_REST
        assert await drive.until("arrived", 60)
    assert world.nearest_m > 0.0
