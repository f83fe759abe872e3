"""Roles of modules, by the packages that they come from."""

from __future__ import annotations

import pytest

from app.program.module_meter import role_of


@pytest.mark.parametrize(
    ("python_module", "role"),
    [
        ("app.modules.sensors.kinect", "sensors"),
        ("app.modules.perception.slam.slam_2d", "perception"),
        ("app.modules.motivations.tour_guide.tour_guide", "motivations"),
        ("app.modules.behaviors.face.face", "behaviors"),
        ("app.modules.actuation.joint_control", "actuation"),
        ("app.modules.recording.recorder", "other"),
        ("hbba_example.behaviors", "behaviors"),
        ("theirs", "other"),
    ],
)
def test_the_role_is_that_of_the_package(python_module: str, role: str) -> None:
    assert role_of(python_module) == role
