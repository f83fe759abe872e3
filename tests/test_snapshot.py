"""What a recording carries of the program that made it."""

from __future__ import annotations

import pytest

from app import paths
from app.config import load_configuration
from app.snapshot import snapshot
from app.system import System
from tests.console.program import Body


@pytest.fixture
def lab() -> System:
    return System(load_configuration(paths.config_dir() / "lab.yaml"), link=Body())


def test_everything_needed_to_replay_is_there(lab: System) -> None:
    manifest = snapshot(lab.config, lab.graph, "IRL-1/TR")
    names = {file.name for file in manifest.files}
    assert names >= {
        "lab.yaml", "channels.yaml", "strategies/lab.yaml", "robots/irl1_tr.yaml", "robots/irl1_tr.urdf",
        "worlds/lab.yaml", "scenarios/lab.yaml",
    }  # fmt: skip
    for file in manifest.files:
        assert file.data == (paths.config_dir() / file.name).read_bytes()
    assert manifest.facts["program"] == "lab.yaml"
    assert manifest.facts["robot"] == "IRL-1/TR"
    assert manifest.facts["version"]


def test_each_stream_of_the_body_is_traced_to_its_channel(lab: System) -> None:
    facts = snapshot(lab.config, lab.graph, "").facts
    assert {key: value for key, value in facts.items() if key.startswith("stream.")} == {
        "stream.kinect": "kinect",
        "stream.imv": "imv",
        "stream.microphones": "microphones",
        "stream.hokuyo": "scan",
        "stream.odometry": "odometry",
        "stream.joints": "joints",
        "stream.status": "link_status",
    }
