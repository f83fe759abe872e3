"""A log replayed headless: complete, filtered as asked, and the same each time."""

from __future__ import annotations

import json
import math
import os
import random
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import takewhile
from pathlib import Path
from typing import Any

import pytest

from app.attention.cached_solver import CachedSolver
from app.link import LinkFailed
from app.logs.library import RecordingLibrary
from app.logs.mcap.reader import McapLog
from app.logs.open import open_log
from app.logs.replay.headless import ReplayWatch, run_headless
from app.logs.replay.options import ReplayOptions
from app.logs.replay.report import ReplaySummary
from app.messages import Exploitation, QRCodes
from app.robots.replayed.log_source import LogSource
from app.runtime.load import CpuMeter
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_log, lab_manifest, lab_messages, numbered, write_log
from tests.patience import PATIENCE_S

DATA = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).parents[4] / "shared" / "data") / "slam"

# Nothing runs on a loop that others wait for: the replay's own loop is virtual.
pytestmark = [pytest.mark.slow, pytest.mark.blocking(reason="the virtual loop waits for threads by design")]


@pytest.fixture(scope="module")
def watched() -> tuple[ReplaySummary, list[tuple[str, Any]]]:
    """A replay of everything, and its messages by channel."""
    seen: list[tuple[str, Any]] = []
    report = run_headless(lab_log(), watch=ReplayWatch(message=lambda channel, said: seen.append((channel, said))))
    return report, seen


@pytest.fixture(scope="module")
def report(watched: tuple[ReplaySummary, list[tuple[str, Any]]]) -> ReplaySummary:
    return watched[0]


def test_every_module_runs_on_the_log(report: ReplaySummary) -> None:
    assert (report.begin, report.log_s) == (BEGIN, pytest.approx(4.0, abs=0.1))
    channels = report.channels
    assert channels["odometry"].messages == 200
    assert channels["joints"].messages == 120
    assert channels["link_status"].messages == 80
    # As many as came: QRCodeDetector wants every second one, to place what it reads
    assert channels["scan"].messages == 40
    taken = report.modules["QRCodeDetector"].inputs["images"].taken
    assert channels["qr_codes"].messages == taken > 10
    assert channels["landmarks"].messages > 0
    assert channels["camera_jpeg"].messages == channels["point_cloud"].messages >= 10  # from 1 to 3 s, as φ gives
    assert report.modules["QRCodeDetector"].cpu_s > 0
    assert all(module.restarts == 0 for module in report.modules.values())


def test_the_operators_commands_drive_again(watched: tuple[ReplaySummary, list[tuple[str, Any]]]) -> None:
    driven = [said.behavior for _, said in watched[1] if isinstance(said, Exploitation)]
    twists = [said for channel, said in watched[1] if channel == "teleop_twist"]
    assert driven[0] is None
    assert driven[-1] is None
    assert "Teleop" in driven
    assert {twist.linear_mps for twist in twists} == {0.0, 0.2}


def test_desires_of_others_come_at_their_times(report: ReplaySummary) -> None:
    """Own motivations from the start; the operator's at 1 s and the script's at 2 s; the operator's gone at 3 s."""
    lines = [(round(line.stamp - BEGIN, 3), line.strategies) for line in report.intentions]
    assert lines[0] == (0.0, ("drive-by-hand",))
    assert lines[1][0] == 0.0
    assert {"find-qr-codes-1", "drive-by-hand"} <= set(lines[1][1])
    assert not any(name.startswith("telepresence") for name in lines[1][1])
    assert lines[2][0] == 1.0
    assert any(name.startswith("telepresence") for name in lines[2][1])
    assert [at for at, _ in lines] == [0.0, 0.0, 1.0, 2.0, 3.0]


def test_without_desires_attention_is_left_to_the_modules() -> None:
    report = run_headless(lab_log(), ReplayOptions(desires=False))
    assert report.channels["camera_jpeg"].messages == 0
    assert {line.stamp for line in report.intentions} == {BEGIN}


def test_beginning_later_has_what_was_desired_then() -> None:
    stood: set[str] = set()

    def message(channel: str, said: Any) -> None:
        if channel == "workspace":
            stood.update(record.id for record in said.desires)

    options = ReplayOptions(begin=BEGIN + 2.5, end=BEGIN + 3.5)
    report = run_headless(lab_log(), options, watch=ReplayWatch(message=message))
    assert report.log_s == 1.0
    assert report.channels["odometry"].messages == 51
    assert [round(line.stamp - BEGIN, 3) for line in report.intentions][-1] == 3.0
    assert "d-4" in stood


def pictures_taken(phi: float, offset: int) -> list[float]:
    stamps: list[float] = []

    def message(_: str, said: Any) -> None:
        if isinstance(said, QRCodes):
            stamps.append(said.stamp)

    # The detector alone: what the others take is their own affair.
    only = ("Kinect", "Hokuyo", "QRCodeDetector")
    options = ReplayOptions(only=only, phi={"QRCodeDetector.images": phi}, offset=offset, desires=False)
    run_headless(lab_log(), options, watch=ReplayWatch(message=message), digests=False)
    return stamps


def test_any_divisor_at_any_offset_takes_exactly_its_share() -> None:
    images = [logged.message.stamp for logged in lab_log().messages(channels={"kinect"})]
    for offset in (0, 3):
        assert pictures_taken(4, offset) == images[offset::4]
    assert pictures_taken(math.inf, 0) == []


def test_an_offset_counts_from_the_first_opening_of_an_attended_filter() -> None:
    """Attention opens the filter at the begin: three images go by, then every one is taken until its φ changes."""
    stamps: list[float] = []

    def message(_: str, said: Any) -> None:
        if isinstance(said, QRCodes):
            stamps.append(said.stamp)

    run_headless(lab_log(), ReplayOptions(offset=3, desires=False), watch=ReplayWatch(message=message))
    images = [logged.message.stamp for logged in lab_log().messages(channels={"kinect"})]
    assert stamps == images[3:]


def test_only_one_module_on_what_was_recorded() -> None:
    log = lab_log()
    report = run_headless(log, ReplayOptions(only=("QRCodeDetector",), phi={"QRCodeDetector.images": 2.0}))
    assert list(report.modules) == ["QRCodeDetector"]
    assert report.channels["qr_codes"].messages == 20
    assert log.decoded.keys() == {"kinect", "scan", "odometry", "workspace", "link_status"}


def test_a_channel_without_subscription_is_never_decoded() -> None:
    log = lab_log()
    # Who drives or maps, and who watches over it, wants scans whatever is desired.
    looking = ("Kinect", "Hokuyo", "WheelOdometry", "QRCodeDetector", "FaceDetector", "CameraStream")
    blind = {"QRCodeDetector.images": math.inf, "QRCodeDetector.scans": math.inf, "FaceDetector.images": math.inf}
    run_headless(log, ReplayOptions(only=looking, desires=False, phi=blind))
    assert "kinect" not in log.decoded
    assert "scan" not in log.decoded


def test_a_damaged_log_ends_with_its_reason() -> None:
    log = MemoryLog(lab_messages(4.0), lab_manifest(), damaged_at=BEGIN + 1.5)
    with pytest.raises(LinkFailed, match="is damaged; try hbba log repair"):
        run_headless(log)


def test_paced_by_real_time() -> None:
    began = time.monotonic()
    report = run_headless(MemoryLog(numbered(50, 0.02), lab_manifest()), speed=2.0)
    assert time.monotonic() - began >= report.log_s / 2.0 * 0.9
    assert report.times_real_time < 2.3


# --- The same each time -----------------------------------------------------------------------------------------------


@contextmanager
def a_busy_computer(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Everything that runs in a thread takes its time, another each time: reading, computing, solving."""
    chance = random.Random(7)

    def late(function: Callable[..., Any]) -> Callable[..., Any]:
        def called(*args: Any, **kwargs: Any) -> Any:
            time.sleep(chance.choice((0.0, 0.0, 0.001, 0.01)))
            return function(*args, **kwargs)

        return called

    with monkeypatch.context() as slow:
        slow.setattr(CpuMeter, "call", late(CpuMeter.call))
        slow.setattr(CachedSolver, "solve", late(CachedSolver.solve))
        slow.setattr(LogSource, "piece", late(LogSource.piece))
        yield


@pytest.mark.parametrize(
    "options",
    [
        ReplayOptions(phi={"CameraStream.images": 3.0, "QRCodeDetector.images": 2.0}, offset=1),
        ReplayOptions(only=("QRCodeDetector", "ScenarioCoordinator"), begin=BEGIN + 0.7),
    ],
    ids=["held and shifted", "some modules, later"],
)
def test_two_replays_are_equal_also_on_a_busy_computer(options: ReplayOptions, monkeypatch: pytest.MonkeyPatch) -> None:
    first = run_headless(lab_log(), options)
    with a_busy_computer(monkeypatch):
        second = run_headless(lab_log(), options, speed=4.0)
    assert first.outcome() == second.outcome()
    assert any(channel.messages for channel in first.channels.values())


def test_a_replay_of_everything_is_the_same_on_a_busy_computer(
    monkeypatch: pytest.MonkeyPatch, report: ReplaySummary
) -> None:
    with a_busy_computer(monkeypatch):
        second = run_headless(lab_log(), speed=4.0)
    assert second.outcome() == report.outcome()


def test_a_recording_on_disk_is_replayed_the_same_on_a_busy_computer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, report: ReplaySummary
) -> None:
    """Read by the real reader, pictures and all; and what is lossless on disk gives what it gave in memory."""
    path = write_log(tmp_path / "lab.mcap", lab_messages(4.0), lab_manifest())

    def once() -> ReplaySummary:
        log = McapLog(path)
        try:
            return run_headless(log)
        finally:
            log.close()

    first = once()
    with a_busy_computer(monkeypatch):
        second = once()
    assert first.outcome() == second.outcome()
    assert first.intentions == report.intentions
    for name in ("joints", "link_status", "teleop_twist", "exploitation", "workspace", "intention", "divisors"):
        assert first.channels[name] == report.channels[name], name
    assert first.channels["kinect"].messages == report.channels["kinect"].messages


@pytest.mark.parametrize("file", ["intel-corrected.log.gz", "freiburg-079-corrected.log.gz"])
def test_a_public_laser_log_runs_through_our_modules(file: str, tmp_path: Path) -> None:
    if not (DATA / file).is_file():
        pytest.skip(f"the public laser logs are not there: {DATA} (set HBBA_REFERENCE_DATA)")
    log = open_log(DATA / file)
    try:
        options = ReplayOptions(end=log.info.begin + 90, record="again")
        report = run_headless(log, options, digests=False, recordings=RecordingLibrary(tmp_path))
        replayed = takewhile(lambda logged: logged.at <= report.end, log.messages(channels={"odometry", "scan"}))
        counts = Counter(logged.channel for logged in replayed)
    finally:
        log.close()
    for module in ("Kinect", "QRCodeDetector"):
        assert any(note.startswith(f"{module} does not run: the log has no ") for note in report.notes)
    taken = report.modules["Recorder"].inputs["odometry"]
    assert taken.taken == counts["odometry"] > 100
    assert taken.dropped == 0
    assert report.channels["scan"].messages == counts["scan"] > 20
    again = McapLog(tmp_path / "again.mcap")
    assert {name: again.info.channels[name].count for name in counts} == counts
    again.close()
    assert all(module.restarts == 0 for module in report.modules.values())


def test_processes_agree_whatever_their_hash_seed(report: ReplaySummary, tmp_path: Path) -> None:
    script = (
        "import json, sys; from tests.logs.replay.logs import lab_log; "
        "from app.logs.replay.headless import run_headless; "
        "json.dump(run_headless(lab_log()).document(), sys.stdout)"
    )
    other = "77" if os.environ.get("PYTHONHASHSEED") == "1" else "1"  # than this process's own, drawn if not set
    environment = {**os.environ, "PYTHONHASHSEED": other, "PYTHONASYNCIODEBUG": ""}
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment,
        cwd=Path(__file__).parents[3], timeout=PATIENCE_S,
    )  # fmt: skip
    there, here = json.loads(done.stdout), json.loads(json.dumps(report.document()))
    del there["cost"], here["cost"]
    assert there == here


def test_a_replay_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tempfile

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    run_headless(lab_log(1.0), recordings=RecordingLibrary(tmp_path / "recordings"))
    assert list(tmp_path.iterdir()) == []
