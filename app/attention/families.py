"""Strategies that differ in φ alone, generated from one entry: costs from a line over 1/φ, as calibration measures them
(thesis 4.2.3), utilities from what each doubling of φ takes away.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, PlainValidator, WithJsonSchema

from app.attention.desires import GRAIN, SCALE

#: The placeholder of φ in a family's filters.
PHI = "phi"
_Number = Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False)]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, populate_by_name=True)


class UtilityByPhi(_Model):
    """``at_1 - per_doubling * log2(φ)``, or ``at_1 / φ``."""

    at_1: float = Field(gt=0, le=SCALE, description="Produced utility at φ = 1.")
    per_doubling: float | None = Field(
        None, ge=0, le=SCALE, description="What each doubling of φ takes from it; none: half of it."
    )

    def at(self, phi: int) -> float:
        """At ``phi``, rounded to what the solver counts in."""
        if self.per_doubling is None:
            return round(self.at_1 / phi * GRAIN) / GRAIN
        return round((self.at_1 - self.per_doubling * math.log2(phi)) * GRAIN) / GRAIN


class CostByPhi(_Model):
    """``base + slope / φ``."""

    base: _Number = Field(description="What it costs however rarely a message passes.")
    slope: _Number = Field(description="What all messages cost in addition.")

    def at(self, phi: int) -> float:
        """At ``phi``, rounded up to what the solver counts in."""
        return math.ceil((self.base + self.slope / phi) * GRAIN - 1e-6) / GRAIN


_NAMES = r"^[^{}]*\{phi\}[^{}]*$"


def _named_by_phi(names: str) -> str:
    if re.match(_NAMES, names) is None:
        raise ValueError("should have {phi} in it once, in place of which each strategy's φ is written")
    return names


class CalibratedByPhi(_Model):
    """The calibrated cost, and the line used on a computer without a calibration."""

    calibrated_or: CostByPhi


def _cost_by_phi(value: Any) -> CalibratedByPhi | CostByPhi:
    # A plain union would complain of each that it could be.
    if isinstance(value, dict) and "base" in value:
        return CostByPhi.model_validate(value)
    return CalibratedByPhi.model_validate(value)


_Cost = Annotated[
    CalibratedByPhi | CostByPhi, PlainValidator(_cost_by_phi, json_schema_input_type=CalibratedByPhi | CostByPhi)
]
_MULTIPLE = r"^([1-9]\d{0,3}) phi$"


def _by_phi(value: object) -> object:
    # A plain union would complain of each that it could be.
    divisor = isinstance(value, int) and not isinstance(value, bool) and value >= 1
    if divisor or value in (PHI, "off") or (isinstance(value, str) and re.match(_MULTIPLE, value)):
        return value
    raise ValueError("should be phi, a multiple of it such as 2 phi, an integer of at least 1, or off")


_DIVISOR_SCHEMA = {
    "anyOf": [{"enum": [PHI, "off"]}, {"type": "string", "pattern": _MULTIPLE}, {"minimum": 1, "type": "integer"}]
}
_Divisor = Annotated[str | int, BeforeValidator(_by_phi), WithJsonSchema(_DIVISOR_SCHEMA)]


class StrategyFamily(_Model):
    """Strategies of one class at several φ, as the file writes them."""

    names: Annotated[str, AfterValidator(_named_by_phi)] = Field(
        json_schema_extra={"pattern": _NAMES}, description="Their names; {phi} is replaced by φ."
    )
    cls: str = Field(alias="class", min_length=1, description="The desire class they serve.")
    phis: list[Annotated[int, Field(ge=1)]] = Field(min_length=1, description="Each φ that there is a strategy of.")
    utility: UtilityByPhi = Field(
        description="Produced utility: {at_1: v, per_doubling: less}, or {at_1: v} for v / φ."
    )
    filters: dict[str, _Divisor] = Field(
        min_length=1,
        description="Filters they set, Module.port to phi, to a multiple (2 phi), to an integer of at least 1, or off.",
    )
    requires: dict[str, float] = Field(default={}, description="As of a strategy.")
    parameters: dict[str, dict[str, Any]] = Field(default={}, description="As of a strategy.")
    costs: dict[str, _Cost] = Field(
        default={},
        description="By resource: {base: b, slope: s}, for b + s / φ, or {calibrated_or: {base: b, slope: s}}.",
    )

    def members(self) -> Iterator[dict[str, Any]]:
        """Each strategy as the file would have written it by itself."""
        for phi in self.phis:
            yield {
                "name": self.names.replace("{phi}", str(phi)),
                "class": self.cls,
                "utility": self.utility.at(phi),
                "filters": {name: _divisor(divisor, phi) for name, divisor in self.filters.items()},
                "requires": self.requires,
                "parameters": self.parameters,
                "costs": {name: _cost(cost, phi) for name, cost in self.costs.items()},
            }


def _cost(entry: CalibratedByPhi | CostByPhi, phi: int) -> Any:
    """The cost at ``phi``, as the entry of a strategy has it."""
    return entry.at(phi) if isinstance(entry, CostByPhi) else {"calibrated_or": entry.calibrated_or.at(phi)}


def _divisor(entry: str | int, phi: int) -> str | int:
    """The divisor of a filter at ``phi``."""
    if entry == PHI:
        return phi
    multiple = re.match(_MULTIPLE, entry) if isinstance(entry, str) else None
    return entry if multiple is None else int(multiple[1]) * phi
