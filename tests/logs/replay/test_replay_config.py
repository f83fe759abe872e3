"""The program put together for a log: its own, less what the log has nothing for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.logs.log import Logged
from app.logs.manifest import Manifest
from app.logs.replay.options import ReplayOptions
from app.logs.replay.replay import Replay
from app.logs.replay.replay_config import prepare
from app.messages import LaserScan, Odometry
from app.runtime.clock import VirtualClock
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_log, lab_messages, numbered


def scans_alone() -> MemoryLog:
    """What a CARMEN log gives: odometry and scans, nothing attached."""
    kept = [logged for logged in lab_messages(2.0) if isinstance(logged.message, Odometry | LaserScan)]
    return MemoryLog(kept)


def test_a_recording_brings_its_own_program(tmp_path: Path) -> None:
    program = prepare(lab_log(), ReplayOptions(), tmp_path)
    assert program.configuration.program_document.file.startswith(str(tmp_path))
    assert program.streams == {
        "kinect": "kinect", "hokuyo": "scan", "odometry": "odometry", "joints": "joints", "status": "link_status",
    }  # fmt: skip
    assert program.description.name == "IRL-1/TR"
    assert program.description.model_path.is_relative_to(tmp_path)
    assert program.description.limits.linear_mps == 0.4
    assert not program.description.simulated
    assert program.left_out == {
        "Recorder": "not asked for",
        "PanoramicCamera": "the log has no panorama",
        "Microphones": "the log has no microphones",
        "Battery": "the log has no battery",
    }
    assert program.fed == ("teleop_command",)
    assert set(program.silent.values()) == {"panorama", "microphones", "battery"}


def test_what_the_log_has_nothing_for_stays_out(tmp_path: Path) -> None:
    program = prepare(scans_alone(), ReplayOptions(), tmp_path)
    assert program.left_out["Kinect"] == "the log has no kinect"
    assert program.left_out["WheelOdometry"] == "the log has no joints"
    assert program.left_out["MobileBaseControl"] == "the log has no status"
    # Its module is out, its channel comes from the log.
    assert program.fed == ("odometry",)
    assert program.silent["QRCodeDetector.images"] == "kinect"
    assert program.configuration.channels["kinect"].external


def test_only_some_modules_get_the_rest_from_the_log(tmp_path: Path) -> None:
    program = prepare(lab_log(), ReplayOptions(only=("QRCodeDetector",)), tmp_path)
    assert list(program.configuration.program.modules) == ["QRCodeDetector"]
    assert set(program.fed) == {"kinect", "scan", "odometry", "joints", "link_status", "teleop_command"}


def test_a_module_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no module 'QrCodeDetector'; did you mean 'QRCodeDetector'"):
        prepare(lab_log(), ReplayOptions(only=("QrCodeDetector",)), tmp_path)


def test_a_log_for_which_nothing_can_run(tmp_path: Path) -> None:
    log = MemoryLog([Logged(BEGIN, "joints_of_another", message.message) for message in numbered(1)])
    with pytest.raises(ConfigError, match=r"no module of this program can run on it .*Kinect: the log has no kinect"):
        prepare(log, ReplayOptions(only=("Kinect",)), tmp_path)


def test_another_program_on_the_same_log(tmp_path: Path) -> None:
    program = prepare(lab_log(), ReplayOptions(config=paths.config_dir() / "lab.yaml"), tmp_path)
    assert program.configuration.program_document.file == str(paths.config_dir() / "lab.yaml")


def test_a_channel_that_carries_something_else_is_not_fed(tmp_path: Path) -> None:
    messages = [Logged(logged.at, "teleop_command", logged.message) for logged in numbered(5)] + numbered(5)
    log = MemoryLog(sorted(messages, key=lambda logged: logged.at))
    program = prepare(log, ReplayOptions(only=("Teleop",)), tmp_path)
    assert "teleop_command" not in program.fed


@contextmanager
def built(log: MemoryLog, options: ReplayOptions | None = None) -> Iterator[Replay]:
    replay = Replay(log, VirtualClock(BEGIN), options)
    yield replay
    replay.close()


def test_strategies_lose_what_is_not_there() -> None:
    with built(lab_log()) as replay:
        table = replay.system.table
    assert "Record" not in table.classes
    assert table["telepresence-2"].filters == {"CameraStream.images": 2, "PointCloudBuilder.images": 2}
    with built(lab_log(), ReplayOptions(only=("CameraStream",))) as alone:
        table = alone.system.table
        assert alone.notes() == []
    assert table["telepresence-2"].filters == {"CameraStream.images": 2}
    assert table.classes == ("Telepresence",)


def test_modules_that_would_hear_nothing_stay_out_with_their_strategies() -> None:
    with built(scans_alone()) as replay:
        notes, table = replay.notes(), replay.system.table
        running = set(replay.system.graph.modules)
        name = replay.system.link.description.name
    for module, channels in (
        ("QRCodeDetector", "kinect and no panorama"),
        ("FaceDetector", "kinect and no panorama"),
        ("CameraStream", "kinect"),
        ("PanoramaStream", "panorama"),
        ("PointCloudBuilder", "kinect"),
    ):
        assert f"{module} does not run: the log has no {channels}" in notes
    deaf = [note for note in notes if "gets nothing" in note]
    assert "ScenarioCoordinator.loud_noises gets nothing: the log has no loud_noises" in deaf
    some = (
        "EpisodicMemory.",
        "PerceptEvents.",
        "PersonTracker.",
        "ScenarioCoordinator.",
        "PlaceKeeper.landmarks ",
        "SLAM2D.landmark_poses ",
        "TourGuide.",
        "Follow.",
        "PlanAndFollowPath.images ",
        "PlanAndFollowPath.base ",
        "LookA",
        "LookWhereGoing.",
        "Curiosity.base ",
        "HeadControl.track_",
        "HeadTeleop.",
        "HeadControl.salient ",
        "EgoSphere.",
        "GazeAtSalient.",
        "Track",
        "PlanAndFollowPath.joints ",
        "PointAt.joints ",
        "Reach.joints ",
        "Wave.joints ",
        "Rest.joints ",
        "Hold.joints ",
        "Release.joints ",
        "LeftArmControl.joints ",
        "RightArmControl.joints ",
        "Face.",
        "ProgressSupervisor.exp",
        "Say.sources ",
        "Docking.battery ",
        "Recharge.battery ",
    )
    assert [note for note in deaf if not note.startswith(some)] == []
    # What people feed may come or not, and what is desired may be desired in vain.
    assert {"Teleop", "ScenarioCoordinator"} <= running
    assert not {"FindQRCodes", "Telepresence"} & set(table.classes)
    assert name == "memory.mcap (memory)"


def test_a_module_alone_that_would_hear_nothing_is_refused() -> None:
    with pytest.raises(ConfigError, match="QRCodeDetector: the log has no kinect and no panorama"):
        Replay(scans_alone(), VirtualClock(BEGIN), ReplayOptions(only=("QRCodeDetector",))).close()


@pytest.mark.parametrize(
    ("phi", "words"),
    [
        ({"QRCodeDetector.image": 2.0}, "no filter 'QRCodeDetector.image'"),
        ({"QRCodeDetector.images": 0.5}, "divisor"),
        (
            {"QRCodeDetector.odometry": 2.0},
            "channel of QRCodeDetector.odometry may not be decimated: 1 or",
        ),
    ],
)
def test_a_filter_that_cannot_be_held(phi: dict[str, float], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        Replay(lab_log(), VirtualClock(BEGIN), ReplayOptions(phi=phi))


def test_a_log_that_would_write_elsewhere_is_refused(tmp_path: Path) -> None:
    from app.logs.log import LogError
    from app.logs.manifest import AttachedFile

    evil = Manifest((AttachedFile("/tmp/evil.yaml", "application/yaml", b""),), {"program": "lab.yaml"})
    with pytest.raises(LogError, match="no relative path"):
        prepare(MemoryLog(numbered(3), evil), ReplayOptions(), tmp_path)


def test_closed_is_a_divisor_too() -> None:
    with built(lab_log(), ReplayOptions(phi={"QRCodeDetector.images": math.inf})) as replay:
        assert replay.system.graph.filters.divisors()["QRCodeDetector.images"] == math.inf
