"""MCAP files for tests, written with the MCAP library alone: our own writer is not what these tests ask about."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer

from app.base.geometry import CameraModel, Pose2, Pose3
from app.logs import layout as mcap_layout
from app.logs.log import Logged
from app.logs.manifest import Manifest
from app.logs.ros.encoder import Encoder
from app.logs.ros.record import Record
from app.logs.stamps import to_ns
from app.messages import Image, JointState, LaserScan, LinkStatus, Odometry, Twist, read_only
from app.runtime.channel_table import ChannelSpec

BEGIN = 1_790_000_000.0
NOTHING = Manifest()


def spec(message: str, rate_hz: float | None = None) -> ChannelSpec:
    """A row of the table of channels."""
    return ChannelSpec(type=message, rate_hz=rate_hz)


CHANNELS = {
    "kinect": spec("Image", 15),
    "scan": spec("LaserScan", 40),
    "odometry": spec("Odometry", 100),
    "joints": spec("JointState", 30),
    "link_status": spec("LinkStatus", 20),
}


def write_log(
    path: Path,
    messages: Iterable[Logged],
    channels: Mapping[str, ChannelSpec] | None = None,
    manifest: Manifest = NOTHING,
    *,
    chunk_size: int = 64 * 1024,
    keep: Callable[[Record], bool] = lambda record: True,
    extra: Callable[[Writer], None] = lambda writer: None,
    library: str | None = None,
) -> Path:
    """A finished recording of ``messages``; records that ``keep`` refuses are left out, ``extra`` may add more."""
    encoder = Encoder(channels or CHANNELS)
    ids: dict[str, int] = {}
    with open(path, "wb") as file:
        writer = Writer(file, chunk_size=chunk_size, compression=CompressionType.ZSTD)
        writer.start(mcap_layout.PROFILE, library or mcap_layout.library())
        writer.add_metadata(mcap_layout.FACTS, dict(manifest.facts))
        for attached in manifest.files:
            writer.add_attachment(0, 0, attached.name, attached.media_type, attached.data)
        for logged in messages:
            for record in encoder.encode(logged.channel, logged.message):
                if not keep(record):
                    continue
                if record.topic not in ids:
                    text = encoder.definition(record.type).encode()
                    schema = writer.register_schema(record.type, mcap_layout.SCHEMA_ENCODING, text)
                    metadata = encoder.channel_metadata(record.topic)
                    ids[record.topic] = writer.register_channel(
                        record.topic, mcap_layout.MESSAGE_ENCODING, schema, metadata
                    )
                writer.add_message(ids[record.topic], to_ns(logged.at), record.data, record.stamp_ns)
        extra(writer)
        writer.finish()
    return path


def drive(seconds: float, size: tuple[int, int] = (48, 64), seed: int = 1) -> list[Logged]:
    """A made-up drive with every sensor of ``CHANNELS`` at its rate, in order of arrival, a little after capture."""
    rng = np.random.default_rng(seed)
    makers: dict[str, Callable[[float], Any]] = {
        "kinect": lambda at: _image(at, size, rng),
        "scan": lambda at: _scan(at, rng),
        "odometry": lambda at: Odometry(at, Pose2(0.3 * (at - BEGIN), 0.1, 0.05 * (at - BEGIN)), 0.3, 0.05),
        "joints": lambda at: JointState(at, ("pan", "tilt"), (0.1 * (at - BEGIN), -0.2)),
        "link_status": lambda at: LinkStatus(at, "driving", "", False, 0.02, Twist(at, 0.3, 0.05), 1.0),
    }
    times = [
        (BEGIN + i / rate, channel)
        for channel, row in CHANNELS.items()
        if (rate := row.rate_hz) is not None
        for i in range(int(seconds * rate))
    ]
    return [Logged(at + 0.003, channel, makers[channel](at)) for at, channel in sorted(times)]


def _image(at: float, size: tuple[int, int], rng: np.random.Generator) -> Image:
    height, width = size
    ramp = np.linspace(0, 200, width)[np.newaxis, :, np.newaxis] + np.linspace(0, 40, height)[:, np.newaxis, np.newaxis]
    color = (ramp + np.array([0, 10, 15])).astype(np.uint8)
    depth = (1500 + np.arange(width) + rng.integers(0, 3, size)).astype(np.uint16)
    pose = Pose3.from_translation_rpy((0.1, 0.0, 1.1), (0.0, 0.1, 0.3 * (at - BEGIN)))
    camera = CameraModel(width, height, 525.5, 525.25, 0.5 * (width - 1), 0.5 * (height - 1))
    return Image(at, "kinect_optical_frame", read_only(color), read_only(depth), camera, pose)


def _scan(at: float, rng: np.random.Generator) -> LaserScan:
    ranges = (4 + rng.random(720)).astype(np.float32)
    ranges[::50] = np.inf
    pose = Pose3.from_translation_rpy((0.2, 0.0, 0.3))
    ones = read_only(np.ones(720, np.float32))
    return LaserScan(at, "hokuyo_link", read_only(ranges), ones, -2.3, 0.0065, 0.06, 30.0, 0.0249, pose)
