"""The folder of maps."""

from __future__ import annotations

import os
import shutil
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.base.errors import ConfigError
from app.maps.library import GRAPH, MAP, PICTURE, ZONES, MapLibrary, MapNameTaken, UnknownMap, default_folder
from app.messages import Zone
from tests.maps.grids import room

STAIRS = Zone("stairs", "keep_out", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 1.0)


def write_graph(path: Path) -> None:
    path.write_bytes(b"graph")


@pytest.fixture
def library(tmp_path: Path) -> MapLibrary:
    return MapLibrary(tmp_path / "maps")


def test_a_map_is_kept_listed_and_read(library: MapLibrary) -> None:
    assert library.listing() == []
    library.keep("lab", room(), [STAIRS], {GRAPH: write_graph})
    (facts,) = library.listing()
    assert (facts.name, facts.size_m, facts.resolution_m, facts.graph, facts.zones) == (
        "lab",
        (2.0, 2.0),
        0.05,
        True,
        1,
    )
    assert facts.known_m2 == pytest.approx(1.5 * 1.5)
    assert not facts.problem
    assert np.array_equal(library.grid("lab").cells, room().cells)
    assert [zone.name for zone in library.zones("lab")] == ["stairs"]
    assert (library.folder / "lab" / GRAPH).read_bytes() == b"graph"


def test_keeping_replaces_the_older_map_wholly(library: MapLibrary) -> None:
    library.keep("lab", room(), [STAIRS], {GRAPH: write_graph})
    library.keep("lab", room(60))
    facts = library.facts("lab")
    assert (facts.size_m, facts.graph, facts.zones) == ((3.0, 3.0), False, 0)
    assert [entry.name for entry in library.folder.iterdir()] == ["lab"]


def test_what_fails_half_way_leaves_the_older_map_alone(library: MapLibrary) -> None:
    library.keep("lab", room())

    def fail(path: Path) -> None:
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        library.keep("lab", room(60), [], {GRAPH: fail})
    assert library.facts("lab").size_m == (2.0, 2.0)
    assert [entry.name for entry in library.folder.iterdir()] == ["lab"]


def test_a_map_whose_replacement_was_cut_short_is_there_again(library: MapLibrary) -> None:
    library.keep("lab", room())
    # As a program leaves it that dies between the two renames.
    (library.folder / "lab").rename(library.folder / ".lab.old")
    assert library.grid("lab").cells.shape == (40, 40)
    assert library.names() == ["lab"]


def test_what_a_program_left_that_died_while_it_kept_a_map_is_swept_up_and_no_other(library: MapLibrary) -> None:
    library.keep("lab", room())
    for name, age_s in ((".new-dead", 7200.0), (".new-writing", 5.0)):
        (library.folder / name).mkdir()
        then = time.time() - age_s
        os.utime(library.folder / name, (then, then))
    assert library.names() == ["lab"]
    assert sorted(entry.name for entry in library.folder.iterdir()) == [".new-writing", "lab"]


def test_a_map_that_is_deleted_does_not_come_back_as_it_was_before(library: MapLibrary) -> None:
    # As a program leaves it that dies right after the second rename.
    library.keep("lab", room())
    shutil.copytree(library.folder / "lab", library.folder / ".lab.old")
    assert library.names() == ["lab"]
    library.delete("lab")
    assert library.names() == []


def test_who_lists_maps_while_one_is_replaced_takes_it_for_no_dead_programs(
    library: MapLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    library.keep("lab", room())
    rename = Path.rename
    listers: list[threading.Thread] = []

    def slow_rename(path: Path, target: Path) -> Path:
        renamed = rename(path, target)
        if not listers:
            # Between the two renames of the map that is replaced.
            listers.append(threading.Thread(target=library.names))
            listers[0].start()
            listers[0].join(0.2)
        return renamed

    monkeypatch.setattr(Path, "rename", slow_rename)
    library.keep("lab", room(), [STAIRS])
    listers[0].join()
    assert len(library.zones("lab")) == 1
    assert [path.name for path in library.folder.iterdir()] == ["lab"]


def test_zones_are_replaced_alone(library: MapLibrary) -> None:
    library.keep("lab", room(), [STAIRS])
    library.keep_zones("lab", [])
    assert library.zones("lab") == ()
    assert library.grid("lab").cells.shape == (40, 40)


def test_renaming_and_deleting(library: MapLibrary) -> None:
    library.keep("lab", room())
    library.keep("hall", room())
    with pytest.raises(MapNameTaken, match="a map 'hall' already"):
        library.rename("lab", "hall")
    library.rename("lab", "ground-floor")
    assert library.names() == ["ground-floor", "hall"]
    library.delete("hall")
    assert library.names() == ["ground-floor"]
    with pytest.raises(UnknownMap, match="no map 'hall'; there are: ground-floor"):
        library.delete("hall")


@pytest.mark.parametrize("name", ["", ".hidden", "../up", "a/b", "a b", "x" * 101, "ä"])
def test_names_that_may_not_be(library: MapLibrary, name: str) -> None:
    for call in (library.path, library.facts, library.delete, lambda n: library.keep(n, room())):
        with pytest.raises(ValueError, match="a map's name has 1 to 100 letters"):
            call(name)


def test_a_damaged_map_is_listed_with_its_problem(library: MapLibrary) -> None:
    library.keep("lab", room())
    (library.folder / "lab" / PICTURE).write_bytes(b"P5\n3 3\n255\n")
    library.keep("hall", room())
    (library.folder / "hall" / ZONES).write_text("zones: [{name: 1}]", encoding="utf-8")
    hall, lab = library.listing()
    assert "zones.yaml:1" in hall.problem
    assert "map.pgm" in lab.problem
    with pytest.raises(ConfigError):
        library.grid("lab")


def test_folders_that_are_no_maps_are_let_be(library: MapLibrary) -> None:
    (library.folder / "notes").mkdir(parents=True)
    (library.folder / "map.yaml").write_text("a file", encoding="utf-8")
    assert library.listing() == []


def test_its_picture_is_what_people_call_a_map(library: MapLibrary) -> None:
    library.keep("lab", room())
    pixels = cv2.imdecode(np.frombuffer(library.picture("lab"), np.uint8), cv2.IMREAD_UNCHANGED)
    # The pillar is in the south: low in the picture.
    assert pixels is not None
    assert pixels[40 - 1 - 13, 21] == 0
    assert (pixels[20, 20], pixels[0, 0]) == (254, 205)


def test_files_are_readable_for_others(library: MapLibrary) -> None:
    library.keep("lab", room())
    assert os.stat(library.folder / "lab").st_mode & 0o777 == 0o755
    assert (library.folder / "lab" / MAP).is_file()


def test_where_maps_are_kept_is_for_the_user_to_say(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HBBA_MAPS", "/somewhere")
    assert default_folder() == Path("/somewhere")
    monkeypatch.delenv("HBBA_MAPS")
    monkeypatch.setenv("XDG_DATA_HOME", "/data")
    assert default_folder() == Path("/data/hbba/maps")
