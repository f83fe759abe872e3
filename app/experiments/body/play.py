"""What is desired and when, read from a file and carried out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import Source
from app.base.yaml_source import load_yaml, suggestion
from app.program.system import System

_SOURCE = Source("operator", "the experiment")
Seconds = Annotated[float, Field(ge=0, le=3600)]


class Cue(BaseModel):
    """A desire from second ``at`` of the play until second ``until``, or its end."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    at: Seconds
    until: Seconds | None = None
    cls: str = Field(alias="class", min_length=1)
    intensity: float = 5.0
    utility: float = 4.0
    params: dict[str, Any] = Field(default_factory=dict)


class Play(BaseModel):
    """``cues`` over so many ``seconds``; the emergency stop is pressed at second ``stop``, if any."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    seconds: Annotated[float, Field(gt=0, le=3600)]
    stop: Seconds | None = None
    cues: tuple[Cue, ...]


@dataclass(frozen=True, slots=True)
class Moment:
    """Something to do at second ``at``: ``end`` or ``begin`` the desire of the play's cue ``number``, or ``stop``."""

    at: float
    what: Literal["begin", "end", "stop"]
    number: int = 0


def load_play(path: Path, classes: Collection[str]) -> Play:
    """Read a play of desires of ``classes``. Raises ConfigError (file, line, key)."""
    document = load_yaml(path)
    play = document.validate(Play)
    for number, cue in enumerate(play.cues):
        key_path = ("cues", number)
        if cue.cls not in classes:
            known = suggestion(cue.cls, sorted(classes))
            raise document.error(f"cues.{number}: this program has no desire class {cue.cls!r}; {known}", key_path)
        if cue.until is not None and cue.until <= cue.at:
            raise document.error(f"cues.{number}: until ({cue.until:g}) must be after at ({cue.at:g})", key_path)
    return play


def moments(play: Play) -> list[Moment]:
    """What to do, in the order of time; at one second ends come before begins."""
    found = [Moment(cue.at, "begin", number) for number, cue in enumerate(play.cues)]
    found += [Moment(cue.until, "end", number) for number, cue in enumerate(play.cues) if cue.until is not None]
    if play.stop is not None:
        found.append(Moment(play.stop, "stop"))
    return sorted((each for each in found if each.at <= play.seconds), key=lambda each: (each.at, each.what != "end"))


async def perform(system: System, play: Play) -> float | None:
    """State the desires of ``play``, press the stop, and wait for its end; returns when the stop was pressed (s,
    robot's clock), if it was. Raises InvalidDesire naming the field."""
    begin = system.clock.now()
    stopped_at: float | None = None
    desires: dict[int, str] = {}
    for moment in moments(play):
        await system.clock.sleep(max(begin + moment.at - system.clock.now(), 0.0))
        if moment.what == "begin":
            desires[moment.number] = _desire(system, play.cues[moment.number])
        elif moment.what == "stop":
            system.link.e_stop("the experiment's stop")
            stopped_at = system.clock.now()
        elif any(desire.id == desires[moment.number] for desire in system.workspace.desires()):
            system.workspace.remove(desires[moment.number])
    await system.clock.sleep(max(begin + play.seconds - system.clock.now(), 0.0))
    return stopped_at


def _desire(system: System, cue: Cue) -> str:
    desire = system.workspace.add(
        cue.cls, intensity=cue.intensity, utility=cue.utility, params=cue.params, source=_SOURCE
    )
    return desire.id
