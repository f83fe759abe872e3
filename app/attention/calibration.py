"""Measured costs of modules on this computer: c(φ) and events(φ), read from ``config/calibration/<host>.yaml``.

The thesis measured each perception at several φ on a recording, and found CPU use and events to be close to linear in
1/φ (thesis 4.2.3, figure 4.4). ``hbba calibrate`` measures and writes this file; a strategy refers to it with ``costs:
{cpu: {calibrated_or: 6}}``: the measured cost where this computer was calibrated, else 6.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from app.base.yaml_source import load_yaml

#: The resource that calibration measures: thread CPU time, in % of one core.
RESOURCE = "cpu"


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Point(_Model):
    """Measurements at one φ."""

    phi: int = Field(ge=1)
    cpu: float = Field(ge=0, description="% of one core, in real time: the median of the runs")
    events: float = Field(ge=0, description="percepts a second: the mean of the runs")
    runs: int = Field(1, ge=1, description="how many runs were made: starting offsets, repetitions")
    cpu_spread: float = Field(0, ge=0, description="least to greatest of the runs, % of one core")


class CostFit(_Model):
    """``base + slope / φ``, by least squares; ``residual`` is the root mean square distance of the points from it."""

    base: float
    slope: float
    residual: float = Field(ge=0)

    def at(self, phi: float) -> float:
        """The line's value at ``phi``; a closed filter's (infinite φ) is ``base``."""
        return self.base + self.slope / phi


class Relation(_Model):
    """CPU use and number of events of a module as functions of φ of one filter."""

    points: tuple[Point, ...] = Field(min_length=1)
    cpu: CostFit
    events: CostFit

    def cost(self, phi: float) -> float:
        """CPU (% of one core) at ``phi``: as measured there, else by the line."""
        for point in self.points:
            if point.phi == phi:
                return point.cpu
        return max(0.0, self.cpu.at(phi))


class CostCalibration(_Model):
    """Relations of one computer, by filter and parameters (:func:`relation_name`), and the data they were measured
    on."""

    host: str
    made: str = Field(description="date and time, ISO 8601")
    processor: str = ""
    version: str = ""
    log: str = Field("", description="the recording they were measured on")
    relations: dict[str, Relation] = Field(default_factory=dict)

    def cost(
        self, filters: Mapping[str, float], parameters: Mapping[str, Mapping[str, Any]] | None = None
    ) -> float | None:
        """CPU (% of one core) of modules filtered so, and handed ``parameters``; None if none of that was measured."""
        costs = []
        for name, phi in filters.items():
            handed = (parameters or {}).get(name.partition(".")[0], {})
            relation = self.relations.get(relation_name(name, handed))
            if relation is not None:
                costs.append(relation.cost(phi))
        return sum(costs) if costs else None


def relation_name(filter_name: str, parameters: Mapping[str, Any]) -> str:
    """The key of the relation of ``Module.port`` for a strategy that sets ``parameters`` of the module."""
    if not parameters:
        return filter_name
    return f"{filter_name} with {', '.join(f'{key}={value}' for key, value in sorted(parameters.items()))}"


def load_cost_calibration(folder: Path, host: str) -> CostCalibration | None:
    """The calibration of ``host`` in ``folder``, or None where there is none. Raises ConfigError."""
    path = calibration_file(folder, host)
    return load_yaml(path).validate(CostCalibration) if path.is_file() else None


def calibration_file(folder: Path, host: str) -> Path:
    """Path of the calibration of ``host``, which need not exist."""
    return folder / f"{host}.yaml"
