"""What the robot sees and hears, as :mod:`app.console.perceived` makes its JSON."""

from __future__ import annotations

from pydantic import BaseModel, Field

from app.messages.base import Stamp


class FaceModel(BaseModel):
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
    score: float
    box: tuple[float, float, float, float] = Field(description="Left, top, width, height in the image (px).")
    image: tuple[int, int] = Field(description="Width and height of the image (px).")


class SoundModel(BaseModel):
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
    power: float = Field(description="How strongly the microphones agree, 0 to 1.")
    level_db: float
    active: bool
    last_active: Stamp
    speech: float | None = Field(description="Probability that it is a voice; null: not judged.")


class NoiseModel(BaseModel):
    """A loud noise."""

    stamp: Stamp
    ratio: float
    level_db: float


class CodeModel(BaseModel):
    """A QR code read in one camera's image."""

    text: str
    camera: str = Field(description="Frame of the image.")
    stamp: Stamp
    corners: list[tuple[float, float]] = Field(description="Its four corners in the image (px).")
    image: tuple[int, int] = Field(description="Width and height of the image (px).")


class PerceptsModel(BaseModel):
    """What is perceived now; noises are those of the last 2 s."""

    stamp: Stamp
    faces: list[FaceModel]
    sounds: list[SoundModel]
    noises: list[NoiseModel]
    codes: list[CodeModel]
