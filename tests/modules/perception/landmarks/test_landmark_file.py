from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.modules.perception.landmarks.landmark_file import StoredLandmarks, read_landmarks, write_landmarks
from app.modules.perception.landmarks.landmark_map import LandmarkMap
from tests.modules.perception.landmarks.graphs import keyframes, seen


def some() -> StoredLandmarks:
    landmarks = LandmarkMap()
    graph = {3: Pose2(), 7: Pose2(1.0, 0.5, 0.2)}
    for id, robot in graph.items():
        landmarks.follow(keyframes(graph, robot, keyframe=id))
        for text, x in (("Büro \udcff", 3.0), ("", 1.0), ("HBBA:STOP/1\0", 5.0)):
            landmarks.take(float(id), text, seen(robot, (x, 1.0, 1.2), 3.0), robot)
    return StoredLandmarks(landmarks.known, *landmarks.anchors())


def test_landmarks_are_read_as_they_were_written(tmp_path: Path) -> None:
    stored = some()
    write_landmarks(tmp_path / "landmarks.npz", stored)
    found = read_landmarks(tmp_path / "landmarks.npz")
    assert found.ids.tolist() == [3, 7]
    np.testing.assert_array_equal(found.X_MK, stored.X_MK)
    assert len(found.landmarks) == 3
    for mark, kept in zip(found.landmarks, stored.landmarks, strict=True):
        assert (mark.id, mark.text, mark.seen) == (kept.id, kept.text, kept.seen)
        assert (mark.first_seen, mark.last_seen, mark.here) == (kept.first_seen, kept.last_seen, False)
        for name in ("anchors", "p_KQ", "information", "headings"):
            np.testing.assert_array_equal(getattr(mark.sightings, name), getattr(kept.sightings, name))


def test_a_map_without_landmarks_has_none(tmp_path: Path) -> None:
    assert read_landmarks(tmp_path / "landmarks.npz").landmarks == ()
    write_landmarks(tmp_path / "landmarks.npz", read_landmarks(tmp_path / "none.npz"))
    assert read_landmarks(tmp_path / "landmarks.npz").landmarks == ()


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"format": np.array(9)}, "format 9; this program reads 1"),
        ({"id": None}, "there is no 'id'"),
        ({"id": np.array([1, 1, 2])}, "two with one id"),
        ({"text_length": np.array([-1, 0, 3])}, "damaged"),
        ({"keyframe": np.array([3, 7, 3, 7, 3, 8])}, "whose pose is missing"),
        ({"keyframe": np.array([3, 3, 3, 7, 3, 7])}, "two rows for one keyframe"),
        ({"row_of": np.array([0, 0, 0, 0, 1, 1])}, "a landmark has no sighting"),
        ({"position": np.full((6, 3), np.nan)}, "numbers that are not finite"),
        ({"information": np.zeros((6, 3, 3))}, "information is not above 0"),
        ({"heading": np.zeros((6, 2), np.float32)}, "heading has 2 dimensions of float32"),
    ],
)
def test_a_damaged_file_is_refused_in_words(tmp_path: Path, changed: dict[str, Any], problem: str) -> None:
    path = tmp_path / "landmarks.npz"
    write_landmarks(path, some())
    arrays = {**np.load(path), **changed}
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(ConfigError, match=problem) as refused:
        read_landmarks(path)
    assert "the map's landmarks" in str(refused.value)
    assert "landmarks.npz" in str(refused.value)
