"""Files and facts that a recording carries beside its messages, so that it can be replayed alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

YAML = "application/yaml"
JSON = "application/json"


@dataclass(frozen=True, slots=True)
class AttachedFile:
    """A file as it was: ``name`` is its path relative to the folder of the program's configuration, with ``/``."""

    name: str
    media_type: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Manifest:
    """Files and facts of the program that made a recording.

    ``files``: configuration, strategies, robot, model, world, calibration. ``facts``: ``program`` (name of the file
    among ``files`` that the program starts from), ``robot``, ``version``, ``commit`` (empty where unknown), ``host``;
    and ``stream.<name>``: the channel that the body's stream of that name was recorded from.
    """

    files: tuple[AttachedFile, ...] = ()
    facts: Mapping[str, str] = field(default_factory=dict)
