"""``hbba log``: lists recordings and shows, cuts, repairs and exports one."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands.arguments import TIMES, find_log, moment, names, whole
from app.commands.log_rerun import add_rerun, show
from app.commands.output import add_json, print_json


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "log",
        help="list, inspect, cut, repair and export recordings",
        description="Manage recordings. FILE is a log (of this program, a ROS bag, a CARMEN log) or the name of "
        "one of your recordings. Without anything, list these.",
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION")
    add_json(parser)
    listing = actions.add_parser(
        "list", help="list your recordings", description="List your recordings, the newest first."
    )
    _add_json(listing)
    _add_info(actions)
    _add_cut(actions)
    _add_repair(actions)
    _add_export(actions)
    add_rerun(actions)


def run(args: argparse.Namespace) -> int:
    """Do it. Exit code 2 for a person's mistake or a log that cannot be read, 1 where the disk does not take it."""
    from app.logs.log import LogError
    from app.logs.output_file import DiskTrouble

    doing = {
        "info": _info, "cut": _cut, "repair": _repair, "export": _export, "rerun": _rerun, None: _list, "list": _list,
    }[args.action]  # fmt: skip
    try:
        return doing(args)
    except LogError as failure:
        print(f"hbba log: {failure}", file=sys.stderr)
        return 1 if isinstance(failure, DiskTrouble) else 2


# --- list and info -----------------------------------------------------------------------------------------------


def _list(args: argparse.Namespace) -> int:
    from app.commands.log_report import print_recordings, recordings_document
    from app.logs.catalog import Catalog
    from app.logs.library import RecordingLibrary, default_folder

    library = RecordingLibrary(default_folder())
    try:
        recordings, free = Catalog(library).recordings(), library.free_bytes()
    except OSError as failure:
        raise ConfigError(f"{library.folder}: cannot be read: {failure.strerror or failure}") from None
    if args.json:
        print_json(recordings_document(recordings, library.folder, free))
    else:
        print_recordings(recordings, library.folder, free)
    return 0


def _add_info(actions: Any) -> None:
    parser = actions.add_parser(
        "info",
        help="what is in a log",
        description="Say what is in a log. Exit code 1 if it was not closed or is damaged: `hbba log repair` helps.",
    )
    _add_file(parser)
    _add_json(parser)
    parser.add_argument("--remap", type=Path, metavar="FILE", help="which topics of a ROS bag are which channels")


def _info(args: argparse.Namespace) -> int:
    from app.commands.log_report import look_into, print_contents
    from app.commands.progress import shown

    path = find_log(args.file)
    with shown(f"look through {path.name}") as progress:
        contents = look_into(path, _remap(args.remap), progress)
    print_contents(contents, as_json=args.json)
    return 0 if contents.state == "complete" else 1


# --- cut and repair ----------------------------------------------------------------------------------------------


def _add_cut(actions: Any) -> None:
    parser = actions.add_parser(
        "cut",
        help="copy a piece of a log into a new one",
        description="Copy the messages that arrived between two times, the state at the first, and everything that "
        f"is attached. Messages are copied, not encoded again. Times are {TIMES}.",
    )
    _add_file(parser)
    _add_times(parser)
    _add_channels(parser, "only these channels or topics")
    _add_out(parser, "the new log (default: FILE-cut.mcap)", "OUT")
    _add_json(parser)


def _cut(args: argparse.Namespace) -> int:
    from app.commands.log_report import clock, size
    from app.commands.progress import shown
    from app.log_tools.cut import cut, span

    path = _find_mcap(args.file)
    out = args.out or path.with_name(f"{path.stem}-cut.mcap")
    first, last = span(path)
    begin, end = _times(args, first, last)
    with shown(f"cut {path.name}") as progress:
        report = cut(path, out, begin, end, args.channels, force=args.force, progress=progress)
    if args.json:
        print_json(asdict(report))
        return 0
    standing = f", {report.standing} of them state from before the begin" if report.standing else ""
    print(
        f"{out}: {clock(report.end - report.begin)} from {clock(report.begin - first)} to {clock(report.end - first)}, "
        f"{report.messages + report.standing} records{standing}, {size(report.bytes)}"
    )
    return 0


def _add_repair(actions: Any) -> None:
    parser = actions.add_parser(
        "repair",
        help="make a log readable that was cut off or damaged",
        description="Copy everything that is sound in an MCAP file into a new one with index and summary, and say what "
        "is missing. A healthy file is left alone.",
    )
    _add_file(parser)
    _add_out(parser, "the new log (default: FILE-repaired.mcap)", "OUT")
    parser.add_argument("--in-place", action="store_true", help="replace FILE itself, once the new one is whole")
    _add_json(parser)


def _repair(args: argparse.Namespace) -> int:
    from app.commands.log_report import repair_lines
    from app.commands.progress import shown
    from app.log_tools.repair import repair

    if args.in_place and args.out:
        raise ConfigError("--in-place replaces FILE, so there is nothing for -o to name: give one of them")
    path = _find_mcap(args.file)
    out = args.out or path.with_name(f"{path.stem}-repaired.mcap")
    with shown(f"repair {path.name}") as progress:
        report = repair(path, out, force=args.force, progress=progress, in_place=args.in_place)
    if args.json:
        print_json(asdict(report))
    else:
        print("\n".join(repair_lines(report)))
    return 0


# --- export ------------------------------------------------------------------------------------------------------


def _add_export(actions: Any) -> None:
    from app.log_tools.export.kinds import KINDS

    parser = actions.add_parser(
        "export",
        help="pictures, video, tables, sound and point clouds of a log",
        description="Write a log's messages as files for other programs, into a folder. "
        + "; ".join(f"{name}: {text}" for name, text in KINDS.items())
        + f". Times are {TIMES}.",
    )
    _add_file(parser)
    parser.add_argument("kind", choices=list(KINDS), help="what to write")
    _add_times(parser)
    _add_channels(parser, "only these channels (default: all that can be written so)")
    parser.add_argument("--every", type=whole(1), default=1, metavar="N", help="only one of N messages; not for wav")
    parser.add_argument("--remap", type=Path, metavar="FILE", help="which topics of a ROS bag are which channels")
    _add_out(parser, "the folder (default: FILE-export, here)", "FOLDER")
    _add_json(parser)


def _export(args: argparse.Namespace) -> int:
    from app.commands.progress import shown
    from app.log_tools.export.exporter import Wish, export
    from app.logs.open import open_log

    path = find_log(args.file)
    log = open_log(path, _remap(args.remap))
    try:
        begin, end = _times(args, log.info.begin, log.info.end)
        folder = args.out or Path(f"{path.stem}-export")
        wish = Wish(args.kind, folder, channels=args.channels, begin=begin, end=end, every=args.every, force=args.force)
        with shown(f"export {path.name}") as progress:
            result = export(log, wish, progress)
    finally:
        log.close()
    if args.json:
        print_json(asdict(result))
        return 0
    for line in result.lines():
        print(line)
    return 0


def _rerun(args: argparse.Namespace) -> int:
    return show(args, _find_mcap)


# --- Arguments ---------------------------------------------------------------------------------------------------


def _find_mcap(text: str) -> Path:
    """As :func:`find_log`, but a single file. Raises ConfigError."""
    path = find_log(text)
    if path.is_dir():
        from app.logs.open import some

        inside = some(sorted(str(each) for each in path.glob("*.mcap"))) or "there is none in it"
        raise ConfigError(f"{path} is a folder; name an MCAP file: {inside}")
    return path


def _add_file(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a log, or the name of one of your recordings")


def _add_times(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--from", dest="begin", type=moment, metavar="T", help="begin here (default: the log's begin)")
    parser.add_argument("--to", dest="end", type=moment, metavar="T", help="end here (default: the log's end)")


def _add_channels(parser: argparse.ArgumentParser, text: str) -> None:
    parser.add_argument("--channels", type=names, metavar="A,B", help=text)


def _add_out(parser: argparse.ArgumentParser, text: str, metavar: str) -> None:
    parser.add_argument("-o", "--out", type=Path, metavar=metavar, help=text)
    parser.add_argument("--force", action="store_true", help="replace what is there")


def _add_json(parser: argparse.ArgumentParser) -> None:
    # Left out here, it is what `hbba log` itself was given.
    add_json(parser, default=argparse.SUPPRESS)


def _times(args: argparse.Namespace, first: float, last: float) -> tuple[float, float]:
    """The requested begin and end, within the log (robot's clock, s). Raises ConfigError."""
    begin = first if args.begin is None else args.begin(first)
    end = last if args.end is None else args.end(first)
    if begin > last or end < first:
        raise ConfigError(f"the log has {last - first:.3f} s, from {_date(first)} to {_date(last)}")
    if end < begin:
        raise ConfigError(f"--to must not be before --from ({end - first:.3f} s, {begin - first:.3f} s)")
    return max(begin, first), min(end, last)


def _date(seconds: float) -> str:
    return datetime.fromtimestamp(seconds).astimezone().isoformat(sep=" ", timespec="milliseconds")


def _remap(path: Path | None) -> Any:
    from app.logs.importers.remap import load_remap

    return None if path is None else load_remap(path)
