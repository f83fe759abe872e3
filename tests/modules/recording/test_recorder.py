"""The Recorder on a real clock and real files: what it is asked for is on disk, and the robot never waits for it."""

from __future__ import annotations

import asyncio
import errno
import os
from pathlib import Path

import pytest

from app.messages import Landmarks, LoadReport, ModuleRecord, Odometry, TimelineEvent
from tests.logs.mcap.disks import BEGIN, Disk, image, landmarks, odometry
from tests.modules.recording.robot import Robot, files, of, read


async def test_without_a_desire_it_discards_its_messages(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        for i in range(1000):
            robot.feed("odometry", odometry(BEGIN + i / 100))
            await asyncio.sleep(0)
        await robot.taken("odometry", 1000)
        statistics = robot.graph.channel("odometry").statistics().subscriptions["Recorder.odometry"]
        assert (statistics.depth, statistics.dropped) == (0, 0)
        assert not robot.graph.channel("kinect").wanted
    assert await asyncio.to_thread(os.listdir, tmp_path) == []


async def test_what_is_fed_while_it_is_desired_is_in_the_file(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.feed("odometry", odometry(BEGIN - 1))
        await robot.taken("odometry", 1)
        robot.desire(name="walk")
        status = await robot.until(lambda status: status.state == "recording" and status.name == "walk")
        assert status.began == pytest.approx(robot.clock.now(), abs=5)
        assert robot.graph.channel("kinect").wanted
        for i in range(200):
            robot.feed("odometry", odometry(BEGIN + i / 100))
            await asyncio.sleep(0)
        robot.feed("kinect", image(BEGIN))
        robot.feed("load", LoadReport(BEGIN, 1.0, 0.0, None, ()))
        await robot.taken("odometry", 201)
        await robot.taken("kinect", 1)
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
        assert not robot.graph.channel("kinect").wanted
        robot.feed("odometry", odometry(BEGIN + 9))
        await robot.taken("odometry", 202)
    messages = await read(tmp_path / "walk.mcap")
    assert [m.stamp for m in of(messages, Odometry)] == [BEGIN + i / 100 for i in range(200)]
    assert {logged.channel for logged in messages} == {"odometry", "kinect"}


async def test_it_says_how_much_it_has_written(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(name="walk")
        for i in range(50):
            robot.feed("odometry", odometry(BEGIN + i / 100))
            await asyncio.sleep(0)
        status = await robot.until(lambda status: status.messages == 50 and status.queued_bytes == 0)
        assert (status.state, status.dropped, status.reason) == ("recording", 0, "")
        assert status.bytes > 0
        assert status.duration_s <= robot.clock.now() - status.began


async def test_a_log_begins_with_the_whole_state(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.feed("landmarks", landmarks(BEGIN - 60, "older"))
        robot.feed("landmarks", landmarks(BEGIN - 50, "newer"))
        robot.feed("module_states", ModuleRecord(BEGIN - 40, "Kinect", "running", 0, ""))
        robot.feed("module_states", ModuleRecord(BEGIN - 30, "Hokuyo", "running", 0, ""))
        robot.feed("module_states", ModuleRecord(BEGIN - 20, "Kinect", "failed", 0, "lost"))
        robot.feed("events", TimelineEvent(1, BEGIN - 10, "module", "Kinect", "Kinect failed"))
        await robot.taken("module_states", 3)
        await robot.record(5, name="walk")
    messages = await read(tmp_path / "walk.mcap")
    state = [logged.message for logged in messages if logged.at == messages[0].at]
    (marks,) = of(messages, Landmarks)
    assert [mark.text for mark in marks.landmarks] == ["newer"]
    modules = of(messages, ModuleRecord)
    assert {(m.module, m.status) for m in modules} == {("Kinect", "failed"), ("Hokuyo", "running")}
    assert set(map(type, state)) == {Landmarks, ModuleRecord}  # what merely happened before is not part of it
    assert not of(messages, TimelineEvent)


async def test_a_name_that_is_taken_gets_a_number_and_none_is_the_time(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        await robot.record(name="walk")
        await robot.record(name="walk")
        await robot.record(name="walk")
        await robot.record()
    *rest, timed = sorted(await asyncio.to_thread(files, tmp_path), key=lambda name: name[:4] != "walk")
    assert rest == ["walk-2.mcap", "walk-3.mcap", "walk.mcap"]
    assert timed[:2] == "20"
    assert len(of(await read(tmp_path / "walk-3.mcap"), Odometry)) == 100


async def test_other_parameters_begin_another_file(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(name="first")
        robot.feed("odometry", odometry(BEGIN))
        await robot.taken("odometry", 1)
        await robot.record(name="second")
    assert len(of(await read(tmp_path / "first.mcap"), Odometry)) == 1
    assert len(of(await read(tmp_path / "second.mcap"), Odometry)) == 100


async def test_stopping_the_program_closes_the_file(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(name="walk")
        robot.feed("odometry", odometry(BEGIN))
        await robot.taken("odometry", 1)
    assert len(of(await read(tmp_path / "walk.mcap"), Odometry)) == 1


async def test_a_crash_closes_the_file_and_the_next_life_goes_on_in_another(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(name="walk")
        robot.feed("odometry", odometry(BEGIN))
        await robot.taken("odometry", 1)
        robot.graph.modules["Recorder"].module.fail(RuntimeError("a mistake"))
        await robot.until(lambda status: status.name == "walk-2")
        robot.feed("odometry", odometry(BEGIN + 1))
        await robot.taken("odometry", 2)
    assert [m.stamp for m in of(await read(tmp_path / "walk.mcap"), Odometry)] == [BEGIN]
    assert [m.stamp for m in of(await read(tmp_path / "walk-2.mcap"), Odometry)] == [BEGIN + 1]


@pytest.mark.parametrize(
    ("number", "words"), [(errno.ENOSPC, "disk is full"), (errno.EIO, "disk fails"), (errno.EROFS, "may be written")]
)
async def test_a_disk_that_fails_stops_recording_and_nothing_else(
    tmp_path: Path, disk: Disk, number: int, words: str
) -> None:
    async with Robot(tmp_path) as robot:
        other = robot.graph.channel("odometry").subscribe("another module", capacity=1000)
        robot.desire(name="walk")
        await robot.until(lambda status: status.name == "walk")
        disk.error = OSError(number, os.strerror(number))
        for i in range(300):
            robot.feed("odometry", odometry(BEGIN + i / 100))
            await asyncio.sleep(0)
        status = await robot.until(lambda status: status.state == "stopped")
        assert words in status.reason
        assert other.statistics().depth == 300
        assert robot.supervisor.states["Recorder"].status == "running"
        # Still desired, it stays stopped; withdrawn and desired again, it tries again.
        disk.error = None
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
        await robot.record(name="again")
        assert robot.supervisor.states["Recorder"].restarts == 0
    assert len(of(await read(tmp_path / "again.mcap"), Odometry)) == 100


async def test_a_write_that_blocks_delays_no_module(tmp_path: Path, disk: Disk) -> None:
    async with Robot(tmp_path, queue_messages=100, too_slow_after_s=0.2) as robot:
        other = robot.graph.channel("odometry").subscribe("another module", capacity=100_000)
        disk.unblock.clear()
        disk.met.clear()
        robot.desire(name="walk")
        await asyncio.to_thread(disk.met.wait)
        fed, longest = 0, 0.0
        while True:  # until it gives up by itself: not one of these turns of the loop waits for the disk
            before = robot.clock.now()
            robot.feed("odometry", odometry(BEGIN + fed / 100))
            fed += 1
            await asyncio.sleep(0.001)
            longest = max(longest, robot.clock.now() - before)
            if (status := robot.graph.channel("recorder").latest) is not None and status.state == "stopped":
                break
        assert "too slow" in status.reason
        assert status.dropped > 0
        assert other.statistics().depth == fed
        assert longest < 10.0  # a busy computer may; the disk would hold it up for ever
        assert robot.supervisor.states["Recorder"].status == "running"
        disk.unblock.set()
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
    assert len(of(await read(tmp_path / "walk.mcap"), Odometry)) == 100


async def test_the_writers_cpu_time_is_the_recorders(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        meter = robot.graph.modules["Recorder"].context.meter
        await robot.record(1, name="one")
        before = meter.cpu_ns
        robot.desire(name="pictures")
        await robot.until(lambda status: status.name == "pictures")
        for i in range(20):
            robot.feed("kinect", image(BEGIN + i, seed=i, scale=10))
        await robot.taken("kinect", 20)
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
        # A picture of 640 x 480 of noise takes milliseconds to encode, and microseconds to be put into a queue.
        assert meter.cpu_ns - before > 20 * 1_000_000


async def test_a_folder_that_cannot_be_made_is_a_reason(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    async with Robot(tmp_path / "file" / "recordings") as robot:
        robot.desire(name="walk")
        status = await robot.until(lambda status: status.state == "stopped")
        assert "file" in status.reason


async def test_a_burst_after_the_loop_stood_still_is_counted_not_a_crash(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(name="walk")
        await robot.until(lambda status: status.name == "walk")
        for i in range(3000):  # in one go: no turn of the loop in between
            robot.feed("odometry", odometry(BEGIN + i / 100))
        status = await robot.until(lambda status: status.messages + status.dropped >= 3000)
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
        assert robot.supervisor.states["Recorder"].restarts == 0
    assert 0 < status.dropped < 3000
    assert len(of(await read(tmp_path / "walk.mcap"), Odometry)) == 3000 - status.dropped


async def test_why_it_stopped_is_logged_once(tmp_path: Path, disk: Disk, caplog: pytest.LogCaptureFixture) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(name="tour")
        await robot.until(lambda status: status.state == "recording")
        disk.error = OSError(errno.EIO, os.strerror(errno.EIO))
        robot.feed("odometry", odometry(BEGIN))
        await robot.until(lambda status: status.state == "stopped")
        disk.error = None
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
        robot.desire(name="next")
        await robot.until(lambda status: status.state == "recording")
    assert sum(record.message.startswith("recording stopped: the disk fails") for record in caplog.records) == 1


@pytest.mark.parametrize("keep_minutes", [0, 5])
async def test_no_recording_starts_on_a_disk_that_is_nearly_full(tmp_path: Path, keep_minutes: float) -> None:
    async with Robot(tmp_path, least_free_mb=1e9) as robot:
        for i in range(10):
            robot.feed("landmarks", landmarks(BEGIN + i, "poster"))
        await robot.taken("landmarks", 10)
        robot.desire(name="tour", keep_minutes=keep_minutes)
        status = await robot.until(lambda status: status.state == "stopped")
        assert status.reason.startswith("the disk is nearly full")
        assert await asyncio.to_thread(lambda: list(tmp_path.iterdir())) == []
