"""A program whose one perception may run on another computer, and that computer: in this process, or in its own."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import numpy as np

from app.attention.desires import Source
from app.base import paths
from app.base.child_processes import python
from app.base.geometry import CameraModel, Pose3
from app.logs.library import RecordingLibrary
from app.maps.library import MapLibrary
from app.messages import Image
from app.program.config import load_configuration
from app.program.nodes import described_modules, node_of
from app.program.system import System
from app.remote.node import Node
from app.remote.session import configuration
from app.remote.settings import TlsFiles
from tests.console.program import Body
from tests.patience import PATIENCE_S

ME = Source("operator", "test")
ROOT = Path(__file__).resolve().parents[2]

PROGRAM = """\
robot: robot.yaml
channels: channels.yaml
strategies: [strategies.yaml]
modules:
  Darkness:
    class: tests.remote.stuck:StuckDetector
    inputs: {{images: camera}}
    outputs: {{darkness: darkness}}
    settings: {settings}
nodes:
  listen: {listen}
  {tls}
  computers:
    desk: {{modules: [Darkness], cpu: 100, deadline_s: {deadline_s}}}
"""
CHANNELS = """\
camera: {type: Image, rate_hz: 15, external: true}
darkness: {type: Darkness}
"""
#: At home there is CPU for the lesser strategy alone.
STRATEGIES = """\
resources:
  cpu: {capacity: 15, unit: "%"}
strategies:
  - {name: look, class: DetectDarkness, utility: 4, filters: {Darkness.images: 1}, costs: {cpu: 50}}
  - {name: look-seldom, class: DetectDarkness, utility: 1, filters: {Darkness.images: 2}, costs: {cpu: 10}}
"""


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def write(
    folder: Path,
    port: int,
    *,
    settings: str = "{}",
    protocol: str = "tcp",
    tls: str = "",
    deadline_s: float = PATIENCE_S,
) -> Path:
    """The program's files in ``folder``, which is made."""
    folder.mkdir(exist_ok=True)
    listen = f"{protocol}/127.0.0.1:{port}"
    text = PROGRAM.format(listen=listen, settings=settings, tls=tls, deadline_s=min(deadline_s, 60))
    for name, content in {
        "program.yaml": text,
        "channels.yaml": CHANNELS,
        "strategies.yaml": STRATEGIES,
        "robot.yaml": "{}\n",
    }.items():
        (folder / name).write_text(content)
    return folder / "program.yaml"


def build(program: Path) -> System:
    """The robot's program; outside the event loop, since it reads its files."""
    folder = program.parent
    return System(
        load_configuration(program),
        link=Body(),
        recordings=RecordingLibrary(folder / "recordings"),
        maps=MapLibrary(folder / "maps"),
        nodes=True,
    )


def image(stamp: float, frame: str = "camera") -> Image:
    color = np.zeros((48, 64, 3), np.uint8)
    return Image(stamp, frame, color, None, CameraModel.from_vertical_fov(64, 48, 0.75), Pose3.identity())


def node_of_program(program: Path) -> tuple[Node, str]:
    """The node of a program's files, and where it joins; outside the event loop."""
    read = load_configuration(program)
    name, settings = node_of(read, None)
    assert read.program.nodes is not None
    return Node(name, described_modules(read, name, settings), read.channels), read.program.nodes.listen


@contextlib.asynccontextmanager
async def joined(made: tuple[Node, str], tls: TlsFiles | None = None) -> AsyncIterator[asyncio.Task[None]]:
    """The node at work in this process."""
    node, listen = made
    task = asyncio.create_task(node.run(configuration(join=listen, tls=tls)))
    try:
        yield task
    finally:
        task.cancel()
        await asyncio.wait({task})


@contextlib.asynccontextmanager
async def node_process(program: Path, *arguments: str) -> AsyncIterator[asyncio.subprocess.Process]:
    """``hbba node`` in a process of its own, which is killed in the end."""
    port = load_port(program)
    process = await asyncio.create_subprocess_exec(
        *python("-m", "app.cli", "node", "--config", str(program), "--join", f"tcp/127.0.0.1:{port}", *arguments),
        env={**os.environ, "PYTHONPATH": str(ROOT), "HBBA_HOST": paths.host_name()},
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.send_signal(signal.SIGCONT)
            process.kill()
        await process.communicate()


def load_port(program: Path) -> int:
    text = program.read_text()
    return int(text.partition("127.0.0.1:")[2].partition("\n")[0])


async def until(system: System, holds: Callable[[], bool]) -> None:
    """Wait until ``holds`` after an intention was applied, or a link has changed."""
    changed = asyncio.Event()
    ends = [system.translator.observe(lambda _: changed.set())]
    assert system.nodes is not None
    ends.append(system.nodes.hub.observe(lambda *_: changed.set()))
    try:
        async with asyncio.timeout(PATIENCE_S):
            while not holds():
                changed.clear()
                await changed.wait()
    finally:
        for end in ends:
            end()


def chosen(system: System) -> set[str]:
    """The strategies in force."""
    current = system.translator.current
    return set() if current is None else set(current.selection.strategies)


async def looks(system: System, stamp: float) -> None:
    """Publish images, one after another, until one was looked at; its stamp is that of its image."""
    darkness = system.graph.channels["darkness"].subscribe("test", capacity=8)
    published = set()
    try:
        async with asyncio.timeout(PATIENCE_S):
            while True:
                stamp += 0.1
                published.add(stamp)
                system.graph.channels["camera"].publish(image(stamp))
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(0.2):
                        message = await darkness.receive()
                        assert message.stamp in published
                        return
    finally:
        system.graph.channels["darkness"].unsubscribe(darkness)
