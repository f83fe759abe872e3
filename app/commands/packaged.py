"""Configuration by name: the program's own files are found from any folder, in a checkout and from a wheel alike; and
the programs that installed packages announce."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Literal

from app.base import paths
from app.base.errors import ConfigError
from app.base.extensions import announced_configuration, announced_names, package_file, split_package_file

#: Kinds of configuration; "configuration" is any of them, a program before the others.
Kind = Literal["program", "robot", "scenario", "array", "configuration"]

_FOLDERS: dict[Kind, tuple[str, ...]] = {
    "program": ("",),
    "robot": ("robots",),
    "scenario": ("scenarios",),
    "array": ("arrays",),
    "configuration": ("", "robots", "scenarios", "arrays", "worlds", "strategies", "calibration", "tours"),
}

#: The kinds that packages announce by name.
_OF_PACKAGES: frozenset[Kind] = frozenset({"program", "configuration"})


def config_file(named: str | Path, kind: Kind, option: str = "") -> Path:
    """The file that ``named`` means: a path that exists; else a path in ``config/``, or a name there, of the program's;
    else ``package:NAME/PATH``, or a program that a package announces.

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
    if split_package_file(given) is not None:
        file = package_file(given, root)
        if not file.is_file():
            raise ConfigError(f"there is no {kind} {named}", option)
        return file
    if kind in _OF_PACKAGES and (announced := announced_configuration(str(named))) is not None:
        return announced
    known = config_names(kind)
    close = difflib.get_close_matches(inside.stem, known, n=1)
    hint = f"; did you mean {close[0]!r}? Allowed:" if close else ";"
    none = "none, " if kind == "scenario" else ""
    more = "; those of a package are known once it is installed" if kind in _OF_PACKAGES else ""
    raise ConfigError(f"there is no {kind} {named}{hint} a file, {none}or one of: {', '.join(known)}{more}", option)


def program_named(named: str | Path | None) -> Path | None:
    """The file of ``--config``; None where none was asked for. Raises ConfigError."""
    return None if named is None else config_file(named, "program", "--config")


def config_names(kind: Kind) -> list[str]:
    """The names of files of ``kind``, as :func:`config_file` takes them: the program's own, then those of packages."""
    root = paths.config_dir()
    files = [path for folder in _FOLDERS[kind] for path in sorted((root / folder).glob("*.yaml"))]
    if kind == "configuration":
        own = [path.relative_to(root).with_suffix("").as_posix() for path in files]
    else:
        own = [path.stem for path in files if kind != "program" or _is_program(path)]
    return [*own, *(announced_names() if kind in _OF_PACKAGES else ())]


def _is_program(path: Path) -> bool:
    """Whether it is a program: the folder of programs holds their table of channels, too."""
    return re.search(r"^modules:", path.read_text(encoding="utf-8"), re.MULTILINE) is not None
