"""Which topic is meant: guessed where only one can be, asked where several can, said by a remap file."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.base.errors import ConfigError
from app.cli import main
from app.commands.check import check_file
from app.commands.log_report import look_into
from app.logs.importers.remap import RemapError, load_remap
from app.logs.log import Log, LogError
from app.logs.open import open_log
from app.messages import Image, LaserScan, Odometry, Twist
from tests.logs.importers import drive
from tests.logs.importers.bags import Sent, header, write_ros1, write_ros2_mcap

EXAMPLES = sorted((Path(__file__).parents[3] / "docs" / "examples").glob("remap-*.yaml"))


def opened(folder: Path, sent: list[Sent], remap: str | None = None) -> Log:
    path = folder / "run.mcap"
    if not path.exists():
        write_ros2_mcap(path, sent)
    return open_log(path, None if remap is None else load_remap(written(folder, remap)))


def written(folder: Path, text: str) -> Path:
    file = folder / "remap.yaml"
    file.write_text(text)
    return file


def renamed(sent: list[Sent], change: Callable[[str], str]) -> list[Sent]:
    return [replace(message, topic=change(message.topic)) for message in sent]


def without(sent: list[Sent], *topics: str) -> list[Sent]:
    return [message for message in sent if message.topic not in topics]


def short() -> list[Sent]:
    """The drive, with pictures of its first second only."""
    return [message for message in drive.drive() if message.at < drive.ns(1.0) or "camera" not in message.topic]


def test_two_lasers_are_a_question_that_answers_itself(tmp_path: Path) -> None:
    sent = short()
    both = sent + renamed([m for m in sent if m.topic == "/scan"], lambda _: "/scan_rear")
    with pytest.raises(LogError, match=r"2 topics could be the channel 'scan': /scan, /scan_rear") as question:
        opened(tmp_path, both)
    proposal = re.search(r"channels:\n(?:  .*\n)+", str(question.value))
    assert proposal is not None
    log = opened(tmp_path, both, proposal[0])
    assert set(log.info.channels) == {"kinect", "scan", "odometry", "joints"}
    assert "/scan_rear" in log.info.ignored
    log.close()


def test_two_cameras_are_a_question_but_two_transports_of_one_are_not(tmp_path: Path) -> None:
    sent = short()
    packed = [m for m in drive.drive(compressed=True) if "compressed" in m.topic and m.at < drive.ns(1.0)]
    log = opened(tmp_path, sent + packed)
    assert log.info.channels["kinect"].count == 10
    assert "another topic serves" in log.info.ignored["/camera/rgb/image_raw/compressed"]
    log.close()
    other = tmp_path / "other"
    other.mkdir()
    left = renamed([m for m in sent if m.topic == "/camera/rgb/image_raw"], lambda _: "/left/image_raw")
    with pytest.raises(LogError, match=r"'kinect': /camera/rgb/image_raw, /left/image_raw"):
        opened(other, sent + left)


def test_of_two_cameras_the_one_with_a_depth_of_its_own_is_the_first_guess(tmp_path: Path) -> None:
    sent = short()
    panorama = renamed([m for m in sent if m.topic == "/camera/rgb/image_raw"], lambda _: "/a_panorama/image_raw")
    panorama = [replace(m, fields={**m.fields, "header": header(m.at, "panorama")}) for m in panorama]
    with pytest.raises(LogError, match=r"'kinect': /camera/rgb/image_raw, /a_panorama/image_raw") as question:
        opened(tmp_path, panorama + sent)
    proposal = re.search(r"channels:\n(?:  .*\n)+", str(question.value))
    assert proposal is not None
    assert "kinect: {color: /camera/rgb/image_raw, depth: /camera/depth_registered/image_raw" in proposal[0]
    other = tmp_path / "other"
    other.mkdir()
    apart = [m for m in panorama + sent if m.topic != "/camera/rgb/image_raw"]
    left = renamed(list(panorama), lambda _: "/left/image_raw")
    with pytest.raises(LogError, match="2 topics") as question:
        opened(other, apart + left)
    assert "depth:" not in str(question.value), "a depth image of neither camera belongs to no channel"


@pytest.mark.parametrize("as_json", [True, False])
def test_the_content_of_a_bag_is_shown_before_its_topics_are_assigned(
    as_json: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sent = short()
    both = sent + renamed([m for m in sent if m.topic == "/scan"], lambda _: "/scan_rear")
    path = write_ros1(tmp_path / "run.bag", both)
    assert main(["log", "info", str(path), *["--json"] * as_json]) == 0
    text = capsys.readouterr().out
    if as_json:
        contents = json.loads(text)
        text = contents["undecided"]
        assert contents["duration_s"] == pytest.approx(look_into(path).duration_s)
        assert contents["ignored"]["/scan_rear"] == "sensor_msgs/msg/LaserScan, in laser, 80 messages"
        assert contents["ignored"]["/camera/rgb/image_raw"].startswith("sensor_msgs/msg/Image, in color, in ")
    else:
        assert "\n  /scan_rear: sensor_msgs/msg/LaserScan, in laser, 80 messages\n" in text
        assert "\n2 topics could be the channel 'scan'" in text
    remap = re.search(r"channels:\n(?:  .*\n)+", text)
    assert remap is not None
    assert main(["log", "info", str(path), "--remap", str(written(tmp_path, remap[0]))]) == 0


def test_a_remap_file_names_channels_as_it_likes(tmp_path: Path) -> None:
    log = opened(
        tmp_path,
        short(),
        "channels:\n"
        "  front_scan: {topic: /scan}\n"
        "  odometry: {tf: odom -> base_link}\n"
        "  asked_twist: {topic: /cmd_vel}\n",
    )
    assert {name: channel.message_type for name, channel in log.info.channels.items()} == {
        "front_scan": LaserScan, "odometry": Odometry,
    } | ({"asked_twist": Twist})  # fmt: skip
    assert log.manifest.facts == {"stream.odometry": "odometry"}
    assert "which no channel of the remap file names" in log.info.ignored["/odom"]
    log.close()


def test_frames_may_have_other_names(tmp_path: Path) -> None:
    sent = drive.drive(odometry=False)
    names = {"odom": "wheels", "base_link": "torso"}
    other = [
        replace(m, fields={"transforms": [with_frames(t, names) for t in m.fields["transforms"]]})
        if "tf" in m.topic
        else m
        for m in sent
    ]
    log = opened(tmp_path, other, "frames: {base: torso, odom: wheels}\n")
    assert log.info.notes == ()
    assert "odometry" in log.info.channels
    first = next(log.messages(channels={"scan"})).message
    np.testing.assert_allclose(first.X_BL.translation, drive.X_BL.translation, atol=1e-12)
    log.close()


def with_frames(transform: dict, names: dict[str, str]) -> dict:  # type: ignore[type-arg]
    head = transform["header"]
    parent, child = (names.get(n, n) for n in (head["frame_id"], transform["child_frame_id"]))
    return {**transform, "header": {**head, "frame_id": "/" + parent}, "child_frame_id": child}


def test_without_tf_sensors_are_where_the_remap_file_says_or_else_a_note(tmp_path: Path) -> None:
    sent = without(short(), "/tf", "/tf_static")
    log = opened(tmp_path, sent)
    assert len(log.info.notes) == 2
    assert "X_BL in a remap file" in " ".join(log.info.notes)
    assert look_into(tmp_path / "run.mcap").notes == log.info.notes
    image: Image = next(log.messages(channels={"kinect"})).message
    np.testing.assert_allclose(image.X_BC.rotation @ [0, 0, 1], [1, 0, 0], atol=1e-9)  # it looks ahead
    np.testing.assert_allclose(image.X_BC.rotation @ [0, -1, 0], [0, 0, 1], atol=1e-9)  # and is upright
    log.close()
    log = opened(
        tmp_path,
        sent,
        "channels:\n"
        "  kinect: {color: /camera/rgb/image_raw, X_BC: {xyz: [0.1, 0, 1.2], rpy_deg: [-90, 0, -90]}}\n"
        "  scan: {topic: /scan, X_BL: {xyz: [0.3, 0, 0.4]}}\n",
    )
    assert not [note for note in log.info.notes if "tf" in note]
    image = next(log.messages(channels={"kinect"})).message
    assert image.depth is None
    np.testing.assert_allclose(image.X_BC.transform(np.array([0.0, 0.0, 1.0])), [1.1, 0, 1.2], atol=1e-9)
    scan = next(log.messages(channels={"scan"})).message
    np.testing.assert_allclose(scan.X_BL.translation, [0.3, 0, 0.4])
    log.close()


def test_a_camera_that_tf_lacks_is_placed_on_the_neck_that_moves(tmp_path: Path) -> None:
    sent = [
        message
        if message.topic != "/tf_static"
        else replace(
            message,
            fields={"transforms": [t for t in message.fields["transforms"] if t["child_frame_id"] != drive.OPTICAL]},
        )
        for message in short()
    ]
    remap = "channels: {kinect: {color: /camera/rgb/image_raw, X_BC: {frame: %s, xyz: [0.05, 0.02, 0], "
    remap += "rpy_deg: [-90, 0, -90]}}}\n"
    log = opened(tmp_path, sent, remap % "neck")
    images = [logged.message for logged in log.messages(channels={"kinect"})]
    assert len(images) > 5
    for image in images[1:]:
        np.testing.assert_allclose(image.X_BC.rotation, drive.camera_at(image.stamp).rotation, atol=0.02)
        np.testing.assert_allclose(image.X_BC.translation, drive.camera_at(image.stamp).translation, atol=0.02)
    turned = images[1].X_BC.rotation[:, 2] @ images[-1].X_BC.rotation[:, 2]
    assert turned < math.cos(0.2), "the neck did not turn"
    log.close()
    with pytest.raises(RemapError, match=r"where 'tail' is in 'base_link'.*frames of tf: base_link"):
        opened(tmp_path, sent, remap % "tail")


def test_a_depth_without_a_colour_is_no_camera(tmp_path: Path) -> None:
    log = opened(tmp_path, without(short(), "/camera/rgb/image_raw"))
    assert "kinect" not in log.info.channels
    assert "no colour picture" in log.info.ignored["/camera/depth_registered/image_raw"]
    log.close()


def test_an_unregistered_depth_is_said(tmp_path: Path) -> None:
    sent = renamed(short(), lambda topic: topic.replace("depth_registered", "depth"))
    depth = [
        replace(m, fields={**m.fields, "header": {**m.fields["header"], "frame_id": "camera_depth_optical_frame"}})
        if m.topic == "/camera/depth/image_raw" else m
        for m in sent
    ]  # fmt: skip
    log = opened(tmp_path, depth)
    assert any("not to be registered" in note for note in log.info.notes)
    log.close()


def test_a_picture_whose_depth_was_lost_has_none_measured(tmp_path: Path) -> None:
    sent = drive.drive()
    depths = [m for m in sent if m.topic == "/camera/depth_registered/image_raw"]
    log = opened(tmp_path, [m for m in sent if m is not depths[7]])
    images = [m.message for m in log.messages(channels={"kinect"})]
    assert [i for i, image in enumerate(images) if not image.depth.any()] == [7]
    log.close()


def test_a_message_that_cannot_be_read_is_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    sent = short()
    number = next(i for i, m in enumerate(sent) if m.topic == "/camera/rgb/image_raw" and m.at > drive.ns(0.5))
    sent[number] = replace(sent[number], fields={**sent[number].fields, "data": np.zeros(10, np.uint8)})
    log = opened(tmp_path, sent)
    assert len(list(log.messages(channels={"kinect"}))) == 9
    assert "a message is left out" in caplog.text
    log.close()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("channels:\n  scan: {topic: /scn}\n", r"remap\.yaml:2: the bag has no topic '/scn'; did you mean '/scan'"),
        ("channels:\n  scan: {topic: /battery}\n", r":2: /battery .* of no type that becomes a channel"),
        ("channels:\n  kinect:\n    color: /camera/depth_registered/image_raw\n", r":3: .*no colour image"),
        ("channels:\n  kinect: {color: /camera/rgb/image_raw, info: /odom}\n", r":2: .*no CameraInfo"),
        ("channels:\n  odometry: {topic: /odom, X_BL: {xyz: [0, 0, 0]}}\n", r":2: X_BL places a laser"),
        ("channels:\n  scan: {topic: /scan, tf: odom -> base}\n", r":2: .*exactly one of"),
        ("channels:\n  scan: {topic: /scan, depth: /d}\n", r":2: .*depth only goes with `color`"),
        ("channels:\n  odometry: {tf: odom}\n", r":2: .*odom -> base_link"),
        ("channels:\n  scan: {topik: /scan}\n", r":2: .*did you mean 'topic'"),
        ("frames: {base: 3}\n", r":1: frames\.base"),
    ],
)
def test_mistakes_in_a_remap_file_are_said_with_their_line(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        opened(tmp_path, short(), text)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_hbba_check_knows_remap_files(example: Path) -> None:
    assert check_file(example) == ("remap", ())


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 2


def test_a_bag_without_anything_to_read_says_what_it_holds(tmp_path: Path) -> None:
    battery = [m for m in drive.drive() if m.topic == "/battery"]
    with pytest.raises(LogError, match="it holds sensor_msgs/msg/BatteryState"):
        opened(tmp_path, battery)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_a_damaged_bag_is_an_error_in_words(tmp_path: Path, share: float) -> None:
    path = write_ros1(tmp_path / "a.bag", short())
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(LogError, match=r"a\.bag: "):
        open_log(path)


def test_damage_inside_is_an_error_where_it_is_met(tmp_path: Path) -> None:
    path = write_ros2_mcap(tmp_path / "a.mcap", drive.drive())
    data = bytearray(path.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 2000] = bytes(2000)
    path.write_bytes(data)
    with pytest.raises(LogError, match=r"a\.mcap: is damaged"):
        list(open_log(path).messages())
