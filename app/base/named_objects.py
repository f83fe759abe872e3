"""Objects named in configuration as ``package.module:Name``, and the packages that others add to this program."""

from __future__ import annotations

import importlib
import traceback

from app.base.errors import ConfigError


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
        absent = isinstance(failure, ModuleNotFoundError) and failure.name is not None
        if absent and f"{module_path}.".startswith(f"{failure.name}."):
            return None
        raise ConfigError(f"{module_path} cannot be imported: {_sentence(failure)}") from failure


def _sentence(failure: Exception) -> str:
    """What went wrong and where, for people."""
    if isinstance(failure, SyntaxError):
        return f"{failure.filename}:{failure.lineno}: {failure.msg}"
    frames = [frame for frame in traceback.extract_tb(failure.__traceback__) if not frame.filename.startswith("<")]
    last = frames[-1]
    return f"{last.filename}:{last.lineno}: {type(failure).__name__}: {failure}"
