"""Requests about desires and budgets, checked as it comes in. Answers are of :mod:`app.console.records`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from app.attention.strategies import MOST

#: 30 days: longer is for ever, which is said by leaving it out.
LONGEST_TTL_S = 30 * 24 * 3600.0


class Request(BaseModel):
    """Base of every request body: unknown members are refused, numbers are not read from strings."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, populate_by_name=True)


def never_null(schema: dict[str, Any]) -> None:
    """Take null out of ``schema``: of a member that may be left out, which the model says by None, but not be null."""
    schema.update(next(choice for choice in schema.pop("anyOf") if choice.get("type") != "null"))
    schema.pop("default")


class NewDesire(Request):
    """A desire to create."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "class": "FindQRCodes",
                    "intensity": 8,
                    "utility": 4,
                    "security": False,
                    "params": {},
                    "ttl": 30,
                }
            ]
        }
    )

    cls: str = Field(alias="class", description="A class of GET /api/v1/desire-classes.")
    intensity: float = Field(gt=0, le=8, description="How much it is desired.")
    utility: float = Field(ge=0, le=8, description="Utility desired; 0 inhibits the class.")
    security: bool = Field(False, description="Whether it must be fulfilled.")
    params: dict[str, Any] = Field(default={}, description="Parameters as the class declares them.")
    ttl: float | None = Field(
        None, gt=0, le=LONGEST_TTL_S, description="Seconds after which it expires; null: it stays until removed."
    )


class DesireChange(Request):
    """A change of a desire; members left out stay."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"intensity": 5, "ttl": 60}]})

    intensity: float | None = Field(None, gt=0, le=8, json_schema_extra=never_null)
    utility: float | None = Field(None, ge=0, le=8, json_schema_extra=never_null)
    security: bool | None = Field(None, json_schema_extra=never_null)
    params: dict[str, Any] | None = Field(
        None,
        description="All parameters; they replace the former ones, and those left out take their default.",
        json_schema_extra=never_null,
    )
    ttl: float | None = Field(None, gt=0, le=LONGEST_TTL_S, description="Seconds from now; null: it stays.")


class SupposedDesire(Request):
    """What the strongest desire of a class is supposed to ask for."""

    intensity: float = Field(gt=0, le=8)
    utility: float = Field(1, ge=0, le=8, description="0 inhibits the class.")
    security: bool = False


class WhatIf(Request):
    """What is supposed; all else is as it is."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"desires": {"FindQRCodes": {"intensity": 8}}, "capacities": {"cpu": 60}}]}
    )

    desires: dict[str, SupposedDesire | None] = Field(default={}, description="By class; null: none of that class.")
    costs: dict[str, dict[str, Annotated[float, Field(ge=0, le=MOST)]]] = Field(
        default={}, description="By strategy and resource."
    )
    capacities: dict[str, Annotated[float, Field(ge=0, le=MOST)]] = Field(default={}, description="By resource.")


class ResourceChange(Request):
    """A new budget; attention selects again at once."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"capacity": 60}]})

    capacity: float = Field(
        ge=0, le=MOST, description="How much of it attention may give, in its unit; thousandths are the finest step."
    )
