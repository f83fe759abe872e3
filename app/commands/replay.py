"""``hbba replay FILE``: play a recording back, with the console to look at it or without."""

from __future__ import annotations

import argparse
import asyncio
import logging
import math
import socket
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base import logging_setup
from app.base.errors import ConfigError
from app.commands.arguments import TIMES, find_log, moment, names, real, recording_name, whole
from app.commands.console_access import ConsoleAccess, console_access, warn_of_plain_connections
from app.commands.kernels import kernels_ready
from app.commands.output import add_json, check_writable, json_text, print_json, write_text
from app.commands.packaged import program_named
from app.commands.run import Stopping, add_console_options, announcer, until_stopped

if TYPE_CHECKING:
    from fastapi import FastAPI

    from app.logs.log import Log
    from app.logs.replay.options import ReplayOptions
    from app.logs.replay.replay import Replay

#: Period (s) of checking for connected viewers.
LOOK_S = 1.0
#: Everything has stopped by then, or is made to. No robot moves: longer than in `hbba run`.
STOP_WITHIN_S = 10.0


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "replay",
        help="play a recording back",
        description="Run the modules on a recording: of this program (MCAP), a ROS 1 or ROS 2 bag, or a CARMEN log. "
        "With the console, where it can be paused and scrubbed; with --headless as fast as the machine allows, the "
        f"same each time. Times are {TIMES}.",
    )
    parser.add_argument("file", metavar="FILE", help="a log, or the name of one of your recordings")
    parser.add_argument(
        "--speed", type=_speed, metavar="X",
        help="times real time: 0.1 to 20 with the console, 0.1 to 100 without; or max (default: 1 with the console, "
        "else max)",
    )  # fmt: skip
    parser.add_argument("--from", dest="begin", type=moment, metavar="T", help="begin here (default: the log's begin)")
    parser.add_argument("--to", dest="end", type=moment, metavar="T", help="end here (default: the log's end)")
    parser.add_argument("--only", type=names, metavar="A,B", help="run only these modules; the rest comes from the log")
    parser.add_argument(
        "--phi", type=_phi, action="append", default=[], metavar="M.PORT=N",
        help="fix this filter at this divisor (off: closed) instead of what attention selects; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--offset",
        type=whole(0),
        default=0,
        metavar="K",
        help="skip the first K messages at each filter that is fixed or set by strategies",
    )
    parser.add_argument("--no-desires", action="store_true", help="leave out the recorded desires of operators")
    parser.add_argument(
        "--config", type=Path, metavar="FILE", help="run this program (a file, a name), not the recorded one"
    )
    parser.add_argument("--remap", type=Path, metavar="FILE", help="which topics of a ROS bag are which channels")
    parser.add_argument("--record", type=recording_name, metavar="NAME", help="record the replay under this name")
    parser.add_argument("--headless", action="store_true", help="without the console; prints a report")
    add_json(parser, "with --headless: print the report as one JSON document instead")
    parser.add_argument("--out", type=Path, metavar="FILE", help="with --headless: write that JSON document here")
    parser.add_argument(
        "--exit-when-unwatched",
        type=real(0, above=True, rule="must be a number of seconds greater than 0"),
        metavar="S",
        help="end S seconds after the last viewer left",
    )
    add_console_options(parser)


def run(args: argparse.Namespace) -> int:
    """Replay until the end, or with the console until a signal comes. Raises ConfigError."""
    from app.link import LinkFailed
    from app.logs.importers.remap import load_remap
    from app.logs.log import LogError
    from app.logs.open import open_log

    if not args.headless and (args.json or args.out is not None):
        option = "--json" if args.json else "--out"
        raise ConfigError(f"{option} says what came of a replay without the console: add --headless")
    check_writable(args.out)
    path = find_log(args.file)
    try:
        remap = load_remap(args.remap) if args.remap is not None else None

        def opened() -> Log:
            return open_log(path, remap)

        with ExitStack() as stack:
            log = opened()
            stack.callback(log.close)
            options = _options(args, log)
            if args.headless:
                return _headless(args, log, options)
            return _with_console(args, log, options, opened, stack)
    except (LinkFailed, LogError) as failure:
        print(f"hbba replay: {failure}", file=sys.stderr)
        return 2


def _options(args: argparse.Namespace, log: Log) -> ReplayOptions:
    from app.logs.replay.options import ReplayOptions

    info = log.info
    begin = None if args.begin is None else max(args.begin(info.begin), info.begin)
    end = None if args.end is None else args.end(info.begin)
    if begin is not None and begin >= info.end:
        raise ConfigError(f"--from {begin - info.begin:g} s: the log has {info.duration_s:.1f} s", str(info.path))
    if end is not None and end <= (begin or info.begin):
        raise ConfigError(f"--to {end - info.begin:g} s: must be later than the begin", str(info.path))
    return ReplayOptions(
        begin=begin,
        end=None if end is None else min(end, info.end),
        only=args.only,
        phi=dict(args.phi),
        offset=args.offset,
        config=program_named(args.config),
        desires=not args.no_desires,
        record=args.record,
    )


def _headless(args: argparse.Namespace, log: Log, options: ReplayOptions) -> int:
    import cv2

    from app.commands.progress import shown
    from app.commands.replay_report import print_report
    from app.logs.replay.headless import ReplayWatch, run_headless

    cv2.setNumThreads(1)
    logging_setup.configure("warning" if args.log_level == "info" else args.log_level, as_json=args.log_json)
    # In hours that pass in seconds, the recording's pauses are no news.
    logging.getLogger("hbba.freshness").setLevel(logging.ERROR)
    begin = log.info.begin if options.begin is None else options.begin
    end = log.info.end if options.end is None else options.end
    with shown(f"replay {log.info.path.name}") as progress:
        watch = ReplayWatch(lambda position: progress(position - begin, end - begin))
        report = run_headless(log, options, speed=_finite(args.speed), watch=watch)
    if args.json:
        print_json(report.document())
    else:
        print_report(report)
    if args.out is not None:
        write_text(args.out, json_text(report.document()) + "\n")
    return 0


def _with_console(
    args: argparse.Namespace, log: Log, options: ReplayOptions, opened: Callable[[], Log], stack: ExitStack
) -> int:
    from app.console.server import address_of, listen, listen_for_scene
    from app.logs.replay.playback_state import FASTEST
    from app.logs.replay.replay import Replay
    from app.runtime.replay_clock import ReplayClock

    if args.speed is not None and FASTEST < args.speed < math.inf:
        raise ConfigError(f"--speed {args.speed:g}: with the console at most {FASTEST:g}, or max")
    past = opened()  # read beside the body, in another thread
    stack.callback(past.close)
    begin = log.info.begin if options.begin is None else options.begin
    clock = ReplayClock(begin, log.info.end if options.end is None else options.end)
    replay = Replay(log, clock, options)
    stack.callback(replay.close)
    console = replay.program.configuration.program.console
    host = args.host or console.host
    access = console_access(args, host)
    logging_setup.configure(args.log_level, as_json=args.log_json)
    warn_of_plain_connections(access, host)
    for note in replay.notes():
        print(note)
    listener = stack.enter_context(listen(host, console.port if args.port is None else args.port))
    host_names = (*console.host_names, *args.host_name)
    scene_port = console.scene_port if args.scene_port is None else args.scene_port
    scene = stack.enter_context(listen_for_scene(host, address_of(listener)[1], scene_port))
    listeners = (listener, scene)
    live = _live(args, replay, clock=clock, past=past, listeners=listeners, access=access, host_names=host_names)
    return asyncio.run(until_stopped(live, Stopping(within_s=STOP_WITHIN_S)))


async def _live(
    args: argparse.Namespace,
    replay: Replay,
    clock: Any,
    past: Log,
    listeners: tuple[socket.socket, socket.socket],
    access: ConsoleAccess,
    host_names: Sequence[str],
) -> None:
    """Replay with a console until it is stopped. Raises LinkFailed.

    ``listeners`` are those of the page and of the 3D view alone.
    """
    import cv2

    from app.console.access.origins import Ports
    from app.console.app import create_app
    from app.console.panels import load_panels
    from app.console.server import address_of, serve
    from app.logs.replay.playback import Playback

    cv2.setNumThreads(1)
    await kernels_ready()
    listener, scene = listeners
    host, port = address_of(listener)
    ports = Ports(port, address_of(scene)[1])
    announce = announcer(f"HBBA replays {past.info.path.name}", host, port, access, open_browser=args.open)
    speed = 1.0 if args.speed is None else _finite(args.speed)
    playback = Playback(replay.system, replay.body, clock, past, speed=speed)
    panels = await asyncio.to_thread(load_panels)
    app = create_app(  # takes long: before anything plays
        replay.system,
        token=access.token,
        passwords=access.passwords,
        host=host,
        host_names=host_names,
        ports=ports,
        playback=playback,
        panels=panels,
    )
    async with replay, playback:
        up = asyncio.Event()

        def started(url: str) -> None:
            announce(url)
            up.set()

        serving = serve(app, host, port, listener=listener, scene=scene, tls=access.tls, started=started)
        tasks = [asyncio.create_task(serving, name="console")]
        tasks.append(asyncio.create_task(_failed(replay), name="replay's failure"))
        if args.exit_when_unwatched is not None:
            tasks.append(asyncio.create_task(_unwatched(app, up, args.exit_when_unwatched), name="unwatched"))
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            if replay.recorded:
                print(f"recorded as {replay.recorded}")


async def _failed(replay: Replay) -> None:
    raise await replay.system.wait_failed()


async def _unwatched(app: FastAPI, up: asyncio.Event, after_s: float) -> None:
    """Wait until no viewer was connected for ``after_s``, counted from the first time one could."""
    await up.wait()
    unwatched_s = 0.0
    while unwatched_s < after_s:
        await asyncio.sleep(LOOK_S)
        unwatched_s = 0.0 if app.state.hub.viewers else unwatched_s + LOOK_S


def _finite(speed: float | None) -> float | None:
    """``max`` is no speed: as fast as possible."""
    return None if speed is None or math.isinf(speed) else speed


# --- Arguments -------------------------------------------------------------------------------------------------------


_NUMBER = real(0.1, 100, rule="a speed is a number from 0.1 to 100, or max")


def _speed(text: str) -> float:
    return math.inf if text == "max" else _NUMBER(text)


def _phi(text: str) -> tuple[str, float]:
    name, _, divisor = text.partition("=")
    module, _, port = name.partition(".")
    if module and port:
        if divisor == "off":
            return name, math.inf
        if divisor.isdecimal() and int(divisor) >= 1:
            return name, float(divisor)
    raise argparse.ArgumentTypeError(f"is written Module.port=N with a whole N from 1, or off, not {text!r}")
