"""Disks that fail on purpose, and messages to put on them."""

from __future__ import annotations

import errno
import os
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np

from app.base.geometry import CameraModel, Pose2, Pose3
from app.logs.manifest import AttachedFile, Manifest
from app.logs.mcap.open_file import RawFile, create
from app.logs.ros.encoder import Encoder
from app.messages import Image, Landmark, Landmarks, Odometry, read_only
from app.runtime.channel_table import ChannelSpec, ChannelTable

BEGIN = 1_790_000_000.0

MANIFEST = Manifest(
    (AttachedFile("lab.yaml", "application/yaml", b"robot: robots/none.yaml\n"),),
    {"program": "lab.yaml", "robot": "a test body"},
)


def table() -> ChannelTable:
    rows = {
        "odometry": {"type": "Odometry", "rate_hz": 100},
        "kinect": {"type": "Image", "rate_hz": 15},
        "landmarks": {"type": "Landmarks", "latched": True},
    }
    return ChannelTable({name: ChannelSpec.model_validate(row) for name, row in rows.items()})


def encoder() -> Encoder:
    return Encoder(table())


def odometry(at: float) -> Odometry:
    return Odometry(at, Pose2(at - BEGIN, 0.5, 0.25), 0.3, -0.1)


def landmarks(at: float, text: str) -> Landmarks:
    return Landmarks(at, (Landmark(text, (1.0, 2.0, 0.5), 0.1, 3, at, at),))


def image(at: float, seed: int = 0, scale: int = 1) -> Image:
    """Noise, which no compression makes smaller, 64 x 48 px times ``scale``."""
    rng = np.random.default_rng(seed)
    width, height = 64 * scale, 48 * scale
    color = read_only(rng.integers(0, 256, (height, width, 3), dtype=np.uint8))
    depth = read_only(rng.integers(0, 2**16, (height, width), dtype=np.uint16))
    camera = CameraModel(width, height, 60.0 * scale, 60.0 * scale, 0.5 * (width - 1), 0.5 * (height - 1))
    return Image(at, "kinect_optical_frame", color, depth, camera, Pose3(np.eye(3), np.zeros(3)))


class FaultyFile:
    """A file on a disk of ``room`` bytes; ``fault()`` is called before each write and may raise or block."""

    def __init__(self, file: RawFile, room: Callable[[], int], fault: Callable[[int], None]) -> None:
        self._file = file
        self._room = room
        self._fault = fault
        self.size = 0

    def write(self, data: memoryview, /) -> int | None:
        self._fault(self.size)
        room = self._room() - self.size
        if room <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        taken = self._file.write(data[:room])
        self.size += taken or 0
        return taken

    def truncate(self, size: int, /) -> int:
        self.size = size
        return self._file.truncate(size)

    def close(self) -> None:
        self._file.close()


class Disk:
    """Opens files that fail as set; ``blocked`` writes wait until ``unblock`` is set."""

    def __init__(self, room: int = 1 << 40) -> None:
        self.room = room
        #: Raised by every write from now on.
        self.error: OSError | None = None
        self.unblock = threading.Event()
        #: A write has come.
        self.met = threading.Event()
        #: How many writes wait.
        self.waiting = 0
        self.unblock.set()

    def open(self, path: Path) -> RawFile:
        return FaultyFile(create(path), lambda: self.room, self._fault)

    def _fault(self, size: int) -> None:
        self.waiting += 1
        self.met.set()
        self.unblock.wait()
        self.waiting -= 1
        if self.error is not None:
            raise self.error
