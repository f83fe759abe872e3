"""Configuration by name: the program's own files are found from any folder, in a checkout and from a wheel alike."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Literal

from app.base import paths
from app.base.errors import ConfigError

#: Kinds of configuration; "configuration" is any of them, a program before the others.
Kind = Literal["program", "robot", "scenario", "array", "configuration"]

_FOLDERS: dict[Kind, tuple[str, ...]] = {
    "program": ("",),
    "robot": ("robots",),
    "scenario": ("scenarios",),
    "array": ("arrays",),
    "configuration": ("", "robots", "scenarios", "arrays", "worlds", "strategies", "calibration"),
}


def config_file(named: str | Path, kind: Kind, option: str = "") -> Path:
    """The file that ``named`` means: a path that exists; else a path in ``config/``, or a name there, of the program's.

    Raises ConfigError, which names those that there are, for ``option``.
    """
    given = Path(named)
    if given.exists() and not given.is_dir():
        return given
    root = paths.config_dir()
    inside = given.relative_to("config") if given.parts[:1] == ("config",) else given
    if not inside.is_absolute():
        folders = [root / folder for folder in _FOLDERS[kind]]
        for folder in (*folders, root):
            for path in (folder / inside, folder / f"{inside}.yaml"):
                if path.is_file() and path.parent in folders and (kind != "program" or _is_program(path)):
                    return path.resolve()
    known = config_names(kind)
    close = difflib.get_close_matches(inside.stem, known, n=1)
    hint = f"; did you mean {close[0]!r}? Allowed:" if close else ";"
    none = "none, " if kind == "scenario" else ""
    raise ConfigError(f"there is no {kind} {named}{hint} a file, {none}or one of: {', '.join(known)}", option)


def program_named(named: str | Path | None) -> Path | None:
    """The file of ``--config``; None where none was asked for. Raises ConfigError."""
    return None if named is None else config_file(named, "program", "--config")


def config_names(kind: Kind) -> list[str]:
    """The names of the program's own files of ``kind``, as :func:`config_file` takes them."""
    root = paths.config_dir()
    files = [path for folder in _FOLDERS[kind] for path in sorted((root / folder).glob("*.yaml"))]
    if kind == "configuration":
        return [path.relative_to(root).with_suffix("").as_posix() for path in files]
    return [path.stem for path in files if kind != "program" or _is_program(path)]


def _is_program(path: Path) -> bool:
    """Whether it is a program: the folder of programs holds their table of channels, too."""
    return re.search(r"^modules:", path.read_text(encoding="utf-8"), re.MULTILINE) is not None
