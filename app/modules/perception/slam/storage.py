"""File format of the pose graph, ``graph.npz``: keyframes with their views, their poses, and edges.

An archive of arrays, as numpy writes them, without pickles. Rows of all keyframes are concatenated in ``points``,
``ends`` and ``hits``; ``points_of`` and ``ends_of`` (N + 1) hold where each begins and the last ends.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.npz_source import checked_array, joined, read_arrays
from app.modules.perception.slam.information import matrices, packed
from app.modules.perception.slam.types import Edge, Keyframe, SlamState

FORMAT = 2


def write_state(path: Path, state: SlamState) -> None:
    keyframes, edges = state.keyframes, state.edges
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            format=np.array(FORMAT),
            id=np.array([k.id for k in keyframes], np.int64),
            stamp=np.array([k.stamp for k in keyframes], np.float64),
            travelled_m=np.array([k.travelled_m for k in keyframes], np.float64),
            origin=np.array([k.origin for k in keyframes], np.float32).reshape(-1, 2),
            pose=np.array([(p.x, p.y, p.theta) for p in state.poses], np.float64).reshape(-1, 3),
            points=joined([k.points for k in keyframes], (0, 4), np.float32),
            points_of=_offsets([k.points for k in keyframes]),
            ends=joined([k.ends for k in keyframes], (0, 2), np.float32),
            ends_of=_offsets([k.ends for k in keyframes]),
            hits=joined([k.hits for k in keyframes], (0,), np.bool_),
            edge=np.array([(e.a, e.b) for e in edges], np.int64).reshape(-1, 2),
            edge_pose=np.array([(e.X_ab.x, e.X_ab.y, e.X_ab.theta) for e in edges], np.float64).reshape(-1, 3),
            edge_information=np.array([e.information for e in edges], np.float64).reshape(-1, 6),
            edge_loop=np.array([e.loop for e in edges], np.bool_),
            submap=np.array([id for submap in state.submaps for id in submap], np.int64),
            submap_of=_offsets(state.submaps),
        )
        file.flush()


def read_state(path: Path) -> SlamState:
    """The state in the file ``path``. Raises ConfigError for a damaged file or another format."""
    arrays = read_arrays(path, "the map's graph")
    try:
        if int(arrays["format"]) != FORMAT:
            raise ConfigError(f"the map's graph has format {arrays['format']}; this program reads {FORMAT}", str(path))
        return _state(arrays)
    except KeyError as missing:
        raise ConfigError(f"the map's graph is damaged: it has no {missing}", str(path)) from None
    except (ValueError, TypeError, IndexError) as damage:
        raise ConfigError(f"the map's graph is damaged: {damage}", str(path)) from None


def _state(a: Mapping[str, NDArray[Any]]) -> SlamState:
    ids = checked_array(a, "id", np.int64, (-1,))
    count = len(ids)
    known = set(ids.tolist())
    if len(known) != count:
        raise ValueError("two keyframes have the same id")
    stamps, travelled = (checked_array(a, name, np.float64, (count,)) for name in ("stamp", "travelled_m"))
    origins = checked_array(a, "origin", np.float32, (count, 2))
    poses = checked_array(a, "pose", np.float64, (count, 3))
    points = _split(checked_array(a, "points", np.float32, (-1, 4)), a, "points_of", count)
    all_ends = checked_array(a, "ends", np.float32, (-1, 2))
    ends = _split(all_ends, a, "ends_of", count)
    hits = _split(checked_array(a, "hits", np.bool_, (len(all_ends),)), a, "ends_of", count)
    keyframes = tuple(
        Keyframe(
            id=int(ids[i]), stamp=float(stamps[i]), points=points[i], ends=ends[i], hits=hits[i], origin=origins[i],
            travelled_m=float(travelled[i]),
        )
        for i in range(count)
    )  # fmt: skip
    pairs = checked_array(a, "edge", np.int64, (-1, 2))
    measured = checked_array(a, "edge_pose", np.float64, (len(pairs), 3))
    information = checked_array(a, "edge_information", np.float64, (len(pairs), 6))
    loops = checked_array(a, "edge_loop", np.bool_, (len(pairs),))
    submaps = _split(checked_array(a, "submap", np.int64, (-1,)), a, "submap_of", None)
    if not known.issuperset(pairs.ravel().tolist()) or not known.issuperset(a["submap"].tolist()):
        raise ValueError("it names keyframes that it does not have")
    if not all(len(submap) for submap in submaps):
        raise ValueError("a submap has no keyframe")
    if not (np.linalg.eigvalsh(matrices(information)) > 0).all():
        raise ValueError("edge_information is not above 0")
    edges = tuple(
        Edge(int(one), int(other), Pose2(*X.tolist()), packed(w), bool(loop))
        for (one, other), X, w, loop in zip(pairs, measured, matrices(information), loops, strict=True)
    )
    return SlamState(
        keyframes, tuple(Pose2(*pose) for pose in poses.tolist()), edges, tuple(tuple(s.tolist()) for s in submaps)
    )


def _offsets(parts: Any) -> NDArray[np.int64]:
    """Offset of each part in the concatenation, and the end of the last."""
    return np.cumsum([0, *(len(part) for part in parts)], dtype=np.int64)


def _split(
    array: NDArray[Any], arrays: Mapping[str, NDArray[Any]], offsets: str, count: int | None
) -> list[NDArray[Any]]:
    bounds = checked_array(arrays, offsets, np.int64, (-1 if count is None else count + 1,))
    if not len(bounds) or bounds[0] != 0 or bounds[-1] != len(array) or (np.diff(bounds) < 0).any():
        raise ValueError(f"{offsets} does not fit what it divides")
    return [np.ascontiguousarray(array[a:b]) for a, b in pairwise(bounds.tolist())]
