"""Maps as ROS's ``map_server`` keeps them: a YAML file and a picture (wiki.ros.org/map_server, "Map format").

The picture's top row has the greatest y. Written are 8-bit PGM in ``trinary`` mode, as ``map_saver`` does; read are all
three modes, PGM and PNG, of up to :data:`MOST_CELLS`: reading one takes some 4 bytes of memory a pixel, 10 in color.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from app.base.errors import ConfigError
from app.base.image_source import TooLarge, decoded, kind_of
from app.base.plain_file import read_plain
from app.base.yaml_source import load_yaml
from app.messages import OccupancyGrid, read_only

#: Grey of cells in a trinary picture.
_OCCUPIED, _UNKNOWN, _FREE = 0, 205, 254
#: Cells from and up to which ``map_saver`` writes occupied and free.
OCCUPIED_FROM, FREE_UP_TO = 65, 25
#: A map of more cells is none: at 5 cm, these are 400 m by 400 m.
MOST_CELLS = 64_000_000
#: Limit of the picture file's size: as many grey values, each written as text.
_MOST_BYTES = 4 * MOST_CELLS + 100_000
#: Rows of a colored picture that are made grey in one go.
_ROWS = 64

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
    cells = _cells(*_pixels(picture), file)
    return OccupancyGrid(
        path.stat().st_mtime,
        "map",
        cells=read_only(cells),
        resolution_m=file.resolution,
        origin=(file.origin[0], file.origin[1]),
        version=0,
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


def _pixels(path: Path) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
    """The picture at ``path``: grey (H, W), and where it has one its alpha (H, W)."""
    try:
        data = read_plain(path, _MOST_BYTES)
    except OSError as failure:
        raise ConfigError(f"the map's picture cannot be read: {failure.strerror or failure}", str(path)) from None
    try:
        pixels = decoded(data, cv2.IMREAD_UNCHANGED, MOST_CELLS) if kind_of(data) in ("PNG", "PNM") else None
    except TooLarge as failure:
        raise ConfigError(f"the map's picture {failure}", str(path)) from None
    if pixels is None:
        raise ConfigError(
            "the map's picture is damaged or cut off, or of a kind that is none of PGM and PNG", str(path)
        )
    del data
    if pixels.ndim == 2 and pixels.dtype == np.uint8:
        return pixels, None
    shape = pixels.shape[:2]
    grey = np.empty(shape, np.uint8)
    alpha = np.empty(shape, np.uint8) if pixels.ndim == 3 and pixels.shape[2] == 4 else None
    for top in range(0, shape[0], _ROWS):  # all at once, the means would take eight times the memory
        rows = pixels[top : top + _ROWS]
        if rows.dtype == np.uint16:
            rows = rows // 256
        grey[top : top + _ROWS] = rows if rows.ndim == 2 else rows[..., :3].mean(axis=2).round()
        if alpha is not None:
            alpha[top : top + _ROWS] = rows[..., 3]
    return grey, alpha


def _cells(grey: NDArray[np.uint8], alpha: NDArray[np.uint8] | None, file: MapServerFile) -> NDArray[np.int8]:
    """The cells of a picture (both (H, W)), the lowest row first."""
    cells = np.asarray(cv2.LUT(grey, _meaning(file)), np.int8)
    if alpha is not None and file.mode == "scale":
        cells[alpha < 255] = -1
    return np.asarray(cv2.flip(cells, 0, dst=cells), np.int8)


def _meaning(file: MapServerFile) -> NDArray[np.int8]:
    """The cell value of each of the 256 shades of grey."""
    grey = np.arange(256)
    if file.mode == "raw":
        return np.where(grey <= 100, grey, -1).astype(np.int8)
    dark = (grey if file.negate else 255 - grey) / 255.0
    cells = np.full(256, -1, np.int8)
    cells[dark > file.occupied_thresh] = 100
    cells[dark < file.free_thresh] = 0
    if file.mode == "scale":
        between = (dark >= file.free_thresh) & (dark <= file.occupied_thresh)
        span = max(file.occupied_thresh - file.free_thresh, 1e-9)
        cells[between] = np.round(99 * (dark[between] - file.free_thresh) / span).astype(np.int8)
    return cells
