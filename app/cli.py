"""The command ``hbba``. Every command is a file of ``app/commands``; what is heavy is imported only when it runs."""

from __future__ import annotations

import argparse
import difflib
import os
import sys
from collections.abc import Sequence
from typing import Any

from app.commands import COMMANDS
from app.commands.printable import printable
from app.errors import ConfigError

#: Libraries of linear algebra compute in the calling thread: it would spin while it waits for others of theirs, which
#: on a busy computer costs four times what is computed; and matrices here are small.
_SINGLE = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class _Version(argparse.Action):
    """``--version``, which looks the number up only when asked."""

    def __init__(self, option_strings: Sequence[str], dest: str, **_: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version and leave")

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        print(f"hbba {version('hbba')}")
        parser.exit()


class _Parser(argparse.ArgumentParser):
    """Refuses what it does not know itself, with its own usage: argparse leaves that to the parser of all commands."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Nothing is left unknown."""
        known, unknown = super().parse_known_args(args, namespace)
        if unknown:
            options = [option[2:] for option in self._option_string_actions if option.startswith("--")]
            given = next((each[2:].partition("=")[0] for each in unknown if each.startswith("--")), "")
            close = difflib.get_close_matches(given, options, n=1)
            hint = f"; did you mean --{close[0]}?" if close else ""
            self.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
        return known, unknown


def build_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    parser = _Parser(
        prog="hbba",
        description="A robot runtime with selective attention and a web operator console.",
        epilog="Start with `hbba run`, and with `hbba doctor` where something does not work.",
    )
    parser.add_argument("--version", action=_Version)
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for command in COMMANDS.values():
        command.add_parser(subparsers)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; a person's mistake is one sentence and the code 2."""
    for name in _SINGLE:  # read when the library is loaded, which no command has done yet
        os.environ.setdefault(name, "1")
    args = build_parser().parse_args(argv)
    try:
        code = COMMANDS[args.command].run(args)
        sys.stdout.flush()
        return code
    except ConfigError as failure:
        print(printable(f"hbba {args.command}: {failure}"), file=sys.stderr)
        return 2
    except BrokenPipeError:
        # Whoever read our output has gone (`hbba solve ... | head`): nothing is left to say, not even at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
