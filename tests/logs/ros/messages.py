"""Generated messages: a hypothesis strategy for any message class, and a comparison of two."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from app import messages
from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3
from app.messages import (
    EncodedImage,
    Image,
    JointState,
    LaserScan,
    LogLine,
    OccupancyGrid,
    Odometry,
    PlannedPath,
    PointCloud,
)
from app.messages.base import field_names, is_record

#: Stamps as the robot's clock gives them: from there on float64 and nanoseconds say the same.
STAMPS = st.floats(2**23, 2**31 - 1)
_FLOATS = st.floats(width=64)
_TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
_LENGTHS = st.floats(-1e3, 1e3)
_GREATEST_FLOAT32 = float(np.finfo(np.float32).max)
#: Bounded, or most draws would be too great for 32 bits and thrown away; what no bounds hold is added.
_POSITIVE_FLOATS32 = st.floats(0, _GREATEST_FLOAT32, width=32) | st.just(np.inf)
_FLOATS32 = st.floats(-_GREATEST_FLOAT32, _GREATEST_FLOAT32, width=32) | st.sampled_from([np.inf, -np.inf, np.nan])


def message_classes() -> list[type[Any]]:
    """Every message class of ``app.messages``: the dataclasses with a stamp."""
    return [found for found in vars(messages).values() if is_record(found) and "stamp" in field_names(found)]


def instances(cls: type[Any]) -> st.SearchStrategy[Any]:
    """Instances of ``cls``, as wild as its docstring allows."""
    if cls not in _STRATEGIES:
        hints = typing.get_type_hints(cls)
        _STRATEGIES[cls] = st.builds(cls, **{name: _values(name, hints[name]) for name in field_names(cls)})
    return _STRATEGIES[cls]


def sequences(cls: type[Any], min_size: int = 1, max_size: int = 3) -> st.SearchStrategy[list[Any]]:
    """Some instances of ``cls`` as one channel may carry them: a camera keeps its lens."""
    kinds = [_images((lens,)) for lens in (CameraModel, FisheyeModel)] if cls is Image else [instances(cls)]
    return st.one_of(*[st.lists(kind, min_size=min_size, max_size=max_size) for kind in kinds])


def same(a: Any, b: Any) -> bool:
    """Whether two messages are equal to the last bit (NaN being NaN), of the same types throughout."""
    if type(a) is not type(b):
        return False
    if is_record(type(a)):
        return all(same(getattr(a, name), getattr(b, name)) for name in field_names(type(a)))
    if isinstance(a, np.ndarray):
        return bool(a.dtype == b.dtype and a.shape == b.shape and np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[name], b[name]) for name in a)
    return bool(a == b) or (a != a and b != b)


def _values(name: str, hint: Any) -> st.SearchStrategy[Any]:
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return st.one_of(*[st.none() if a is types.NoneType else _values(name, a) for a in arguments])
    if origin is tuple and arguments[1:] == (Ellipsis,):
        return st.lists(_values("", arguments[0]), max_size=5).map(tuple)
    if origin is tuple:
        return st.tuples(*[_values("", a) for a in arguments])
    if origin is Mapping:
        return st.dictionaries(_TEXT, _values("", arguments[1]), max_size=3)
    if hint is Any:
        return st.recursive(st.none() | st.booleans() | st.floats(allow_nan=False) | _TEXT, st.lists, max_leaves=3)
    if origin is np.ndarray:
        dtype = np.dtype(typing.get_args(arguments[1])[0])
        return arrays.arrays(dtype, arrays.array_shapes(max_dims=2, min_side=0, max_side=5))
    if origin is typing.Literal:
        return st.sampled_from(arguments)
    if hint is float:
        return STAMPS if name == "stamp" else _FLOATS
    simple = {int: st.integers(-(2**63), 2**63 - 1), bool: st.booleans(), bytes: st.binary(max_size=30)}
    if hint is str:
        return _TEXT
    return simple[hint] if hint in simple else instances(hint)


_FRAMES = st.from_regex(r"[a-z][a-z_]{0,20}", fullmatch=True)
_POSES = st.builds(
    Pose3.from_translation_rpy, st.tuples(_LENGTHS, _LENGTHS, _LENGTHS), st.tuples(*[st.floats(-3.2, 3.2)] * 3)
)


@st.composite
def _images(draw: st.DrawFn, lenses: tuple[type[Any], ...] = (CameraModel, FisheyeModel)) -> Image:
    height, width = draw(st.integers(1, 20)), draw(st.integers(1, 20))
    shade = draw(st.tuples(*[st.integers(0, 255)] * 3))
    color = np.full((height, width, 3), shade, np.uint8)
    depth = draw(st.none() | arrays.arrays(np.uint16, (height, width)))
    lens = draw(st.sampled_from(lenses))
    camera = lens(width, height, *draw(st.tuples(*[st.floats(1, 1e4)] * (5 if lens is FisheyeModel else 4))))
    return Image(draw(STAMPS), draw(_FRAMES), color, depth, camera, draw(_POSES))


@st.composite
def _scans(draw: st.DrawFn) -> LaserScan:
    count = draw(st.integers(0, 30))
    ranges = draw(arrays.arrays(np.float32, count, elements=_POSITIVE_FLOATS32))
    intensities = draw(arrays.arrays(np.float32, count, elements=_FLOATS32))
    angles = draw(st.tuples(st.floats(-3, 3), st.floats(1e-3, 0.1), st.floats(0, 1), st.floats(2, 100)))
    return LaserScan(draw(STAMPS), draw(_FRAMES), ranges, intensities, *angles, draw(st.floats(0, 1)), draw(_POSES))


@st.composite
def _joint_states(draw: st.DrawFn) -> JointState:
    names = draw(st.lists(_TEXT, max_size=5).map(tuple))
    efforts = tuple(draw(_FLOATS) for _ in names) if draw(st.booleans()) else ()
    return JointState(draw(STAMPS), names, tuple(draw(_FLOATS) for _ in names), efforts)


@st.composite
def _clouds(draw: st.DrawFn) -> PointCloud:
    count = draw(st.integers(0, 20))
    points = draw(arrays.arrays(np.float32, (count, 3), elements=_FLOATS32))
    return PointCloud(draw(STAMPS), points, draw(arrays.arrays(np.uint8, (count, 3))), draw(instances(Pose2)))


@st.composite
def _grids(draw: st.DrawFn) -> OccupancyGrid:
    cells = draw(arrays.arrays(np.int8, st.tuples(st.integers(0, 9), st.integers(0, 9)), elements=st.integers(-1, 100)))
    figures = draw(st.floats(1e-3, 10)), (draw(_LENGTHS), draw(_LENGTHS)), draw(st.integers(0, 2**62))
    return OccupancyGrid(draw(STAMPS), draw(_FRAMES), cells, *figures)


@st.composite
def _paths(draw: st.DrawFn) -> PlannedPath:
    poses = draw(arrays.arrays(np.float64, (draw(st.integers(0, 9)), 3), elements=_LENGTHS))
    return PlannedPath(draw(STAMPS), draw(_FRAMES), poses)


#: By class; those that are not written here are added as they are made.
_STRATEGIES: dict[type[Any], st.SearchStrategy[Any]] = {
    Pose3: _POSES,
    Image: _images(),
    LaserScan: _scans(),
    JointState: _joint_states(),
    PointCloud: _clouds(),
    OccupancyGrid: _grids(),
    PlannedPath: _paths(),
    Odometry: st.builds(
        Odometry, STAMPS, st.builds(Pose2, _LENGTHS, _LENGTHS, st.floats(-6.28, 6.28)), _FLOATS, _FLOATS, _FLOATS
    ),
    LogLine: st.builds(LogLine, STAMPS, st.integers(0, 255), _TEXT, _TEXT),
    EncodedImage: st.builds(
        EncodedImage, STAMPS, _FRAMES, st.binary(max_size=100), st.integers(1, 4000), st.integers(1, 4000), _POSES
    ),
}
