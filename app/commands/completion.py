"""``hbba completion SHELL``: what makes a shell complete commands, options and names."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import Any

from app.base import paths
from app.commands.parser import Parser

SHELLS = ("bash", "zsh", "fish")

#: Arguments that take a log: a file, or the name of one of the user's recordings.
_TAKE_LOGS = ("hbba calibrate", "hbba log ", "hbba replay", "hbba slam")

_LOGS = {"bash": "_hbba_logs", "zsh": "_hbba_logs", "fish": "(_hbba_logs)"}
_SCENARIOS = {"bash": "_hbba_scenarios", "zsh": "_hbba_scenarios", "fish": "(_hbba_scenarios)"}

# The functions that these name. The folder of recordings is that of app.logs.library, which is not asked: Python
# would take a quarter of a second for each key.
_FUNCTIONS = {
    "bash": """
_hbba_logs() {
  local file
  for file in "${HBBA_RECORDINGS:-${XDG_DATA_HOME:-$HOME/.local/share}/hbba/recordings}/$1"*.mcap; do
    [[ -e $file ]] && file=${file##*/} && echo "${file%.mcap}"
  done
  compgen -f -- "$1"
}
_hbba_scenarios() {
  compgen -W "SCENARIOS" -- "$1"
  compgen -f -- "$1"
}
""",
    "zsh": """
_hbba_logs() {
  local folder="${HBBA_RECORDINGS:-${XDG_DATA_HOME:-$HOME/.local/share}/hbba/recordings}"
  local -a recordings=($folder/*.mcap(N:t:r))
  _alternative "recordings:recording:($recordings)" "files:file:_files"
}
_hbba_scenarios() {
  _alternative "scenarios:scenario:(SCENARIOS)" "files:file:_files"
}
""",
    "fish": """
function _hbba_logs
  set -l folder "$HBBA_RECORDINGS"
  test -n "$folder"; or test -z "$XDG_DATA_HOME"; or set folder "$XDG_DATA_HOME/hbba/recordings"
  test -n "$folder"; or set folder "$HOME/.local/share/hbba/recordings"
  for file in $folder/*.mcap
    string replace -r '^.*/(.*)\\.mcap$' '$1' -- $file
  end
  __fish_complete_path (commandline -ct)
end
function _hbba_scenarios
  printf '%s\\n' SCENARIOS
  __fish_complete_path (commandline -ct)
end
""",
}


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "completion",
        help="print a completion script for your shell",
        description="Print a script that makes your shell complete commands, options, files, recordings and scenarios. "
        "bash: hbba completion bash > ~/.local/share/bash-completion/completions/hbba; zsh: hbba completion zsh > "
        "FOLDER/_hbba with a FOLDER of $fpath; fish: hbba completion fish > ~/.config/fish/completions/hbba.fish.",
    )
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def run(args: argparse.Namespace) -> int:
    import shtab

    from app.commands.parser import build_parser

    parser = build_parser()
    for each in leaves(parser):
        for action in each._actions:
            if (kind := _kind_of(each.prog, action)) is not None:
                # The attribute that shtab reads.
                action.complete = kind  # type: ignore[attr-defined]
    scenarios = sorted(path.stem for path in (paths.config_dir() / "scenarios").glob("*.yaml"))
    functions = _FUNCTIONS[args.shell].replace("SCENARIOS", " ".join(["none", *scenarios]))
    print(shtab.complete(parser, args.shell, preamble=functions))
    return 0


def leaves(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The parsers of the commands that do something: ``parser`` itself, or those below it."""
    if isinstance(parser, Parser):
        parser.fill()
        for word in parser.words.values():
            yield from leaves(word)
    below = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if not below:
        yield parser
    for action in below:
        for each in action.choices.values():
            yield from leaves(each)


def _kind_of(command: str, action: argparse.Action) -> Mapping[str, Any] | None:
    """The completion for the value of ``action``; None if it has none."""
    import shtab

    if action.dest in ("file", "log") and not action.option_strings and command.startswith(_TAKE_LOGS):
        return _LOGS
    if action.dest == "scenario":
        return _SCENARIOS
    kind: Mapping[str, Any] | None = None
    if action.metavar == "FOLDER":
        kind = shtab.DIRECTORY
    elif action.metavar in ("FILE", "LOG", "OUT", "ARRAY", "SOURCE"):
        kind = shtab.FILE
    return kind
