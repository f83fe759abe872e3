"""``hbba new``: the skeleton of a package that brings something to the program: working, tested and in order."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.output import add_json, print_json

if TYPE_CHECKING:
    from app.program.config import Configuration

TEMPLATES = Path(__file__).with_name("templates")
KINDS = {
    "module": "a perception: a module with a desire class, strategies and a message type of its own",
    "motivation": "a module that desires something while there is reason to",
    "behavior": "a module that drives the base while it is desired",
    "body": "a robot: what its sensors give, and what becomes of commands",
}
#: What the last command shows on the page.
_SEEN = {
    "module": "On the page: the lane {title} is open. Drive (W, A, S, D) until you are stopped before something: the "
    "tab Found lists it.",
    "motivation": "On the page: drive (W, A, S, D) until you are stopped before something: the lane Find QR codes "
    "opens, and closes five seconds after you have left.",
    "behavior": "On the page: Add a desire, {title}: the robot drives up to what is ahead.",
    "body": "On the page: the body in the 3D view, and what its laser sees.",
}
_SUFFIX = ".template"
_PLACEHOLDER = re.compile(r"\{\{(\w+)\}\}")
#: Names that the templates import or use otherwise, which a class of theirs must not have.
_TAKEN = frozenset(
    {"Any", "BaseModel", "ClassVar", "ConfigDict", "DesireClass", "Field", "IntentionWorkspace", "Mapping", "Module",
     "ModuleContext", "Settings", "Source", "UnknownDesire"}
)  # fmt: skip


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "new",
        help="write the skeleton of a package with a module, motivation, behavior or body",
        description="Write a package into a folder of its own: code, configuration by name, and a test. It works as it "
        "is; change it into what you want. docs/writing-a-module.md begins with it.",
    )
    kinds = "; ".join(f"{kind}: {what}" for kind, what in KINDS.items())
    parser.add_argument("kind", choices=list(KINDS), metavar="KIND", help=kinds)
    parser.add_argument("name", metavar="NAME", help="of its class, such as DoorDetector")
    parser.add_argument(
        "--in", dest="folder", type=Path, default=Path(), metavar="FOLDER", help="where (default: the working folder)"
    )
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    names = names_of(args.kind, args.name)
    package = write(args.kind, names, args.folder)
    if args.json:
        written = sorted(path.relative_to(package).as_posix() for path in package.rglob("*") if path.is_file())
        print_json({"folder": str(package), "configuration": names["module"], "files": written})
        return 0
    print(f"{package}: {args.kind} {args.name}. Next:\n")
    print(f"  pip install -e {package}\n  hbba check {names['module']}\n  pytest {package}")
    print(f"  hbba run --config {names['module']}")
    print(f"\n{_SEEN[args.kind].format(**names)}")
    return 0


def names_of(kind: str, name: str) -> dict[str, str]:
    """The names in the templates of ``kind``, for a class ``name``. Raises ConfigError for one that cannot be."""
    from app.base import paths
    from app.commands.packaged import config_names
    from app.program.config import load_configuration

    if not re.fullmatch(r"[A-Z][A-Za-z0-9]{1,39}", name):
        raise ConfigError(
            f"{name!r} is no name of a class: 2 to 40 letters and digits, each word with a capital, as DoorDetector",
            "NAME",
        )
    lab = load_configuration(paths.config_dir() / "lab.yaml")
    if name in _taken(lab):
        raise ConfigError(f"the program itself has something called {name}; choose another", "NAME")
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z][a-z0-9]*|[a-z0-9]+", name)
    module = "_".join(words).lower()
    if module in config_names("program") or module in lab.channels:
        raise ConfigError(f"there is a configuration or a channel called {module}; choose another name", "NAME")
    return {
        "kind": kind,
        "Class": name,
        "module": module,
        "channel": module,
        "name": module.replace("_", "-"),
        "CONSTANT": module.upper(),
        "package": f"hbba_{module}",
        "distribution": f"hbba-{module.replace('_', '-')}",
        "title": " ".join(words).capitalize(),
        "entry_points": _BODY.format(module=module, constant=module.upper()) if kind == "body" else "",
    }


def write(kind: str, names: dict[str, str], folder: Path) -> Path:
    """Write the package into a new folder within ``folder``, and return that. Raises ConfigError, nothing written."""
    package = folder / names["distribution"]
    if package.exists():
        raise ConfigError("is there already; nothing is overwritten", str(package))
    files = {
        target: _PLACEHOLDER.sub(lambda found: names[found[1]], source.read_text("utf-8"))
        for root in (TEMPLATES / "common", TEMPLATES / kind)
        for source in sorted(root.rglob(f"*{_SUFFIX}"))
        for target in [package / _target(source.relative_to(root), names)]
    }
    try:
        for path, text in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
    except OSError as failure:
        raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(package)) from None
    return package


_BODY = """
[project.entry-points."hbba.bodies"]
{module} = "hbba_{module}.{module}:{constant}"
"""


def _target(path: Path, names: dict[str, str]) -> Path:
    named = path.as_posix().removesuffix(_SUFFIX).replace("PACKAGE", names["package"])
    return Path(named.replace("MODULE", names["module"]))


def _taken(lab: Configuration) -> frozenset[str]:
    """Names of classes of the templates, and of the program's own messages, modules and desire classes."""
    from app import messages
    from app.program.desire_classes import desire_classes

    return _TAKEN | set(messages.__all__) | lab.program.modules.keys() | set(desire_classes(lab))
