"""The parser of the command line: every command, and refusals with a suggestion."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any


class _Version(argparse.Action):
    """``--version``, which looks the number up only when asked."""

    def __init__(self, option_strings: Sequence[str], dest: str, **_: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, help="print the version and leave")

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        print(f"hbba {version('hbba')}")
        parser.exit()


class Parser(argparse.ArgumentParser):
    """Refuses unknown arguments itself, with its own usage: argparse leaves that to the parser of all commands."""

    #: Declares the rest of its arguments, once they are needed.
    filler: Callable[[], None] | None = None
    #: Parsers of their own, by the first word: of a command whose own first argument may be any word.
    words: Mapping[str, Parser] = MappingProxyType({})

    def fill(self) -> None:
        """Declare what was left till its arguments are needed."""
        filler, self.filler = self.filler, None
        if filler is not None:
            filler()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Nothing is left unknown."""
        if args and args[0] in self.words:
            return self.words[args[0]].parse_known_args(args[1:], namespace)
        self.fill()
        known, unknown = super().parse_known_args(args, namespace)
        if unknown:
            options = [option[2:] for option in self._option_string_actions if option.startswith("--")]
            given = next((each[2:].partition("=")[0] for each in unknown if each.startswith("--")), "")
            self.error(f"unrecognized arguments: {' '.join(unknown)}{_hint(given, options, '--')}")
        return known, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """As argparse; a suggestion is added, which argparse does only from Python 3.14 on."""
        if action.choices is not None and value not in action.choices:
            known = [str(choice) for choice in action.choices]
            words = f"invalid choice: {value!r}{_hint(str(value), known)} (choose from {', '.join(known)})"
            raise argparse.ArgumentError(action, words)


def _hint(given: str, known: Iterable[str], before: str = "") -> str:
    close = difflib.get_close_matches(given, known, n=1)
    return f"; did you mean {before}{close[0]}?" if close else ""


def build_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    from app.commands import COMMANDS  # which declare themselves with this parser

    parser = Parser(
        prog="hbba",
        description="A robot runtime with selective attention and a web operator console.",
        epilog="Start with `hbba run`, and with `hbba doctor` where something does not work.",
    )
    parser.add_argument("--version", action=_Version)
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for command in COMMANDS.values():
        command.add_parser(subparsers)
    return parser
