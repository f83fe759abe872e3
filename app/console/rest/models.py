"""The shapes of REST's answers and requests, for the OpenAPI description and for checking what comes in."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from app.attention.strategies import MOST
from app.attention.timeline import EventKind

Stamp = Annotated[float, Field(description="Seconds of the robot's clock (Unix epoch).", examples=[1795000000.25])]
Divisor = Annotated[
    int | None, Field(description="φ: one message in φ passes; null: closed, none passes.", examples=[2])
]
#: 30 days: longer is for ever, which is said by leaving it out.
LONGEST_TTL_S = 30 * 24 * 3600.0


class Answer(BaseModel):
    """Base of every answer."""

    model_config = ConfigDict(populate_by_name=True)


class Request(BaseModel):
    """Base of every request body: unknown members are refused, numbers are not read from strings."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, populate_by_name=True)


class SourceModel(Answer):
    """Who asked."""

    kind: Literal["motivation", "operator", "rest"]
    name: str


class DesireModel(Answer):
    """One desire of the Intention Workspace."""

    id: str = Field(examples=["d-3f0c81a2b4"])
    cls: str = Field(alias="class", examples=["FindQRCodes"])
    intensity: float = Field(description="How much it is desired, over 0 and at most 8.", examples=[8])
    utility: float = Field(description="Utility desired, 0 to 8; 0 inhibits the class.", examples=[4])
    security: bool = Field(description="Whether it must be fulfilled.")
    params: dict[str, Any] = Field(description="Parameters as the class declares them.")
    source: SourceModel
    created: Stamp
    expires: float | None = Field(description="When it expires (robot's clock); null: never.")


class DesireList(Answer):
    """Every desire, in the order they came."""

    desires: list[DesireModel]


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
    """What to change of a desire; what is left out stays."""

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


class DesireClassModel(Answer):
    """What can be desired."""

    name: str = Field(examples=["FindQRCodes"])
    title: str
    description: str
    parameters: dict[str, Any] = Field(alias="schema", title="JsonSchema", description="JSON Schema of `params`.")
    served: bool = Field(description="Whether a strategy of this program's modules serves it; else it stays a desire.")


class ScaleModel(Answer):
    """The ends of the scales of desires."""

    intensity: float
    utility: float


class DesireClassList(Answer):
    """Every desire class, in the order the console shows them, and the ends of the scales."""

    classes: list[DesireClassModel]
    scale: ScaleModel


class StrategyModel(Answer):
    """One way to serve a desire class."""

    name: str
    cls: str = Field(alias="class")
    utility: float = Field(description="Produced utility v, over 0 and at most 8.")
    requires: dict[str, float] = Field(description="Utility needed of other classes.")
    filters: dict[str, Divisor] = Field(description="φ by `Module.port`.")
    parameters: dict[str, dict[str, Any]] = Field(description="What modules are handed while it is selected.")
    costs: dict[str, float] = Field(description="What it uses of each resource.")
    selected: bool
    declared: str | None = Field(description="File and line.")


class StrategyList(Answer):
    """Every strategy, in table order."""

    strategies: list[StrategyModel]


class ResourceModel(Answer):
    """What strategies share."""

    name: str = Field(examples=["cpu"])
    capacity: float = Field(description="How much of it attention may give now.", examples=[120])
    declared: float = Field(description="Its capacity in configuration.")
    used: float = Field(description="What the intention at work uses of it.")
    unit: str
    description: str


class ResourceList(Answer):
    """Every resource."""

    resources: list[ResourceModel]


class ResourceChange(Request):
    """A new budget; attention chooses anew at once."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"capacity": 60}]})

    capacity: float = Field(
        ge=0, le=MOST, description="How much of it attention may give, in its unit; thousandths are the finest step."
    )


class SelectedStrategy(Answer):
    """A strategy at work."""

    name: str
    cls: str = Field(alias="class")
    utility: float
    filters: dict[str, Divisor]
    costs: dict[str, float]


class ResourceUse(Answer):
    """What is used of a resource."""

    used: float
    capacity: float
    unit: str = ""


class MoreCapacity(Answer):
    """What would help a desire: ``amount`` more of a resource."""

    kind: Literal["capacity"]
    utility: float = Field(description="The utility it would get.")
    resource: str
    amount: float
    unit: str


class WithoutClass(Answer):
    """What would help a desire: that nobody desired another class."""

    kind: Literal["without"]
    utility: float = Field(description="The utility it would get.")
    without: str = Field(description="The other class.")


class ReasonModel(Answer):
    """Why a desired class gets what it gets."""

    state: Literal["fulfilled", "degraded", "unfulfilled", "inhibited"]
    utility: float = Field(description="The utility it gets.")
    wanted: float = Field(description="The utility desired.")
    best: float = Field(description="The most that any selection could give it.")
    text: str = Field(description="The reason in words.")
    alternatives: list[MoreCapacity | WithoutClass]


class IntentionModel(Answer):
    """The intention at work: what was selected, what follows from it, and why."""

    stamp: Stamp
    strategies: list[SelectedStrategy]
    fulfilled: list[str] = Field(description="Classes whose strongest desire is fulfilled.")
    omega: float = Field(description="Ω, what the selection is worth (thesis, equation 4.9).")
    bound: float = Field(description="No selection can be worth more; equal to `omega` when proven.")
    use: dict[str, ResourceUse]
    filters: dict[str, Divisor] = Field(description="φ of every filter that attention controls.")
    proven: bool = Field(description="Whether no better selection exists.")
    solve_ms: float
    relaxed: list[str] = Field(description="Security desires that could not be kept.")
    reasons: dict[str, ReasonModel] = Field(description="By desired class.")
    parameters: dict[str, dict[str, Any]] = Field(description="What each module was handed.")
    desires: dict[str, str] = Field(description="Id of the strongest desire of each class that it answers.")


class EventModel(Answer):
    """One event of the timeline."""

    id: int = Field(description="Grows by one.")
    stamp: Stamp
    kind: EventKind
    subject: str = Field(description="A desire class, a module, a filter.")
    text: str = Field(description="One sentence.")
    data: dict[str, Any]


class EventList(Answer):
    """Events, oldest first."""

    events: list[EventModel]
