"""A recording of the lab, played on a real loop: play, pause, and the state shown after a seek."""

from __future__ import annotations

import asyncio
import re
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from app.logs.log import Log, LogError, Logged
from app.logs.mcap.damage import place
from app.logs.mcap.reader import McapLog
from app.logs.replay import seek
from app.logs.replay.options import ReplayOptions
from app.logs.replay.playback_state import checked_speed
from app.logs.replay.replay import Replay
from app.messages import Image, Landmark, Landmarks
from app.runtime.replay_clock import ReplayClock
from tests.logs.replay.logs import BEGIN, MemoryLog, damage, lab_log, lab_manifest, lab_messages, write_log
from tests.logs.replay.playing import played, prepare
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.slow

Prepared = tuple[Any, ReplayClock, Replay]


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a seek, what is shown is processed before its caller goes on, however busy the computer is."""
    monkeypatch.setattr(seek, "SHOW_WITHIN_S", PATIENCE_S)


@pytest.fixture
def lab() -> Prepared:
    """Six seconds of the lab."""
    return prepare(lab_log(6.0))


def stamps(play: Any, channel: str) -> list[float]:
    """The stamps of what ``channel`` carries from now on, appended as it comes."""
    found: list[float] = []
    play.replay.system.graph.channels[channel].observe(lambda message: found.append(message.stamp))
    return found


async def enough(play: Any, channel: str, is_enough: Callable[[], bool]) -> None:
    """Wait for the next message of ``channel`` with which it is enough."""
    come = asyncio.Event()

    def look(_: object) -> None:
        if is_enough():
            come.set()

    end = play.replay.system.graph.channels[channel].observe(look)
    await asyncio.wait_for(come.wait(), PATIENCE_S)
    end()


async def test_it_plays_in_real_time_pauses_and_goes_on(lab: Prepared) -> None:
    async with played(lab, playing=True) as play:
        odometry = stamps(play, "odometry")
        began, from_ = time.monotonic(), play.playback.state.position
        await asyncio.wait_for(play.clock.sleep_until(BEGIN + 0.5), PATIENCE_S)
        elapsed_s = time.monotonic() - began
        assert elapsed_s > BEGIN + 0.5 - from_ - 0.05
        play.playback.pause()
        state = play.playback.state
        assert (state.phase, state.playing) == ("paused", False)
        await play.playback._seeker.quiet()
        assert play.playback.state.position == state.position
        # What was due may come late on a busy computer; of what was not due, at most the next one (50 Hz).
        assert odometry[-1] <= state.position + 0.02
        play.playback.play()
        await enough(play, "odometry", lambda: odometry[-1] > state.position)
        assert odometry == sorted(odometry)


async def test_at_another_speed(lab: Prepared) -> None:
    async with played(lab, playing=True, speed=10.0) as play:
        began = time.monotonic()
        await asyncio.wait_for(play.clock.sleep_until(BEGIN + 3.0), PATIENCE_S)
        play.playback.set_speed(5.0)
        assert play.playback.state.speed == 5.0
        await play.phase("ended")
        assert time.monotonic() - began > 0.3 + 0.6 - 0.2
        assert play.playback.state.position == BEGIN + 5.98


async def test_a_command_after_a_failure_raises_at_once(
    lab: Prepared, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def fail() -> float:
        raise RuntimeError("a mistake of ours")

    async with played(lab) as play, asyncio.timeout(PATIENCE_S):
        monkeypatch.setattr(play.playback._seeker, "next_step", fail)
        for asked in (play.playback.step, play.playback.step, partial(play.playback.seek, BEGIN + 1.0)):
            with pytest.raises(LogError, match="playback failed: a mistake of ours"):
                await asked()
    assert "playback failed" in caplog.text


@pytest.mark.parametrize("speed", [0.0, 0.05, 21.0, float("nan"), -1.0])
def test_a_speed_that_cannot_be_is_refused(speed: float) -> None:
    with pytest.raises(ValueError, match=r"from 0\.1 to 20"):
        checked_speed(speed)


async def test_as_fast_as_possible_nothing_is_dropped(lab: Prepared) -> None:
    images = [m.message.stamp for m in lab[0].messages(None, {"kinect"})]
    async with played(lab, playing=True, speed=None) as play:
        codes = stamps(play, "qr_codes")
        state = await play.phase("ended")
        assert state.position == state.end
        counters = play.replay.system.graph.modules["QRCodeDetector"].context.inputs["images"].subscription.statistics()
        assert (counters.dropped, counters.depth) == (0, 0)
        # Every image that attention let through was worked on, in order.
        assert len(codes) == counters.passed == counters.taken
        assert codes == sorted(codes)
        assert codes[-1] >= images[-8]


async def test_a_seek_shows_the_state_there_while_paused(lab: Prepared) -> None:
    async with played(lab) as play:
        graph = play.replay.system.graph
        for position in (BEGIN + 4.0, BEGIN + 1.5):
            await play.playback.seek(position)
            state = play.playback.state
            assert (state.position, state.phase, state.playing) == (position, "paused", False)
            assert play.replay.system.clock.now() == position
            for channel in ("odometry", "joints", "kinect", "link_status", "qr_codes", "landmarks"):
                latest = graph.channels[channel].latest
                assert latest is not None, channel
                assert position - 0.2 < latest.stamp <= position, channel
            last = max(m.at for m in lab[0].messages(None, {"kinect"}) if m.at <= position)
            assert graph.channels["qr_codes"].latest.stamp == pytest.approx(last - 0.02)
        assert play.jumps == [BEGIN + 4.0, BEGIN + 1.5]


async def test_what_stood_before_is_forgotten_at_a_seek(lab: Prepared) -> None:
    async with played(lab, playing=True, speed=20.0) as play:
        system = play.replay.system
        await asyncio.wait_for(play.clock.sleep_until(BEGIN + 4.0), PATIENCE_S)
        assert system.timeline.query()
        restarts = {name: state.restarts for name, state in system.supervisor.states.items()}
        play.playback.pause()
        await play.playback.seek(BEGIN + 0.2)
        assert all(event.stamp == BEGIN + 0.2 for event in system.timeline.query())
        assert system.graph.channels["landmarks"].latest.landmarks[0].sightings == 1
        assert {name: state.restarts for name, state in system.supervisor.states.items()} == restarts
        assert all(state.status == "running" for state in system.supervisor.states.values())


async def test_desires_are_those_that_stood_there(lab: Prepared) -> None:
    def classes() -> list[tuple[str, str]]:
        return sorted((d.cls, d.source.name) for d in play.replay.system.workspace.desires())

    wished = ("DetectNoises", "FindQRCodes", "LocateFaces", "SLAM", "Teleoperation")
    always = [(cls, "ScenarioCoordinator") for cls in wished]
    async with played(lab) as play:
        await play.playback.seek(BEGIN + 2.5)
        assert classes() == sorted([*always, ("FindQRCodes", "script"), ("Telepresence", "ada")])
        await play.playback.seek(BEGIN + 0.5)
        assert classes() == always
        await play.playback.seek(BEGIN + 5.0)
        assert classes() == sorted([*always, ("FindQRCodes", "script")])
        assert play.replay.system.translator.is_settled


def test_landmarks_that_were_known_are_known_again() -> None:
    door = Landmarks(BEGIN + 0.9, (Landmark("door", (3.0, 1.0, 1.0), 0.05, 7, BEGIN + 0.3, BEGIN + 0.9),))
    messages = [*lab_messages(3.0), Logged(BEGIN + 0.9, "landmarks", door)]
    log = MemoryLog(sorted(messages, key=lambda logged: logged.at), lab_manifest())
    prepared = prepare(log)

    async def main() -> None:
        async with played(prepared) as play:
            landmarks = play.replay.system.graph.channels["landmarks"]
            await play.playback.seek(BEGIN + 2.0)
            texts = [landmark.text for landmark in landmarks.latest.landmarks]
            assert texts == ["door", "https://example.org/lab"], "the module goes on from them"
            await play.playback.seek(BEGIN + 0.5)
            assert [landmark.text for landmark in landmarks.latest.landmarks] == ["https://example.org/lab"]

    asyncio.run(main())


async def test_it_goes_on_playing_after_a_seek(lab: Prepared) -> None:
    async with played(lab, playing=True) as play:
        await play.playback.seek(BEGIN + 3.0)
        assert play.playback.state.phase == "playing"
        odometry = stamps(play, "odometry")
        await enough(play, "odometry", lambda: len(odometry) > 10)
        expected = [m.at for m in lab[0].messages(BEGIN + 3.0, {"odometry"}) if BEGIN + 3.0 < m.at <= odometry[-1]]
        assert odometry == pytest.approx(expected[-len(odometry) :])


async def test_of_many_seeks_only_the_newest_counts(lab: Prepared) -> None:
    async with played(lab) as play:
        await asyncio.gather(*(play.playback.seek(BEGIN + i / 10) for i in range(40)))
        assert play.playback.state.position == BEGIN + 3.9
        assert len(play.jumps) <= 2
        assert play.jumps[-1] == BEGIN + 3.9


async def test_seeks_to_one_place_at_once_are_all_answered(lab: Prepared) -> None:
    async with played(lab) as play:
        stopping = asyncio.Event()
        play.replay.system.supervisor.observe(lambda _: stopping.set())
        first = asyncio.create_task(play.playback.seek(BEGIN + 2.0))
        await stopping.wait()
        assert play.playback.moving
        await asyncio.wait_for(asyncio.gather(first, play.playback.seek(BEGIN + 2.0)), PATIENCE_S)
        assert play.jumps == [BEGIN + 2.0]


async def test_a_seek_beyond_an_end_goes_to_it(lab: Prepared) -> None:
    async with played(lab) as play:
        await play.playback.seek(BEGIN + 60)
        assert play.playback.state.position == BEGIN + 5.98
        assert play.playback.state.phase == "ended"
        await play.playback.seek(0.0)
        assert play.playback.state.position == BEGIN
        assert play.playback.state.phase == "paused"


async def test_steps_go_from_image_to_image(lab: Prepared) -> None:
    async with played(lab) as play:
        await play.playback.seek(BEGIN + 4.0)
        codes = stamps(play, "qr_codes")
        for _ in range(3):
            await play.playback.step()
        assert play.playback.state.phase == "paused"
        images = [m for m in lab[0].messages(BEGIN + 4.0, {"kinect"}) if m.at > BEGIN + 4.0][:3]
        assert play.playback.state.position == images[-1].at
        assert play.replay.system.graph.channels["kinect"].latest.stamp == images[-1].message.stamp
        # All of them have been worked on when the step is over.
        assert codes == [image.message.stamp for image in images]


@pytest.mark.parametrize(
    ("without", "to"), [(("kinect",), BEGIN + 0.103), (("kinect", "scan"), BEGIN + 0.2)], ids=["scans", "neither"]
)
def test_steps_where_there_are_no_images(without: tuple[str, ...], to: float) -> None:
    prepared = prepare(MemoryLog([m for m in lab_messages(2.0) if m.channel not in without], lab_manifest()))

    async def main() -> None:
        async with played(prepared) as play:
            await play.playback.seek(BEGIN + 0.1)
            await play.playback.step()
            assert play.playback.state.position == pytest.approx(to, abs=1e-5)

    asyncio.run(main())


async def test_at_the_end_it_pauses_and_play_begins_again(lab: Prepared) -> None:
    async with played(lab, playing=True, speed=20.0) as play:
        state = await play.phase("ended")
        assert (state.position, state.playing) == (state.end, False)
        await play.playback.step()
        assert play.playback.state.phase == "ended"
        play.playback.set_speed(1.0)
        play.playback.play()
        await play.phase("playing")
        assert play.jumps == [BEGIN]
        assert play.playback.state.position < BEGIN + 1.0


@pytest.fixture
def blind() -> Prepared:
    """The same without viewers."""
    return prepare(lab_log(6.0), ReplayOptions(only=("Hokuyo", "WheelOdometry")))


async def test_a_subscription_made_while_paused_gets_the_state_there(blind: Prepared) -> None:
    async with played(blind) as play:
        await play.playback.seek(BEGIN + 4.0)
        channel = play.replay.system.graph.channels["scan"]
        assert channel.latest is None, "nobody wanted scans"
        scans = channel.subscribe("test")
        scan = await asyncio.wait_for(scans.receive(), PATIENCE_S)
        assert BEGIN + 3.85 < scan.stamp <= BEGIN + 4.0


class Slow(MemoryLog):
    """A file that cannot be read beyond 1.5 s until :attr:`gate` opens."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.gate = threading.Event()
        #: Called in the reader's thread when it must wait.
        self.stuck: Any = lambda: None

    def messages(self, begin: Any = None, channels: Any = None) -> Any:
        for logged in super().messages(begin, channels):
            if logged.at > BEGIN + 1.5 and not self.gate.is_set():
                self.stuck()
                assert self.gate.wait(PATIENCE_S)
            yield logged


@pytest.fixture
def slow() -> Prepared:
    """A recording on a disk that keeps one waiting."""
    return prepare(Slow(lab_messages(3.0), lab_manifest()))


async def test_time_waits_for_a_file_that_is_slow(slow: Prepared) -> None:
    async with played(slow, playing=True, speed=4.0) as play:
        odometry = stamps(play, "odometry")
        stuck, waits = asyncio.Event(), asyncio.Event()
        loop, on_waiting = asyncio.get_running_loop(), play.replay.body.on_waiting

        def noted(now: bool) -> None:
            on_waiting(now)
            (waits.set if now else waits.clear)()

        play.replay.body.on_waiting = noted
        slow[0].stuck = lambda: loop.call_soon_threadsafe(stuck.set)
        await asyncio.wait_for(stuck.wait(), PATIENCE_S)
        await asyncio.wait_for(waits.wait(), PATIENCE_S)
        stood = play.playback.state.position
        await play.playback._seeker._system.graph.pending_work.quiet()
        assert play.playback.state.position == stood
        assert play.playback.state.phase == "playing"
        slow[0].gate.set()
        await play.phase("ended")
        # No subscription was late: every message came, each in its time.
        assert odometry[-1] == pytest.approx(BEGIN + 2.98, abs=0.001)
        assert odometry == sorted(odometry)


async def test_it_ends_once_everything_is_delivered_however_late(
    slow: Prepared, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a busy computer time overtakes the reading: as a clock that is moved on while the reader waits."""
    monkeypatch.setattr(seek, "SHOW_WITHIN_S", 0.0)
    async with played(slow, playing=True, speed=4.0) as play, asyncio.timeout(PATIENCE_S):
        odometry = stamps(play, "odometry")
        stuck, loop = asyncio.Event(), asyncio.get_running_loop()
        slow[0].stuck = lambda: loop.call_soon_threadsafe(stuck.set)
        await stuck.wait()
        play.clock.advance_to(play.playback.state.end)
        for _ in range(100):
            await asyncio.sleep(0)
        assert play.playback.state.phase == "playing"
        slow[0].gate.set()
        await play.phase("ended")
        assert odometry[-1] == pytest.approx(BEGIN + 2.98, abs=0.001)


class Torn(MemoryLog):
    """A file that is damaged, once it is."""

    torn = False

    def messages(self, begin: Any = None, channels: Any = None) -> Any:
        if self.torn:
            raise LogError("memory.mcap is damaged; try hbba log repair")
        return super().messages(begin, channels)


@pytest.fixture
def torn() -> Prepared:
    """A recording that can be damaged while it is played."""
    return prepare(Torn(lab_messages(3.0), lab_manifest()))


async def test_what_cannot_be_read_is_said_and_all_stays(torn: Prepared) -> None:
    log = torn[0]
    async with played(torn) as play:
        await play.playback.seek(BEGIN + 1.0)
        log.torn = True
        for doing in (play.playback.seek(BEGIN + 2.0), play.playback.step()):
            with pytest.raises(LogError, match="hbba log repair"):
                await doing
        assert play.playback.state.position == BEGIN + 1.0
        assert play.playback.state.phase == "paused"
        assert isinstance(play.replay.system.graph.channels["kinect"].latest, Image)
        log.torn = False
        await play.playback.seek(BEGIN + 2.0)
        assert play.playback.state.position == BEGIN + 2.0


async def test_it_begins_at_the_time_of_the_clock(lab: Prepared) -> None:
    log, clock, replay = lab
    clock.jump(BEGIN + 2.0)
    async with played((log, clock, replay)) as play:
        await play.phase("paused")
        assert play.playback.state.position == BEGIN + 2.0
        assert play.replay.system.graph.channels["odometry"].latest.stamp == BEGIN + 2.0


@pytest.fixture
def hurt(tmp_path: Path) -> Iterator[tuple[Prepared, Log, float, float]]:
    """A recording with a damaged chunk, its other handle, and from when to when that chunk was."""
    path = write_log(tmp_path / "hurt.mcap", lab_messages(6.0), lab_manifest())
    begin, end = damage(path, BEGIN + 3.0)
    log, past = McapLog(path), McapLog(path)
    clock = ReplayClock(log.info.begin, log.info.end)
    yield (log, clock, Replay(log, clock)), past, begin, end
    log.close()
    past.close()


async def test_playback_pauses_before_damage_and_goes_on_behind_it(hurt: Any) -> None:
    prepared, past, begin, end = hurt
    async with played(prepared, playing=True, speed=4.0, past=past) as play, asyncio.timeout(PATIENCE_S):
        odometry = stamps(play, "odometry")
        state = await play.phase("paused")
        assert state.problem == f"{end - begin:.1f} s from {place(begin - BEGIN)} cannot be read"
        assert state.position >= begin
        assert max(odometry) < begin
        assert odometry[-1] == pytest.approx(begin, abs=0.021)
        play.playback.play()
        assert play.playback.state.problem == ""
        await play.phase("ended")
        assert play.playback.state.problem == ""
        assert not [stamp for stamp in odometry if begin <= stamp <= end]
        assert odometry[-1] == pytest.approx(BEGIN + 5.98)
        assert play.replay.notes()[-1].startswith("the log is damaged: ")


async def test_a_damaged_part_shows_the_state_before_it_and_elsewhere_all_is_well(hurt: Any) -> None:
    prepared, past, begin, end = hurt
    async with played(prepared, past=past) as play, asyncio.timeout(PATIENCE_S):
        await play.playback.seek((begin + end) / 2)
        await play.problem()
        assert play.playback.state.phase == "paused"
        odometry = play.replay.system.graph.channels["odometry"]
        assert odometry.latest.stamp < begin
        for position in (BEGIN + 1.0, BEGIN + 5.0):
            await play.playback.seek(position)
            assert play.playback.state.problem == ""
            assert odometry.latest.stamp == pytest.approx(position)
        play.playback.play()
        await play.phase("ended")


async def test_without_a_speed_it_pauses_there_too(hurt: Any) -> None:
    prepared, past, begin, end = hurt
    async with played(prepared, playing=True, speed=None, past=past) as play, asyncio.timeout(PATIENCE_S):
        state = await play.phase("paused")
        assert begin <= state.position <= end
        assert state.problem
        await play.playback.step()
        assert play.playback.state.position > state.position


async def test_where_reading_cannot_go_on_it_pauses_and_stays_usable(torn: Prepared) -> None:
    log = torn[0]
    async with played(torn, playing=True, speed=10.0) as play, asyncio.timeout(PATIENCE_S):
        log.torn = True
        play.replay.body._restart_reading()
        state = await play.phase("paused")
        assert re.fullmatch(r"nothing from 0:0\d\.\d on can be read", state.problem)
        log.torn = False
        await play.playback.seek(BEGIN + 1.0)
        assert play.playback.state.problem == ""
        play.playback.play()
        await play.phase("ended")
