"""A desire to look at a point, through the whole program and the guard to the head of the simulated robot."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from app.attention.desires import Source
from app.attention.outcome import outcome_of
from app.base import paths
from app.base.kinematic_model import load_model
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import JointState, Twist
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body

EYE = "kinect_optical_frame"
ME = Source("operator", "a test")


@pytest.mark.slow
def test_the_camera_looks_at_points_within_two_degrees_and_the_head_stays_within_its_limits() -> None:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    body = body.model_copy(update={"scenario": None})
    head = body.groups["head"]
    model = load_model(body.model)

    def true_angle_deg(run: WorldRun, p_WP: NDArray[np.float64]) -> float:
        simulation = run.link._simulation
        assert simulation is not None
        physics = simulation.physics
        joints = dict(zip(physics.joints, physics.joint_positions().tolist(), strict=True))
        X_WE = physics.true_pose().to_pose3() @ model.pose(EYE, joints)
        x, y, z = X_WE.inverse().transform(p_WP)
        return math.degrees(math.atan2(math.hypot(x, y), z))

    def in_world(run: WorldRun, frame: str, point: list[float]) -> NDArray[np.float64]:
        X_WF = run.link.true_pose() if frame == "base_link" else run.link.start_pose
        return np.asarray(X_WF.to_pose3().transform(np.array(point)))

    async def script(run: WorldRun) -> tuple[dict[str, float], list[Any], list[JointState]]:
        system, angles = run.system, {}
        moved: list[JointState] = []
        run.link.attach("joints", moved.append)
        await system.clock.sleep(1.0)

        def look(frame: str, point: list[float]) -> str:
            params = dict(zip("xyz", point, strict=True)) | {"frame": frame}
            return system.workspace.add("LookAt", intensity=8, utility=1, params=params, source=ME).id

        for frame, point in (
            ("base_link", [1.5, 1.5, 0.9]),
            ("base_link", [0.5, -2.0, 1.8]),
            ("odom", [3.0, -1.0, 1.2]),
        ):
            desire = look(frame, point)
            report = await outcome_of(system.workspace, desire)
            assert (report.outcome, report.behavior, report.ended) == ("done", "LookAt", None)
            assert true_angle_deg(run, in_world(run, frame, point)) < 3.0, "the head still comes to rest"
            await system.clock.sleep(4.0)
            assert desire in system.exploited()
            angles[f"{frame} {point}"] = true_angle_deg(run, in_world(run, frame, point))
            if frame == "odom":
                for _ in range(30):  # the base turns, the head keeps to the point
                    run.link.command(Twist(system.clock.now(), 0.0, 0.3))
                    await system.clock.sleep(0.1)
                await system.clock.sleep(1.0)
                angles["after a turn"] = true_angle_deg(run, in_world(run, frame, point))
                assert abs(run.link.true_pose().theta - run.link.start_pose.theta) > 0.5
            system.workspace.remove(desire)
            await system.clock.sleep(1.0)
            assert desire not in system.exploited()
        assert len(system.timeline.query(kinds=["accomplishment"])) == 3
        exploitation = system.timeline.query(kinds=["exploitation"])
        events = [(event.text, event.data["classes"]) for event in exploitation if event.subject == "LookAt"]
        return angles, events, moved

    angles, events, moved = run_in_world(configuration, body, script)
    assert all(angle < 2.0 for angle in angles.values()), angles
    assert [text for text, _ in events] == ["LookAt moves the head", "LookAt moves the head no more"] * 3
    assert events[0][1] == ["LookAt"]
    for joint in head.joints:
        positions = np.array([message.positions[message.names.index(joint.name)] for message in moved])
        stamps = np.array([message.stamp for message in moved])
        noise = 4 * body.streams.joints.noise_rad
        assert positions.min() >= joint.lower - noise
        assert positions.max() <= joint.upper + noise
        # The servo follows set-points of limited speed; twice the noise of a position in a thirtieth of a second.
        assert np.abs(np.diff(positions) / np.diff(stamps)).max() <= joint.velocity + 2 * noise * 30
