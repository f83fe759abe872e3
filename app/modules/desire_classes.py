"""The desire classes of this robot: what can be asked of it, with which parameters (thesis 4.2.5)."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from app.attention.desires import DesireClass
from app.base.library import LONGEST_NAME
from app.logs.library import NAME_PATTERN, name_or_nothing
from app.maps.zones import FURTHEST_M


class FindQRCodesParameters(BaseModel):
    """Parameters of a desire of class FindQRCodes."""

    model_config = ConfigDict(extra="forbid", title="Find QR codes")

    upscale: bool = Field(
        True,
        title="Second try enlarged",
        description="Look again in the Kinect's image enlarged two times when nothing was found: reads codes from "
        "further away, for about twice the computing time.",
    )


class LocateFacesParameters(BaseModel):
    """Parameters of a desire of class LocateFaces."""

    model_config = ConfigDict(extra="forbid", title="Locate faces")

    min_score: float = Field(
        0.8,
        gt=0,
        lt=1,
        title="Least score",
        description="How sure the detector must be that it is a face, 0 to 1: higher loses small and turned faces, "
        "lower takes other things for faces.",
    )


class LocateVoicesParameters(BaseModel):
    """Parameters of a desire of class LocateVoices."""

    model_config = ConfigDict(extra="forbid", title="Locate voices")

    voices: int = Field(
        2,
        ge=1,
        le=4,
        title="Voices apart",
        description="Greatest number of separated sources, where the strategy in force separates.",
    )


class DetectNoisesParameters(BaseModel):
    """Parameters of a desire of class DetectNoises."""

    model_config = ConfigDict(extra="forbid", title="Detect loud noises")

    ratio: float = Field(
        20.0,
        ge=2,
        le=1000,
        title="How loud",
        description="A noise is loud if its energy is this many times that of the background.",
    )
    hold_off_s: float = Field(
        0.25,
        ge=0,
        le=10,
        title="Hold-off",
        description="Least quiet time between two noises that count as two, in seconds.",
    )


class TeleoperationParameters(BaseModel):
    """Parameters of a desire of class Teleoperation."""

    model_config = ConfigDict(extra="forbid", title="Drive by hand")

    speed: float = Field(
        1.0,
        gt=0,
        le=1,
        title="Speed",
        description="Share of the robot's greatest speeds that full stick gives, 0 to 1.",
    )


class TelepresenceParameters(BaseModel):
    """Parameters of a desire of class Telepresence."""

    model_config = ConfigDict(extra="forbid", title="See through the robot's eyes")

    max_points: int = Field(
        19_200, ge=1_000, le=76_800, title="Points", description="Most points of one coloured point cloud."
    )
    jpeg_quality: int = Field(
        80, ge=30, le=95, title="Picture quality", description="JPEG quality of the camera picture, 30 to 95."
    )


class RecordParameters(BaseModel):
    """Parameters of a desire of class Record."""

    model_config = ConfigDict(extra="forbid", title="Record")

    name: Annotated[str, AfterValidator(name_or_nothing)] = Field(
        "",
        json_schema_extra={"pattern": NAME_PATTERN, "maxLength": LONGEST_NAME},
        title="Name",
        description="What the recording is called; empty: the date and time at which it begins.",
    )
    keep_minutes: float = Field(
        0,
        ge=0,
        le=120,
        title="Keep the last minutes",
        description="0 records everything into one file; otherwise only the last so many minutes are kept on disk, "
        "until they are saved.",
    )


class GoToParameters(BaseModel):
    """Parameters of a desire of class GoTo."""

    model_config = ConfigDict(extra="forbid", title="Go to a place", allow_inf_nan=False)

    x: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="x", description="Where to, in metres on the map.")
    y: float = Field(ge=-FURTHEST_M, le=FURTHEST_M, title="y", description="Where to, in metres on the map.")
    heading: float | None = Field(
        None, ge=-7, le=7, title="Heading", description="How to stand there, in rad on the map; none: any way."
    )
    tolerance_m: float = Field(
        0.25, ge=0.05, le=5, title="Near enough", description="So many metres from there will do."
    )
    tolerance_rad: float = Field(
        0.2, ge=0.05, le=3.2, title="Turned enough", description="So many rad from the heading will do."
    )
    speed: float = Field(1.0, gt=0, le=1, title="Speed", description="Share of the robot's greatest speeds, 0 to 1.")


def desire_classes() -> tuple[DesireClass, ...]:
    """Every desire class that modules of this program serve, in the order the console shows them."""
    return (
        DesireClass(
            name="FindQRCodes",
            title="Find QR codes",
            description="Read the QR codes in both cameras' views and remember where they hang (m, in odom).",
            parameters=FindQRCodesParameters,
        ),
        DesireClass(
            name="LocateFaces",
            title="Locate faces",
            description="Find faces in both cameras' views, track them, and publish their positions (m, in base_link).",
            parameters=LocateFacesParameters,
        ),
        DesireClass(
            name="DetectNoises",
            title="Detect loud noises",
            description="Detect a clap, a call or the like: a sound much louder than the background.",
            parameters=DetectNoisesParameters,
        ),
        DesireClass(
            name="LocateVoices",
            title="Locate voices",
            description="Locate and track voices and other sounds (directions in base_link), and separate them.",
            parameters=LocateVoicesParameters,
        ),
        DesireClass(
            name="SLAM",
            title="Map and know where it is",
            description="Map the place with the laser, close loops, and localize the robot on the map (m).",
        ),
        DesireClass(
            name="GoTo",
            title="Go to a place",
            description="Drive to a place on the map, around obstacles.",
            parameters=GoToParameters,
        ),
        DesireClass(
            name="Teleoperation",
            title="Drive by hand",
            description="Drive the base by an operator's commands while the dead-man is held.",
            parameters=TeleoperationParameters,
        ),
        DesireClass(
            name="Telepresence",
            title="See through the robot's eyes",
            description="Send people the camera's picture and its coloured point cloud (m, in base_link).",
            parameters=TelepresenceParameters,
        ),
        DesireClass(
            name="Listen",
            title="Hear through the robot's ears",
            description="Send people what the robot's front microphone hears.",
        ),
        DesireClass(
            name="Record",
            title="Record",
            description="Write what the robot senses, decides and does into a log that can be replayed.",
            parameters=RecordParameters,
        ),
    )
