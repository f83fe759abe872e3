"""Files by their chunks: completed wherever they end, joined without a byte of a message changed."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from app.logs.log import LogError
from app.logs.manifest import Manifest
from app.logs.mcap.chunks import ChunkSpan, complete, join, scan
from app.logs.mcap.open_file import FileTopic, McapFile
from tests.logs.mcap.disks import BEGIN, MANIFEST, encoder, image, landmarks, odometry

Read = list[tuple[str, int, bytes]]


def write(
    path: Path, begin: int, count: int, topics: dict[str, FileTopic] | None = None, *, manifest: Manifest
) -> Path:
    """Odometry, and now and then something else, in chunks of three."""
    file = McapFile(path, encoder(), manifest, BEGIN, {} if topics is None else topics)
    for i in range(begin, begin + count):
        file.write(BEGIN + i, "odometry", odometry(BEGIN + i))
        if i % 5 == 4:
            file.write(BEGIN + i, "kinect", image(BEGIN + i, seed=i))
        if i % 7 == 6:
            file.write(BEGIN + i, "landmarks", landmarks(BEGIN + i, f"code {i}"))
        if i % 3 == 2:
            file.flush()
    file.close()
    return path


def read(path: Path) -> Read:
    """Everything in it, through its summary and indexes, by an independent reader that checks every CRC."""
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        found = [(channel.topic, m.log_time, m.data) for _, channel, m in reader.iter_messages(log_time_order=False)]
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == len(found)
        assert summary.statistics.chunk_count == len(summary.chunk_indexes)
        assert {c.schema_id for c in summary.channels.values()} <= summary.schemas.keys()
    return found


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, Read, list[ChunkSpan]]:
    """A file's bytes, what is in it, and its chunks."""
    path = write(tmp_path_factory.mktemp("whole") / "log.mcap", 0, 30, manifest=MANIFEST)
    with open(path, "rb") as file:
        chunks = scan(file).chunks
    return path.read_bytes(), read(path), chunks


@settings(max_examples=150)
@given(data=st.data())
def test_a_file_that_ends_anywhere_is_completed_up_to_its_last_whole_chunk(
    whole: tuple[bytes, Read, list[ChunkSpan]], tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    content, messages, chunks = whole
    end = data.draw(st.integers(chunks[0].offset, len(content)))
    path = tmp_path_factory.mktemp("cut") / "log.mcap"
    path.write_bytes(content[:end])
    complete(path)
    kept = [chunk for chunk in chunks if chunk.offset + chunk.length <= end]
    assert read(path) == messages[: sum(sum(chunk.counts.values()) for chunk in kept)]
    if end == len(content):
        assert path.read_bytes() == content


def test_completing_twice_changes_nothing(whole: tuple[bytes, Read, list[ChunkSpan]], tmp_path: Path) -> None:
    content, _, _ = whole
    path = tmp_path / "log.mcap"
    path.write_bytes(content[: 2 * len(content) // 3])
    complete(path)
    once = path.read_bytes()
    complete(path)
    assert path.read_bytes() == once


def test_joined_files_hold_what_each_held_in_their_order(tmp_path: Path) -> None:
    topics: dict[str, FileTopic] = {}
    parts = [
        write(tmp_path / "1.mcap", 0, 4, topics, manifest=MANIFEST),  # knows only odometry
        write(tmp_path / "2.mcap", 4, 20, topics, manifest=Manifest()),
        write(tmp_path / "3.mcap", 24, 9, topics, manifest=Manifest()),
    ]
    with open(tmp_path / "all.mcap", "xb") as file:
        count = join(parts, file)
    joined = read(tmp_path / "all.mcap")
    assert joined == [message for part in parts for message in read(part)]
    assert count == len(joined)
    with open(tmp_path / "all.mcap", "rb") as file:
        reader = make_reader(file)
        assert [a.name for a in reader.iter_attachments()] == ["lab.yaml"]
        assert [m.metadata["robot"] for m in reader.iter_metadata()] == ["a test body"]


def test_a_part_without_its_end_is_joined_too(tmp_path: Path) -> None:
    topics: dict[str, FileTopic] = {}
    parts = [
        write(tmp_path / "1.mcap", 0, 10, topics, manifest=MANIFEST),
        write(tmp_path / "2.mcap", 10, 10, topics, manifest=Manifest()),
    ]
    content = parts[1].read_bytes()
    parts[1].write_bytes(content[: len(content) // 2])
    with open(tmp_path / "all.mcap", "xb") as file:
        join(parts, file)
    joined, first = read(tmp_path / "all.mcap"), read(parts[0])
    assert joined[: len(first)] == first
    assert len(joined) > len(first)


@pytest.mark.parametrize("content", [b"", b"#ROSBAG V2.0\n", b"\x89MCAP"])
def test_what_is_no_mcap_file_is_said_to_be_none(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    with pytest.raises(LogError, match="is not an MCAP file"):
        complete(path)
    assert path.read_bytes() == content
