"""Selection problems in files: what ``hbba solve`` reads (docs/solve.md).

A problem is a strategy file with ``desires``, and optionally ``tables`` (strategy files to add) and ``selected`` (what
is selected now, which decides ties).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import GRAIN, SCALE, Desire, Source, strongest_first
from app.attention.problem import SelectionProblem
from app.attention.strategies import StrategyTable
from app.attention.strategy_file import StrategyFile, build_table
from app.base.yaml_source import Document, load_yaml, suggestion

_HERE = Source("operator", "hbba solve")


class DesireEntry(BaseModel):
    """A desire as the file writes it."""

    model_config = ConfigDict(extra="forbid", strict=True, populate_by_name=True)

    cls: str = Field(alias="class", min_length=1, description="The class desired.")
    intensity: Annotated[float, Field(gt=0, le=SCALE)] = Field(description="How much, over 0 and at most 8.")
    utility: Annotated[float, Field(ge=0, le=SCALE)] = Field(
        1.0, description="Desired utility u: how good it must be at least; 0 inhibits the class."
    )
    security: bool = Field(False, description="Whether it must be fulfilled.")
    params: dict[str, Any] = Field(default={}, description="Parameters for the modules of its strategies.")


class ProblemFile(StrategyFile):
    """A selection problem: desires, strategies and resources."""

    model_config = ConfigDict(extra="forbid", strict=True, title="HBBA selection problem")

    desires: list[DesireEntry] = Field(
        default=[], description="Desires; of several of one class the most intense counts, of equals the first."
    )
    tables: list[str] = Field(default=[], description="Strategy files to add, relative to this file.")
    selected: list[str] = Field(default=[], description="Strategies selected now: among equal optima they stay.")


@dataclass(frozen=True, slots=True)
class StatedProblem:
    """A problem as a person stated it, and the table it came with."""

    problem: SelectionProblem
    table: StrategyTable


def read_problem(document: Document, folder: Path) -> StatedProblem:
    """The problem that ``document`` states; its ``tables`` are looked up in ``folder``. Raises ConfigError."""
    file = document.validate(ProblemFile)
    files: list[tuple[Document, StrategyFile]] = []
    for index, name in enumerate(file.tables):
        if not (folder / name).is_file():
            raise document.error(f"there is no file {name!r} in {folder}", ("tables", index))
        table_document = load_yaml(folder / name)
        files.append((table_document, table_document.validate(StrategyFile)))
    files.append((document, file))
    classes = {entry.cls for entry in file.desires}
    for _, each in files:
        classes |= {entry.cls for entry in each.strategies} | {family.cls for family in each.families}
    table = build_table(files, classes=classes, ports=None)
    names = [strategy.name for strategy in table.strategies]
    for index, name in enumerate(file.selected):
        if name not in names:
            raise document.error(f"selected: unknown strategy {name!r}; {suggestion(name, names)}", ("selected", index))
    desires = []
    for index, entry in enumerate(file.desires):
        for key, value in (("intensity", entry.intensity), ("utility", entry.utility)):
            if abs(value * GRAIN - round(value * GRAIN)) > 1e-6:
                raise document.error(f"{key} should have at most 3 decimals, not {value!r}", ("desires", index, key))
        desires.append(
            Desire(
                f"desires[{index}]",
                entry.cls,
                intensity=entry.intensity,
                utility=entry.utility,
                security=entry.security,
                params=entry.params,
                source=_HERE,
                created=float(index),
            )
        )
    strongest: dict[str, Desire] = {}
    for desire in sorted(desires, key=strongest_first):
        strongest.setdefault(desire.cls, desire)
    ordered = {desire.cls: strongest[desire.cls] for desire in desires}
    return StatedProblem(
        SelectionProblem(ordered, table.strategies, table.capacities(), frozenset(file.selected)), table
    )


def problem_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of the problem format."""
    schema = ProblemFile.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
