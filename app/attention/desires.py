"""Desires and their classes (thesis 2.2.3, 4.2.5).

A desire asks for one class of behavior or perception: with an intensity *i* (how much), a desired utility *u* (how good
it must be; 0 inhibits the class), a security flag *z* (must be fulfilled) and the parameters its class declares.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import msgspec
from pydantic import BaseModel, ConfigDict, ValidationError

from app.base.broken_rule import Rule, broken_rule
from app.base.yaml_source import dotted, suggestion, validation_message
from app.messages import Desire as Desire
from app.messages import Source as Source
from app.messages import SourceKind as SourceKind

SCALE: Final = 8.0
"""The scale's end for intensity, desired utility and produced utility: t_i = t_u = t_v of the thesis."""

GRAIN: Final = 1000
"""Intensities, utilities and costs are whole thousandths, so that optima are compared exactly."""


class UnknownDesireClass(Exception):
    """No desire class has this name. ``name`` is the unknown one, ``known`` those there are."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        self.name = name
        self.known = tuple(sorted(known))
        super().__init__(f"no desire class is called {name!r}; {suggestion(name, self.known)}")


class InvalidDesire(Exception):
    """A desire was refused. ``field`` is the dotted name of the invalid field, ``message`` says what is allowed,
    ``rule`` is the rule of its parameters that it breaks, if any."""

    def __init__(self, field: str, message: str, rule: Rule | None = None) -> None:
        self.field = field
        self.message = message
        self.rule = rule
        super().__init__(f"{field}: {message}")


class NoParameters(BaseModel):
    """The parameters of a desire class that takes none."""

    model_config = ConfigDict(extra="forbid")


@dataclass(frozen=True, slots=True)
class DesireClass:
    """A desire class: its name in configuration and REST, words for people, and its parameters as a pydantic model.

    ``achievement``: a desire of it leaves the Intention Workspace by itself once a behavior reports that it is done, or
    that it cannot be done (a place to go to, a text to say). Else a report leaves it where it is: what it asks for is
    maintained until it is withdrawn (a point to look at, a perception).
    """

    name: str
    title: str
    description: str
    parameters: type[BaseModel] = NoParameters
    achievement: bool = False

    def validated(self, params: Mapping[str, Any] | None) -> dict[str, Any]:
        """``params`` checked, completed with defaults and made JSON-able; raises InvalidDesire naming the parameter."""
        given = dict(params or {})
        if self.parameters.model_config.get("extra") != "allow":
            allowed = [info.alias or name for name, info in self.parameters.model_fields.items()]
            for key in given:
                if key not in allowed:
                    raise InvalidDesire(
                        f"params.{key}", f"{self.name} has no such parameter; {suggestion(key, allowed)}"
                    )
        try:
            return self.parameters.model_validate(given).model_dump(mode="json", by_alias=True)
        except ValidationError as failure:
            detail = failure.errors(include_url=False)[0]
            field = dotted(("params", *detail["loc"]))
            raise InvalidDesire(field, validation_message(self.parameters, detail), broken_rule(detail)) from None


class DesireClasses(Mapping[str, DesireClass]):
    """The desire classes of a robot by name; an unknown name raises UnknownDesireClass, which names those there are."""

    def __init__(self, classes: Iterable[DesireClass]) -> None:
        self._classes: dict[str, DesireClass] = {}
        for desire_class in classes:
            if desire_class.name in self._classes:
                raise ValueError(f"two desire classes are called {desire_class.name!r}")
            self._classes[desire_class.name] = desire_class

    def __getitem__(self, name: str) -> DesireClass:
        try:
            return self._classes[name]
        except KeyError:
            raise UnknownDesireClass(name, self._classes) from None

    def __contains__(self, name: object) -> bool:
        return name in self._classes

    def __iter__(self) -> Iterator[str]:
        return iter(self._classes)

    def __len__(self) -> int:
        return len(self._classes)


def checked_number(field: str, value: object, *, above: float | None = None) -> float:
    """``value`` rounded to a thousandth; raises InvalidDesire unless within [0, 8] (``above``: strictly greater)."""
    low = 0.0 if above is None else above + 1 / GRAIN
    problem = f"must be a number from {low:g} to {SCALE:g}, not {value!r}"
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InvalidDesire(field, problem)
    rounded = round(value * GRAIN) / GRAIN
    if rounded > SCALE or rounded < 0 or (above is not None and rounded <= above):
        raise InvalidDesire(field, problem)
    return rounded


def may_be_raised(desire: Desire) -> bool:
    """Whether an emotion may raise it: it inhibits nothing, and is not kept as security."""
    return desire.utility > 0 and not desire.security


def effective(desire: Desire) -> Desire:
    """``desire`` with the intensity that counts: raised by its modulation, if it has one, to 8 at most."""
    if desire.modulation is None or not may_be_raised(desire):
        return desire
    intensity = min(SCALE, round((desire.intensity + desire.modulation.by) * GRAIN) / GRAIN)
    return msgspec.structs.replace(desire, intensity=intensity)


def strongest_first(desire: Desire) -> tuple[float, bool, float]:
    """Sort key: the most intense desire first; of equally intense ones security before others, then the newest.

    The thesis leaves the tie open. The newest wins, so that a new request takes effect; security wins, so that only a
    desire of greater intensity can override it.
    """
    return (-desire.intensity, not desire.security, -desire.created)
