"""The models of ``config/worlds/*.yaml``: a building, its furniture and its posters.

World frame W: metres, x east, y north, z up, the origin at the floor's south-west corner.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, Field, field_validator, model_validator

from app.base.yaml_source import suggestion
from app.robots.config_model import Positive
from app.robots.simulated.scenery.furniture import KINDS

LETTER_WIDTH_M, LETTER_HEIGHT_M = 0.2159, 0.2794
"""US Letter in portrait."""
CODE_SIDE_M = 0.190
"""Side of a poster's code without its quiet zone."""
CODE_RISE_M = 0.030
"""Height of the code's centre above the page's centre; the title is below."""

Point = tuple[float, float]
Pattern = Literal[
    "plain", "plaster", "brick", "wood", "planks", "carpet", "tiles", "terrazzo", "concrete",
    "ceiling", "books", "leaves", "picture", "whiteboard", "window", "screen", "cardboard",
]  # fmt: skip
Color = tuple[
    Annotated[int, Field(ge=0, le=255)], Annotated[int, Field(ge=0, le=255)], Annotated[int, Field(ge=0, le=255)]
]


class FileModel(BaseModel, extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True):
    """Base of what is written in these files: frozen; unknown keys and numbers that are not finite are refused."""


class MaterialConfig(FileModel):
    """A surface: a generated pattern in one or two colours (RGB), one repeat covering ``tile_m`` metres.

    Without ``tile_m`` the pattern is stretched once over each face.
    """

    pattern: Pattern = "plain"
    color: Color = (200, 200, 200)
    second: Color | None = None
    tile_m: tuple[Positive, Positive] | None = None
    shine: Annotated[float, Field(ge=0, le=1)] = 0.1
    glow: Annotated[float, Field(ge=0, le=1)] = 0.0


class DoorConfig(FileModel):
    """An opening: its middle lies ``at`` metres along the wall. ``leaf_deg`` gives it a leaf, open by that angle.

    The leaf hangs at the end nearer the wall's start, or ``hinge: far``; a positive angle swings it to the left of the
    wall's direction.
    """

    at: Positive
    width: Positive = 1.0
    height: Positive = 2.1
    leaf_deg: Annotated[float, Field(ge=-170, le=170)] | None = None
    hinge: Literal["near", "far"] = "near"


class WallConfig(FileModel):
    """A straight wall between two points of its middle line."""

    start: Point = Field(alias="from")
    end: Point = Field(alias="to")
    material: str
    thickness: Positive = 0.12
    doors: tuple[DoorConfig, ...] = ()

    @property
    def length_m(self) -> float:
        return math.dist(self.start, self.end)

    @model_validator(mode="after")
    def _doors_fit(self) -> WallConfig:
        taken = 0.0
        for door in sorted(self.doors, key=lambda d: d.at):
            if door.at - door.width / 2 < taken or door.at + door.width / 2 > self.length_m:
                raise ValueError(
                    f"the door at {door.at} m overlaps another or leaves its wall of {self.length_m:.1f} m"
                )
            taken = door.at + door.width / 2
        return self


class AreaConfig(FileModel):
    """A rectangle of floor with a material of its own (a room's floor, a rug)."""

    start: Point = Field(alias="from")
    end: Point = Field(alias="to")
    material: str


class ObjectConfig(FileModel):
    """A piece of furniture on the floor (or ``z`` above it), turned by ``yaw_deg``; kinds are in ``furniture.py``.
    ``size``: its length, width and height (m), in place of the kind's usual size. ``mass_kg``: of one that is not fixed
    to the building, so that it can be pushed, held and carried.
    """

    kind: str
    at: Point
    yaw_deg: float = 0.0
    size: tuple[Positive, Positive, Positive] | None = None
    material: str | None = None
    z: float = 0.0
    mass_kg: Positive | None = None

    @field_validator("kind")
    @classmethod
    def _kind_exists(cls, kind: str) -> str:
        if kind not in KINDS:
            raise ValueError(f"there is no furniture of this kind; {suggestion(kind, KINDS)}")
        return kind


class CylindersConfig(FileModel):
    """Upright cylinders of one size, on the floor at the points ``at``: a field of obstacles in few lines."""

    at: Annotated[tuple[Point, ...], Field(min_length=1, max_length=5000)]
    radius: Positive = 0.075
    height: Positive = 1.0
    material: str


class PosterConfig(FileModel):
    """A US-Letter page with a QR code, flat on a wall.

    ``at`` is a point of the wall's face behind the page, ``height`` that of the *code's* centre above the floor;
    ``facing_deg`` the direction the page looks (0 east, 90 north).
    """

    text: Annotated[str, Field(min_length=1, max_length=32)]
    title: str
    at: Point
    height: Positive = 1.2
    facing_deg: float

    @property
    def p_WQ(self) -> tuple[float, float, float]:
        """The true centre of the code in the world (m)."""
        return (self.at[0], self.at[1], self.height)


class LightConfig(FileModel):
    """A light from far away, shining along ``direction``; ``strength`` 0 to 1."""

    direction: tuple[float, float, float]
    strength: Annotated[float, Field(ge=0, le=1)]


class RoomConfig(FileModel):
    """A room for acoustics: a rectangle of floor, ``height`` m high (default: the walls' height).

    ``rt60_s``: reverberation time, of the low and of the high band (about 700 Hz and 4 kHz), or one for the low band
    (the high is then 0.8 of it); default: by size and materials.
    """

    name: str
    start: Point = Field(alias="from")
    end: Point = Field(alias="to")
    height: Positive | None = None
    rt60_s: Positive | tuple[Positive, Positive] | None = None

    @model_validator(mode="after")
    def _has_an_area(self) -> RoomConfig:
        if abs(self.end[0] - self.start[0]) < 0.5 or abs(self.end[1] - self.start[1]) < 0.5:
            raise ValueError(f"the room {self.name!r} is narrower than half a metre")
        return self


class GapConfig(FileModel):
    """A line on the floor between two rooms without a wall."""

    start: Point = Field(alias="from")
    end: Point = Field(alias="to")


class WorldConfig(FileModel):
    """A building of one storey. ``rooms`` and ``gaps`` are for acoustics alone; doors are openings without an entry
    there."""

    name: str
    size: tuple[Positive, Positive]
    wall_height: Positive = 2.7
    floor: str
    ceiling: str | None = None
    materials: dict[str, MaterialConfig]
    walls: tuple[WallConfig, ...] = ()
    areas: tuple[AreaConfig, ...] = ()
    rooms: tuple[RoomConfig, ...] = ()
    gaps: tuple[GapConfig, ...] = ()
    objects: tuple[ObjectConfig, ...] = ()
    cylinders: tuple[CylindersConfig, ...] = ()
    posters: tuple[PosterConfig, ...] = ()
    ambient: Annotated[float, Field(ge=0, le=1)] = 0.45
    lights: tuple[LightConfig, ...] = ()
    seed: int = 1

    @model_validator(mode="after")
    def _materials_exist(self) -> WorldConfig:
        used = [self.floor, *(w.material for w in self.walls), *(a.material for a in self.areas)]
        used += [c.material for c in self.cylinders]
        used += [name for name in (self.ceiling, *(o.material for o in self.objects)) if name is not None]
        for name in used:
            if name not in self.materials:
                raise ValueError(f"there is no material {name!r}; there are {', '.join(sorted(self.materials))}")
        return self
