"""Repair: cut a log anywhere, flip any bit of it: what is sound is kept, and nothing else happens."""

from __future__ import annotations

import io
import random
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import SeekingReader
from mcap.records import Chunk, Header, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer

from app.log_tools.repair import RepairReport, examine, repair
from app.logs.log import LogError

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND
FILES = {"lab.yaml": b"robot: robot.yaml\n", "robot.yaml": b"name: IRL-1/TR\n" * 40}

Content = list[tuple[str, int, bytes]]


@dataclass
class Made:
    """A log as bytes, with what is in it and where its chunks end."""

    data: bytes
    messages: Content
    #: Offset behind each chunk, and how many messages there are up to there.
    chunk_ends: list[tuple[int, int]] = field(default_factory=list)


def make_log(
    compression: CompressionType = CompressionType.ZSTD, chunked: bool = True, count: int = 300, finish: bool = True
) -> Made:
    """Three channels, 10 ms apart, payloads that compress as little and as much as real ones."""
    noise = random.Random(1)
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=4096, compression=compression, use_chunking=chunked)
    writer.start("ros2", "test")
    writer.add_metadata("hbba", {"robot": "IRL-1/TR"})
    for name, content in FILES.items():
        writer.add_attachment(START, START, name, "application/yaml", content)
    schema = writer.register_schema("std_msgs/msg/UInt8MultiArray", "ros2msg", b"uint8[] data")
    channels = {topic: writer.register_channel(topic, "cdr", schema, {"rate_hz": "30"}) for topic in ("/a", "/b", "/c")}
    messages: Content = []
    for index in range(count):
        topic = f"/{'abc'[index % 3]}"
        payload = noise.randbytes(noise.randrange(200)) + bytes(noise.randrange(200))
        at = START + index * SECOND // 100
        writer.add_message(channels[topic], at, payload, at - 5, index)
        messages.append((topic, at, payload))
    if finish:
        writer.finish()
    made = Made(stream.getvalue(), messages)
    if finish and chunked:
        done = 0
        for place in SeekingReader(io.BytesIO(made.data)).get_summary().chunk_indexes:
            stream.seek(place.chunk_start_offset + 9)
            chunk = Chunk.read(StreamReader(stream)._stream)
            done += sum(isinstance(record, Message) for record in breakup_chunk(chunk))
            made.chunk_ends.append((place.chunk_start_offset + place.chunk_length, done))
        assert len(made.chunk_ends) > 5
    return made


LOGS = {kind: make_log(kind) for kind in CompressionType}
KINDS = st.sampled_from(list(CompressionType))


def content(path: Path) -> Content:
    """Every message of a finished log, read by the library's own strictest reader."""
    with path.open("rb") as stream:
        reader = SeekingReader(stream, validate_crcs=True)
        assert reader.get_summary() is not None
        return [(channel.topic, message.log_time, message.data) for _, channel, message in reader.iter_messages()]


def attachments(path: Path) -> dict[str, bytes]:
    with path.open("rb") as stream:
        return {each.name: each.data for each in SeekingReader(stream).iter_attachments()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("repair")


def repaired(data: bytes, folder: Path) -> tuple[RepairReport, Path]:
    source, out = folder / "broken.mcap", folder / "out.mcap"
    source.write_bytes(data)
    return repair(source, out, force=True), out


@pytest.mark.parametrize("kind", list(CompressionType))
def test_a_healthy_log_is_left_alone(kind: CompressionType, tmp_path: Path) -> None:
    report, out = repaired(LOGS[kind].data, tmp_path)
    assert report.healthy
    assert report.out is None
    assert not out.exists()
    assert (report.messages, report.channels, report.attachments, report.losses) == (300, 3, 2, ())
    assert report.end - report.begin == pytest.approx(2.99)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(kind=KINDS, place=st.floats(0, 1, exclude_max=True))
def test_cut_anywhere_every_whole_chunk_before_the_cut_is_kept(
    folder: Path, kind: CompressionType, place: float
) -> None:
    log = LOGS[kind]
    cut = int(place * len(log.data))
    expected = max((done for end, done in log.chunk_ends if end <= cut), default=0)
    try:
        report, out = repaired(log.data[:cut], folder)
    except LogError:
        assert cut < log.chunk_ends[0][0]
        return
    assert not report.healthy
    assert report.bytes == cut
    kept = content(out)
    assert len(kept) >= expected
    # What there is of the chunk that was cut may be kept too, but nothing that was not recorded.
    assert kept == log.messages[: len(kept)]
    assert report.messages == len(kept)
    assert attachments(out).items() <= FILES.items()
    if expected:
        assert attachments(out) == FILES


@pytest.mark.slow
@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    kind=KINDS,
    flips=st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 7)), min_size=1, max_size=6),
    cut=st.none() | st.floats(0.3, 1),
)
def test_flip_any_bits_and_every_untouched_chunk_is_kept(
    folder: Path, kind: CompressionType, flips: list[tuple[float, int]], cut: float | None
) -> None:
    log = LOGS[kind]
    data = bytearray(log.data)
    places = []
    for place, bit in flips:
        at = int(place * len(data))
        data[at] ^= 1 << bit
        places.append(at)
    if cut is not None:
        del data[int(cut * len(data)) :]
    sound: Content = []
    begin, done = 0, 0
    for end, total in log.chunk_ends:
        if end <= len(data) and not any(begin <= at < end for at in places):
            sound += log.messages[done:total]
        begin, done = end, total
    try:
        report, out = repaired(bytes(data), folder)
    except LogError:
        assert not sound
        return
    kept = set(log.messages if report.healthy else content(out))
    if not any(at < log.chunk_ends[0][0] for at in places):
        assert set(sound) <= kept
    # Otherwise schema and channels, which stand in the first chunk, may be lost with it, and all messages with them.
    whole = max((end for end, _ in log.chunk_ends if end <= len(data)), default=0)
    if not any(at >= whole for at in places):  # no checksum covers the beginning of a chunk that was cut off
        assert kept <= set(log.messages)


def test_the_definitions_of_a_damaged_first_chunk_come_from_the_summary(tmp_path: Path) -> None:
    log = LOGS[CompressionType.ZSTD]
    data = bytearray(log.data)
    end, first = log.chunk_ends[0]
    data[end - 20] ^= 0xFF
    report, out = repaired(bytes(data), tmp_path)
    assert content(out) == log.messages[first:]
    (loss,) = [loss for loss in report.losses if not loss.index]
    assert loss.what == "a chunk"


def test_missing_parts_are_reported_in_bytes_and_seconds(tmp_path: Path) -> None:
    log = LOGS[CompressionType.ZSTD]
    (begin, before), (end, after) = log.chunk_ends[3:5]
    data = bytearray(log.data)
    data[end - 10] ^= 0xFF
    report, out = repaired(bytes(data), tmp_path)
    (loss,) = [loss for loss in report.losses if not loss.index]
    assert loss.seconds == pytest.approx((log.messages[after][1] - log.messages[before - 1][1]) / SECOND)
    assert report.unreadable_bytes == loss.bytes
    assert begin < loss.offset < end
    assert report.messages == 300 - (after - before) == len(content(out))


def test_a_program_killed_before_the_end_loses_nothing_that_was_written(tmp_path: Path) -> None:
    made = make_log(finish=False)
    source = tmp_path / "killed.mcap"
    source.write_bytes(made.data)
    look = examine(source)
    assert (look.finished, look.healthy, look.losses, look.ended) == (False, False, (), False)
    report = repair(source, None, in_place=True)
    assert report.out == source
    kept = content(source)
    assert kept == made.messages[: len(kept)]
    assert len(kept) > 250
    assert repair(source, None, in_place=True).healthy
    assert [each.name for each in tmp_path.iterdir()] == ["killed.mcap"]


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.floats(0.1, 1, exclude_max=True))
def test_a_log_without_chunks_is_kept_up_to_the_cut(folder: Path, place: float) -> None:
    log = make_log(chunked=False, count=60)
    cut = int(place * len(log.data))
    try:
        _, out = repaired(log.data[:cut], folder)
    except LogError:
        assert place < 0.5
        return
    kept = content(out)
    assert kept == log.messages[: len(kept)]
    assert sum(len(payload) for _, _, payload in kept) > cut - 6000


def test_damage_within_a_log_without_chunks_costs_the_message_it_hits(tmp_path: Path) -> None:
    log = make_log(chunked=False, count=60)
    target = next(message for message in log.messages[20:] if len(message[2]) > 100)
    data = bytearray(log.data)
    at = log.data.index(target[2]) - 22 - 8
    data[at + 3] ^= 0x40  # the record's length
    _, out = repaired(bytes(data), tmp_path)
    assert content(out) == [message for message in log.messages if message != target]


def test_metadata_and_profile_are_kept(tmp_path: Path) -> None:
    _, out = repaired(LOGS[CompressionType.LZ4].data[:-100], tmp_path)
    with out.open("rb") as stream:
        reader = SeekingReader(stream)
        assert [(each.name, each.metadata) for each in reader.iter_metadata()] == [("hbba", {"robot": "IRL-1/TR"})]
        assert reader.get_header() == Header("ros2", "test")
        assert {each.metadata["rate_hz"] for each in reader.get_summary().channels.values()} == {"30"}


def test_whether_all_was_written_is_known_where_the_messages_end(tmp_path: Path) -> None:
    log = LOGS[CompressionType.ZSTD]
    for data, ended in (
        (log.data, True),
        (log.data[:-100], True),  # within the summary
        (log.data[: log.chunk_ends[2][0]], False),
        (log.data[: log.chunk_ends[2][0] - 10], False),
    ):
        source = tmp_path / "broken.mcap"
        source.write_bytes(data)
        assert examine(source).ended is ended


@pytest.mark.parametrize("data", [b"", b"hello, this is no log at all", bytes(100_000), b"\x89MCAP0\r\n"])
def test_what_is_no_log_is_said_to_be_none(data: bytes, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"broken\.mcap"):
        repaired(data, tmp_path)
    assert not (tmp_path / "out.mcap").exists()


def test_an_existing_file_is_not_overwritten(tmp_path: Path) -> None:
    source, out = tmp_path / "a.mcap", tmp_path / "b.mcap"
    source.write_bytes(LOGS[CompressionType.ZSTD].data[:-100])
    out.write_bytes(b"mine")
    with pytest.raises(LogError, match="exists already"):
        repair(source, out)
    assert out.read_bytes() == b"mine"


def test_interrupted_it_leaves_no_half_file(tmp_path: Path) -> None:
    source, out = tmp_path / "a.mcap", tmp_path / "b.mcap"
    source.write_bytes(LOGS[CompressionType.ZSTD].data[:-100])

    def interrupt(done: int, total: int) -> None:
        if done > 0.8 * total:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        repair(source, out, progress=interrupt)
    assert [each.name for each in tmp_path.iterdir()] == ["a.mcap"]


def positions(calls: list[tuple[int, int]]) -> Iterator[float]:
    return (done / total for done, total in calls)


def test_progress_grows_to_the_whole(tmp_path: Path) -> None:
    source = tmp_path / "a.mcap"
    source.write_bytes(LOGS[CompressionType.ZSTD].data[:-100])
    calls: list[tuple[int, int]] = []
    repair(source, tmp_path / "b.mcap", progress=lambda done, total: calls.append((done, total)))
    shares = list(positions(calls))
    assert shares == sorted(shares)
    assert shares[-1] == 1
