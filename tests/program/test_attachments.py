"""What a recording carries of the program that made it."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from app.base import paths
from app.commands.body_options import chosen
from app.logs.manifest import Manifest
from app.logs.replay.options import ReplayOptions
from app.logs.replay.replay_config import prepare
from app.program.attachments import snapshot
from app.program.config import load_configuration
from app.program.system import System
from tests.console.program import Body
from tests.logs.replay.logs import MemoryLog, lab_messages


@pytest.fixture
def lab() -> System:
    return System(load_configuration(paths.config_dir() / "lab.yaml"), link=Body())


def test_everything_needed_to_replay_is_there(lab: System) -> None:
    manifest = snapshot(lab.config, lab.graph, "IRL-1/TR")
    names = {file.name for file in manifest.files}
    assert names >= {
        "lab.yaml", "channels.yaml", "strategies/lab.yaml", "robots/irl1_tr.yaml", "robots/irl1_tr.urdf",
        "rules/lab.yaml", "worlds/lab.yaml", "scenarios/lab.yaml",
    }  # fmt: skip
    for file in manifest.files:
        assert file.data == (paths.config_dir() / file.name).read_bytes()
    assert manifest.facts["program"] == "lab.yaml"
    assert manifest.facts["robot"] == "IRL-1/TR"
    assert manifest.facts["version"]


def test_the_body_that_ran_is_recorded_though_the_program_s_file_names_another(tmp_path: Path) -> None:
    """As with `hbba run --robot my_robot.yaml --scenario trial`: replayed, it is that body again."""
    text = (paths.config_dir() / "robots" / "irl1_tr.yaml").read_text(encoding="utf-8")
    mine = tmp_path / "my_robot.yaml"
    for key in ("model", "world", "scenario"):
        file = next(
            line.split(":")[1].split("#")[0].strip() for line in text.splitlines() if line.startswith(f"{key}:")
        )
        text = text.replace(f"{key}: {file}", f"{key}: {(paths.config_dir() / 'robots' / file).resolve()}")
    mine.write_text(text.replace("name: IRL-1/TR", "name: Mine"), encoding="utf-8")
    configuration, body = chosen(
        argparse.Namespace(robot=mine, config=None, scenario="trial", camera=None, microphones=None)
    )
    manifest = System(configuration, link=Body(), body=body).graph.modules["Recorder"].module.service(Manifest)
    names = {file.name for file in manifest.files}
    assert names >= {"scenarios/trial.yaml", "robots/irl1_tr.yaml"}
    assert manifest.facts["scenario"] == "scenarios/trial.yaml"
    program = prepare(MemoryLog(lab_messages(1.0), manifest), ReplayOptions(), tmp_path / "replayed")
    assert program.configuration.path(program.configuration.program.robot).read_bytes() == mine.read_bytes()


def test_each_stream_of_the_body_is_traced_to_its_channel(lab: System) -> None:
    facts = snapshot(lab.config, lab.graph, "").facts
    assert {key: value for key, value in facts.items() if key.startswith("stream.")} == {
        "stream.kinect": "kinect",
        "stream.panorama": "panorama",
        "stream.microphones": "microphones",
        "stream.loudspeaker": "played_sound",
        "stream.hokuyo": "scan",
        "stream.battery": "battery",
        "stream.odometry": "odometry",
        "stream.joints": "joints",
        "stream.status": "link_status",
    }
