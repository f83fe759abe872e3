"""The cost of recording, at the full rates of the lab: Kinect 15 Hz, panoramic camera 10 Hz, laser 40 Hz, and the rest.

``lab``: the running program, simulated body and all, recording and not recording in turn: the Recorder's CPU time as
the program itself counts it (loop and writer's thread), that of the whole process, and how late the event loop comes.
``stream``: what the lab's body gave, set to exactly these rates (a busy computer's simulation gives less) and written
as fast as it goes, by ours and by rosbags' Writer; the latter makes the ROS types of the same sensors (JPEG quality 90,
raw depth, sound as Int16MultiArray), without tf, points and what ROS has no place for. ``phi 2`` to ``8``: pictures and
scans thinned so, sound left out from 4 on, as the lab's strategies do.
``python -m benchmarks.recording`` prints the table. Per cent are of one core.
"""

from __future__ import annotations

import asyncio
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import quantiles
from typing import Any

import cv2
import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from app.attention.desires import Source
from app.logs.library import RecordingLibrary
from app.logs.manifest import Manifest
from app.logs.mcap.file_sink import FileSink
from app.logs.mcap.writer import FLUSH_S
from app.logs.ros.encoder import Encoder
from app.logs.stamps import to_ns
from app.messages import Audio, Image, JointState, LaserScan, Odometry, Twist
from app.program.config import load_configuration
from app.program.system import System
from benchmarks.report import Row, benchmark_main, row

CONFIG = Path(__file__).resolve().parent.parent / "config" / "lab.yaml"
Arrived = tuple[float, str, Any]
#: A body turning before the lab's furniture: its pictures change, as they do when a robot is worth recording.
SPIN_RADPS = 0.4
_SOUND_UP_TO = 2


def measure(rounds: int, window_s: int) -> list[Row]:
    """Both cases."""
    stream: list[Arrived] = []
    rows = asyncio.run(_lab(rounds, window_s, stream))
    return [*rows, *_streams(at_full_rates(stream, window_s), rounds)]


# --- the running program ---


async def _lab(rounds: int, window_s: int, stream: list[Arrived]) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        configuration = await asyncio.to_thread(load_configuration, CONFIG)
        library = RecordingLibrary(Path(folder))
        system = System(configuration, recordings=library)
        off: list[_Window] = []
        on: list[_Window] = []
        async with system:
            driving = asyncio.create_task(_spin(system))
            with system.workspace.transaction():
                for motive in system.workspace.desires():
                    system.workspace.remove(motive.id)
            await asyncio.sleep(3)
            for number in range(rounds):
                off.append(await _window(system, window_s))
                desire = system.workspace.add(
                    "Record", params={}, source=Source("rest", "benchmark"), intensity=1.0, utility=1.0
                )
                await asyncio.sleep(2)  # its first second makes the types of all topics
                ends = _tap(system, stream) if number == 0 else []
                on.append(await _window(system, window_s))
                for end in ends:
                    end()
                system.workspace.remove(desire.id)
                await asyncio.sleep(1)
            driving.cancel()
        assert not any(window.dropped for window in on), "a benchmark of a recorder that drops is worth nothing"
    peer = "not recording"
    late = row("recording", "lab", "loop late p99", "ms", [w.late_ms for w in on], [w.late_ms for w in off], peer)
    whole = row("recording", "lab", "whole process", "%", [w.process for w in on], [w.process for w in off], peer)
    return [
        row("recording", "lab", "Recorder", "%", [w.recorder for w in on], [w.recorder for w in off], peer),
        whole,
        late,
        row("recording", "lab", "on disk", "MB/s", [w.megabytes for w in on]),
        row("recording", "lab", "pictures", "Hz", [w.pictures for w in on]),
        row("recording", "lab", "scans", "Hz", [w.scans for w in on]),
    ]


@dataclass(frozen=True, slots=True)
class _Window:
    """Seconds of the program's life.

    CPU (%), p99 lateness of the loop (ms), MB/s written, pictures and scans recorded per second, messages dropped.
    """

    recorder: float
    process: float
    late_ms: float
    megabytes: float
    pictures: float
    scans: float
    dropped: int


async def _window(system: System, seconds: int) -> _Window:
    meter = system.graph.modules["Recorder"].context.meter
    inputs = system.graph.modules["Recorder"].context.inputs
    taken = [inputs[name].subscription.taken for name in ("kinect", "scan")]
    late: list[float] = []
    begin, process, cpu, before = time.monotonic(), time.process_time(), meter.cpu_ns, _written(system)
    while time.monotonic() - begin < seconds:
        asked = time.monotonic()
        await asyncio.sleep(0.005)
        late.append(1e3 * (time.monotonic() - asked - 0.005))
    elapsed = time.monotonic() - begin
    status = system.graph.channel("recorder").latest
    return _Window(
        100 * (meter.cpu_ns - cpu) / 1e9 / elapsed,
        100 * (time.process_time() - process) / elapsed,
        quantiles(late, n=100)[-1],
        (_written(system) - before) / 1e6 / elapsed,
        (inputs["kinect"].subscription.taken - taken[0]) / elapsed,
        (inputs["scan"].subscription.taken - taken[1]) / elapsed,
        0 if status is None else status.dropped,
    )


def _written(system: System) -> int:
    status = system.graph.channel("recorder").latest
    return 0 if status is None else int(status.bytes)


async def _spin(system: System) -> None:
    while True:
        system.link.command(Twist(system.clock.now(), 0.0, SPIN_RADPS))
        await asyncio.sleep(0.1)


def _tap(system: System, stream: list[Arrived]) -> list[Callable[[], None]]:
    """Keep what the body gives from now on."""

    def take(channel: str) -> Callable[[Any], None]:
        return lambda message: stream.append((system.clock.now(), channel, message))

    channels = {"kinect": "kinect", "panorama": "panorama", "microphones": "microphones", "hokuyo": "scan",
                "odometry": "odometry", "joints": "joints"}  # fmt: skip
    return [system.link.attach(name, take(channel)) for name, channel in channels.items()]


# --- the same once more ---


def at_full_rates(stream: list[Arrived], seconds: int) -> list[Arrived]:
    """The same messages, each channel at the rate of its table; where there are too few, they come round again."""
    table, begin = load_configuration(CONFIG).channels, stream[0][0]
    timed: list[Arrived] = []
    for name in {channel for _, channel, _ in stream}:
        messages = [message for _, channel, message in stream if channel == name]
        rate = table[name].rate_hz or 1.0
        timed += [(begin + i / rate, name, messages[i % len(messages)]) for i in range(round(seconds * rate))]
    return sorted(timed, key=lambda arrived: arrived[:2])


def thinned(stream: list[Arrived], divisor: int) -> list[Arrived]:
    """Every so-manieth picture and scan, and all the rest; sound only where that is every second one at least."""
    seen = {"kinect": 0, "panorama": 0, "scan": 0}
    kept = []
    for arrived in stream:
        if arrived[1] == "microphones" and divisor > _SOUND_UP_TO:
            continue
        if arrived[1] in seen:
            seen[arrived[1]] += 1
            if seen[arrived[1]] % divisor:
                continue
        kept.append(arrived)
    return kept


def _streams(stream: list[Arrived], rounds: int) -> list[Row]:
    mine: list[tuple[float, float]] = []
    peer: list[tuple[float, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        # The first of each makes the types of all topics.
        for number in range(rounds + 1):
            mine.append(ours(stream, Path(folder) / f"ours-{number}.mcap"))
            peer.append(rosbags(stream, Path(folder) / f"peer-{number}"))
        costs = {phi: [ours(thinned(stream, phi), Path(folder) / f"{phi}-{n}.mcap")[0] for n in range(rounds)]
                   for phi in (2, 4, 8)}  # fmt: skip
    name = "rosbags Writer"
    return [
        *(row("recording", f"stream, phi {phi}", "CPU", "%", cpu) for phi, cpu in costs.items()),
        row("recording", "stream", "CPU", "%", [o[0] for o in mine[1:]], [p[0] for p in peer[1:]], name),
        row("recording", "stream", "on disk", "MB/s", [o[1] for o in mine[1:]], [p[1] for p in peer[1:]], name),
    ]


def ours(stream: list[Arrived], path: Path) -> tuple[float, float]:
    """Write ``stream`` as the Recorder does; % of a core, had it come in real time, and MB/s."""
    table = load_configuration(CONFIG).channels
    begin = time.process_time()
    sink = FileSink([path], Encoder(table), Manifest(), stream[0][0])
    flushed = stream[0][0]
    for at, channel, message in stream:
        sink.write(at, channel, message)
        if at - flushed >= FLUSH_S:
            sink.flush()
            flushed = at
    sink.close(discard=False)
    return _per_second(stream, time.process_time() - begin, path.stat().st_size)


def rosbags(stream: list[Arrived], path: Path) -> tuple[float, float]:
    """The same by rosbags."""
    begin = time.process_time()
    peer = _Peer(path)
    with peer.writer:
        for at, channel, message in stream:
            peer.write(to_ns(at), channel, message)
    return _per_second(stream, time.process_time() - begin, sum(file.stat().st_size for file in path.iterdir()))


def _per_second(stream: list[Arrived], cpu_s: float, size: int) -> tuple[float, float]:
    duration = stream[-1][0] - stream[0][0]
    return 100 * cpu_s / duration, size / 1e6 / duration


class _Peer:
    """Sensors' messages as ROS 2 types, by rosbags alone."""

    def __init__(self, path: Path) -> None:
        self.store = get_typestore(Stores.ROS2_HUMBLE)
        self.writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        self.writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._connections: dict[str, Any] = {}

    def write(self, at: int, channel: str, message: Any) -> None:
        """Write all that ``message`` becomes."""
        header = self._make("std_msgs/msg/Header", self._time(message.stamp), getattr(message, "frame", ""))
        match message:
            case Image():
                bgr = cv2.cvtColor(message.color, cv2.COLOR_RGB2BGR)
                jpeg = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 90])[1].reshape(-1)
                self._put(at, f"/{channel}/color", "sensor_msgs/msg/CompressedImage", header, "jpeg", jpeg)
                if message.depth is None:
                    return
                height, width = message.depth.shape
                depth = message.depth.view(np.uint8).reshape(-1)
                kind = "sensor_msgs/msg/Image"
                self._put(at, f"/{channel}/depth", kind, header, height, width, "16UC1", 0, 2 * width, depth)
            case LaserScan():
                end = message.angle_min + (len(message.ranges) - 1) * message.angle_increment
                self._put(
                    at, f"/{channel}", "sensor_msgs/msg/LaserScan", header, message.angle_min, end,
                    message.angle_increment, message.duration_s / len(message.ranges), 0.025, message.range_min,
                    message.range_max, message.ranges, message.intensities,
                )  # fmt: skip
            case Odometry():
                point = self._make("geometry_msgs/msg/Point", message.X_OB.x, message.X_OB.y, 0.0)
                turn = self._make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
                pose = self._make("geometry_msgs/msg/Pose", point, turn)
                still = self._make("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
                twist = self._make("geometry_msgs/msg/Twist", still, still)
                zeros = np.zeros(36)
                self._put(
                    at, f"/{channel}", "nav_msgs/msg/Odometry", header, "base_link",
                    self._make("geometry_msgs/msg/PoseWithCovariance", pose, zeros),
                    self._make("geometry_msgs/msg/TwistWithCovariance", twist, zeros),
                )  # fmt: skip
            case Audio():
                layout = self._make("std_msgs/msg/MultiArrayLayout", [], 0)
                self._put(at, f"/{channel}", "std_msgs/msg/Int16MultiArray", layout, message.samples.reshape(-1))
            case JointState():
                none = np.empty(0)
                positions = np.array(message.positions)
                kind = "sensor_msgs/msg/JointState"
                self._put(at, f"/{channel}", kind, header, list(message.names), positions, none, none)

    def _make(self, name: str, *values: Any) -> Any:
        return self.store.types[name](*values)

    def _time(self, stamp: float) -> Any:
        return self._make("builtin_interfaces/msg/Time", *divmod(to_ns(stamp), 10**9))

    def _put(self, at: int, topic: str, kind: str, *values: Any) -> None:
        if topic not in self._connections:
            self._connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        self.writer.write(self._connections[topic], at, self.store.serialize_cdr(self._make(kind, *values), kind))


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(2, 5) if quick else measure(5, 15)))
