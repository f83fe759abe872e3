"""A perception on another computer: faces in Kinect images, 15 a second, found by a node over a real link on this one.

The robot's program has CPU for ``locate-near-faces-2`` (utility 2); the node has it for ``locate-faces-1`` (8).
``killed`` (SIGKILL), ``frozen`` (SIGSTOP), ``cut`` (the link passes nothing) and ``slow`` (it passes 300 kB/s): the
time from there until attention has put local strategies in force, and until the first faces found at home. ``back``:
from the end of the fault, or from the start of another process, until the node is used again. ``well``: round trips of
images, bytes and rate. ``python -m benchmarks.nodes`` prints the table.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import signal
import socket
import sys
import tempfile
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from app.attention.desires import Source
from app.base import paths
from app.base.child_processes import python
from app.base.geometry import Pose2
from app.link import BaseLimits, LinkFailed, RobotDescription
from app.logs.library import RecordingLibrary
from app.maps.library import MapLibrary
from app.messages import Audio, Faces, JointCommand, Odometry, Twist
from app.program.config import load_configuration
from app.program.system import System
from benchmarks.report import Row, benchmark_main, row
from benchmarks.shaped_tcp import ShapedTcp
from tests.scenery.face_scenes import NAMES, facing, kinect_image

BENCHMARK = "nodes"
ROOT = Path(__file__).resolve().parent.parent
PATIENCE_S = 180.0
IMAGES_HZ, ODOMETRY_HZ = 15.0, 50.0
SLOW_BPS = 300e3

PROGRAM = """\
robot: robot.yaml
channels: channels.yaml
strategies: [strategies.yaml]
modules:
  FaceDetector:
    class: app.modules.perception.face_detector:FaceDetector
    inputs: {{images: kinect, odometry: odometry}}
    outputs: {{faces: faces}}
nodes:
  listen: tcp/127.0.0.1:{port}
  computers:
    desk: {{modules: [FaceDetector], cpu: 100, bandwidth: 10, deadline_s: {deadline_s}}}
"""
CHANNELS = """\
kinect: {type: Image, rate_hz: 15, external: true}
odometry: {type: Odometry, rate_hz: 50, decimable: false, external: true}
faces: {type: Faces}
"""
STRATEGIES = """\
resources:
  cpu: {capacity: 15, unit: "% of one core"}
families:
  - names: locate-faces-{phi}
    class: LocateFaces
    phis: [1, 2, 4, 8]
    utility: {at_1: 8}
    filters: {FaceDetector.images: phi}
    parameters: {FaceDetector: {fine: true}}
    costs: {cpu: {base: 0, slope: 60}}
  - names: locate-near-faces-{phi}
    class: LocateFaces
    phis: [1, 2, 4]
    utility: {at_1: 4}
    filters: {FaceDetector.images: phi}
    parameters: {FaceDetector: {fine: false}}
    costs: {cpu: {base: 0, slope: 22}}
"""


class _StillBody:
    """A RobotLink of a body without streams, which never moves."""

    description = RobotDescription(
        "a still body",
        paths.config_dir() / "robots" / "irl1_tr.urdf",
        BaseLimits(0.4, 1.0, 0.4, 4.0),
        {},
        simulated=True,
    )

    async def start(self) -> None: ...

    async def stop(self) -> None: ...

    async def wait_failed(self) -> LinkFailed:
        await asyncio.Event().wait()
        raise AssertionError

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        return lambda: None

    def demand(self, stream: str, rate_hz: float) -> None: ...

    def periods(self, stream: str) -> int:
        return 1

    def command(self, command: Twist | JointCommand) -> None: ...

    def play(self, audio: Audio) -> None: ...

    def e_stop(self, reason: str) -> None: ...

    def clear_e_stop(self) -> None: ...


@dataclass(slots=True)
class _Figures:
    """Samples of all rounds, s; by what was done to the node."""

    fallen_back: dict[str, list[float]] = field(default_factory=dict)
    found: dict[str, list[float]] = field(default_factory=dict)
    back: dict[str, list[float]] = field(default_factory=dict)
    trips: list[float] = field(default_factory=list)
    megabytes_per_s: list[float] = field(default_factory=list)
    looked_at_hz: list[float] = field(default_factory=list)
    looked_at_home_hz: list[float] = field(default_factory=list)
    utility: list[float] = field(default_factory=list)
    utility_home: list[float] = field(default_factory=list)


def measure(rounds: int, window_s: float, deadline_s: float = 0.5) -> list[Row]:
    """All cases."""
    figures = asyncio.run(_measure(rounds, window_s, deadline_s))
    rows = []
    for case, samples in figures.fallen_back.items():
        rows.append(row(BENCHMARK, case, "until local strategies", "s", samples))
        rows.append(row(BENCHMARK, case, "until local faces", "s", figures.found[case]))
        rows.append(row(BENCHMARK, case, "back", "s", figures.back[case]))
    trips = sorted(figures.trips)
    home = "without the node"
    return [
        *rows,
        row(BENCHMARK, "well", "round trip p50", "ms", [1e3 * trips[len(trips) // 2]]),
        row(BENCHMARK, "well", "round trip p95", "ms", [1e3 * trips[math.ceil(0.95 * len(trips)) - 1]]),
        row(BENCHMARK, "well", "sent", "MB/s", figures.megabytes_per_s),
        row(BENCHMARK, "well", "looked at", "Hz", figures.looked_at_hz, figures.looked_at_home_hz, home),
        row(BENCHMARK, "well", "utility", "", figures.utility, figures.utility_home, home),
    ]


async def _measure(rounds: int, window_s: float, deadline_s: float) -> _Figures:
    figures = _Figures()
    with tempfile.TemporaryDirectory() as name:
        folder, port = Path(name), _free_port()
        system = await asyncio.to_thread(_build, folder, port, deadline_s)
        with ShapedTcp(port) as link:
            async with system:
                system.workspace.add("LocateFaces", intensity=8, utility=1, source=Source("rest", "benchmark"))
                feeding = asyncio.create_task(_feed(system))
                try:
                    for _ in range(rounds):
                        await _round(system, _Fault(system, folder, link, figures, window_s))
                finally:
                    feeding.cancel()
    return figures


@dataclass(slots=True)
class _Fault:
    """One round: a node, what happens to it, and what it takes to do without it and to have it again."""

    system: System
    folder: Path
    link: ShapedTcp
    figures: _Figures
    window_s: float

    async def case(self, name: str, begin: Callable[[], object], end: Callable[[], object]) -> None:
        """Begin a fault and wait for the robot to do without the node; end it, and wait for the node."""
        clock = self.system.clock
        faces = self.system.graph.channels["faces"].subscribe("benchmark", capacity=64)
        began = clock.now()
        begin()
        await _until(self.system, lambda: not _at_desk(self.system))
        applied = clock.now()
        local = self.system.graph.modules["FaceDetector"].context.outputs["faces"]
        offered = local.offered
        async with asyncio.timeout(PATIENCE_S):
            while local.offered == offered:
                await faces.receive()
        self.figures.found.setdefault(name, []).append(clock.now() - began)
        self.figures.fallen_back.setdefault(name, []).append(applied - began)
        self.system.graph.channels["faces"].unsubscribe(faces)
        ended = clock.now()
        end()
        await _until(self.system, lambda: _at_desk(self.system))
        self.figures.back.setdefault(name, []).append(clock.now() - ended)

    async def window(self, rates: list[float], utilities: list[float]) -> None:
        """Rate of images looked at, and utility produced, over some time."""
        count = 0

        def note(_: Faces) -> None:
            nonlocal count
            count += 1

        end = self.system.graph.channels["faces"].observe(note)
        await self.system.clock.sleep(self.window_s)
        end()
        rates.append(count / self.window_s)
        current = self.system.translator.current
        assert current is not None
        utilities.append(sum(strategy.utility for strategy in current.strategies))


async def _round(system: System, fault: _Fault) -> None:
    await _until(system, lambda: not _at_desk(system) and system.translator.current is not None)
    await fault.window(fault.figures.looked_at_home_hz, fault.figures.utility_home)
    assert system.nodes is not None
    link = system.nodes.hub.link("desk")
    async with _process(fault) as first:
        await _until(system, lambda: _at_desk(system))
        sent = link.sent_bytes
        end = link.observe_trips(fault.figures.trips.append)
        await fault.window(fault.figures.looked_at_hz, fault.figures.utility)
        end()
        fault.figures.megabytes_per_s.append(1e-6 * (link.sent_bytes - sent) / fault.window_s)
        await fault.case("frozen", lambda: first.send_signal(signal.SIGSTOP), lambda: first.send_signal(signal.SIGCONT))
        await fault.case("cut", lambda: _hold(fault.link, True), lambda: _hold(fault.link, False))
        await fault.case("slow", lambda: _rate(fault.link, SLOW_BPS), lambda: _rate(fault.link, None))
        async with contextlib.AsyncExitStack() as stack:
            later = asyncio.get_running_loop().create_future()

            async def again() -> None:
                later.set_result(await stack.enter_async_context(_process(fault)))

            starting: list[asyncio.Task[None]] = []
            await fault.case("killed", first.kill, lambda: starting.append(asyncio.create_task(again())))
    await _until(system, lambda: not _at_desk(system))


def _hold(link: ShapedTcp, held: bool) -> None:
    link.held = held


def _rate(link: ShapedTcp, bytes_per_s: float | None) -> None:
    link.bytes_per_s = bytes_per_s


def _at_desk(system: System) -> bool:
    current = system.translator.current
    return current is not None and any(name.endswith("@desk") for name in current.selection.strategies)


async def _until(system: System, holds: Callable[[], bool]) -> None:
    changed = asyncio.Event()
    end = system.translator.observe(lambda _: changed.set())
    try:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                changed.clear()
                await changed.wait()
    finally:
        end()


@contextlib.asynccontextmanager
async def _process(fault: _Fault) -> AsyncIterator[asyncio.subprocess.Process]:
    join = f"tcp/127.0.0.1:{fault.link.port}"
    process = await asyncio.create_subprocess_exec(
        *python("-m", "app.cli", "node", "--config", str(fault.folder / "program.yaml"), "--join", join),
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.send_signal(signal.SIGCONT)
            process.kill()
        await process.wait()


def _build(folder: Path, port: int, deadline_s: float) -> System:
    program = PROGRAM.format(port=port, deadline_s=deadline_s)
    files = {"program": program, "channels": CHANNELS, "strategies": STRATEGIES, "robot": "{}\n"}
    for name, text in files.items():
        (folder / f"{name}.yaml").write_text(text)
    return System(
        load_configuration(folder / "program.yaml"),
        link=_StillBody(),
        recordings=RecordingLibrary(folder / "recordings"),
        maps=MapLibrary(folder / "maps"),
        nodes=True,
    )


async def _feed(system: System) -> None:
    """A face 1.5 m ahead, again and again, and a robot that keeps still."""
    name = NAMES[0]
    picture = kinect_image(0.0, Pose2(0.0, 0.0, 0.0), [facing(name, (1.6, 0.0, 1.3))])
    period_s = 1 / ODOMETRY_HZ
    due, beat = system.clock.now(), 0
    while True:
        stamp = system.clock.now()
        system.graph.channels["odometry"].publish(Odometry(stamp, Pose2(0.0, 0.0, 0.0), 0.0, 0.0))
        if int(beat * IMAGES_HZ / ODOMETRY_HZ) != int((beat + 1) * IMAGES_HZ / ODOMETRY_HZ):
            system.graph.channels["kinect"].publish(replace(picture, stamp=stamp))
        beat += 1
        due = max(due + period_s, stamp)
        await system.clock.sleep_until(due)


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: measure(1, 5) if quick else measure(5, 10)))
