"""The whole program in the simulated lab, in virtual time: through a door, around a box that the laser looks over."""

from __future__ import annotations

import math

import pytest

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import Pose2, wrap_angle
from app.base.yaml_source import parse
from app.experiments.world_run import WorldRun, run_in_world
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.robots.simulated.contacts import Contact
from app.robots.simulated.world_config import ObjectConfig, WorldConfig
from tests.robots.conftest import needs_gl

#: Looking down the south corridor; then behind the living room's door, which is on the left of it.
START, GOAL = Pose2(11.1, 8.3, -math.pi / 2), Pose2(13.3, 2.8, 0.0)
#: 0.25 m high, on the straight way there: the laser looks over it from 0.40 m, and the camera from under 2.7 m on.
BOX = ObjectConfig(kind="box", at=(11.1, 5.0), size=(0.4, 0.3, 0.25))


@pytest.mark.slow
@needs_gl
def test_through_a_door_and_around_a_box_that_the_laser_looks_over() -> None:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    start = body.start.model_copy(update={"x": START.x, "y": START.y, "heading_deg": math.degrees(START.theta)})
    assert body.streams.kinect is not None
    # Small pictures, and few: drawing them is what this test spends its time on.
    kinect = body.streams.kinect.model_copy(update={"width": 320, "height": 240, "rate_hz": 6})
    streams = body.streams.model_copy(update={"panorama": None, "kinect": kinect})
    body = body.model_copy(update={"start": start, "scenario": None, "streams": streams})
    world = parse(paths.config_dir() / "worlds" / "lab.yaml", WorldConfig)
    # The suitcase beside the corridor's mouth is too near to the start to be seen by the camera before it is passed.
    others = tuple(thing for thing in world.objects if thing.kind != "suitcase")
    world = world.model_copy(update={"objects": (*others, BOX)})

    async def script(run: WorldRun) -> tuple[Pose2, tuple[Contact, ...], float]:
        await run.system.clock.sleep(1.0)
        goal = START.inverse() @ GOAL
        desire = run.system.workspace.add(
            "GoTo",
            intensity=8,
            utility=1,
            params={"x": goal.x, "y": goal.y, "heading": goal.theta},
            source=Source("operator", "a test"),
        )
        nearest = math.inf
        for _ in range(400):
            await run.system.clock.sleep(0.1)
            pose = run.link.true_pose()
            nearest = min(nearest, math.dist((pose.x, pose.y), BOX.at))
            if run.system.workspace.report(desire.id).outcome is not None:
                break
        report = run.system.workspace.report(desire.id)
        assert (report.outcome, report.behavior) == ("done", "PlanAndFollowPath")
        (event,) = run.system.timeline.query(kinds=["accomplishment"])
        assert event.subject == "GoTo"
        return run.link.true_pose(), run.link.contacts, nearest

    pose, contacts, nearest = run_in_world(configuration, body, script, world=world, cameras=True)
    assert not contacts
    assert math.dist((pose.x, pose.y), (GOAL.x, GOAL.y)) <= 0.25 + 0.05
    assert abs(wrap_angle(pose.theta - GOAL.theta)) <= 0.2 + 0.02
    assert nearest < 1.2, "the box was on its way"
