"""``hbba run``: the robot and its console, until Ctrl-C."""

from __future__ import annotations

import argparse
import asyncio
import atexit
import gc
import logging
import os
import signal
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable, Coroutine, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from app.base import logging_setup
from app.commands.arguments import add_config, file_named
from app.commands.body_options import add_body_options, chosen
from app.commands.console_access import (
    ConsoleAccess,
    add_access_options,
    console_access,
    warn_of_plain_connections,
)
from app.commands.kernels import kernels_ready
from app.commands.viewers import add_viewer_options, with_ros2, with_viewers
from app.runtime.realtime import garbage_held, tune_for_latency

if TYPE_CHECKING:
    from app.base.network_link import LinkSettings
    from app.console.fleet.asking import Fleet
    from app.program.config import Configuration
    from app.program.system import System
    from app.robots.factory import Body

#: Everything has stopped by then, or is made to.
STOP_WITHIN_S = 2.0
#: Seconds of one step of its countdown.
COUNT_S = 0.02
#: Characters of a robot's name.
LONGEST_NAME = 40

log = logging.getLogger("hbba.run")


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "run",
        help="start the robot and its console",
        description="Start the robot and its console; Ctrl-C stops both. Options win over the configuration.",
    )
    add_config(parser)
    add_body_options(parser)
    add_console_options(parser)
    add_viewer_options(parser)
    parser.add_argument("--name", type=_name, metavar="NAME", help="this robot's name among those of a fleet")
    parser.add_argument(
        "--fleet",
        type=file_named,
        metavar="FILE",
        help="file with the consoles of other robots, which the page lists",
    )
    parser.add_argument(
        "--link",
        type=_link,
        metavar="SETTINGS",
        help="delay and bound every stream to the pages, for tests: delay=300ms,jitter=50ms,loss=2%%,rate=4Mbit (each "
        "may be left out; delay is that of a round trip)",
    )


def add_console_options(parser: argparse.ArgumentParser) -> None:
    """The options of every command that serves a console."""
    parser.add_argument("--host", metavar="H", help="address to listen on (default 127.0.0.1: this computer alone)")
    parser.add_argument("--port", type=_port, metavar="N", help="port to listen on (default 8080; 0: any free one)")
    parser.add_argument(
        "--scene-port",
        type=_port,
        metavar="N",
        help="port of the 3D view alone (default: the next one, or any that is free; 0: any free one)",
    )
    add_access_options(parser)
    parser.add_argument(
        "--host-name",
        type=_host_name,
        action="append",
        default=[],
        metavar="NAME",
        help="a name others reach this computer by, beside its own; may be repeated",
    )
    parser.add_argument("--open", action="store_true", help="open the console in a browser")
    parser.add_argument("--log-level", choices=logging_setup.LEVELS, default="info", help="least severe events to log")
    parser.add_argument("--log-json", action="store_true", help="log one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """Run until a signal comes or the body fails. Raises ConfigError."""
    with garbage_held():
        return _run(args)


def _run(args: argparse.Namespace) -> int:
    from app.console.server import address_of, listen, listen_for_scene
    from app.link import LinkFailed
    from app.runtime.allocator import share_arenas

    share_arenas()
    configuration, body = chosen(args)
    configuration = with_ros2(with_viewers(configuration, args.foxglove), args.ros2)
    configuration = _named(configuration, args.name)
    console = configuration.program.console
    host = args.host or console.host
    access = console_access(args, host)
    fleet = None if args.fleet is None else _fleet(args.fleet)
    try:
        with ExitStack() as stack:
            listener = stack.enter_context(listen(host, console.port if args.port is None else args.port))
            scene_port = console.scene_port if args.scene_port is None else args.scene_port
            scene = stack.enter_context(listen_for_scene(host, address_of(listener)[1], scene_port))
            logging_setup.configure(args.log_level, as_json=args.log_json)
            warn_of_plain_connections(access, host)
            names = (*console.host_names, *args.host_name)
            live = _live(
                configuration,
                body,
                (listener, scene),
                access,
                names,
                open_browser=args.open,
                link=args.link,
                fleet=fleet,
            )
            return asyncio.run(until_stopped(live, Stopping()))
    except LinkFailed as failure:
        print(f"hbba run: {failure}", file=sys.stderr)
        return 1


async def until_stopped(live: Coroutine[Any, Any, None], stopping: Stopping) -> int:
    """Run ``live`` to its end, or until a stop is requested at any time. Raises what it raises."""
    loop = asyncio.get_running_loop()
    running = asyncio.create_task(live)
    stopping.install(lambda: loop.call_soon_threadsafe(running.cancel))
    try:
        await running
    except asyncio.CancelledError:
        return 0
    finally:
        stopping.begin()
        # Python goes through all objects once more before it ends: 0.4 s in which nothing is left to be done.
        atexit.register(gc.freeze)
    return 0


async def _live(
    configuration: Configuration,
    body: Body,
    listeners: tuple[socket.socket, socket.socket],
    access: ConsoleAccess,
    names: Sequence[str],
    *,
    open_browser: bool,
    link: LinkSettings | None,
    fleet: Fleet | None,
) -> None:
    """Bring everything up, say where, wait for the end, take everything down. Raises LinkFailed, ConfigError.

    ``listeners`` are those of the page and of the 3D view alone.
    """
    import cv2

    from app.console.access.origins import Ports
    from app.console.app import create_app
    from app.console.link_shaper import Link
    from app.console.panels import load_panels
    from app.console.server import address_of, serve
    from app.console.webhooks.kept import default_file
    from app.memory.store import MemoryStore
    from app.memory.store import default_folder as default_memory_folder
    from app.program.system import System
    from app.robots.factory import create_link
    from app.runtime.clock import RealClock
    from app.tours.run_library import RunLibrary, default_folder

    cv2.setNumThreads(1)  # modules have their own threads; OpenCV's pool would only fight them for the cores

    await kernels_ready()
    listener, scene = listeners
    host, port = address_of(listener)
    ports = Ports(port, address_of(scene)[1])
    announce = announcer("HBBA is up", host, port, access, open_browser=open_browser)
    log.info("starting", extra={"configuration": configuration.program_document.file})
    clock = RealClock()
    system = System(
        configuration, link=create_link(body, clock.offset), body=body, clock=clock, runs=RunLibrary(default_folder()),
        memory=MemoryStore(default_memory_folder()), nodes=True,
    )  # fmt: skip
    panels = await asyncio.to_thread(load_panels)
    # Building takes long enough to disturb driving.
    app = create_app(
        system,
        token=access.token,
        passwords=access.passwords,
        host=host,
        host_names=names,
        ports=ports,
        panels=panels,
        replay_options=access.replay_options,
        link=Link(link, seed=0),
        webhooks_file=default_file(),
        fleet=fleet,
    )
    if link is not None and link.shapes:
        log.warning("the link to the pages is shaped: %s", link.words)
    async with system:
        await serve_once_started(
            system, lambda: serve(app, host, port, listener=listener, scene=scene, tls=access.tls, started=announce)
        )


async def serve_once_started(system: System, serve: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Run ``serve()`` to its end, once all modules have started or have failed to. Raises LinkFailed when the body is
    lost before."""
    failure = asyncio.create_task(system.keep_going(), name="body's failure")
    # Connections must not take the file descriptors that modules' imports need.
    starting = asyncio.create_task(system.supervisor.started(), name="modules' start")
    tasks: list[asyncio.Task[Any]] = [failure, starting]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        if not failure.done():
            tune_for_latency()
            console = asyncio.create_task(serve(), name="console")
            tasks.append(console)
            await asyncio.wait({console, failure}, return_when=asyncio.FIRST_COMPLETED)
        if failure.done():
            raise failure.result()
        await console
    finally:
        log.info("stopping")
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def announcer(what: str, host: str, port: int, access: ConsoleAccess, *, open_browser: bool) -> Callable[[str], None]:
    """A function that prints the console's address, and opens it if requested, once the console listens."""

    token = access.token

    def announce(url: str) -> None:
        print(f"{what}: {login_url(url, token)}  (Ctrl-C stops it)", flush=True)
        if host in ("0.0.0.0", "::"):
            print(
                f"From other computers: {login_url(f'{access.scheme}://{socket.gethostname()}:{port}', token)}",
                flush=True,
            )
        if open_browser:
            asyncio.get_running_loop().run_in_executor(None, webbrowser.open, login_url(url, token))

    return announce


def login_url(url: str, token: str | None) -> str:
    """The address for a browser. The token follows the #, a part that no browser sends to a server or logs."""
    return url if token is None else f"{url}/#token={quote(token, safe='')}"


class Stopping:
    """The way down: the first signal asks for it; a second one, or the end of the time allowed, forces it."""

    def __init__(self, force: Callable[[int], object] | None = None, within_s: float = STOP_WITHIN_S) -> None:
        """``force`` (exit code) ends the process and its children; replaced in tests."""
        self._force = force or end_now
        self._within_s = within_s
        self._ask: Callable[[], object] = lambda: None
        self._begun = False
        self._forced = threading.Event()

    def install(self, ask: Callable[[], object]) -> None:
        """Install handlers of signals that call ``ask``: Python's own, which run even while the event loop is
        blocked."""
        self._ask = ask
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # else: started by nohup
                signal.signal(number, self.signalled)

    def signalled(self, number: int, _frame: FrameType | None = None) -> None:
        """A signal has come."""
        if self._begun:
            self._forced.set()
            self._force(128 + number)
            return
        self.begin()
        self._ask()

    def begin(self) -> None:
        """Note the begin of the shutdown: it may take the time allowed."""
        if self._begun:
            return
        self._begun = True
        threading.Thread(target=self._count_down, name="stopping", daemon=True).start()

    def _count_down(self) -> None:
        """Count in small steps, without the time in which a busy computer keeps the main thread from running."""
        counted_s, kept_s = 0.0, kept_waiting_s()
        while counted_s < self._within_s:
            if self._forced.wait(COUNT_S):
                return
            before_s, kept_s = kept_s, kept_waiting_s()
            counted_s += max(COUNT_S - (kept_s - before_s), 0.0)
        log.error("not stopped within %g s: ended by force", self._within_s)
        self._force(1)


def kept_waiting_s() -> float:
    """For how long (s) the main thread has waited for a processor so far; 0 where the system does not say."""
    try:
        _, waited_ns, _ = Path("/proc/self/schedstat").read_bytes().split()
    except (OSError, ValueError):
        return 0.0
    return int(waited_ns) / 1e9


def end_now(code: int) -> None:
    """End this process and all its children at once."""
    import psutil

    for child in psutil.Process().children(recursive=True):
        child.kill()
    os._exit(code)


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"a port is a number from 0 to 65535, not {text!r}")
    return int(text)


def _link(text: str) -> LinkSettings:
    from app.base.network_link import parse_link

    try:
        return parse_link(text)
    except ValueError as failure:
        raise argparse.ArgumentTypeError(str(failure)) from None


def _fleet(file: Path) -> Fleet:
    from app.console.fleet.asking import Fleet
    from app.console.fleet.fleet_file import load_fleet

    return Fleet(load_fleet(file))


def _named(configuration: Configuration, name: str | None) -> Configuration:
    if name is None:
        return configuration
    console = configuration.program.console.model_copy(update={"name": name})
    return replace(configuration, program=configuration.program.model_copy(update={"console": console}))


def _name(text: str) -> str:
    if not 0 < len(text.strip()) <= LONGEST_NAME or not text.isprintable():
        raise argparse.ArgumentTypeError(f"a robot's name has 1 to {LONGEST_NAME} characters, not {text!r}")
    return text.strip()


def _host_name(text: str) -> str:
    from app.console.access.origins import host_name

    if (name := host_name(text)) == "" or ":" in text:
        raise argparse.ArgumentTypeError(f"a host name is one as robot.example, without a port, not {text!r}")
    return name
