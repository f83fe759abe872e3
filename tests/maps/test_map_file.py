"""Maps as ROS's map_server keeps them."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given

from app.base.errors import ConfigError
from app.maps.map_file import pgm_bytes, read_map, yaml_text
from app.messages import OccupancyGrid
from tests.maps.grids import room, trinary_grids

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
def test_a_mistake_in_the_yaml_file_is_reported_with_its_line(tmp_path: Path, yaml: str, line: int, words: str) -> None:
    path = write(tmp_path, yaml, FOREIGN_PGM)
    with pytest.raises(ConfigError, match=words) as mistake:
        read_map(path)
    assert (mistake.value.file, mistake.value.line) == (str(path), line)


@pytest.mark.parametrize("picture", [FOREIGN_PGM[:-2], b"", b"P5\n3 2\n", b"a drawing"])
def test_a_damaged_picture_is_reported(tmp_path: Path, picture: bytes) -> None:
    path = write(tmp_path, FOREIGN_YAML, picture)
    with pytest.raises(ConfigError, match="damaged or cut off") as mistake:
        read_map(path)
    assert mistake.value.file == str(tmp_path / "map.pgm")


def white_png(width: int, height: int, rows: int) -> bytes:
    """A white PNG that says it has this size and holds the first ``rows`` of it."""

    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    packer = zlib.compressobj(9)
    packed = b"".join(packer.compress(b"\0" + b"\xff" * width) for _ in range(rows)) + packer.flush()
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def test_a_picture_of_too_many_cells_is_refused_before_it_is_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.base.image_source.cv2.imdecode", None)
    for picture in (b"P5\n8000 8001\n255\n", white_png(14_000, 14_000, 1), b"P5\n2000000000 2000000000\n255\n"):
        path = write(tmp_path, FOREIGN_YAML, picture)
        with pytest.raises(ConfigError, match=r"the map's picture has \d+ x \d+ pixels; at most 64 million") as refusal:
            read_map(path)
        assert refusal.value.file == str(tmp_path / "map.pgm")


@pytest.mark.slow
def test_a_map_of_as_many_cells_as_may_be_takes_some_four_bytes_for_each(tmp_path: Path) -> None:
    (tmp_path / "map.png").write_bytes(white_png(8_000, 8_000, 8_000))
    (tmp_path / "map.yaml").write_text(FOREIGN_YAML.replace("map.pgm", "map.png"), encoding="utf-8")
    measure = (
        "import resource, sys; from pathlib import Path; from app.maps.library import MapLibrary;"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024;"
        "before = peak(); facts = MapLibrary(Path(sys.argv[1])).facts(sys.argv[2]);"
        "print(facts.known_m2, peak() - before)"
    )
    call = [sys.executable, "-c", measure, str(tmp_path.parent), tmp_path.name]
    known, grown = subprocess.run(call, check=True, capture_output=True, text=True).stdout.split()
    assert float(known) == pytest.approx(64e6 * 0.01)
    assert int(grown) < 300


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_colored_pictures_are_as_grey_as_the_mean_of_their_colors(dtype: type[np.generic], tmp_path: Path) -> None:
    scale = 1 if dtype == np.uint8 else 256
    colors = np.random.default_rng(3).integers(0, 256, (150, 7, 4)) * scale
    (tmp_path / "map.png").write_bytes(cv2.imencode(".png", colors.astype(dtype))[1].tobytes())
    yaml = FOREIGN_YAML.replace("map.pgm", "map.png").replace("0.65", "0.5").replace("0.196", "0.5") + "mode: scale\n"
    (tmp_path / "map.yaml").write_text(yaml, encoding="utf-8")
    grey = (colors[..., :3] // scale).mean(axis=2).round()
    expected = np.where((255 - grey) / 255 > 0.5, 100, 0)
    expected[colors[..., 3] // scale < 255] = -1
    assert np.array_equal(read_map(tmp_path / "map.yaml").cells, expected[::-1])


@pytest.mark.parametrize("ending", [".jpg", ".bmp", ".tiff", ".webp", ".gif"])
def test_no_picture_but_pgm_and_png_is_decoded(ending: str, tmp_path: Path) -> None:
    picture = cv2.imencode(ending, np.zeros((20, 20, 3), np.uint8))[1].tobytes()
    with pytest.raises(ConfigError, match="of a kind that is none of PGM and PNG"):
        read_map(write(tmp_path, FOREIGN_YAML, picture))


@pytest.mark.parametrize("name", ["map.yaml", "map.pgm"])
@pytest.mark.parametrize("kind", ["a pipe", "a device"])
def test_a_pipe_or_a_device_in_a_files_place_is_refused_and_not_waited_for(
    name: str, kind: str, tmp_path: Path
) -> None:
    path = write(tmp_path, FOREIGN_YAML, FOREIGN_PGM)
    (tmp_path / name).unlink()
    if kind == "a pipe":
        os.mkfifo(tmp_path / name)
    else:
        (tmp_path / name).symlink_to("/dev/zero")
    with pytest.raises(ConfigError, match=f"cannot be read: is {kind}, no regular file"):
        read_map(path)


def test_a_missing_picture_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(FOREIGN_YAML, encoding="utf-8")
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        read_map(path)


def test_a_room_stays_a_room(tmp_path: Path) -> None:
    grid = room()
    assert np.array_equal(read_map(write(tmp_path, yaml_text(grid, "map.pgm"), pgm_bytes(grid))).cells, grid.cells)
