"""Points of the camera's picture as points on the map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from fastapi import APIRouter
from fastapi.responses import Response
from pydantic import ConfigDict, Field

from app.console import reports
from app.console.live.hub import Hub
from app.console.problems import Problem
from app.console.records.camera import CameraPoint
from app.console.rest.answers import Json, problems
from app.console.rest.models import Request
from app.console.rest.routing import router as api_router
from app.messages import Localization

if TYPE_CHECKING:
    from app.program.system import System


class CameraClick(Request):
    """A point of a picture of the camera."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"stamp": 1767225600.25, "u": 0.5, "v": 0.4}]})

    stamp: float = Field(description="Of the picture, at most 3 s old.")
    u: float = Field(ge=0, le=1, description="From its left edge, as a share of its width.")
    v: float = Field(ge=0, le=1, description="From its top edge, as a share of its height.")


def camera_router(system: System, hub: Hub) -> APIRouter:
    """The route ``/camera/point``."""
    router = api_router("maps")

    @router.post(
        "/camera/point",
        response_model=CameraPoint,
        summary="A point of the picture on the map",
        responses=problems(400, 409, 422),
    )
    async def find_camera_point(click: CameraClick) -> Response:
        """Where that is on the map, which the robot saw there when the picture was taken."""
        point = hub.look_here.point(click.stamp, click.u, click.v)
        if point is None:
            raise Problem(409, "picture-too-old", "That picture is not there any more: take a newer one.")
        localization: Localization | None = reports.latest(system.graph, "localization")
        if localization is None:
            raise Problem(409, "pose-unknown", "Where the robot is on the map is not known: start SLAM.")
        ((x, y),) = localization.X_MO.transform(np.array([[point.x, point.y]]))
        return Json(CameraPoint(round(float(x), 3), round(float(y), 3), round(point.z, 3), point.measured))

    return router
