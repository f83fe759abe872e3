"""Rings that the Recorder turns, saved on request, after an event and after its death."""

from __future__ import annotations

import asyncio
import errno
import os
import threading
from pathlib import Path
from typing import Any

import pytest

from app.logs.library import RecordingLibrary
from app.logs.log import LogError
from app.logs.mcap.ring import HeldSegments, Ring
from app.logs.mcap.ring_folder import leftovers
from app.logs.recorder_service import RecorderUnavailable
from app.messages import Odometry, TimelineEvent
from app.modules.recording import ring_saver
from tests.logs.mcap.disks import BEGIN, MANIFEST, Disk, encoder, odometry
from tests.modules.recording.robot import Robot, files, of, read
from tests.patience import PATIENCE_S


async def test_a_ring_is_saved_on_request_and_turns_on(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        assert robot.control.available
        with pytest.raises(RecorderUnavailable, match="no ring"):
            await robot.control.save_ring()
        robot.desire(keep_minutes=5)
        await robot.until(lambda status: status.state == "ring")
        for i in range(100):
            robot.feed("odometry", odometry(BEGIN + i / 100))
            await asyncio.sleep(0)
        await robot.taken("odometry", 100)
        assert await robot.control.save_ring(name="seen") == "seen"
        assert await robot.control.save_ring(1, name="seen") == "seen-2"
        with pytest.raises(ValueError, match="name"):
            await robot.control.save_ring(name="../else")
        robot.feed("odometry", odometry(BEGIN + 1))
        await robot.taken("odometry", 101)
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
    assert not robot.control.available
    assert len(of(await read(tmp_path / "seen.mcap"), Odometry)) == 100
    assert await asyncio.to_thread(leftovers, robot.library.ring_folder) == []  # withdrawn: the rest is not needed


async def test_a_ring_that_changes_its_length_turns_on(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(keep_minutes=5)
        await robot.until(lambda status: status.state == "ring")
        robot.feed("odometry", odometry(BEGIN))
        await robot.taken("odometry", 1)
        robot.desire(keep_minutes=2)
        robot.feed("odometry", odometry(BEGIN + 1))
        await robot.taken("odometry", 2)
        await robot.control.save_ring(name="both")
    assert len(of(await read(tmp_path / "both.mcap"), Odometry)) == 2


async def test_a_saving_that_is_given_up_lets_the_ring_forget(tmp_path: Path, disk: Disk) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(keep_minutes=5)
        await robot.until(lambda status: status.state == "ring")
        robot.feed("odometry", odometry(BEGIN))
        await robot.until(lambda status: status.messages == 1)
        disk.unblock.clear()
        saving = asyncio.create_task(robot.control.save_ring())
        async with asyncio.timeout(PATIENCE_S):
            while not disk.waiting:  # noqa: ASYNC110  # the writer's thread is in the middle of it
                await asyncio.sleep(0)
        saving.cancel()
        await asyncio.wait({saving})
        disk.unblock.set()
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
    # Nothing held it, so that all of it was thrown away with the wish for it.
    assert await asyncio.to_thread(leftovers, RecordingLibrary(tmp_path).ring_folder) == []


async def test_a_ring_that_finds_no_room_to_be_saved_says_so_and_turns_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with Robot(tmp_path, least_free_mb=200) as robot:
        robot.desire(keep_minutes=5)
        await robot.until(lambda status: status.state == "ring")
        robot.feed("odometry", odometry(BEGIN))
        await robot.taken("odometry", 1)
        monkeypatch.setattr(robot.library, "free_bytes", lambda: 200_000_000)
        with pytest.raises(LogError, match="200 MB are kept free"):
            await robot.control.save_ring(name="seen")
        assert await asyncio.to_thread(files, tmp_path) == []
        monkeypatch.undo()
        assert await robot.control.save_ring(name="seen") == "seen"


async def test_an_event_saves_the_ring(tmp_path: Path) -> None:
    patterns = [{"kind": "guard", "subject": "e_stopped"}, {"kind": "module"}]
    async with Robot(tmp_path, save_ring_on=patterns, save_after_s=0) as robot:
        robot.desire(keep_minutes=5)
        await robot.until(lambda status: status.state == "ring")
        robot.feed("odometry", odometry(BEGIN))
        robot.feed("events", TimelineEvent(1, BEGIN, "guard", "driving", "The base drives"))
        robot.feed("events", TimelineEvent(2, BEGIN, "guard", "e_stopped", "Emergency stop"))
        async with asyncio.timeout(PATIENCE_S):
            while not await asyncio.to_thread(files, tmp_path):
                await robot.statuses.receive()
    (saved,) = await asyncio.to_thread(files, tmp_path)
    assert saved.endswith("-guard-e_stopped.mcap")
    assert [event.subject for event in of(await read(tmp_path / saved), TimelineEvent)] == ["driving", "e_stopped"]


async def test_the_ring_of_an_earlier_run_becomes_a_recording(tmp_path: Path) -> None:
    library = RecordingLibrary(tmp_path)

    def live() -> None:
        earlier = Ring(library.ring_folder, encoder, MANIFEST, BEGIN, 60.0)
        for i in range(100):
            earlier.write(BEGIN + i / 10, "odometry", odometry(BEGIN + i / 10))
        earlier.close(discard=False)

    await asyncio.to_thread(live)
    async with Robot(tmp_path) as robot:
        async with asyncio.timeout(PATIENCE_S):
            while not await asyncio.to_thread(files, tmp_path):
                await robot.statuses.receive()
    (saved,) = await asyncio.to_thread(files, tmp_path)
    assert saved.endswith("-ring.mcap")
    assert len(of(await read(tmp_path / saved), Odometry)) == 100
    assert await asyncio.to_thread(leftovers, library.ring_folder) == []


async def test_a_ring_that_a_full_disk_ended_is_saved_when_there_is_room_again(tmp_path: Path, disk: Disk) -> None:
    async with Robot(tmp_path) as robot:
        robot.desire(keep_minutes=5)
        await robot.until(lambda status: status.state == "ring")
        for i in range(200):
            robot.feed("odometry", odometry(BEGIN + i / 100))
            await asyncio.sleep(0)
        await robot.until(lambda status: status.messages == 200 and status.bytes > 0)
        disk.error = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        robot.feed("odometry", odometry(BEGIN + 2))
        await robot.until(lambda status: status.state == "stopped")
        disk.error = None
        await robot.record(name="next")
        async with asyncio.timeout(PATIENCE_S):
            while len(await asyncio.to_thread(files, tmp_path)) < 2:
                await robot.statuses.receive()
    (ring,) = [name for name in await asyncio.to_thread(files, tmp_path) if name.endswith("-ring.mcap")]
    assert len(of(await read(tmp_path / ring), Odometry)) > 0


async def turning(robot: Robot, count: int = 100) -> None:
    """A ring that holds ``count`` odometries."""
    robot.desire(keep_minutes=5)
    await robot.until(lambda status: status.state == "ring")
    for i in range(count):
        robot.feed("odometry", odometry(BEGIN + i / 100))
        await asyncio.sleep(0)
    await robot.taken("odometry", count)


async def test_a_recording_that_takes_the_rings_place_throws_nothing_away(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with Robot(tmp_path) as robot:
        await turning(robot)
        robot.desire(name="over")
        robot.feed("odometry", odometry(BEGIN + 1))
        await robot.taken("odometry", 101)
        async with asyncio.timeout(PATIENCE_S):
            # The file is there a moment before its report.
            while len(found := await asyncio.to_thread(files, tmp_path)) < 2 or "is saved as" not in caplog.text:
                await robot.statuses.receive()
        robot.desire(False)
        await robot.until(lambda status: status.state == "idle")
    (ring,) = [name for name in found if name.endswith("-ring.mcap")]
    assert len(of(await read(tmp_path / ring), Odometry)) == 100
    assert len(of(await read(tmp_path / "over.mcap"), Odometry)) == 1
    assert f"is saved as {ring.removesuffix('.mcap')}" in caplog.text
    assert await asyncio.to_thread(leftovers, robot.library.ring_folder) == []


async def test_a_saving_under_way_is_not_robbed_by_the_recording_that_follows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_work, go_on, found_ended, save = threading.Event(), threading.Event(), threading.Event(), HeldSegments.save

    def slow(*args: Any) -> Path:
        at_work.set()
        assert go_on.wait(PATIENCE_S)
        return save(*args)

    def looking(folder: Path) -> list[Path]:
        found = leftovers(folder)
        if found:
            found_ended.set()
        return found

    monkeypatch.setattr(HeldSegments, "save", slow)
    monkeypatch.setattr(ring_saver, "leftovers", looking)
    async with Robot(tmp_path) as robot:
        await turning(robot)
        saving = asyncio.create_task(robot.control.save_ring(name="seen"))
        assert await asyncio.to_thread(at_work.wait, PATIENCE_S)
        robot.desire(name="over")
        # The Recorder's own look: another beside it would hold the ring's lock for a moment, and be taken for a rescue.
        assert await asyncio.to_thread(found_ended.wait, PATIENCE_S)
        # The ring has ended, and time goes by in which it could be taken away.
        ended = robot.clock.now()
        await robot.until(lambda status: status.stamp > ended + 0.3)
        go_on.set()
        assert await saving == "seen"
        async with asyncio.timeout(PATIENCE_S):
            while len(found := await asyncio.to_thread(files, tmp_path)) < 3:
                await robot.statuses.receive()
    (ring,) = [name for name in found if name.endswith("-ring.mcap")]
    for name in ("seen.mcap", ring):
        assert len(of(await read(tmp_path / name), Odometry)) == 100
