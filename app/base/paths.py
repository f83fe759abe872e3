"""Paths of the program's own files, in a checkout or installed from a wheel."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def config_dir() -> Path:
    """The folder of configuration: the checkout's ``config/`` if this is one, else the copy packed in the wheel."""
    checkout = checkout_dir()
    return checkout / "config" if checkout is not None else _PACKAGE / "_config"


def checkout_dir() -> Path | None:
    """The checkout this program runs from, or None where it is installed."""
    root = _PACKAGE.parent
    return root if (root / "pyproject.toml").is_file() and (root / "config").is_dir() else None


def static_dir() -> Path:
    """Folder of the built operator page, which need not exist."""
    return _PACKAGE / "console" / "static"


def host_name() -> str:
    """Name of this computer: ``$HBBA_HOST``, or its network name. Its calibration has this name."""
    return os.environ.get("HBBA_HOST") or platform.node() or "this-computer"


def version() -> str:
    """The program's version; empty where it is not installed."""
    try:
        return metadata.version("hbba")
    except metadata.PackageNotFoundError:
        return ""


def processor() -> str:
    """Model name of this computer's processor, or its architecture."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
