"""The page's types of what crosses between it and the robot, made of the Python records that declare them.

    make types     write web/src/protocol/generated.ts

A test compares the file with the records.
"""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from app.console import schema
from app.console.live.messages import FROM_ROBOT, FaceReport, VisitorLink, VisitorView
from app.console.live.protocol import FromPage, TimedMessage
from app.console.records.attention import ResourceList, StrategyList
from app.console.records.camera import CameraPoint
from app.console.records.fleet import FleetReport
from app.console.records.lanes import LanesPast
from app.console.records.maps import MapList
from app.console.records.places import PlaceReport
from app.console.records.program import SceneAddress, ScenePoint
from app.console.records.recordings import RecordingList, ReplayReport, Saved
from app.console.records.route import RouteReport
from app.console.records.tours import RehearsalReport, RunReportList, TourList, TourMediaList, TourReport, TourRunReport
from app.console.rest.camera import CameraClick
from app.console.rest.link_models import LinkChange
from app.console.rest.map_models import GoalRequest, LoadRequest, RenameRequest, ZonesRequest
from app.console.rest.models import DesireChange, NewDesire, WhatIf
from app.console.rest.place_models import NewPlace, PlaceChange
from app.console.rest.playback_models import PlaybackChange
from app.console.rest.recording_models import NewRecording, SaveRequest
from app.console.rest.rehearsal import NewRehearsal
from app.console.rest.route_models import RouteRequest
from app.console.rest.session import LoginRequest
from app.console.rest.tour_run_models import NewTourRun, TourPress
from app.console.rest.viewers import SceneClick
from app.console.rest.visitor_models import VisitorKey, VisitorPress
from app.tours.model import Tour

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "web" / "src" / "protocol" / "generated.ts"
#: Answers of REST, and of the streams of face and visitors, that a page reads: no messages of the live stream.
ANSWERS = (
    CameraPoint,
    FaceReport,
    LanesPast,
    MapList,
    PlaceReport,
    RecordingList,
    ReplayReport,
    ResourceList,
    RehearsalReport,
    RouteReport,
    FleetReport,
    RunReportList,
    Saved,
    SceneAddress,
    ScenePoint,
    StrategyList,
    Tour,
    TourList,
    TourMediaList,
    TourReport,
    TourRunReport,
    VisitorLink,
    VisitorView,
)
#: Bodies of requests to REST that the page makes.
REQUESTS = (
    CameraClick,
    SceneClick,
    DesireChange,
    GoalRequest,
    LoadRequest,
    LoginRequest,
    NewDesire,
    NewPlace,
    NewRecording,
    NewRehearsal,
    NewTourRun,
    PlaceChange,
    PlaybackChange,
    LinkChange,
    RenameRequest,
    RouteRequest,
    SaveRequest,
    TourPress,
    VisitorKey,
    VisitorPress,
    WhatIf,
    ZonesRequest,
)
WIDTH = 120
HEADER = """/**
 * What crosses the live stream and REST. Written by `make types` from the Python records; change those, not this file.
 * Stamps are the robot's clock, in seconds.
 */
"""


def generate() -> str:
    """The text of ``generated.ts``."""
    records = schema.sent([*(message.record for message in FROM_ROBOT.values()), *ANSWERS], "{name}")
    commands = schema.received([*get_args(FromPage), TimedMessage, *REQUESTS], "{name}")
    parts = [HEADER, 'import type { JsonSchema } from "./jsonSchema";\n']
    parts += [interface(name, records[name]) for name in sorted(records)]
    parts += [interface(name, commands[name]) for name in sorted(commands)]
    parts.append(_by_type("RobotMessages", "The robot's messages", _from_robot()))
    parts.append(
        "export type FromRobot = { [T in keyof RobotMessages]: { type: T } & RobotMessages[T] }[keyof RobotMessages];\n"
    )
    of_page = [struct.__name__ for struct in get_args(FromPage)]
    parts.append("\n  | ".join(["export type ToRobot =", *of_page]) + ";\n")
    return "\n".join(parts)


def _from_robot() -> Iterator[tuple[str, str, str]]:
    for kind, message in FROM_ROBOT.items():
        yield kind, message.record.__name__, message.about


def _by_type(name: str, about: str, members: Iterator[tuple[str, str, str]]) -> str:
    lines = [f"/** {about} by `type`. */", f"export interface {name} {{"]
    for kind, record, when in members:
        lines += [*comment(when, "  "), f"  {kind}: {record};"]
    return "\n".join([*lines, "}"]) + "\n"


def interface(name: str, declared: schema.Schema) -> str:
    """The declaration of the record ``name`` with its comments."""
    lines = [*comment(declared.get("description", "")), f"export interface {name} {{"]
    for member, value in declared.get("properties", {}).items():
        optional = "" if member in declared.get("required", ()) else "?"
        lines += [*comment(value.get("description", ""), "  "), *_member(f"  {member}{optional}:", typescript(value))]
    return "\n".join([*lines, "}"]) + "\n"


def _member(name: str, kind: str) -> list[str]:
    if len(line := f"{name} {kind};") <= WIDTH or " | " not in kind:
        return [line]
    *choices, last = kind.split(" | ")
    return [name, *(f"    | {choice}" for choice in choices), f"    | {last};"]


def comment(text: str, indent: str = "") -> list[str]:
    """``text`` as a documentation comment; no lines for none."""
    text = " ".join(text.split())
    if not text:
        return []
    if len(line := f"{indent}/** {text} */") <= WIDTH:
        return [line]
    lines = textwrap.wrap(text, WIDTH - len(indent) - 3, break_long_words=False)
    return [f"{indent}/**", *(f"{indent} * {line}" for line in lines), f"{indent} */"]


def typescript(value: schema.Schema) -> str:
    """The type of a value. Raises TypeError where TypeScript has no word for ``value``."""
    if value.get("title") == "JsonSchema":
        return "JsonSchema"
    if "$ref" in value:
        return str(value["$ref"])
    if "const" in value:
        return json.dumps(value["const"])
    if "enum" in value:
        return " | ".join(json.dumps(each) for each in value["enum"])
    if choices := value.get("anyOf") or value.get("oneOf"):
        return " | ".join(typescript(each) for each in choices)
    match value.get("type"):
        case "string" | "boolean" | "null" as kind:
            return str(kind)
        case "integer" | "number":
            return "number"
        case "array":
            return _list(value)
        case "object":
            return _object(value)
        case [*kinds]:
            return " | ".join(typescript({"type": kind}) for kind in kinds)
        case None:
            return "unknown"
    raise TypeError(f"no TypeScript is known for {value}")


def _list(value: schema.Schema) -> str:
    places = value.get("prefixItems")
    if places is None and value.get("minItems") == value.get("maxItems") is not None:
        places = [value["items"]] * int(value["minItems"])
    if places is not None:
        return f"[{', '.join(typescript(place) for place in places)}]"
    item = typescript(value.get("items", {}))
    return f"({item})[]" if " | " in item else f"{item}[]"


def _object(value: schema.Schema) -> str:
    if value.get("properties"):
        raise TypeError(f"an object within a record is a record itself, not {value}")
    values = value.get("additionalProperties")
    if keyed := value.get("patternProperties"):
        (values,) = keyed.values()
    return f"Record<string, {typescript(values) if isinstance(values, dict) else 'unknown'}>"


def main() -> None:
    """Write the file, and say whether it changed."""
    text = generate()
    changed = not FILE.exists() or FILE.read_text("utf-8") != text
    FILE.write_text(text, "utf-8")
    sys.stdout.write(f"{FILE.relative_to(ROOT)} {'changed' if changed else 'is as it was'}\n")


if __name__ == "__main__":
    main()
