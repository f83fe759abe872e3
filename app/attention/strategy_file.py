"""Files of strategies and resources, ``config/strategies/*.yaml``: read, checked and put into one table."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    TypeAdapter,
    ValidationError,
    WithJsonSchema,
)

from app.attention.calibration import RESOURCE, CostCalibration
from app.attention.desires import GRAIN, SCALE
from app.attention.families import StrategyFamily
from app.attention.strategies import CLOSED, MOST, Location, Resource, Strategy, StrategyTable
from app.base.yaml_source import Document, KeyPath, dotted, load_yaml, suggestion, validation_message


def _grained(value: float) -> float:
    if not math.isclose(value * GRAIN, round(value * GRAIN), rel_tol=0, abs_tol=1e-6):
        raise ValueError(f"should have at most {len(str(GRAIN)) - 1} decimals")
    return value


def _divisor(value: Any) -> float:
    if value is None or value == "off" or value == math.inf:
        return CLOSED
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError("should be an integer of at least 1, or off")
    return float(value)


_DIVISOR_SCHEMA = {
    "anyOf": [{"type": "integer", "minimum": 1}, {"const": "off"}, {"type": "null"}],
    "description": "One of so many messages passes; off or null: closed.",
}
Amount = Annotated[float, Field(ge=0, le=MOST, allow_inf_nan=False)]
Utility = Annotated[float, Field(gt=0, le=SCALE, allow_inf_nan=False)]
Divisor = Annotated[float, BeforeValidator(_divisor), WithJsonSchema(_DIVISOR_SCHEMA)]


class ResourceEntry(BaseModel):
    """A resource as the file writes it."""

    model_config = ConfigDict(extra="forbid", strict=True)

    capacity: Amount = Field(description="How much of it there is, in its unit.")
    unit: str = Field("", description="The unit of capacity and costs, for people.")
    description: str = Field("", description="What it is, for people.")


class CalibratedCost(BaseModel):
    """A cost taken from this computer's calibration, and the one used without a calibration."""

    model_config = ConfigDict(extra="forbid", strict=True)

    calibrated_or: Amount = Field(description="Used where this computer was not calibrated for these filters.")


_AMOUNT: TypeAdapter[float] = TypeAdapter(Amount)


def _cost(value: Any) -> float | CalibratedCost:
    # A plain union would complain twice, of the amount it could be and of the mapping.
    if isinstance(value, dict):
        return CalibratedCost.model_validate(value)
    return _AMOUNT.validate_python(value, strict=True)


Cost = Annotated[float | CalibratedCost, PlainValidator(_cost, json_schema_input_type=Amount | CalibratedCost)]


class StrategyEntry(BaseModel):
    """A strategy as the file writes it."""

    model_config = ConfigDict(extra="forbid", strict=True, populate_by_name=True)

    name: str = Field(min_length=1, description="Its name, unique in the table.")
    cls: str = Field(alias="class", min_length=1, description="The desire class it serves.")
    utility: Utility = Field(description="Produced utility v, over 0 and at most 8.")
    filters: dict[str, Divisor] = Field(
        default={}, description="Filters it sets, Module.port to divisor: an integer of at least 1, or off."
    )
    requires: dict[str, Utility] = Field(
        default={}, description="Classes it depends on, each with the utility l it needs of it."
    )
    parameters: dict[str, dict[str, Any]] = Field(
        default={}, description="Parameters of modules while it is selected, by module."
    )
    costs: dict[str, Cost] = Field(
        default={}, description="What it uses of each resource: an amount, or {calibrated_or: amount}."
    )


class StrategyFile(BaseModel):
    """A file of strategies, and of resources if it declares some."""

    model_config = ConfigDict(extra="forbid", strict=True)

    resources: dict[str, ResourceEntry] = Field(default={}, description="Resources by name.")
    strategies: list[StrategyEntry] = Field(default=[], description="Strategies; their order breaks the last ties.")
    families: list[StrategyFamily] = Field(
        default=[], description="Strategies that differ in φ alone, generated; they come after the others."
    )


def load_strategies(
    paths: Iterable[Path | str],
    *,
    classes: Iterable[str] | None,
    ports: Mapping[str, Collection[str]] | None = None,
    undivided: Collection[str] = (),
    calibration: CostCalibration | None = None,
) -> StrategyTable:
    """Read strategy files, in the order given, into one table.

    ``classes`` are the desire classes; ``ports`` maps each module to its ports (None: not checked); ``undivided`` are
    filters that may open or close but not decimate (sound, whose every frame counts); ``calibration`` gives calibrated
    costs (None: the costs without one). A resource may be declared in several files if they agree. Raises ConfigError,
    with file and line, for an unknown class, module, port or resource, a name given twice, or a number out of its
    range.
    """
    documents = [load_yaml(path) for path in paths]
    files = [document.validate(StrategyFile) for document in documents]
    return build_table(
        list(zip(documents, files, strict=True)),
        classes=classes,
        ports=ports,
        undivided=undivided,
        calibration=calibration,
    )


def build_table(
    files: Iterable[tuple[Document, StrategyFile]],
    *,
    classes: Iterable[str] | None,
    ports: Mapping[str, Collection[str]] | None = None,
    undivided: Collection[str] = (),
    calibration: CostCalibration | None = None,
) -> StrategyTable:
    """The table of several read files; checks as :func:`load_strategies` does."""
    files = tuple(files)
    known = None if classes is None else sorted(set(classes))
    resources: dict[str, Resource] = {}
    for document, file in files:
        for name, entry in file.resources.items():
            _check_amount(document, ("resources", name, "capacity"), entry.capacity)
            resource = Resource(name, entry.capacity, entry.unit, entry.description)
            if resources.setdefault(name, resource).capacity != resource.capacity:
                other = resources[name].capacity
                raise document.error(
                    f"resource {name!r} has capacity {resource.capacity:g} here and {other:g} elsewhere",
                    ("resources", name, "capacity"),
                )
    table: dict[str, Strategy] = {}
    for document, file in files:
        for at, item in _entries(document, file):
            if item.name in table:
                raise document.error(
                    f"strategy {item.name!r} is already declared at {table[item.name].location}", (*at, "name")
                )
            _check_names(document, at, item=item, classes=known, resources=resources, ports=ports, undivided=undivided)
            costs = _costs(document, at, item, calibration)
            for key, value in (("utility", item.utility), *((f"requires.{c}", v) for c, v in item.requires.items())):
                _check_amount(document, (*at, *key.split(".", 1)), value)
            table[item.name] = Strategy(
                item.name,
                item.cls,
                utility=item.utility,
                requires=dict(item.requires),
                filters=dict(item.filters),
                parameters={module: dict(values) for module, values in item.parameters.items()},
                costs={name: cost for name, cost in costs.items() if cost},
                location=Location(document.file, document.line(at)),
            )
    return StrategyTable(tuple(table.values()), resources)


def _entries(document: Document, file: StrategyFile) -> Iterator[tuple[KeyPath, StrategyEntry]]:
    """All strategies of a file and their lines in it."""
    for index, item in enumerate(file.strategies):
        yield ("strategies", index), item
    for index, family in enumerate(file.families):
        for member in family.members():
            try:
                yield ("families", index), StrategyEntry.model_validate(member)
            except ValidationError as mistake:
                first = mistake.errors(include_url=False)[0]
                what = f"{dotted(first['loc'])}: {validation_message(StrategyEntry, first)}"
                raise document.error(f"strategy {member['name']!r}: {what}", ("families", index)) from None


def _costs(
    document: Document, at: KeyPath, item: StrategyEntry, calibration: CostCalibration | None
) -> dict[str, float]:
    """Each resource's cost, calibrated ones rounded up to what the solver counts in."""
    costs: dict[str, float] = {}
    for name, cost in item.costs.items():
        where = (*at, "costs", name)
        if not isinstance(cost, CalibratedCost):
            _check_amount(document, where, cost)
            costs[name] = cost
            continue
        _check_amount(document, (*where, "calibrated_or"), cost.calibrated_or)
        if name != RESOURCE:
            raise document.error(f"calibration measures {RESOURCE}, not {name!r}: give an amount", where)
        measured = calibration.cost(item.filters, item.parameters) if calibration is not None else None
        costs[name] = cost.calibrated_or if measured is None else math.ceil(measured * GRAIN - 1e-6) / GRAIN
    return costs


def _check_amount(document: Document, at: KeyPath, value: float) -> None:
    try:
        _grained(value)
    except ValueError as failure:
        raise document.error(f"{at[-1]}: {failure}, not {value!r}", at) from None


def _check_names(
    document: Document,
    at: KeyPath,
    item: StrategyEntry,
    classes: list[str] | None,
    resources: Mapping[str, Resource],
    ports: Mapping[str, Collection[str]] | None,
    undivided: Collection[str],
) -> None:
    """Refuse a class, resource, module or port that does not exist, and a strategy that requires its own class."""
    name = item.name
    if classes is not None and item.cls not in classes:
        raise document.error(
            f"strategy {name!r} serves unknown class {item.cls!r}; {suggestion(item.cls, classes)}", (*at, "class")
        )
    for required in item.requires:
        where = (*at, "requires", required)
        if classes is not None and required not in classes:
            raise document.error(
                f"strategy {name!r} requires unknown class {required!r}; {suggestion(required, classes)}", where
            )
        if required == item.cls:
            raise document.error(f"strategy {name!r} requires its own class {required!r}", where)
    for resource in item.costs:
        if resource not in resources:
            raise document.error(
                f"strategy {name!r} costs unknown resource {resource!r}; {suggestion(resource, list(resources))}",
                (*at, "costs", resource),
            )
    for filter_name in item.filters:
        module, dot, port = filter_name.partition(".")
        where = (*at, "filters", filter_name)
        if not (module and dot and port):
            raise document.error(f"strategy {name!r}: a filter is named Module.port, not {filter_name!r}", where)
        if filter_name in undivided and item.filters[filter_name] not in (1, CLOSED):
            raise document.error(
                f"strategy {name!r} decimates {filter_name}, whose channel may not be decimated: 1 or off", where
            )
        if ports is None:
            continue
        if module not in ports:
            raise document.error(
                f"strategy {name!r} filters unknown module {module!r}; {suggestion(module, list(ports))}", where
            )
        if port not in ports[module]:
            raise document.error(
                f"strategy {name!r} filters unknown port {port!r} of {module}; {suggestion(port, list(ports[module]))}",
                where,
            )
    if ports is not None:
        for module in item.parameters:
            if module not in ports:
                hint = suggestion(module, list(ports))
                raise document.error(
                    f"strategy {name!r} sets parameters of unknown module {module!r}; {hint}",
                    (*at, "parameters", module),
                )
