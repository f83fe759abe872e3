"""Extensions by packages of others: objects named ``package.module:Name``, files named ``package:NAME/PATH``,
and entry points of the groups ``hbba.*``."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
import sys
import tomllib
import traceback
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from pathlib import Path

from app.base import paths
from app.base.errors import ConfigError

DISTRIBUTION = "hbba"
#: The groups of entry points, and what each brings.
GROUPS = {
    "hbba.bodies": "bodies",
    "hbba.configurations": "configurations",
    "hbba.experiments": "experiments",
    "hbba.messages": "messages",
    "hbba.panels": "panels",
}
_CONFIGURATIONS = "hbba.configurations"
_PACKAGE_FILE = "package:"
#: Where files of packages are in a folder that was restored from a recording.
ATTACHED = "_packages"


@dataclass(frozen=True, slots=True)
class Extension:
    """One entry point: its ``name`` in ``group``, the ``value`` it names and the ``distribution`` that brings it."""

    group: str
    name: str
    value: str
    distribution: str

    def load(self) -> object:
        """The object that it names. Raises ConfigError, one sentence, where that cannot be imported or is absent."""
        whose = f"{self.name!r} of {self.group}, from {self.distribution}"
        try:
            if ":" not in self.value:
                return importlib.import_module(self.value)
            found = load_named(self.value)
        except ConfigError as failure:
            raise ConfigError(f"{whose}: {failure.message}") from failure
        except Exception as failure:  # a package of others may raise anything while it is imported
            raise ConfigError(f"{whose}: {self.value} cannot be imported: {_sentence(failure)}") from failure
        if found is None:
            raise ConfigError(f"{whose}: there is no {self.value}")
        return found


def extensions(group: str) -> dict[str, Extension]:
    """The entry points of ``group`` by name. Raises ConfigError where two distributions use one name.

    In a checkout those of the project itself are read from ``pyproject.toml``: metadata of an installation that is
    older than the checkout would hide them.
    """
    found = _own(group)
    for point in _entry_points(group):
        distribution = point.dist.name if point.dist is not None else ""
        if distribution == DISTRIBUTION and paths.checkout_dir() is not None:
            continue
        extension = Extension(group, point.name, point.value, distribution)
        before = found.setdefault(point.name, extension)
        if before != extension:
            raise ConfigError(
                f"two packages bring {point.name!r} of {group}: {before.distribution} and {distribution}; "
                "uninstall one of them"
            )
    return found


def _entry_points(group: str) -> metadata.EntryPoints:
    """Those of ``group`` of everything installed: read again when a folder of packages has changed."""
    folders = [path for path in map(Path, sys.path) if path.is_dir()]
    return _entry_points_of(group, tuple((str(path), path.stat().st_mtime_ns) for path in folders))


@lru_cache(maxsize=32)
def _entry_points_of(group: str, _folders: tuple[tuple[str, int], ...]) -> metadata.EntryPoints:
    # Reads a file of each package: 20 ms and more, and a start asks a dozen times.
    return metadata.entry_points(group=group)


def _own(group: str) -> dict[str, Extension]:
    root = paths.checkout_dir()
    if root is None:
        return {}
    file = root / "pyproject.toml"
    declared = _declared(file, file.stat().st_mtime_ns).get(group, {})
    return {name: Extension(group, name, value, DISTRIBUTION) for name, value in declared.items()}


@lru_cache(maxsize=4)
def _declared(project: Path, _changed_ns: int) -> dict[str, dict[str, str]]:
    declared: dict[str, dict[str, str]] = tomllib.loads(project.read_text("utf-8"))["project"].get("entry-points", {})
    return declared


def announced_packages() -> frozenset[str]:
    """The import packages, this program's own among them, that entry points of the groups ``hbba.*`` name."""
    points = [point.value for group in GROUPS for point in _entry_points(group)]
    return frozenset({"app", *(value.partition(":")[0].partition(".")[0] for value in points)})


def load_named(path: str) -> object | None:
    """The object at ``package.module:Name``, whose module is imported; None where there is no such module or name.

    Raises ConfigError, one sentence with file and line, for a module that is there and cannot be imported.
    """
    module_path, _, name = path.partition(":")
    if not all(part.isidentifier() for part in (*module_path.split("."), name)):
        return None
    try:
        return getattr(importlib.import_module(module_path), name, None)
    except Exception as failure:  # a package of others may raise anything while it is imported
        # Only the named file itself being absent is the configuration's fault.
        absent = failure.name if isinstance(failure, ModuleNotFoundError) else None
        if absent is not None and f"{module_path}.".startswith(f"{absent}."):
            return None
        raise ConfigError(f"{module_path} cannot be imported: {_sentence(failure)}") from failure


def why_absent(path: str) -> str | None:
    """Which part of ``package.module:Name`` is absent, in words; None where none is, or where it is no such path.

    Imports the packages above the module, as :func:`load_named` does.
    """
    module_path, _, name = path.partition(":")
    parts = module_path.split(".")
    if not all(part.isidentifier() for part in (*parts, name)):
        return None
    if parts[0] not in sys.modules and importlib.util.find_spec(parts[0]) is None:
        return f"no package {parts[0]!r} is installed here"
    for count in range(1, len(parts)):
        parent = importlib.import_module(".".join(parts[:count]))
        inside = [found.name for found in pkgutil.iter_modules(getattr(parent, "__path__", ()))]
        if parts[count] not in inside:
            return _absent(f"{parent.__name__} has no module", parts[count], inside)
    names = [known for known in vars(importlib.import_module(module_path)) if not known.startswith("_")]
    return None if name in names else _absent(f"{module_path} has no class", name, names)


def _absent(what: str, name: str, known: list[str]) -> str:
    from app.base.yaml_source import likeliest  # brings pydantic, which the parser of the command line does without

    return f"{what} {name!r}; {likeliest(name, known)}".rstrip("; ")


def may_be_imported_for_a_log(path: str) -> bool:
    """Whether the module of ``package.module:Name`` may be imported because a log names it.

    A log is a file of unknown origin: it may name what is imported already, and what announces itself to this program.
    """
    module_path = path.partition(":")[0]
    return module_path in sys.modules or module_path.partition(".")[0] in announced_packages()


def package_file(named: Path | str, folder: Path) -> Path:
    """The file that a configuration in ``folder`` calls ``named``.

    ``package:NAME/PATH`` is the file PATH of the import package NAME, or of this program's configuration where NAME is
    ``hbba``; any other path is relative to ``folder``. A file that a recording carried along comes before the
    package's. Raises ConfigError for a package that is not installed.
    """
    inside = split_package_file(named)
    if inside is None:
        return folder / named
    package, rest = inside
    attached = folder / ATTACHED / package / rest
    return attached if attached.is_file() else package_folder(package) / rest


def split_package_file(named: Path | str) -> tuple[str, Path] | None:
    """Package and path of ``package:NAME/PATH``; None for a plain path."""
    first, *rest = Path(named).parts or ("",)
    return (first.removeprefix(_PACKAGE_FILE), Path(*rest)) if first.startswith(_PACKAGE_FILE) else None


def announced_configurations() -> dict[str, Path]:
    """The program configurations that packages announce: ``NAME = "package.folder"`` is ``package/folder/NAME.yaml``.

    Raises ConfigError for one whose package is not installed or has no such file.
    """
    return {name: _announced_by(extension) for name, extension in extensions(_CONFIGURATIONS).items()}


def announced_configuration(name: str) -> Path | None:
    """The program configuration ``name`` of a package; None where none announces it. Raises ConfigError for that one
    alone: another package whose folder is gone leaves it as it is."""
    extension = extensions(_CONFIGURATIONS).get(name)
    return None if extension is None else _announced_by(extension)


def announced_names() -> tuple[str, ...]:
    """The names of program configurations that packages announce, whether their files are there or not."""
    return tuple(extensions(_CONFIGURATIONS))


def _announced_by(extension: Extension) -> Path:
    package, *folders = extension.value.split(".")
    whose = f"configuration {extension.name!r}, from {extension.distribution}"
    again = f"install {extension.distribution} again, or uninstall it"
    try:
        file = package_folder(package).joinpath(*folders, f"{extension.name}.yaml")
    except ConfigError as failure:
        raise ConfigError(f"{whose}: {failure.message}; {again}") from failure
    if not file.is_file():
        raise ConfigError(f"{whose}: there is no file {file}; {again}")
    return file


def package_folder(package: str) -> Path:
    """The folder of an installed import package, which is not imported for it. Raises ConfigError."""
    if package == DISTRIBUTION:
        return paths.config_dir()
    spec = importlib.util.find_spec(package) if package.isidentifier() else None
    if spec is None or not spec.submodule_search_locations:
        raise ConfigError(f"there is no package {package!r} installed")
    return Path(next(iter(spec.submodule_search_locations)))


def _sentence(failure: Exception) -> str:
    """The error and its place, for people."""
    if isinstance(failure, SyntaxError):
        return f"{failure.filename}:{failure.lineno}: {failure.msg}"
    frames = [frame for frame in traceback.extract_tb(failure.__traceback__) if not frame.filename.startswith("<")]
    last = frames[-1]
    return f"{last.filename}:{last.lineno}: {type(failure).__name__}: {failure}"
