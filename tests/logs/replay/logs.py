"""Logs for tests, in memory: what the lab's robot would have recorded before a poster, driven a little by hand."""

from __future__ import annotations

import math
import threading
from collections.abc import Collection, Iterator
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
import segno
from mcap.reader import make_reader

from app.base import paths
from app.base.geometry import CameraModel, Pose2, Pose3
from app.logs.log import LogError, Logged, LoggedChannel, LogInfo
from app.logs.manifest import Manifest
from app.logs.mcap.open_file import McapFile
from app.logs.ros.encoder import Encoder
from app.messages import (
    Desire,
    Desires,
    Image,
    JointState,
    LaserScan,
    LinkStatus,
    Message,
    Odometry,
    Source,
    SourceKind,
    TeleopCommand,
    Twist,
    read_only,
)
from app.program.config import load_configuration
from app.program.system import System

BEGIN = 1_700_000_000.0
CAMERA = CameraModel(160, 120, 147.4, 147.4, 79.5, 59.5)


class MemoryLog:
    """A log that is a list; counts what was decoded of each channel, and fails at ``damaged_at`` if that is given."""

    def __init__(self, messages: list[Logged], manifest: Manifest | None = None, damaged_at: float = math.inf) -> None:
        self._messages = messages
        self._damaged_at = damaged_at
        self.decoded: dict[str, int] = {}
        self.readers: set[int] = set()
        self.closed = False
        channels: dict[str, LoggedChannel] = {}
        for logged in messages:
            before = channels.get(logged.channel)
            channels[logged.channel] = LoggedChannel(
                logged.channel, type(logged.message), 1 if before is None else before.count + 1
            )
        self._info = LogInfo(
            path=Path("memory.mcap"),
            format="memory",
            begin=messages[0].at if messages else 0.0,
            end=messages[-1].at if messages else 0.0,
            channels=channels,
            bytes=0,
        )
        self._manifest = manifest or Manifest()

    @property
    def info(self) -> LogInfo:
        return self._info

    @property
    def manifest(self) -> Manifest:
        return self._manifest

    def messages(self, begin: float | None = None, channels: Collection[str] | None = None) -> Iterator[Logged]:
        for logged in self._messages:
            if begin is not None and logged.at < begin:
                continue
            if channels is not None and logged.channel not in channels:
                continue
            if logged.at >= self._damaged_at:
                raise LogError("memory.mcap: is damaged; try hbba log repair")
            self.readers.add(threading.get_ident())
            self.decoded[logged.channel] = self.decoded.get(logged.channel, 0) + 1
            yield logged

    def close(self) -> None:
        self.closed = True


def numbered(count: int, period_s: float = 0.1, channel: str = "odometry") -> list[Logged]:
    """``count`` odometry messages, a ``period_s`` apart, each further on by 1 m."""
    return [
        Logged(BEGIN + i * period_s, channel, Odometry(BEGIN + i * period_s, Pose2(float(i), 0.0, 0.0), 0.0, 0.0))
        for i in range(count)
    ]


@cache
def lab_manifest() -> Manifest:
    """What a recording of the shipped lab carries."""
    system = System(load_configuration(paths.config_dir() / "lab.yaml"))
    return system.graph.modules["Kinect"].context.services[Manifest]


def poster(text: str = "https://example.org/lab") -> np.ndarray[Any, np.dtype[np.uint8]]:
    """A picture (120, 160, 3) of a QR code on a wall."""
    code = np.array(
        [[not cell for cell in row] for row in segno.make_qr(text, error="m").matrix_iter(border=4)], np.uint8
    )
    scale = 100 // len(code)
    code = np.kron(code, np.ones((scale, scale), np.uint8)) * 255
    picture = np.full((120, 160, 3), 150, np.uint8)
    size = len(code)
    picture[10 : 10 + size, 30 : 30 + size] = code[:, :, None]
    return picture


def desire(desire_id: str, cls: str, *, kind: str = "operator", name: str = "ada", **more: Any) -> Desire:
    """A desire as the workspace records it."""
    usual = {"intensity": 6.0, "utility": 4.0, "security": False, "params": {}, "created": BEGIN}
    return Desire(id=desire_id, cls=cls, source=Source(cast(SourceKind, kind), name), **{**usual, **more})


def lab_messages(seconds: float = 4.0, *, images_hz: float = 10.0) -> list[Logged]:
    """Some seconds of everything that the lab's robot records."""
    messages: list[tuple[float, str, Message]] = []
    rng = np.random.default_rng(1)
    picture = poster()
    X_BC = Pose3(np.array([[0, 0, 1.0], [-1, 0, 0], [0, -1, 0]]), np.array([0.1, 0.0, 1.2]))
    read_only(X_BC.rotation)
    read_only(X_BC.translation)

    def each(rate_hz: float, offset: float = 0.0) -> list[float]:
        return [round(offset + i / rate_hz, 6) for i in range(int(seconds * rate_hz))]

    messages += [(t, "odometry", Odometry(BEGIN + t, Pose2(0.1 * t, 0.0, 0.02 * t), 0.1, 0.02)) for t in each(50)]
    messages += [(t, "joints", JointState(BEGIN + t, ("left_wheel_joint",), (t,))) for t in each(30)]
    for t in each(20):
        status = LinkStatus(BEGIN + t, "driving", "", False, 0.01, Twist(BEGIN + t, 0.1, 0.0), 1.0)
        messages.append((t, "link_status", status))
    for t in each(10, 0.003):
        ranges = read_only(rng.uniform(1, 9, 180).astype(np.float32))
        scan = LaserScan(
            BEGIN + t, "hokuyo_link", ranges, ranges, -1.5, 0.0167, 0.1, 30.0, 0.0125,
            Pose3(np.eye(3), np.zeros(3)),
        )  # fmt: skip
        messages.append((t, "scan", scan))
    for t in each(images_hz, 0.007):
        color = picture.copy()
        color[:8] = rng.integers(0, 255, (8, 160, 3), dtype=np.uint8)
        depth = np.full((120, 160), 2000, np.uint16)
        image = Image(BEGIN + t, "kinect_optical_frame", read_only(color), read_only(depth), CAMERA, X_BC)
        messages.append((t + 0.02, "kinect", image))
    for number, t in enumerate(t for t in each(20) if 0.5 <= t < 2.0):
        messages.append((t, "teleop_command", TeleopCommand(BEGIN + t, "ada", number, True, 0.5, 0.1)))
    coordinator = [
        desire("d-1", "FindQRCodes", kind="motivation", name="ScenarioCoordinator", intensity=8.0, utility=1.0),
        desire("d-2", "Teleoperation", kind="motivation", name="ScenarioCoordinator", intensity=8.0, utility=1.0),
    ]
    eyes = desire("d-3", "Telepresence", params={"max_points": 5000, "jpeg_quality": 70})
    codes = desire("d-4", "FindQRCodes", kind="rest", name="script", intensity=8.0, utility=8.0)
    for t, standing in (
        (0.0, coordinator),
        (1.0, [*coordinator, eyes]),
        (2.0, [*coordinator, eyes, codes]),
        (3.0, [*coordinator, codes]),
    ):
        if t < seconds:
            messages.append((t, "workspace", Desires(BEGIN + t, tuple(standing))))
    messages.sort(key=lambda entry: entry[0])
    return [Logged(BEGIN + t, channel, message) for t, channel, message in messages]


def lab_log(seconds: float = 4.0, **more: Any) -> MemoryLog:
    """A log of the lab with all that a recording carries."""
    return MemoryLog(lab_messages(seconds, **more), lab_manifest())


def write_log(path: Path, messages: list[Logged], manifest: Manifest) -> Path:
    """A recording on disk, as the Recorder writes it."""
    channels = load_configuration(paths.config_dir() / "lab.yaml").channels
    file = McapFile(path, Encoder(channels), manifest, messages[0].at)
    for logged in messages:
        file.write(logged.at, logged.channel, logged.message)
    file.close()
    return path


def damage(path: Path, at: float) -> tuple[float, float]:
    """Zero 200 bytes in the middle of the chunk that holds ``at`` (s); returns from when to when it holds messages."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    chunk = next(c for c in summary.chunk_indexes if c.message_start_time / 1e9 <= at <= c.message_end_time / 1e9)
    with path.open("r+b") as file:
        file.seek(chunk.chunk_start_offset + chunk.chunk_length // 2)
        file.write(bytes(200))
    return chunk.message_start_time / 1e9, chunk.message_end_time / 1e9
