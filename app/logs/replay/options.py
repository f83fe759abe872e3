"""Options of a replay."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.program.config import Configuration
from app.runtime.filter_bank import Pin


@dataclass(frozen=True, slots=True)
class ReplayOptions:
    """Options of a replay.

    ``begin`` and ``end``: robot's clock (s), None for the log's own. ``only`` names the modules that run (None: all
    that can). ``phi`` fixes filters (``Module.port``) at a divisor, whatever attention selects (``inf``: closed); every
    fixed or attended filter skips the first ``offset`` messages; ``pins`` fixes filters with an offset of their own.
    ``config``: another program than the log's own, by its file or already loaded. ``desires``: recorded desires of
    authors other than the program's modules are added again. ``record``: name of a new recording of the replay.
    ``parameters`` are set on modules as an intention would, before the first message.
    """

    begin: float | None = None
    end: float | None = None
    only: tuple[str, ...] | None = None
    phi: Mapping[str, float] = field(default_factory=dict)
    offset: int = 0
    pins: Mapping[str, Pin] = field(default_factory=dict)
    config: Path | Configuration | None = None
    desires: bool = True
    record: str | None = None
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
