"""Mistakes and gaps of a tour, each with the value that it is about."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Literal

from pydantic import ValidationError

from app.base.broken_rule import Rule, broken_rule
from app.base.yaml_source import KeyPath, validation_message
from app.tours.model import Tour

#: ``mistake``: such a tour is not kept; ``error``: it is kept, and cannot run; ``warning``: it runs all the same.
Severity = Literal["mistake", "error", "warning"]


@dataclass(frozen=True, slots=True)
class TourProblem:
    """A problem of the value at ``path``; ``message`` is one sentence with what is allowed or what follows, ``rule``
    the rule of the model that the value breaks, if any."""

    path: KeyPath
    message: str
    severity: Severity = "mistake"
    rule: Rule | None = dataclasses.field(default=None, compare=False)

    @property
    def field(self) -> str:
        """The path as REST writes it: ``stops.0.place``."""
        return ".".join(map(str, self.path))


class InvalidTour(ValueError):
    """Data is no tour, for its ``problems``, of which there is at least one."""

    def __init__(self, problems: tuple[TourProblem, ...]) -> None:
        super().__init__("; ".join(f"{problem.field}: {problem.message}" for problem in problems))
        self.problems = problems


def of_validation(failure: ValidationError) -> tuple[TourProblem, ...]:
    """What pydantic found, in the words of the house: misspelt keys first."""
    details = sorted(failure.errors(include_url=False), key=lambda detail: detail["type"] != "extra_forbidden")
    paths = [_path(detail["loc"]) for detail in details]
    found: dict[KeyPath, TourProblem] = {}
    for path, detail in zip(paths, details, strict=True):
        # A list whose values are all wrong is called too short, too.
        if detail["type"] == "too_short" and any(other[: len(path)] == path != other for other in paths):
            continue
        message = validation_message(Tour, {**detail, "loc": path}, "a mapping")
        found.setdefault(path, TourProblem(path, message, rule=broken_rule(detail)))
    return tuple(found.values())


def _path(location: KeyPath) -> KeyPath:
    """Without the parts that name a member of a union or a key of a mapping, which no file has."""
    return tuple(part for part in location if not (isinstance(part, str) and part.startswith("[")))
