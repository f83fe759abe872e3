"""``hbba run``: the robot and its console, until Ctrl-C."""

from __future__ import annotations

import argparse
import asyncio
import errno
import ipaddress
import logging
import os
import secrets
import signal
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from app import logs, paths

if TYPE_CHECKING:
    from app.config import Configuration

#: Everything has stopped by then, or is made to.
STOP_WITHIN_S = 2.0

log = logging.getLogger("hbba.run")


class CannotRun(Exception):
    """Running is impossible here and now; the message is one sentence that says what to do."""


@dataclass(frozen=True, slots=True)
class Address:
    """Where the console listens. ``token`` is asked of everybody who comes from beyond loopback, or of all if given."""

    host: str
    port: int
    token: str | None

    @property
    def url(self) -> str:
        """What to type into a browser, token included."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        host = {"0.0.0.0": socket.gethostname(), "[::]": socket.gethostname()}.get(host, host)
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")


def add_parser(subparsers: Any) -> None:
    """Declare ``hbba run``."""
    parser = subparsers.add_parser(
        "run",
        help="start the robot and its console",
        description="Start the robot and its console; Ctrl-C stops both. Options win over the configuration.",
    )
    parser.add_argument("--config", type=Path, metavar="FILE", help="the program to run (default: the simulated lab)")
    parser.add_argument("--host", metavar="H", help="address to listen on (default 127.0.0.1: this computer alone)")
    parser.add_argument("--port", type=_port, metavar="N", help="port to listen on (default 8080; 0: any free one)")
    parser.add_argument(
        "--token", type=_token, metavar="T", help="what a browser must present; made up beyond loopback"
    )
    parser.add_argument("--open", action="store_true", help="open the console in a browser")
    parser.add_argument("--log-level", choices=logs.LEVELS, default="info", help="least severe events to log")
    parser.add_argument("--log-json", action="store_true", help="log one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """Run until a signal comes or the body fails. Raises ConfigError."""
    from app.config import load_configuration
    from app.link import LinkFailed

    logs.configure(args.log_level, as_json=args.log_json)
    configuration = load_configuration(args.config or paths.config_dir() / "lab.yaml")
    console = configuration.program.console
    host = args.host or console.host
    try:
        with listen(host, console.port if args.port is None else args.port) as listener:
            address = Address(host, listener.getsockname()[1], token_for(host, args.token or console.token))
            stopping = Stopping()
            return asyncio.run(_serve(configuration, listener, address, stopping, open_browser=args.open))
    except (CannotRun, LinkFailed) as failure:
        print(f"hbba run: {failure}", file=sys.stderr)
        return 1


async def _serve(
    configuration: Configuration,
    listener: socket.socket,
    address: Address,
    stopping: Stopping,
    *,
    open_browser: bool,
) -> int:
    """Bring everything up, say where, wait for the end, take everything down. Raises LinkFailed, ConfigError."""
    import cv2

    from app.console.server import serving
    from app.system import System

    cv2.setNumThreads(1)  # modules have their own threads; OpenCV's pool would only fight them for the cores
    stop = asyncio.Event()
    stopping.install(lambda: loop.call_soon_threadsafe(stop.set))
    loop = asyncio.get_running_loop()
    async with System(configuration) as system, serving(system, [listener], token=address.token):
        print(f"HBBA is up: {address.url}  (Ctrl-C stops it)", flush=True)
        if open_browser:
            await asyncio.to_thread(webbrowser.open, address.url)
        asked = asyncio.create_task(stop.wait())
        failed = asyncio.create_task(system.wait_failed())
        await asyncio.wait({asked, failed}, return_when=asyncio.FIRST_COMPLETED)
        asked.cancel()
        if failed.done():
            stopping.begin()
            raise failed.result()
        failed.cancel()
        log.info("stopping")
    return 0


class Stopping:
    """The way down: the first signal asks for it; a second one, or STOP_WITHIN_S, ends everything at once."""

    def __init__(self, force: Callable[[int], object] | None = None) -> None:
        """``force`` (exit code) ends the process and its children; replaced in tests."""
        self._force = force or end_now
        self._ask: Callable[[], object] = lambda: None
        self._begun = False

    def install(self, ask: Callable[[], object]) -> None:
        """From now on, signals call ``ask``. Python's own handlers, as they run even where the event loop is stuck."""
        self._ask = ask
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self.signalled)

    def signalled(self, number: int, _frame: FrameType | None = None) -> None:
        """A signal has come."""
        if self._begun:
            self._force(128 + number)
            return
        self.begin()
        self._ask()

    def begin(self) -> None:
        """The way down has begun: it may take STOP_WITHIN_S."""
        self._begun = True
        timer = threading.Timer(STOP_WITHIN_S, self._overdue)
        timer.daemon = True
        timer.start()

    def _overdue(self) -> None:
        log.error("not stopped within %g s: ended by force", STOP_WITHIN_S)
        self._force(1)


def end_now(code: int) -> None:
    """End this process and all its children at once."""
    import psutil

    for child in psutil.Process().children(recursive=True):
        child.kill()
    os._exit(code)


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens at ``host``:``port`` (0: any free port). Raises CannotRun in words for people."""
    try:
        family, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
    except socket.gaierror:
        raise CannotRun(
            f"--host {host}: there is no such address; allowed: an address or name of this computer"
        ) from None
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(128)
    except PermissionError:
        listener.close()
        raise CannotRun(f"port {port} is reserved for root: choose one from 1024, such as --port 8080") from None
    except OSError as failure:
        listener.close()
        if failure.errno == errno.EADDRINUSE:
            raise CannotRun(
                f"port {port} is taken{_by_whom(port)}: end that program, or choose another port: --port {port + 1}"
            ) from None
        raise CannotRun(f"cannot listen on {host}, port {port}: {failure.strerror}") from None
    return listener


def token_for(host: str, given: str | None) -> str | None:
    """The token to ask for: the one given; beyond loopback one is made up, as anybody there could drive the robot."""
    return given or (None if is_loopback(host) else secrets.token_urlsafe(16))


def is_loopback(host: str) -> bool:
    """Whether only this computer reaches ``host``."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _by_whom(port: int) -> str:
    """`` by NAME (process N)``, where the system tells."""
    import psutil

    try:
        for connection in psutil.net_connections("tcp"):
            listens = connection.status == psutil.CONN_LISTEN and connection.laddr and connection.laddr.port == port
            if listens and connection.pid:
                return f" by {psutil.Process(connection.pid).name()} (process {connection.pid})"
    except psutil.Error:
        pass
    return ""


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"a port is a number from 0 to 65535, not {text!r}")
    return int(text)


def _token(text: str) -> str:
    if len(text) < 8:
        raise argparse.ArgumentTypeError("a token has at least 8 characters")
    return text
