"""Formats are recognised by content; a file of another kind is refused with the formats that are read."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from app.log_tools.repair import repair
from app.logs.importers.remap import Remap
from app.logs.log import LogError
from app.logs.mcap.reader import McapLog
from app.logs.open import open_log
from tests.logs.importers.bags import Sent, header, write_ros2_mcap
from tests.logs.mcap.mcap_files import drive, write_log

ODOMETRY = Sent(10**18, "/odom", "nav_msgs/msg/Odometry", {"header": header(10**18, "odom")})


def test_our_own_recording_is_ours_under_any_name(tmp_path: Path) -> None:
    log = open_log(write_log(tmp_path / "a.bag", drive(0.2)))
    assert isinstance(log, McapLog)
    log.close()


def test_our_own_recording_stays_ours_when_another_tool_copied_it(tmp_path: Path) -> None:
    log = open_log(write_log(tmp_path / "a.mcap", drive(0.2), library="mcap cli"))
    assert isinstance(log, McapLog)
    log.close()


def test_a_recording_that_was_not_closed_is_to_be_repaired(tmp_path: Path) -> None:
    path = write_log(tmp_path / "a.mcap", drive(0.2))
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(LogError, match=r"hbba log repair .*a\.mcap"):
        open_log(path)


def test_another_programs_mcap_without_its_end_is_to_be_repaired_too(tmp_path: Path) -> None:
    path = write_ros2_mcap(tmp_path / "a.mcap", [ODOMETRY])
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(LogError, match=r"hbba log repair .*a\.mcap"):
        open_log(path)
    repair(path, None, in_place=True)
    log = open_log(path)
    assert "odometry" in log.info.channels
    log.close()


def test_channels_that_have_their_names_are_not_remapped(tmp_path: Path) -> None:
    path = write_log(tmp_path / "a.mcap", drive(0.2))
    with pytest.raises(LogError, match="leave the remap file away"):
        open_log(path, Remap())


@pytest.mark.parametrize(
    "content",
    [b"hello, world\n", b"\x00" * 100, gzip.compress(b"hello\n"), b"\x1f\x8bnot packed at all", b"PK\x03\x04zip", b""],
    ids=["text", "zeros", "packed text", "bad gzip", "zip", "empty"],
)
def test_anything_else_is_an_error_that_says_what_is_read(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    with pytest.raises(LogError, match=r"a\.mcap: .*(accepted are .*CARMEN|damaged)"):
        open_log(path)


def test_a_file_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="cannot be read"):
        open_log(tmp_path / "nothing.mcap")


def test_a_folder_that_is_no_bag_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"metadata\.yaml"):
        open_log(tmp_path)
