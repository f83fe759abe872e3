"""Messages as the page and REST are given them, where that differs from the message: a record by message type."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, cast

import numpy as np

from app.base.geometry import Pose2
from app.console import reports
from app.console.live import messages
from app.console.records.maps import LocalizationState, ZoneKind, ZoneList, ZoneReport
from app.console.records.places import PlaceList, PlaceReport
from app.console.wire import etag
from app.messages import Desires, Landmarks, Localization, Place, Places, Zone, Zones


def localization_report(message: Localization) -> messages.LocalizationReport:
    """Where the robot is on the map."""
    variances = np.clip(np.diagonal(message.covariance), 0.0, None)
    x, y, theta = (_rounded(float(sigma)) for sigma in np.sqrt(variances))
    robot = _pose(message.X_MB)
    return messages.LocalizationReport(
        stamp=message.stamp,
        state=cast(LocalizationState, message.state),
        map=message.map,
        x=robot.x,
        y=robot.y,
        theta=robot.theta,
        sigma=(x, y, theta),
        X_MO=_pose(message.X_MO),
        overlap=_rounded(message.overlap),
    )


def zone_reports(zones: Iterable[Zone]) -> ZoneList:
    """Every zone."""
    return ZoneList(
        tuple(
            ZoneReport(
                name=zone.name,
                kind=cast(ZoneKind, zone.kind),
                polygon=tuple((round(float(x), 4), round(float(y), 4)) for x, y in zone.polygon),
                speed=zone.speed,
            )
            for zone in zones
        )
    )


def place_version(place: Place) -> object:
    """What people edit of a place: its version, of which its entity tag is made."""
    pose = None if place.source == "poster" else (place.x, place.y, place.heading)
    return place.id, place.name, place.source, place.poster, pose


def place_report(place: Place) -> PlaceReport:
    """One place."""
    return PlaceReport(
        place.id,
        place.name,
        x=place.x,
        y=place.y,
        heading=place.heading,
        source=place.source,
        poster=place.poster,
        landmark=place.landmark,
        problem=place.problem,
        etag=etag(place_version(place)),
    )


#: By message type, the record of a message.
FORMS: Mapping[type[Any], Callable[[Any], Any]] = {
    Landmarks: lambda message: messages.LandmarkList(reports.landmarks(message)),
    Localization: localization_report,
    Zones: lambda message: zone_reports(message.zones),
    Places: lambda message: PlaceList(tuple(map(place_report, message.places))),
}
#: The same of types that list what there is, before the first message: there is nothing.
NOTHING: Mapping[type[Any], Any] = {
    Desires: Desires(0.0, ()),
    Landmarks: messages.LandmarkList(()),
    Zones: ZoneList(()),
    Places: PlaceList(()),
}


def form(message: Any) -> Any:
    """The record of ``message``: the message itself, or what its type has instead."""
    make = FORMS.get(type(message))
    return message if make is None else make(message)


def _pose(pose: Pose2) -> messages.PoseReport:
    return messages.PoseReport(_rounded(pose.x), _rounded(pose.y), _rounded(pose.theta, 5))


def _rounded(value: float, digits: int = 4) -> float:
    """NaN, which JSON has as null, for what is not known."""
    return round(value, digits) if math.isfinite(value) else math.nan
