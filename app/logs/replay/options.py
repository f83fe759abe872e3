"""What may be chosen when a log is lived again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.program.config import Configuration
from app.runtime.graph import Pin


@dataclass(frozen=True, slots=True)
class ReplayOptions:
    """How a log is replayed.

    ``begin`` and ``end``: robot's clock (s), None for the log's own. ``only`` names the modules that run (None: all
    that can). ``phi`` holds filters (``Module.port``) at a divisor whatever attention wants (``inf``: closed); at every
    filter that is held or attended, the first ``offset`` messages go by; ``pins`` holds filters with an offset of their
    own. ``config``: another program than the log's own, by its file or put together already. ``desires``: those that
    others than the program's modules had are had again. ``record``: name of a new recording of the replay.
    ``parameters`` are handed to modules as an intention would, before anything comes.
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
