"""The program of a rehearsal: what runs in it, what stands in for what, and what is left out."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.link import RobotDescription
from app.program.config import Configuration, load_configuration
from app.program.desire_classes import desire_classes
from app.rehearsal.configuration import rehearsed
from app.robots.config import StartPose, load_robot_config
from app.robots.simulated.kinematic.config import kinematic_of
from app.robots.simulated.kinematic.link import describe


@cache
def lab() -> Configuration:
    return load_configuration(paths.config_dir() / "lab.yaml")


@cache
def body() -> RobotDescription:
    robot = load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")
    return describe(kinematic_of(robot, Path("map.yaml"), StartPose()))


@cache
def program() -> Configuration:
    return rehearsed(lab(), body(), "room")


def test_what_needs_pictures_sound_or_a_charger_is_left_out() -> None:
    left_out = lab().program.modules.keys() - program().program.modules.keys()
    assert left_out >= {"Kinect", "PanoramicCamera", "Microphones", "Battery", "Recorder", "Docking", "Recharge"}
    kept = program().program.modules
    assert kept.keys() >= {"PlanAndFollowPath", "MobileBaseControl", "Say", "LookAt", "PointAt", "ProgressSupervisor"}
    assert "images" in lab().program.modules["PlanAndFollowPath"].inputs
    assert "images" not in kept["PlanAndFollowPath"].inputs


def test_the_truth_stands_in_under_the_names_that_strategies_know() -> None:
    modules = program().program.modules
    assert modules["SLAM2D"].class_path.endswith(":TrueLocalization")
    assert modules["SLAM2D"].settings == {"map": "room"}
    robots = lab().program.modules["SLAM2D"].outputs
    assert modules["SLAM2D"].outputs.items() == {
        each for each in robots.items() if each[0] not in ("keyframes", "confidence")
    }
    assert program().channels["keyframes"].external, "no keyframes move on a map that stays as it is"
    assert modules["FaceDetector"].class_path.endswith(":TrueFaces")
    assert modules["FaceDetector"].inputs == {"images": "kinect", "panorama": "panorama", "map": "map"}
    assert modules["Say"].settings["engine"] == {"engine": "text"}


def test_what_attention_can_choose_runs_and_gets_nothing() -> None:
    kept = program().program.modules
    assert kept.keys() >= {"VoiceLocalizer", "WordRecognizer", "QRCodeDetector", "LoudNoiseDetector"}
    assert kept["VoiceLocalizer"].inputs == lab().program.modules["VoiceLocalizer"].inputs
    before, after = desire_classes(lab()), desire_classes(program())
    assert before.keys() == after.keys()


def test_channels_without_a_producer_are_silent_and_others_come_at_the_bodys_rates() -> None:
    channels = program().channels
    assert channels["kinect"].external
    assert channels["kinect"].rate_hz is None
    assert channels["odometry"].rate_hz == 20
    assert channels["scan"].rate_hz == 40
    assert not channels["localization"].external


def test_modules_can_be_left_out_by_name_and_a_wrong_name_is_refused() -> None:
    assert "ScenarioCoordinator" not in rehearsed(lab(), body(), "room", ("ScenarioCoordinator",)).program.modules
    with pytest.raises(ConfigError, match="did you mean 'ScenarioCoordinator'"):
        rehearsed(lab(), body(), "room", ("ScenarioCoordinater",))


def test_a_program_that_knows_no_map_is_refused() -> None:
    modules = {name: spec for name, spec in lab().program.modules.items() if name != "SLAM2D"}
    lost = replace(lab(), program=lab().program.model_copy(update={"modules": modules}))
    with pytest.raises(ConfigError, match="knows no map"):
        rehearsed(lost, body(), "room")
