"""Worlds of the BARN challenge (Perille et al., SSRR 2020): cylinders, a start, a goal, and a path between them.

A file of worlds is JSON: ``{"robot": {"max_v": 2.0}, "worlds": [{"id": 1, "cylinders": [[x, y, radius], ...], "start":
[x, y, yaw], "goal": [x, y], "goal_tolerance": 1.0, "timeout_s": 100, "path": [[x, y], ...]}, ...]}``, metres and
radians. Other keys are ignored.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.json_source import BeyondBounds, load_json
from app.base.plain_file import read_plain
from app.base.yaml_source import validation_message
from app.robots.config import StartPose
from app.robots.simulated.world_config import CylindersConfig, LightConfig, MaterialConfig, WorldConfig

#: Height of the cylinders (m): above the laser of such a robot.
HEIGHT_M = 1.0
#: Greatest size of a file of worlds: the benchmark's 300 take a hundredth of it.
_MOST_BYTES = 100_000_000

_Number = Annotated[float, Field(allow_inf_nan=False)]
_Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class BarnRobot(_Model):
    """Properties of the worlds' robot that the score needs."""

    max_v: _Positive = 2.0


class BarnWorld(_Model):
    """One world. ``id``: its name; ``path``: a path from the start to the goal, which defines T*."""

    id: int | str
    cylinders: tuple[tuple[_Number, _Number, _Positive], ...]
    start: tuple[_Number, _Number, _Number]
    goal: tuple[_Number, _Number]
    goal_tolerance: _Positive = 1.0
    timeout_s: _Positive = 100.0
    path: tuple[tuple[_Number, _Number], ...] = ()
    path_length: _Positive | None = None

    @field_validator("goal", mode="before")
    @classmethod
    def _goal_without_heading(cls, goal: object) -> object:
        return goal[:2] if isinstance(goal, list | tuple) and len(goal) == 3 else goal

    @model_validator(mode="after")
    def _can_be(self) -> BarnWorld:
        x, y, _ = self.start
        for cx, cy, radius in self.cylinders:
            if math.dist((x, y), (cx, cy)) <= radius:
                raise ValueError(f"the start ({x:g}, {y:g}) lies in the cylinder at ({cx:g}, {cy:g})")
        if math.dist((x, y), self.goal) <= self.goal_tolerance:
            raise ValueError("the start lies within the tolerance of the goal: there is nothing to drive")
        return self

    @property
    def name(self) -> str:
        """The id as text."""
        return str(self.id)

    @property
    def length_m(self) -> float:
        """Length of the file's path, or of the straight line without one."""
        if self.path_length is not None:
            return self.path_length
        if len(self.path) > 1:
            return sum(math.dist(a, b) for a, b in pairwise(self.path))
        return math.dist(self.start[:2], self.goal)

    @property
    def X_WO(self) -> Pose2:
        """The robot's start in the world, which is also the origin of its map."""
        return Pose2(*self.start)

    def start_pose(self) -> StartPose:
        """The start in a body's configuration."""
        x, y, yaw = self.start
        return StartPose(x=x, y=y, heading_deg=math.degrees(yaw))

    def build(self) -> WorldConfig:
        """The world for the simulator: a flat floor and the cylinders."""
        alike: dict[float, list[tuple[float, float]]] = {}
        for x, y, radius in self.cylinders:
            alike.setdefault(radius, []).append((x, y))
        return WorldConfig(
            name=f"BARN {self.name}",
            size=(1.0, 1.0),  # of the drawn area: the ground plane is infinite
            floor="floor",
            materials={"floor": MaterialConfig(color=(150, 150, 148)), "post": MaterialConfig(color=(60, 104, 168))},
            cylinders=tuple(
                CylindersConfig(at=tuple(places), radius=radius, height=HEIGHT_M, material="post")
                for radius, places in alike.items()
            ),
            lights=(LightConfig(direction=(0.4, 0.5, -0.8), strength=0.3),),
        )


class _WorldsFile(_Model):
    robot: BarnRobot = BarnRobot()
    worlds: Annotated[tuple[BarnWorld, ...], Field(min_length=1)]

    @field_validator("worlds")
    @classmethod
    def _ids_differ(cls, worlds: tuple[BarnWorld, ...]) -> tuple[BarnWorld, ...]:
        seen: set[str] = set()
        for world in worlds:
            if world.name in seen:
                raise ValueError(f"two worlds have the id {world.name}")
            seen.add(world.name)
        return worlds


@dataclass(frozen=True, slots=True)
class Worlds:
    """A file of worlds: ``max_mps``: the robot's greatest speed; ``digest``: identifies the file."""

    file: Path
    worlds: tuple[BarnWorld, ...]
    max_mps: float
    digest: str


def load_worlds(path: Path) -> Worlds:
    """Read a file of worlds. Raises ConfigError, naming the world and the invalid value."""
    try:
        raw = read_plain(path, _MOST_BYTES)
        document = load_json(raw.decode("utf-8"))
    except OSError as failure:
        raise ConfigError(f"cannot be read: {failure.strerror or failure}", str(path)) from None
    except UnicodeDecodeError:
        raise ConfigError("is not a text file in UTF-8", str(path)) from None
    except json.JSONDecodeError as failure:
        raise ConfigError(f"is no JSON: {failure.msg}", str(path), failure.lineno) from None
    except BeyondBounds as failure:
        raise ConfigError(f"is not read: {failure}", str(path)) from None
    try:
        file = _WorldsFile.model_validate(document)
    except ValidationError as failure:
        raise ConfigError(_problem(document, failure), str(path)) from None
    return Worlds(path, file.worlds, file.robot.max_v, hashlib.sha256(raw).hexdigest()[:16])


def chosen(worlds: Worlds, only: str | None) -> tuple[BarnWorld, ...]:
    """The worlds that ``only`` names (``1,5,10-20``), in the file's order; all if None. Raises ConfigError."""
    if only is None:
        return worlds.worlds
    by_name = {world.name: world for world in worlds.worlds}
    wanted: set[str] = set()
    for part in (piece.strip() for piece in only.split(",")):
        first, dash, last = part.partition("-")
        if part in by_name:
            wanted.add(part)
        elif dash and first.strip().isdecimal() and last.strip().isdecimal():
            found = [name for name in by_name if name.isdecimal() and int(first) <= int(name) <= int(last)]
            if not found:
                raise ConfigError(f"no world of {worlds.file} lies in {part}; {_ids(by_name)}", "--only")
            wanted.update(found)
        else:
            raise ConfigError(f"{worlds.file} has no world {part!r}; {_ids(by_name)}", "--only")
    return tuple(world for name, world in by_name.items() if name in wanted)


def _ids(names: Sequence[str] | dict[str, BarnWorld]) -> str:
    listed = list(names)
    return f"there are {', '.join(listed[:5])}{f' … {listed[-1]}' if len(listed) > 5 else ''}"


def _problem(document: object, failure: ValidationError) -> str:
    """The first mistake in one sentence that names the world."""
    detail = failure.errors(include_url=False)[0]
    where = list(detail["loc"])
    what = validation_message(_WorldsFile, detail, "a JSON object")
    if len(where) > 1 and where[0] == "worlds" and isinstance(where[1], int) and isinstance(document, dict):
        world = document["worlds"][where[1]]
        named = f"world {world['id']}" if isinstance(world, dict) and "id" in world else f"world number {where[1] + 1}"
        key = ".".join(str(part) for part in where[2:] if part not in ("int", "str"))
        return f"{named}: {key + ': ' if key else ''}{what}"
    if where == ["worlds"] and detail["type"] == "missing":
        return "is no file of worlds: it has no list of 'worlds' (docs/experiments.md says how it is written)"
    key = ".".join(str(part) for part in where)
    return f"{key}: {what}" if key else f"is no file of worlds: {what}"
