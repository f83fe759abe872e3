"""Maps as ROS's ``map_server`` keeps them: a YAML file and a picture (wiki.ros.org/map_server, "Map format").

The picture's top row has the greatest y. Written are 8-bit PGM in ``trinary`` mode, as ``map_saver`` does; read are all
three modes, PGM and PNG.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from app.errors import ConfigError
from app.messages import OccupancyGrid, read_only
from app.yaml_source import load_yaml

#: Grey of cells in a trinary picture.
_OCCUPIED, _UNKNOWN, _FREE = 0, 205, 254
#: Cells from and up to which ``map_saver`` writes occupied and free.
OCCUPIED_FROM, FREE_UP_TO = 65, 25
#: A map of more cells on a side is none.
LONGEST_SIDE = 30_000

Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Metres = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]


class MapServerFile(BaseModel):
    """The YAML file; keys of other programs are let be."""

    model_config = ConfigDict(extra="ignore")

    image: str = Field(min_length=1, description="the picture, in the same folder")
    resolution: float = Field(ge=1e-3, le=10, allow_inf_nan=False, description="m per pixel")
    origin: tuple[Metres, Metres, float] = Field(description="x, y (m) and yaw of the picture's lower left corner")
    negate: bool = Field(False, description="whether white is occupied")
    occupied_thresh: Share = Field(0.65, description="from this darkness on a pixel is occupied")
    free_thresh: Share = Field(0.196, description="below this darkness a pixel is free")
    mode: Literal["trinary", "scale", "raw"] = Field("trinary", description="what shades of grey mean")


def read_map(path: Path) -> OccupancyGrid:
    """The map of the YAML file ``path``, stamped with its file's time. Raises ConfigError with file and line."""
    document = load_yaml(path)
    if not isinstance(document.data, dict):
        raise document.error("is no map: it should name image, resolution and origin")
    file = document.validate(MapServerFile)
    if abs(file.origin[2]) > 1e-6:
        raise document.error("a map's picture must lie along the map's axes: yaw should be 0", ("origin", 2))
    if file.free_thresh > file.occupied_thresh:
        raise document.error("should not be above occupied_thresh", ("free_thresh",))
    if Path(file.image).name != file.image:
        raise document.error(f"the picture must lie beside this file, not at {file.image!r}", ("image",))
    picture = path.parent / file.image
    cells = _cells(_pixels(picture), file)
    return OccupancyGrid(
        path.stat().st_mtime, "map", read_only(cells), file.resolution, (file.origin[0], file.origin[1]), 0
    )


def yaml_text(grid: OccupancyGrid, image: str) -> str:
    """The YAML file of ``grid``, whose picture is called ``image``."""
    x, y = grid.origin
    return (
        f"image: {image}\nresolution: {grid.resolution_m!r}\norigin: [{x!r}, {y!r}, 0.0]\n"
        f"negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n"
    )


def pgm_bytes(grid: OccupancyGrid) -> bytes:
    """The picture of ``grid``: binary PGM, black from 65 on, white up to 25, grey between and where unknown."""
    cells = grid.cells[::-1]
    pixels = np.full(cells.shape, _UNKNOWN, np.uint8)
    pixels[(cells >= 0) & (cells <= FREE_UP_TO)] = _FREE
    pixels[cells >= OCCUPIED_FROM] = _OCCUPIED
    height, width = grid.cells.shape
    return f"P5\n# {grid.resolution_m:.3f} m/pix\n{width} {height}\n255\n".encode() + pixels.tobytes()


def _pixels(path: Path) -> NDArray[np.uint8]:
    """The picture at ``path``: (H, W) grey, or (H, W, 2) with alpha."""
    try:
        data = path.read_bytes()
    except OSError as failure:
        raise ConfigError(f"the map's picture cannot be read: {failure.strerror or failure}", str(path)) from None
    pixels = _decoded(data)
    if pixels is None:
        raise ConfigError(
            "the map's picture is damaged or cut off, or of a kind that is none of PGM and PNG", str(path)
        )
    if max(pixels.shape) > LONGEST_SIDE:
        raise ConfigError(f"the map's picture has more than {LONGEST_SIDE} pixels on a side", str(path))
    if pixels.dtype == np.uint16:
        pixels = pixels // 256
    if pixels.ndim == 3:
        grey = pixels[..., :3].mean(axis=2).round()
        pixels = np.dstack((grey, pixels[..., 3])) if pixels.shape[2] == 4 else grey
    return pixels.astype(np.uint8)


def _decoded(data: bytes) -> NDArray[Any] | None:
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    except cv2.error:
        return None


def _cells(pixels: NDArray[np.uint8], file: MapServerFile) -> NDArray[np.int8]:
    alpha = pixels[..., 1] if pixels.ndim == 3 else None
    grey = (pixels[..., 0] if pixels.ndim == 3 else pixels)[::-1]
    if file.mode == "raw":
        return np.where(grey <= 100, grey, 255).astype(np.uint8).view(np.int8)
    dark = grey / 255.0 if file.negate else (255 - grey.astype(np.float64)) / 255.0
    cells = np.full(grey.shape, -1, np.int8)
    cells[dark > file.occupied_thresh] = 100
    cells[dark < file.free_thresh] = 0
    if file.mode == "scale":
        between = (dark >= file.free_thresh) & (dark <= file.occupied_thresh)
        span = max(file.occupied_thresh - file.free_thresh, 1e-9)
        cells[between] = np.round(99 * (dark[between] - file.free_thresh) / span).astype(np.int8)
        if alpha is not None:
            cells[alpha[::-1] < 255] = -1
    return cells
