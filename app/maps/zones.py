"""Zones in ``zones.yaml`` beside a map, and in requests."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from app.base.yaml_source import load_yaml
from app.messages import Zone, read_only

#: Nothing on a map is further from its origin (m).
FURTHEST_M = 1000.0
#: A smaller one (m^2) is a slip of the hand, or a line.
SMALLEST_M2 = 1e-3
#: Twice the area (m^2) of a triangle that may be of rounding alone.
ROUNDING_M2 = 1e-9

Metres = Annotated[float, Field(ge=-FURTHEST_M, le=FURTHEST_M, allow_inf_nan=False)]


def crossing(polygon: NDArray[np.float64]) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """The first two sides of ``polygon`` (N, 2; m) that cross within, each by the indices of its corners.

    None for a polygon without such sides; sides may touch. For N up to 1000 or so: all pairs are compared.
    """
    after = np.roll(polygon, -1, axis=0)
    along = after - polygon

    def beside(points: NDArray[np.float64]) -> NDArray[np.int8]:
        """On which side of each side (row) each of ``points`` (column) is: 1, -1, or 0 on it, to rounding."""
        offset = points[None, :, :] - polygon[:, None, :]
        area = along[:, None, 0] * offset[..., 1] - along[:, None, 1] * offset[..., 0]
        return (np.sign(area) * (np.abs(area) > ROUNDING_M2)).astype(np.int8)

    apart = beside(polygon) * beside(after) < 0
    first, second = np.nonzero(apart & apart.T)
    if not len(first):
        return None
    a, b, count = int(first[0]), int(second[0]), len(polygon)
    return (a, (a + 1) % count), (b, (b + 1) % count)


class ZoneEntry(BaseModel):
    """One zone; see :class:`app.messages.Zone`."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(min_length=1, max_length=100, description="what people call it; no two zones of a map share one")
    kind: Literal["keep_out", "slow"] = Field(
        "keep_out", description="the robot keeps out of it, or drives slowly in it"
    )
    polygon: tuple[tuple[Metres, Metres], ...] = Field(
        min_length=3, max_length=1000, description="corners x, y on the map, m"
    )
    speed: float = Field(1.0, gt=0, le=1, description="share of the greatest speed allowed in a slow zone")

    @field_validator("polygon")
    @classmethod
    def _has_an_area(cls, polygon: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        area = 0.5 * math.fsum(
            a[0] * b[1] - b[0] * a[1] for a, b in zip(polygon, (*polygon[1:], polygon[0]), strict=True)
        )
        # A polygon that crosses itself may have area 0 though it covers something: its extent decides.
        xs, ys = zip(*polygon, strict=True)
        if abs(area) < SMALLEST_M2 and (max(xs) - min(xs)) * (max(ys) - min(ys)) < SMALLEST_M2:
            raise ValueError("should cover some floor: its corners are on one line or on one point")
        return polygon

    @field_validator("polygon")
    @classmethod
    def _is_simple(cls, polygon: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        if (found := crossing(np.array(polygon))) is not None:
            (a, b), (c, d) = found
            raise ValueError(
                f"should not cross itself: the side from corner {a + 1} to {b + 1} crosses the one from corner {c + 1} "
                f"to {d + 1}; what is inside would not be clear"
            )
        return polygon

    def zone(self) -> Zone:
        """The message."""
        return Zone(self.name, self.kind, read_only(np.array(self.polygon, dtype=np.float64)), self.speed)

    @staticmethod
    def of(zone: Zone) -> ZoneEntry:
        """The entry of ``zone``. Raises pydantic's ValidationError for one that may not be."""
        corners = tuple((x, y) for x, y in zone.polygon.tolist())
        return ZoneEntry.model_validate({"name": zone.name, "kind": zone.kind, "polygon": corners, "speed": zone.speed})


class ZoneFile(BaseModel):
    """All zones of a map."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    zones: tuple[ZoneEntry, ...] = Field((), max_length=1000)

    @model_validator(mode="after")
    def _names_differ(self) -> ZoneFile:
        names = [zone.name for zone in self.zones]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"two zones are called {name!r}; each needs a name of its own")
        return self


def checked(zones: Iterable[Zone]) -> tuple[Zone, ...]:
    """``zones``, if they are valid. Raises ValueError, which names the mistake."""
    return tuple(entry.zone() for entry in ZoneFile(zones=tuple(ZoneEntry.of(zone) for zone in zones)).zones)


def read_zones(path: Path) -> tuple[Zone, ...]:
    """The zones in the file ``path``; none where there is no file. Raises ConfigError with file and line."""
    if not path.exists():
        return ()
    return tuple(entry.zone() for entry in load_yaml(path).validate(ZoneFile).zones)


def zones_text(zones: Iterable[Zone]) -> str:
    """The content of ``zones.yaml``: one zone a block, one corner beside the other."""
    lines = ["# Zones of this map: keep_out, or slow at a share of the greatest speed; corners x, y in m on the map."]
    entries = [ZoneEntry.of(zone) for zone in zones]
    lines.append("zones:" if entries else "zones: []")
    for entry in entries:
        lines.append(f"  - name: {json.dumps(entry.name)}")
        lines.append(f"    kind: {entry.kind}")
        lines.append(f"    polygon: {json.dumps(entry.polygon)}")
        lines.append(f"    speed: {json.dumps(entry.speed)}")
    return "\n".join(lines) + "\n"
