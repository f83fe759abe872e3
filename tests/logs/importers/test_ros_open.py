"""Bags that are small and become gigabytes, or lead to what is no file."""

from __future__ import annotations

import os
import sqlite3
import struct
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest
import zstandard

from app.logs.importers import ros_open
from app.logs.log import LogError
from app.logs.open import open_log
from tests.logs.bombs import GIB, PACKED, put_chunk, zstd_of_zeros
from tests.logs.importers import drive
from tests.logs.importers.bags import Sent, write_ros1, write_ros2_mcap, write_ros2_sqlite


@pytest.fixture
def sent() -> list[Sent]:
    return [message for message in drive.drive() if message.topic in ("/scan", "/tf_static", "/tf", "/odom")]


def repacked(folder: Path, mode: str, pack: Callable[[bytes], bytes]) -> Path:
    """The bag at ``folder``, its messages or its files packed as rosbag2 does."""
    path = folder / "run_0.db3"
    about = (folder / "metadata.yaml").read_text()
    about = about.replace("compression_format: ''", "compression_format: zstd")
    about = about.replace("compression_mode: ''", f"compression_mode: {mode}")
    if mode == "FILE":
        (folder / "run_0.db3.zstd").write_bytes(pack(path.read_bytes()))
        path.unlink()
        about = about.replace("run_0.db3", "run_0.db3.zstd")
    else:
        with sqlite3.connect(path) as database:
            rows = database.execute("SELECT id, data FROM messages").fetchall()
            database.executemany("UPDATE messages SET data = ? WHERE id = ?", [(pack(d), n) for n, d in rows])
        database.close()
    (folder / "metadata.yaml").write_text(about)
    return folder


@pytest.mark.parametrize("mode", ["FILE", "MESSAGE"])
def test_packed_by_rosbag2(mode: str, sent: list[Sent], tmp_path: Path) -> None:
    plain = open_log(write_ros2_sqlite(tmp_path / "plain", sent))
    packed = open_log(repacked(write_ros2_sqlite(tmp_path / "packed", sent), mode, zstandard.compress))
    assert [m.at for m in packed.messages()] == [m.at for m in plain.messages()]
    assert len(list(packed.messages(channels=["scan"]))) == 80
    packed.close()
    plain.close()


def test_a_message_that_becomes_gigabytes_is_refused(sent: list[Sent], tmp_path: Path) -> None:
    bomb = zstd_of_zeros(4 * GIB)
    bag = repacked(write_ros2_sqlite(tmp_path / "run", sent), "MESSAGE", lambda data: bomb)
    with pytest.raises(LogError, match=r"run: a message, or a chunk of them, may unpack to .*; at most 256 MB"):
        open_log(bag)


def test_files_that_the_disk_has_no_room_for_are_not_unpacked(sent: list[Sent], tmp_path: Path) -> None:
    # A frame that says it holds a pebibyte, and one empty block.
    bomb = b"\x28\xb5\x2f\xfd\xc0\x88" + struct.pack("<Q", 1 << 50) + b"\x01\x00\x00"
    bag = repacked(write_ros2_sqlite(tmp_path / "run", sent), "FILE", lambda data: bomb)
    words = rf"run_0\.db3\.zstd: may unpack to 1125899\.9 GB; {tempfile.gettempdir()} has room for"
    with pytest.raises(LogError, match=words):
        open_log(bag)


@pytest.mark.parametrize("kind", PACKED)
@pytest.mark.parametrize("indexed", [True, False])
def test_a_chunk_of_mcap_that_becomes_gigabytes_is_refused(
    kind: str, indexed: bool, sent: list[Sent], tmp_path: Path
) -> None:
    bag = put_chunk(write_ros2_mcap(tmp_path / "run.mcap", sent), kind, GIB, 1_000_000, indexed=indexed)
    if not indexed:
        data = bytearray(bag.read_bytes())
        struct.pack_into("<Q", data, len(data) - 28, 0)  # no summary: all of the file is gone through
        bag.write_bytes(bytes(data))
    with pytest.raises(LogError, match=r"the chunk of messages at byte \d+ may unpack to .*; at most 256 MB"):
        open_log(bag)


@pytest.mark.parametrize("compression", ["lz4", "bz2"])
def test_a_chunk_of_ros_1_that_becomes_too_much_is_refused(
    compression: str, sent: list[Sent], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = write_ros1(tmp_path / "run.bag", sent, compression)
    monkeypatch.setattr(ros_open, "MOST_UNPACKED", 1_000)
    with pytest.raises(LogError, match=r"run\.bag: a message, or a chunk of them, .* 0\.001 MB"):
        open_log(bag)


def test_bzip2_that_is_cut_off_is_damage() -> None:
    with pytest.raises(EOFError, match="cut off"):
        ros_open._unpacked_bz2(b"BZh9")


def test_a_description_of_aliases_is_refused(sent: list[Sent], tmp_path: Path) -> None:
    bag = write_ros2_sqlite(tmp_path / "run", sent)
    lines = ["a0: &a0 {k: x}", *(f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}, *a{i - 1}]}}" for i in range(1, 30))]
    with (bag / "metadata.yaml").open("a") as file:
        file.write("\n".join(lines))
    with pytest.raises(LogError, match=r"metadata\.yaml:\d+: has more than 500,000 names and values"):
        open_log(bag)


@pytest.mark.parametrize("name", ["metadata.yaml", "run_0.db3"])
def test_a_pipe_in_a_files_place_is_refused_and_not_waited_for(name: str, sent: list[Sent], tmp_path: Path) -> None:
    bag = write_ros2_sqlite(tmp_path / "run", sent)
    (bag / name).unlink()
    os.mkfifo(bag / name)
    with pytest.raises(LogError, match="metadata" if name == "metadata.yaml" else "is a pipe, no regular file"):
        open_log(bag)
    with pytest.raises(LogError, match="cannot be read: is a pipe, no regular file"):
        open_log(bag / name)
