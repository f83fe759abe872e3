"""The desire classes of a program: what its modules serve or need (thesis 4.2.5)."""

from __future__ import annotations

from app.attention.desires import DesireClass, DesireClasses
from app.base.errors import ConfigError
from app.program.config import Configuration
from app.runtime.graph import load_class


def desire_classes(configuration: Configuration) -> DesireClasses:
    """The union of what the modules of the program's file declare, in their order there.

    Modules that a replay or a trial leaves out count, so that desires and strategies are those of the whole program.
    Raises ConfigError where two modules declare different classes of one name.
    """
    found: dict[str, tuple[DesireClass, str]] = {}
    for name, class_path in _class_paths(configuration).items():
        key = ("modules", name, "class")
        try:
            module_class = load_class(class_path)
        except ConfigError as failure:
            raise configuration.wiring_error(failure.message, key) from failure
        for declared in () if module_class is None else module_class.desire_classes:  # the graph refuses what is none
            if not isinstance(declared, DesireClass):
                raise configuration.wiring_error(
                    f"desire_classes of {class_path} holds {declared!r}, which is no DesireClass", key
                )
            before, declarer = found.setdefault(declared.name, (declared, name))
            if before != declared:
                raise configuration.wiring_error(
                    f"{name} and {declarer} declare different desire classes called {declared.name!r}; declare one of "
                    "them under another name",
                    key,
                )
    return DesireClasses(declared for declared, _ in found.values())


def _class_paths(configuration: Configuration) -> dict[str, str]:
    """The class of each module: of the file, and of what was added to it since."""
    written = configuration.program_document.data["modules"]
    return {name: module["class"] for name, module in written.items()} | {
        name: spec.class_path for name, spec in configuration.program.modules.items()
    }
