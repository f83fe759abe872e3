"""Messages as JSON for pages and REST, where that differs from the message itself. A form is found by message type."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import msgspec
import numpy as np

from app.attention.timeline_writer import divisor_json
from app.base.geometry import Pose2
from app.console import reports
from app.messages import EventRecord, Landmarks, Lanes, Localization, Zone, Zones


def localization_json(message: Localization) -> dict[str, Any]:
    """Where the robot is on the map."""
    variances = np.clip(np.diagonal(message.covariance), 0.0, None)
    return {
        "stamp": message.stamp,
        "state": message.state,
        "map": message.map,
        **_pose_json(message.X_MB),
        "sigma": [_rounded(float(sigma)) for sigma in np.sqrt(variances)],
        "X_MO": _pose_json(message.X_MO),
        "overlap": _rounded(message.overlap),
    }


def zones_json(zones: Iterable[Zone]) -> list[dict[str, Any]]:
    """Every zone."""
    return [
        {
            "name": zone.name,
            "kind": zone.kind,
            "polygon": [[round(float(x), 4), round(float(y), 4)] for x, y in zone.polygon],
            "speed": zone.speed,
        }
        for zone in zones
    ]


def lanes_json(message: Lanes) -> list[dict[str, Any]]:
    """Every row; φ of what is closed is null."""
    return [
        {
            "class": row.cls,
            "intensity": row.intensity,
            "utility": row.utility,
            "rate": row.rate,
            "divisor": divisor_json(row.divisor),
            "divisors": dict(zip(row.filters, map(divisor_json, row.divisors), strict=True)),
            "state": row.state,
            "text": row.text,
        }
        for row in message.rows
    ]


def event_json(message: EventRecord) -> dict[str, Any]:
    """An event as on REST's timeline."""
    return {
        "id": message.id,
        "stamp": message.stamp,
        "kind": message.kind,
        "subject": message.subject,
        "text": message.text,
        "data": msgspec.Raw(message.data.encode()),
    }


#: By message type, the JSON object of a message.
FORMS: Mapping[type[Any], Callable[[Any], dict[str, Any]]] = {
    EventRecord: event_json,
    Landmarks: lambda message: {"landmarks": reports.landmarks_json(message)},
    Lanes: lambda message: {"stamp": message.stamp, "rows": lanes_json(message)},
    Localization: localization_json,
    Zones: lambda message: {"zones": zones_json(message.zones)},
}
#: The same of types that list what there is, before the first message: there is nothing.
NOTHING: Mapping[type[Any], dict[str, Any]] = {Landmarks: {"landmarks": []}, Zones: {"zones": []}}


def form(message: Any) -> Any:
    """What JSON is made of for ``message``: itself, or what its type has instead."""
    make = FORMS.get(type(message))
    return message if make is None else make(message)


def _pose_json(pose: Pose2) -> dict[str, float | None]:
    return {"x": _rounded(pose.x), "y": _rounded(pose.y), "theta": _rounded(pose.theta, 5)}


def _rounded(value: float, digits: int = 4) -> float | None:
    """Null for what is not known."""
    return round(value, digits) if math.isfinite(value) else None
