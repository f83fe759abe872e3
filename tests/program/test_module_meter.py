"""Roles of modules, by the packages that they come from."""

from __future__ import annotations

import pytest

from app.program.module_meter import role_of
from app.runtime.module import Module


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
    assert role_of(type("Tested", (Module,), {"__module__": python_module})) == role


def test_a_module_may_name_its_role() -> None:
    assert role_of(type("Tested", (Module,), {"__module__": "theirs.sensors", "role": "perception"})) == "perception"
