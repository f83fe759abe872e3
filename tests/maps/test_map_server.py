"""Maps as ROS's map_server keeps them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given

from app.errors import ConfigError
from app.maps.map_server import pgm_bytes, read_map, yaml_text
from app.messages import OccupancyGrid

from .grids import room, trinary_grids

#: As map_saver of ROS 1 (navigation 1.17) writes: its comment, its order, its thresholds.
FOREIGN_YAML = """image: map.pgm
resolution: 0.100000
origin: [-1.500000, -0.500000, 0.000000]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196

"""
FOREIGN_PGM = b"P5\n# CREATOR: map_saver.cpp 0.100 m/pix\n3 2\n255\n" + bytes([0, 254, 205, 254, 254, 0])


def write(folder: Path, yaml: str, picture: bytes, name: str = "map.pgm") -> Path:
    (folder / name).write_bytes(picture)
    path = folder / "map.yaml"
    path.write_text(yaml, encoding="utf-8")
    return path


def test_a_map_that_map_saver_wrote_is_read_its_top_row_being_the_furthest_north(tmp_path: Path) -> None:
    grid = read_map(write(tmp_path, FOREIGN_YAML, FOREIGN_PGM))
    assert grid.cells.tolist() == [[0, 0, 100], [100, 0, -1]]
    assert (grid.resolution_m, grid.origin, grid.frame) == (0.1, (-1.5, -0.5), "map")
    assert not grid.cells.flags.writeable


def test_what_is_written_is_what_map_saver_would_write() -> None:
    cells = np.array([[0, 25, 100], [65, 40, -1]], np.int8)
    grid = OccupancyGrid(0.0, "map", cells, 0.1, (-1.5, -0.5), 7)
    assert pgm_bytes(grid) == b"P5\n# 0.100 m/pix\n3 2\n255\n" + bytes([0, 205, 205, 254, 254, 0])
    assert yaml_text(grid, "map.pgm").splitlines()[:6] == [
        "image: map.pgm", "resolution: 0.1", "origin: [-1.5, -0.5, 0.0]", "negate: 0", "occupied_thresh: 0.65",
        "free_thresh: 0.196",
    ]  # fmt: skip


@given(grid=trinary_grids())
def test_there_and_back(grid: OccupancyGrid, tmp_path_factory: pytest.TempPathFactory) -> None:
    back = read_map(write(tmp_path_factory.mktemp("map"), yaml_text(grid, "map.pgm"), pgm_bytes(grid)))
    assert np.array_equal(back.cells, grid.cells)
    assert (back.resolution_m, back.origin) == (grid.resolution_m, grid.origin)


@pytest.mark.parametrize(
    ("mode", "expected"), [("trinary", [100, -1, 0]), ("scale", [100, 49, 0]), ("raw", [0, -1, -1])]
)
def test_modes(tmp_path: Path, mode: str, expected: list[int]) -> None:
    picture = b"P5\n3 1\n255\n" + bytes([0, 148, 254])
    path = write(tmp_path, FOREIGN_YAML + f"mode: {mode}\n", picture)
    assert read_map(path).cells.tolist() == [expected]


def test_negated_pictures_have_white_walls(tmp_path: Path) -> None:
    path = write(tmp_path, FOREIGN_YAML.replace("negate: 0", "negate: 1"), b"P5\n3 1\n255\n" + bytes([0, 128, 255]))
    assert read_map(path).cells.tolist() == [[0, -1, 100]]


def test_pictures_may_be_png_in_colour_and_text_pgm(tmp_path: Path) -> None:
    grey = np.array([[0, 254, 205]], np.uint8)
    png = cv2.imencode(".png", np.dstack([grey] * 3))[1].tobytes()
    path = write(tmp_path, FOREIGN_YAML.replace("map.pgm", "map.png"), png, "map.png")
    assert read_map(path).cells.tolist() == [[100, 0, -1]]
    path = write(tmp_path, FOREIGN_YAML, b"P2\n3 1\n255\n0 254 205\n")
    assert read_map(path).cells.tolist() == [[100, 0, -1]]


@pytest.mark.parametrize(
    ("yaml", "line", "words"),
    [
        (FOREIGN_YAML.replace("0.100000", "-1"), 2, "resolution: should be greater than or equal to 0.001"),
        (FOREIGN_YAML.replace("0.000000]", "0.7]"), 3, "lie along the map's axes"),
        (FOREIGN_YAML.replace("map.pgm", "../map.pgm"), 1, "must lie beside this file"),
        (FOREIGN_YAML.replace("0.196", "0.9"), 6, "not be above occupied_thresh"),
        (FOREIGN_YAML + "mode: odd\n", 8, "'trinary', 'scale' or 'raw'"),
        ("image: map.pgm\norigin: [0, 0, 0]\n", 1, "resolution: is missing"),
        ("nothing\n", 1, "is no map"),
        ("image: [\n", 2, "not valid YAML"),
    ],
)
def test_a_mistake_in_the_yaml_file_is_told_with_its_line(tmp_path: Path, yaml: str, line: int, words: str) -> None:
    path = write(tmp_path, yaml, FOREIGN_PGM)
    with pytest.raises(ConfigError, match=words) as mistake:
        read_map(path)
    assert (mistake.value.file, mistake.value.line) == (str(path), line)


@pytest.mark.parametrize("picture", [FOREIGN_PGM[:-2], b"", b"P5\n3 2\n", b"a drawing"])
def test_a_damaged_picture_is_told(tmp_path: Path, picture: bytes) -> None:
    path = write(tmp_path, FOREIGN_YAML, picture)
    with pytest.raises(ConfigError, match="damaged or cut off") as mistake:
        read_map(path)
    assert mistake.value.file == str(tmp_path / "map.pgm")


def test_a_picture_that_is_not_there_is_told(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(FOREIGN_YAML, encoding="utf-8")
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        read_map(path)


def test_a_room_stays_a_room(tmp_path: Path) -> None:
    grid = room()
    assert np.array_equal(read_map(write(tmp_path, yaml_text(grid, "map.pgm"), pgm_bytes(grid))).cells, grid.cells)
