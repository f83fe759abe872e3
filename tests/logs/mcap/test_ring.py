"""The ring: only the last minutes stay on disk, and any part of them can be saved while it turns."""

from __future__ import annotations

import errno
import fcntl
import os
import signal
import socket
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from threading import Lock

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from app.logs.log import LogError, Logged
from app.logs.mcap.reader import McapLog
from app.logs.mcap.ring import Ring, Segment
from app.logs.mcap.ring_folder import begin_of, leftovers, rescue
from app.messages import Landmarks, Odometry
from tests.logs.mcap.disks import BEGIN, MANIFEST, Disk, encoder, image, landmarks, odometry


def ring(folder: Path, keep_s: float = 60.0, disk: Disk | None = None) -> Ring:
    return Ring(
        folder / ".ring", encoder, MANIFEST, BEGIN, keep_s,
        state_key=lambda channel, _: channel if channel == "landmarks" else None,
        open_file=(disk or Disk()).open,
    )  # fmt: skip


def turn(turning: Ring, begin_s: float, end_s: float) -> None:
    """Odometry at 10 Hz, flushed twice a second as the writer does."""
    for i in range(round(10 * begin_s), round(10 * end_s)):
        turning.write(BEGIN + i / 10, "odometry", odometry(BEGIN + i / 10))
        if i % 5 == 0:
            turning.flush()


def read(path: Path) -> list[Logged]:
    log = McapLog(path)
    try:
        return list(log.messages())
    finally:
        log.close()


def times(messages: list[Logged], kind: type = Odometry) -> list[float]:
    return [round(logged.at - BEGIN, 3) for logged in messages if isinstance(logged.message, kind)]


def tenths(begin: float, end: float) -> list[float]:
    return [i / 10 for i in range(round(10 * begin), round(10 * end))]


def segments(folder: Path) -> list[Path]:
    return sorted(folder.glob(".ring/*/*.mcap"))


def names(folder: Path) -> Iterator[Path]:
    return iter([folder / "saved.mcap", folder / "saved-2.mcap", folder / "saved-3.mcap"])


def test_the_disk_holds_the_minutes_kept_and_one_segment_more(tmp_path: Path) -> None:
    turning = ring(tmp_path, keep_s=60)
    most = 0
    for begin in range(0, 300, 5):
        turn(turning, begin, begin + 5)
        most = max(most, turning.messages)
        on_disk = sum(path.stat().st_size for path in segments(tmp_path) if "state" not in path.name)
        assert turning.bytes == on_disk
        assert turning.messages == round(10 * (BEGIN + begin + 5 - turning.begin))
    assert 600 <= most <= 710
    assert len(segments(tmp_path)) <= 2 * 8
    turning.close(discard=True)
    assert not segments(tmp_path)


def test_saving_keeps_everything_and_the_ring_turns_on(tmp_path: Path) -> None:
    turning = ring(tmp_path, keep_s=60)
    turn(turning, 0, 47)
    with turning.hold(BEGIN + 47, None) as hold:
        turn(turning, 47, 200)  # what is held is not deleted, though it is long too old
        path = hold.save(names(tmp_path))
        assert hold.segments[0].path.exists()
    assert not hold.segments[0].path.exists()
    assert times(read(path)) == tenths(0, 47)
    turning.close(discard=True)


def test_saving_some_minutes_saves_whole_segments(tmp_path: Path) -> None:
    turning = ring(tmp_path, keep_s=600)
    turn(turning, 0, 100)
    with turning.hold(BEGIN + 100, 30) as hold:
        path = hold.save(names(tmp_path))
    saved = times(read(path))
    assert saved[-1] == 99.9
    assert saved == tenths(saved[0], 100)
    assert 30 <= 100 - saved[0] <= 40
    turning.close(discard=True)


def test_a_saved_ring_begins_with_the_state_that_stood_and_names_no_state_twice(tmp_path: Path) -> None:
    turning = ring(tmp_path, keep_s=60)
    turning.write(BEGIN, "landmarks", landmarks(BEGIN, "first"))
    turning.write(BEGIN + 1, "landmarks", landmarks(BEGIN + 1, "second"))
    turn(turning, 1, 200)
    with turning.hold(BEGIN + 200, None) as hold:
        messages = read(hold.save(names(tmp_path)))
    first = messages[0]
    assert isinstance(first.message, Landmarks)
    assert [mark.text for mark in first.message.landmarks] == ["second"]
    assert len(times(messages, Landmarks)) == 1
    assert first.at == pytest.approx(times(messages)[0] + BEGIN, abs=0.01)
    turning.close(discard=True)


def test_a_saved_ring_is_a_whole_file_with_the_manifest(tmp_path: Path) -> None:
    turning = ring(tmp_path, keep_s=60)
    turn(turning, 0, 25)
    turning.write(BEGIN + 25, "kinect", image(BEGIN + 25))  # a channel that comes late
    turn(turning, 25, 55)
    turning.write(BEGIN + 55, "kinect", image(BEGIN + 55))
    progress: list[tuple[int, int]] = []
    with turning.hold(BEGIN + 55, None) as hold:
        path = hold.save(names(tmp_path), lambda done, total: progress.append((done, total)))
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        counted = {summary.channels[i].topic: n for i, n in summary.statistics.channel_message_counts.items()}
        found: dict[str, int] = {}
        for _, channel, _ in reader.iter_messages():
            found[channel.topic] = found.get(channel.topic, 0) + 1
        assert counted == found
        assert found["/odometry"] == 550
        assert found["/kinect/depth"] == 2
        assert [a.name for a in reader.iter_attachments()] == ["lab.yaml"]
        assert [m.metadata["robot"] for m in reader.iter_metadata()] == ["a test body"]
    assert progress[-1][0] == progress[-1][1] > 0
    assert progress == sorted(progress)
    turning.close(discard=True)


def test_a_taken_name_is_left_alone_and_a_failed_copy_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "saved.mcap").write_bytes(b"older")
    turning = ring(tmp_path)
    turn(turning, 0, 5)
    with turning.hold(BEGIN + 5, None) as hold:
        assert hold.save(names(tmp_path)).name == "saved-2.mcap"

        def fail(done: int, total: int) -> None:
            raise OSError("no room")

        with pytest.raises(OSError, match="no room"):
            hold.save(names(tmp_path), fail)
    assert sorted(path.name for path in tmp_path.glob("*.mcap")) == ["saved-2.mcap", "saved.mcap"]
    assert not list(tmp_path.glob(".ring/.saving*"))
    turning.close(discard=True)


def test_a_file_system_without_links_is_enough(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def link(source: Path, target: Path) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(os, "link", link)
    (tmp_path / "saved.mcap").write_bytes(b"older")
    turning = ring(tmp_path)
    turn(turning, 0, 5)
    with turning.hold(BEGIN + 5, None) as hold:
        assert hold.save(names(tmp_path)).name == "saved-2.mcap"
    assert times(read(tmp_path / "saved-2.mcap")) == tenths(0, 5)
    assert (tmp_path / "saved.mcap").read_bytes() == b"older"
    turning.close(discard=True)


def test_an_empty_ring_has_nothing_to_save(tmp_path: Path) -> None:
    turning = ring(tmp_path)
    with turning.hold(BEGIN, None) as hold, pytest.raises(LogError, match="nothing"):
        hold.save(names(tmp_path))
    turning.close(discard=True)


def test_a_ring_in_use_is_no_leftover_and_a_stopped_one_is(tmp_path: Path) -> None:
    turning = ring(tmp_path)
    turn(turning, 0, 33)
    assert leftovers(tmp_path / ".ring") == []
    turning.close(discard=False)
    (home,) = leftovers(tmp_path / ".ring")
    assert begin_of(home) == BEGIN
    saved = rescue(home, names(tmp_path))
    assert saved is not None
    assert times(read(saved)) == tenths(0, 33)
    assert leftovers(tmp_path / ".ring") == []


def test_leftovers_become_one_recording_in_any_program(tmp_path: Path) -> None:
    turning = ring(tmp_path)
    turn(turning, 0, 33)
    turning.close(discard=False)
    (home,) = leftovers(tmp_path / ".ring")
    others: list[Path | None] = []

    def meanwhile(done: int, total: int) -> None:
        assert leftovers(tmp_path / ".ring") == []
        others.append(rescue(home, names(tmp_path)))

    assert rescue(home, names(tmp_path), meanwhile) == tmp_path / "saved.mcap"
    assert rescue(home, names(tmp_path)) is None
    assert others
    assert not any(others)
    assert [path.name for path in tmp_path.glob("*.mcap")] == ["saved.mcap"]


def test_without_locks_only_what_a_dead_program_left_is_left_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def flock(file: object, operation: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", flock)
    turning = ring(tmp_path)
    turn(turning, 0, 5)
    (tmp_path / ".ring" / ".saving-0").write_bytes(b"perhaps somebody joins it now")
    assert leftovers(tmp_path / ".ring") == []
    assert (tmp_path / ".ring" / ".saving-0").exists()
    with turning.hold(BEGIN + 5, None) as hold:
        assert times(read(hold.save(names(tmp_path)))) == tenths(0, 5)
    turning.close(discard=False)
    with subprocess.Popen(["true"]) as gone:
        pass
    (lock,) = tmp_path.glob(".ring/*/lock")
    lock.write_text(f"{gone.pid} {socket.gethostname()}")
    assert leftovers(tmp_path / ".ring") == [lock.parent]
    lock.write_text(f"{gone.pid} another.computer.example")
    assert leftovers(tmp_path / ".ring") == []


class Guarded(deque[Segment]):
    """Segments that may be changed only while the guard is held: another thread may be reading them."""

    guard: Lock

    def append(self, segment: Segment, /) -> None:
        assert self.guard.locked()
        super().append(segment)

    def popleft(self) -> Segment:
        assert self.guard.locked()
        return super().popleft()

    def clear(self) -> None:
        assert self.guard.locked()
        super().clear()


def test_a_hold_may_be_released_in_another_thread_while_the_ring_turns(tmp_path: Path) -> None:
    turning = ring(tmp_path, keep_s=20)
    turning._segments = guarded = Guarded()
    guarded.guard = turning._guard
    turn(turning, 0, 60)
    assert len(guarded) >= 2
    turning.close(discard=True)
    assert not guarded


def test_a_full_disk_ends_a_ring_whose_segments_stay(tmp_path: Path) -> None:
    disk = Disk()
    turning = ring(tmp_path, disk=disk)
    turn(turning, 0, 33)
    disk.room = 0
    with pytest.raises(OSError, match="No space"):
        turn(turning, 33, 60)
    turning.abandon()
    disk.room = 1 << 40
    (home,) = leftovers(tmp_path / ".ring")
    saved = rescue(home, names(tmp_path))
    assert saved is not None
    assert times(read(saved))[: 10 * 33 - 5] == tenths(0, 32.5)


def test_a_damaged_segment_is_reported_and_nothing_of_its_ring_is_deleted(tmp_path: Path) -> None:
    turning = ring(tmp_path)
    turn(turning, 0, 33)
    turning.close(discard=False)
    damaged = segments(tmp_path)[1]
    data = bytearray(damaged.read_bytes())
    data[150:-100:7] = bytes(len(data[150:-100:7]))
    damaged.write_bytes(data)
    (home,) = leftovers(tmp_path / ".ring")
    with pytest.raises(LogError, match="hbba log repair"):
        rescue(home, names(tmp_path))
    assert len(segments(tmp_path)) == 8
    assert not list(tmp_path.glob("*.mcap"))


def test_nothing_left_over_is_nothing_to_rescue(tmp_path: Path) -> None:
    assert leftovers(tmp_path / "none") == []
    ring(tmp_path).close(discard=False)
    (home,) = leftovers(tmp_path / ".ring")
    assert rescue(home, names(tmp_path)) is None
    assert not home.exists()


CHILD = """
import sys
from pathlib import Path
from tests.logs.mcap.test_ring import ring, turn
turning = ring(Path(sys.argv[1]))
turn(turning, 0, 25.5)
print("written", flush=True)
sys.stdin.read()
"""


@pytest.mark.slow
def test_the_ring_of_a_killed_program_loses_at_most_what_was_not_flushed(tmp_path: Path) -> None:
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, str(tmp_path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    with child:
        assert child.stdout is not None
        assert child.stdout.readline() == "written\n"
        assert leftovers(tmp_path / ".ring") == []  # while it runs, no other program takes it
        os.kill(child.pid, signal.SIGKILL)
    (home,) = leftovers(tmp_path / ".ring")
    saved = rescue(home, names(tmp_path))
    assert saved is not None
    there = times(read(saved))
    assert there == tenths(0, 25.5)[: len(there)]
    assert there[-1] >= 24.9


@settings(max_examples=10)
@given(ends=st.lists(st.integers(1, 40), min_size=1, max_size=5), keep_s=st.integers(5, 60))
def test_whatever_is_saved_when_it_is_the_last_minutes_without_a_gap(
    tmp_path_factory: pytest.TempPathFactory, ends: list[int], keep_s: int
) -> None:
    folder = tmp_path_factory.mktemp("ring")
    turning = ring(folder, keep_s=keep_s)
    now = 0
    for number, length in enumerate(ends):
        turn(turning, now, now + length)
        now += length
        with turning.hold(BEGIN + now, None) as hold:
            saved = times(read(hold.save(iter([folder / f"{number}.mcap"]))))
        assert saved == tenths(saved[0], now)
        assert saved[0] <= max(0, now - keep_s)
    turning.close(discard=True)
