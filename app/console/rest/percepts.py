"""What the robot sees and hears, now."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import Response
from pydantic import Field

from app.console import reports
from app.console.rest.answers import Json
from app.console.rest.models import Answer, Stamp
from app.console.rest.routing import router as api_router
from app.messages import PlacedPercepts

if TYPE_CHECKING:
    from app.program.system import System


class FaceModel(Answer):
    """A face in one camera's image."""

    track: int = Field(description="Its number while it stays in view, in both cameras.")
    camera: str = Field(description="Frame of the image.")
    stamp: Stamp
    azimuth: float = Field(description="From the camera, in base_link's axes; left positive.")
    elevation: float
    panorama: tuple[float, float] | None = Field(description="Azimuth and elevation from the panorama's camera.")
    range_m: float | None
    range_sigma_m: float | None
    x: float | None = Field(description="In `odom`.")
    y: float | None
    z: float | None
    towards_O: float | None = Field(description="The heading in `odom` in which it has the robot.")
    score: float
    box: tuple[float, float, float, float] = Field(description="Left, top, width, height in the image (px).")
    image: tuple[int, int] = Field(description="Width and height of the image (px).")


class SoundModel(Answer):
    """A sound that is being tracked."""

    track: int
    stamp: Stamp
    azimuth: float = Field(description="From the microphones' middle, in base_link's axes; left positive.")
    elevation: float
    panorama: tuple[float, float] | None
    range_m: float | None = Field(description="Supposes a standing person's mouth.")
    range_sigma_m: float | None
    x: float | None
    y: float | None
    z: float | None
    p_OA: tuple[float, float, float] | None = Field(description="The microphones' middle, in `odom`.")
    v_O: tuple[float, float, float] | None = Field(description="Its direction in `odom`, a unit vector.")
    power: float = Field(description="How strongly the microphones agree, 0 to 1.")
    level_db: float
    active: bool
    last_active: Stamp
    speech: float | None = Field(description="Probability that it is a voice; null: nobody has judged.")


class NoiseModel(Answer):
    """A loud noise."""

    stamp: Stamp
    ratio: float
    level_db: float


class CodeModel(Answer):
    """A QR code read in one camera's image."""

    text: str
    camera: str = Field(description="Frame of the image.")
    stamp: Stamp
    corners: list[tuple[float, float]] = Field(description="Its four corners in the image (px).")
    image: tuple[int, int] = Field(description="Width and height of the image (px).")


class PerceptsModel(Answer):
    """What is perceived now; noises are those of the last 2 s."""

    stamp: Stamp
    faces: list[FaceModel]
    sounds: list[SoundModel]
    noises: list[NoiseModel]
    codes: list[CodeModel]


def percepts_router(system: System) -> APIRouter:
    """Routes of ``/percepts``."""
    router = api_router("robot")

    @router.get("/percepts", response_model=PerceptsModel, summary="Faces, sounds, loud noises, codes")
    async def get_percepts() -> Response:
        """The same as `perceived` on the live stream. What attention has closed is not perceived."""
        percepts = reports.latest(system.graph, "placed_percepts")
        return Json(percepts or PlacedPercepts(system.clock.now()))

    return router
