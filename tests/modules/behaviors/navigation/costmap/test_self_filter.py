"""The robot's own arms in its depth image: no obstacles, and nothing else is lost with them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.base.moving_shapes import Capsules
from app.messages import Image, JointCommand, JointState
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings, LocalCostmap
from app.modules.behaviors.navigation.costmap.self_filter import self_filtered
from app.modules.body_shapes import moving_shapes
from app.robots.config import RobotConfig, StartPose
from app.robots.simulated.link import describe
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import VirtualClock, run_virtual
from tests.modules.behaviors.navigation.boxes import World, looking
from tests.modules.behaviors.navigation.maps import ROUND
from tests.robots.conftest import hall, needs_gl, robot

__all__ = ["hall", "robot"]

HERE = Pose2(0.0, 0.0, 0.0)
WALL = (2.0, -3.0, 2.2, 3.0, 0.0, 2.5)
ARM = (0.57, 0.07, 0.63, 0.13, 1.2, 1.35)
OWN = Capsules(np.array([[[0.6, 0.1, 1.2], [0.6, 0.1, 1.35]]]), np.array([0.05]))


def near(image: Image, footprint: Footprint, ahead_m: float) -> Sequence[float]:
    """How far ahead (m) the obstacles are that the image shows within ``ahead_m``."""
    costmap = LocalCostmap(footprint, 1.5, CostmapSettings(depth_step=1))
    costmap.add_depth(image, HERE)
    obstacles = costmap.around(HERE, image.stamp).obstacles
    return sorted(obstacles[np.hypot(obstacles[:, 0], obstacles[:, 1]) < ahead_m][:, 0].tolist())


def test_an_arm_is_no_obstacle_and_the_wall_behind_it_stays() -> None:
    image = World((WALL, ARM)).depth(1.0, HERE, looking())
    bare = World((WALL,)).depth(1.0, HERE, looking())
    assert image.depth is not None
    assert bare.depth is not None
    filtered = self_filtered(image, OWN)
    assert filtered.depth is not None
    assert not filtered.depth.flags.writeable
    arm = (image.depth > 0) & (image.depth < 1000)
    assert arm.sum() > 100
    assert not filtered.depth[arm].any()
    np.testing.assert_array_equal(filtered.depth[~arm], image.depth[~arm])
    assert near(image, ROUND, 1.0)
    assert not near(filtered, ROUND, 1.0)
    assert near(filtered, ROUND, 2.3)


def test_a_thing_beside_the_arm_stays() -> None:
    beside = (0.57, 0.22, 0.63, 0.28, 1.2, 1.35)
    image = World((WALL, beside)).depth(1.0, HERE, looking())
    assert self_filtered(image, OWN) is image


@pytest.mark.parametrize("end", [(-0.5, 0.0, 1.4), (0.06, 0.0, 1.4), (0.6, 2.0, 1.2)])
def test_an_arm_behind_before_the_lens_or_out_of_view_changes_nothing(end: tuple[float, float, float]) -> None:
    image = World((WALL,)).depth(1.0, HERE, looking())
    own = Capsules(np.array([[end, end]]), np.array([0.05]))
    assert self_filtered(image, own) is image


@needs_gl
@pytest.mark.slow
def test_raised_arms_are_seen_by_the_simulated_camera_and_are_no_obstacles(
    robot: RobotConfig, hall: WorldConfig
) -> None:
    body = robot.model_copy(update={"start": StartPose(x=10, y=10)})
    groups = {f"{side}_arm": robot.groups[f"{side}_arm"] for side in ("left", "right")}

    async def main() -> tuple[Image, JointState]:
        clock = VirtualClock()
        link = LockstepLink(body, hall, clock, None, cameras=True)
        images: list[Image] = []
        joints: list[JointState] = []
        link.attach("kinect", images.append)
        link.attach("joints", joints.append)
        await link.start()
        try:
            link.demand("kinect", 15.0)
            for _ in range(40):
                for (name, group), inward in zip(groups.items(), (-0.15, 0.15), strict=True):
                    arm = tuple(joint.name for joint in group.joints)
                    link.command(JointCommand(clock.now(), name, arm, (-1.9, inward, 0.0, 0.0)))
                link.command(JointCommand(clock.now(), "head", ("tilt_joint",), (-0.29,)))
                await clock.sleep(0.1)
        finally:
            await link.stop()
        newest = images[-1]
        return newest, min(joints, key=lambda state: abs(state.stamp - newest.stamp))

    image, joints = run_virtual(main())
    description = describe(robot)
    footprint = Footprint.of(description)
    own = moving_shapes(description).at(dict(zip(joints.names, joints.positions, strict=True)))
    seen = near(image, footprint, 0.8)
    assert seen
    assert max(seen) < 0.6, "its arms"
    assert not near(self_filtered(image, own), footprint, 0.8)
    filtered = self_filtered(image, own).depth
    assert filtered is not None
    assert (filtered > 0).mean() > 0.4, "the hall's floor and walls stay"
    assert math.isfinite(float(filtered.max()))
