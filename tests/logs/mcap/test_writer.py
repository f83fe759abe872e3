"""The writer: every message is in the file, and no fault of a disk reaches its caller."""

from __future__ import annotations

import errno
import os
import re
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Statistics

from app.logs.mcap.disk_time import DiskTime
from app.logs.mcap.file_sink import FileSink
from app.logs.mcap.open_file import is_being_written
from app.logs.mcap.ring import HeldSegments, Ring
from app.logs.mcap.ring_folder import leftovers, rescue
from app.logs.mcap.writer import Limits, RecordingWriter, Sink, weight
from app.logs.ros.encoder import Encoder
from app.logs.ros.record import Record
from tests.logs.mcap.disks import BEGIN, MANIFEST, Disk, encoder, image, landmarks, odometry, table
from tests.patience import PATIENCE_S


def file_writer(
    folder: Path,
    limits: Limits | None = None,
    disk: Disk | None = None,
    free_bytes: Callable[[Path], int] = lambda _: 1 << 40,
    charge: Callable[[Callable[[], None]], None] = lambda work: work(),
    new_encoder: Callable[[], Encoder] = encoder,
) -> RecordingWriter:
    disk, disk_time = disk or Disk(), DiskTime()
    return RecordingWriter(
        lambda: FileSink([folder / "log.mcap"], new_encoder(), MANIFEST, BEGIN, disk_time.timed(disk.open)),
        limits or Limits(),
        lambda: BEGIN,
        free_bytes=free_bytes,
        charge=charge,
        disk=disk_time,
    )


def counts(path: Path) -> dict[str, int]:
    """Records by topic, read through the file's own index by an independent reader that checks every CRC."""
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        found: dict[str, int] = {}
        for _, channel, _ in reader.iter_messages():
            found[channel.topic] = found.get(channel.topic, 0) + 1
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == sum(found.values())
        assert [a.name for a in reader.iter_attachments()] == ["lab.yaml"]
        assert [m.metadata["robot"] for m in reader.iter_metadata()] == ["a test body"]
    return found


def statistics(path: Path) -> Statistics:
    with open(path, "rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    return summary.statistics


def ended(writer: RecordingWriter) -> RecordingWriter:
    assert writer.join(PATIENCE_S)
    return writer


def test_everything_put_is_in_the_file_at_its_time_of_arrival(tmp_path: Path) -> None:
    writer = file_writer(tmp_path)
    for i in range(500):
        writer.put(BEGIN + i / 100, "odometry", odometry(BEGIN + i / 100 - 0.002))
    writer.put(BEGIN + 5, "kinect", image(BEGIN + 5))
    writer.finish()
    ended(writer)
    assert (writer.reason, writer.dropped, writer.queued_bytes) == ("", 0, 0)
    assert writer.sink is not None
    assert (writer.sink.name, writer.sink.messages) == ("log", 501)
    assert writer.sink.bytes == (tmp_path / "log.mcap").stat().st_size
    found = counts(tmp_path / "log.mcap")
    assert found["/odometry"] == 500
    assert found["/kinect/depth"] == 1
    assert statistics(tmp_path / "log.mcap").message_start_time == int(BEGIN) * 10**9
    assert statistics(tmp_path / "log.mcap").message_end_time == int(BEGIN + 5) * 10**9


def test_a_taken_name_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "log.mcap").write_bytes(b"older")
    paths = [tmp_path / "log.mcap", tmp_path / "log-2.mcap"]
    writer = RecordingWriter(lambda: FileSink(paths, encoder(), MANIFEST, BEGIN), Limits(0), lambda: BEGIN)
    writer.finish()
    ended(writer)
    assert (tmp_path / "log.mcap").read_bytes() == b"older"
    assert writer.sink is not None
    assert writer.sink.name == "log-2"


def test_how_long_a_ring_lasts_is_how_much_it_holds(tmp_path: Path) -> None:
    writer = RecordingWriter(
        lambda: Ring(tmp_path, encoder, MANIFEST, BEGIN, 30), Limits(least_free_bytes=0), lambda: BEGIN
    )
    for i in range(600):
        writer.put(BEGIN + i / 10, "odometry", odometry(BEGIN + i / 10))
    assert writer.call(lambda sink: sink.flush()).result(20) is None
    assert writer.sink is not None
    assert 300 <= writer.sink.messages <= 400
    assert writer.duration_s == pytest.approx((writer.sink.messages - 1) / 10)
    writer.finish(discard=True)
    ended(writer)


def test_others_see_that_a_file_is_being_written(tmp_path: Path) -> None:
    disk = Disk()
    sink = FileSink([tmp_path / "log.mcap"], encoder(), MANIFEST, BEGIN, disk.open)
    sink.write(BEGIN, "odometry", odometry(BEGIN))
    assert is_being_written(tmp_path / "log.mcap")
    sink.close(discard=False)
    assert not is_being_written(tmp_path / "log.mcap")


def test_what_finds_no_room_is_dropped_and_counted_and_put_never_waits(tmp_path: Path) -> None:
    disk = Disk()
    disk.unblock.clear()  # a disk that takes nothing at all for now
    size = weight(odometry(BEGIN))
    writer = file_writer(tmp_path, Limits(queue_bytes=10 * size, too_slow_after_s=2.0), disk)
    for i in range(30):
        writer.put(BEGIN + i / 100, "odometry", odometry(BEGIN))
    assert (writer.dropped, writer.queued_bytes) == (20, 10 * size)
    assert not writer.reason
    disk.unblock.set()
    writer.finish()
    ended(writer)
    assert counts(tmp_path / "log.mcap")["/odometry"] == 10
    assert not writer.reason


def test_the_queue_is_bounded_in_messages_too(tmp_path: Path) -> None:
    disk = Disk()
    disk.unblock.clear()
    writer = file_writer(tmp_path, Limits(queue_messages=5), disk)
    for _ in range(12):
        writer.put(BEGIN, "odometry", odometry(BEGIN))
    assert writer.dropped == 7
    disk.unblock.set()
    writer.finish()
    ended(writer)


def test_a_disk_that_stays_too_slow_ends_the_recording_with_a_reason_and_the_file_is_whole(tmp_path: Path) -> None:
    disk = Disk()
    disk.unblock.clear()
    writer = file_writer(tmp_path, Limits(queue_messages=100, too_slow_after_s=2.0), disk)
    assert disk.met.wait(60)
    for i in range(400):
        writer.put(BEGIN + i / 100, "odometry", odometry(BEGIN + i / 100))
    assert re.match(r"the disk is too slow: \d+ messages found no room within 2\.0 s; record to a", writer.reason)
    dropped = writer.dropped
    writer.put(BEGIN + 5, "odometry", odometry(BEGIN + 5))
    assert writer.dropped == dropped  # it is over: later messages are not lost ones
    disk.unblock.set()
    ended(writer)
    assert counts(tmp_path / "log.mcap")["/odometry"] == 100


def test_a_computer_that_stays_too_busy_is_distinguished_from_a_slow_disk(tmp_path: Path) -> None:
    class Slow(Encoder):
        """Encodes when it is let."""

        def encode(self, channel: str, message: Any) -> list[Record]:
            encoding.set()
            let.wait()
            return super().encode(channel, message)

    encoding, let = threading.Event(), threading.Event()
    limits = Limits(queue_messages=100, too_slow_after_s=2.0)
    writer = file_writer(tmp_path, limits, new_encoder=lambda: Slow(table()))
    writer.put(BEGIN, "odometry", odometry(BEGIN))
    assert encoding.wait(60)
    for i in range(400):
        writer.put(BEGIN + i / 100, "odometry", odometry(BEGIN + i / 100))
    assert writer.reason.startswith("this computer is too busy to record: ")
    assert "messages found no room within 2.0 s, and the disk was waited for in only 0 % of that" in writer.reason
    let.set()
    ended(writer)
    assert counts(tmp_path / "log.mcap")["/odometry"] >= 100


def test_a_full_queue_that_empties_again_is_forgiven(tmp_path: Path) -> None:
    disk = Disk()
    disk.unblock.clear()
    drained = threading.Event()

    def charge(work: Callable[[], None]) -> None:
        work()
        if work.__name__ == "_drain" and writer.queued_bytes == 0 and disk.unblock.is_set():
            drained.set()

    writer = file_writer(tmp_path, Limits(queue_messages=10, too_slow_after_s=2.0), disk, charge=charge)
    for i in range(12):
        writer.put(BEGIN + i / 100, "odometry", odometry(BEGIN))
    assert writer.dropped == 2
    disk.unblock.set()
    assert drained.wait(PATIENCE_S)
    writer.put(BEGIN + 60, "odometry", odometry(BEGIN))
    disk.unblock.clear()
    for _ in range(30):
        writer.put(BEGIN + 61, "odometry", odometry(BEGIN))
    assert not writer.reason  # a minute lies between the two, and nothing was dropped in it
    disk.unblock.set()
    writer.finish()
    ended(writer)


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.EIO, "the disk fails"),
        (errno.EROFS, "nothing may be written there"),
        (errno.ENOENT, "the folder or the file is gone"),
        (errno.ENOSPC, "the disk is full"),
        (errno.EFBIG, "the recording cannot be written"),
    ],
)
def test_a_write_that_fails_ends_it_in_words_and_what_was_written_can_be_read(
    tmp_path: Path, number: int, words: str
) -> None:
    disk = Disk()
    flushed = threading.Event()

    def charge(work: Callable[[], None]) -> None:
        work()
        if work.__name__ == "flush":
            flushed.set()

    writer = file_writer(tmp_path, disk=disk, charge=charge)
    for i in range(50):
        writer.put(BEGIN + i / 100, "odometry", odometry(BEGIN + i / 100))
    assert flushed.wait(PATIENCE_S)
    disk.error = OSError(number, os.strerror(number))
    writer.put(BEGIN + 1, "odometry", odometry(BEGIN + 1))
    ended(writer)
    assert words in writer.reason
    assert counts(tmp_path / "log.mcap")["/odometry"] >= 49  # the first may have met its flush before the rest came


def test_room_is_left_on_the_disk_and_the_file_is_closed(tmp_path: Path) -> None:
    free = [10**9]
    writer = file_writer(tmp_path, Limits(least_free_bytes=200 * 10**6), free_bytes=lambda _: free[0])
    writer.put(BEGIN, "odometry", odometry(BEGIN))
    free[0] = 199 * 10**6
    ended(writer)
    assert "199 MB free" in writer.reason
    assert "200 MB stay free" in writer.reason
    assert counts(tmp_path / "log.mcap")["/odometry"] == 1


def test_a_folder_that_cannot_be_made_is_a_reason_not_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    paths = [tmp_path / "file" / "log.mcap"]
    writer = RecordingWriter(lambda: FileSink(paths, encoder(), MANIFEST, BEGIN), Limits(), lambda: BEGIN)
    ended(writer)
    assert "file" in writer.reason
    assert writer.sink is None


def test_a_file_that_is_deleted_meanwhile_is_noticed(tmp_path: Path) -> None:
    writer = file_writer(tmp_path)
    while not (tmp_path / "log.mcap").exists():
        time.sleep(0.001)
    (tmp_path / "log.mcap").unlink()
    ended(writer)
    assert "gone" in writer.reason


def test_a_message_that_is_wrong_is_left_out_and_counted(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    writer = file_writer(tmp_path)
    writer.put(BEGIN, "odometry", odometry(BEGIN))
    for _ in range(3):
        writer.put(BEGIN, "no such channel", odometry(BEGIN))
        writer.put(BEGIN, "odometry", odometry(float("nan")))
    writer.put(BEGIN, "odometry", odometry(BEGIN))
    writer.finish()
    ended(writer)
    assert not writer.reason
    assert writer.dropped == 6
    assert writer.sink is not None
    assert writer.sink.messages == 2
    assert counts(tmp_path / "log.mcap")["/odometry"] == 2
    assert len([record for record in caplog.records if "left out" in record.message]) == 2


def test_a_mistake_of_ours_ends_it_with_a_reason(tmp_path: Path) -> None:
    class Broken(FileSink):
        def flush(self) -> None:
            raise ZeroDivisionError("a mistake")

    paths = [tmp_path / "log.mcap"]
    writer = RecordingWriter(lambda: Broken(paths, encoder(), MANIFEST, BEGIN), Limits(0), lambda: BEGIN)
    writer.put(BEGIN, "odometry", odometry(BEGIN))
    ended(writer)
    assert "ZeroDivisionError" in writer.reason


def test_a_call_is_answered_in_between_and_refused_once_it_is_over(tmp_path: Path) -> None:
    writer = file_writer(tmp_path)

    def name(sink: Sink) -> str:
        return sink.name

    assert writer.call(name).result(10) == "log"
    writer.finish()
    ended(writer)
    with pytest.raises(OSError, match="is over"):
        writer.call(name).result(10)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(room=st.integers(3_000, 60_000), count=st.integers(1, 60))
def test_wherever_the_disk_is_full_the_file_is_whole_up_to_there(
    tmp_path_factory: pytest.TempPathFactory, room: int, count: int
) -> None:
    folder = tmp_path_factory.mktemp("full")
    disk = Disk(room)
    sink = FileSink([folder / "log.mcap"], encoder(), MANIFEST, BEGIN, disk.open)
    written = 0
    try:
        for i in range(count):
            sink.write(BEGIN + i, "kinect", image(BEGIN + i, seed=i))
            sink.write(BEGIN + i, "landmarks", landmarks(BEGIN + i, f"code {i}"))
            sink.flush()
            written += 1
        sink.close(discard=False)
    except OSError:
        sink.abandon()
    if not sink.messages:
        assert not (folder / "log.mcap").exists()
        return
    # The disk in this test is full for the recording alone: its end found room after the cut.
    assert counts(folder / "log.mcap").get("/kinect/depth", 0) in (written, written + 1)


def test_a_call_that_the_disk_fails_ends_the_recording_with_its_reason(tmp_path: Path) -> None:
    disk = Disk()
    ring = partial(Ring, tmp_path / ".ring", encoder, MANIFEST, BEGIN, 60.0, open_file=disk.open)
    writer = RecordingWriter(ring, Limits(), lambda: BEGIN, free_bytes=lambda _: 1 << 40)
    writer.put(BEGIN, "odometry", odometry(BEGIN))

    def hold(sink: Sink) -> HeldSegments:
        assert isinstance(sink, Ring)
        sink.flush()
        disk.error = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return sink.hold(BEGIN + 1, None)

    with pytest.raises(OSError, match="No space"):
        writer.call(hold).result(20)
    ended(writer)
    assert writer.reason.startswith("the disk is full")
    disk.error = None
    (home,) = leftovers(tmp_path / ".ring")
    assert rescue(home, iter([tmp_path / "saved.mcap"])) == tmp_path / "saved.mcap"
