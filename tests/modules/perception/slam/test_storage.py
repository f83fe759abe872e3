"""The pose graph in its file."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.modules.perception.slam.information import diagonal
from app.modules.perception.slam.mapper import Slam
from app.modules.perception.slam.scans import BeamGeometry
from app.modules.perception.slam.storage import read_state, write_state
from app.modules.perception.slam.types import Edge, Keyframe, SlamState
from tests.modules.perception.slam.places import ANGLES, HALL, X_BL, scan, way

numbers = st.floats(-1e6, 1e6)
poses = st.builds(Pose2, numbers, numbers, numbers)


@st.composite
def states(draw: st.DrawFn) -> SlamState:
    ids = draw(st.lists(st.integers(0, 10**6), unique=True, max_size=5))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    keyframes = []
    for id in ids:
        points, ends = draw(st.integers(0, 4)), draw(st.integers(0, 4))
        keyframes.append(
            Keyframe(
                id,
                draw(numbers),
                rng.normal(size=(points, 4)).astype(np.float32),
                rng.normal(size=(ends, 2)).astype(np.float32),
                rng.random(ends) < 0.5,
                rng.normal(size=2).astype(np.float32),
                draw(numbers),
            )
        )
    one = st.sampled_from(ids) if ids else st.nothing()
    sure = st.floats(1e-6, 1e9)
    edges = st.builds(Edge, one, one, poses, st.builds(diagonal, sure, sure, sure), st.booleans())
    return SlamState(
        tuple(keyframes),
        tuple(draw(poses) for _ in ids),
        tuple(draw(st.lists(edges, max_size=4))) if ids else (),
        tuple(draw(st.lists(st.lists(one, min_size=1, max_size=4).map(tuple), max_size=3))) if ids else (),
    )


def same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(same(a, b) for a, b in zip(one, other, strict=True))
    if isinstance(one, Keyframe):
        return all(same(getattr(one, name), getattr(other, name)) for name in Keyframe.__dataclass_fields__)
    return bool(one == other)


@settings(max_examples=40)
@given(state=states())
def test_there_and_back(state: SlamState, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("graph") / "graph.npz"
    write_state(path, state)
    back = read_state(path)
    for name in SlamState.__dataclass_fields__:
        assert same(getattr(state, name), getattr(back, name)), name


def mapped() -> Slam:
    slam = Slam()
    beams = BeamGeometry(ANGLES, 0.1, 30.0, Pose2(float(X_BL.translation[0]), 0.0, 0.0))
    start = Pose2(1.5, 3.0)
    for number, pose in enumerate(way((1.5, 3.0), (6.0, 3.0))):
        slam.add(number * 0.1, scan(HALL, pose, seed=number).ranges, beams, start.inverse() @ pose)
    return slam


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("graph") / "graph.npz"
    write_state(path, mapped().state())
    return path


def test_mapping_goes_on_from_what_was_kept(written: Path) -> None:
    state = read_state(written)
    slam = Slam(state=state, X_MB=Pose2(4.5, 0.0, 0.0))
    beams = BeamGeometry(ANGLES, 0.1, 30.0, Pose2(0.2, 0.0, 0.0))
    # Odometry restarts, elsewhere.
    for number, pose in enumerate(way((6.0, 3.0), (8.0, 3.0))):
        match = slam.add(100.0 + number, scan(HALL, pose, seed=99 + number).ranges, beams, Pose2(5, 5) @ Pose2(pose.x))
    assert len(slam.keyframes) > len(state.keyframes)
    assert (match.X_MB.x, match.X_MB.y) == pytest.approx((6.5, 0.0), abs=0.03)


def changed(written: Path, tmp_path: Path, **arrays: Any) -> Path:
    with np.load(written) as archive:
        content = {name: archive[name] for name in archive.files}
    content = {name: array for name, array in {**content, **arrays}.items() if array is not None}
    path = tmp_path / "graph.npz"
    np.savez_compressed(path, **content)
    return path


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"format": np.array(9)}, "format 9; this program reads 2"),
        ({"pose": None}, "has no 'pose'"),
        ({"pose": np.zeros((1, 3))}, "pose has the shape"),
        ({"stamp": np.array(["now"])}, "stamp has 1 dimensions of <U3"),
        ({"points_of": np.array([0, 1, 2])}, "points_of has the shape"),
        ({"edge": np.array([[0, 10**9]])}, "damaged"),
        ({"submap": np.array([0]), "submap_of": np.array([0, 1, 1])}, "a submap has no keyframe"),
        (
            {
                "edge": np.array([[0, 1]]),
                "edge_pose": np.zeros((1, 3)),
                "edge_information": np.zeros((1, 6)),
                "edge_loop": np.array([False]),
            },
            "edge_information is not above 0",
        ),
        ({"submap": np.array([10**9]), "submap_of": np.array([0, 1])}, "keyframes that it does not have"),
    ],
)
def test_a_graph_that_cannot_be_is_reported(written: Path, tmp_path: Path, arrays: dict[str, Any], words: str) -> None:
    path = changed(written, tmp_path, **arrays)
    with pytest.raises(ConfigError, match=words) as damage:
        read_state(path)
    assert damage.value.file == str(path)


def test_numbers_that_are_none_are_reported(written: Path, tmp_path: Path) -> None:
    with np.load(written) as archive:
        poses = archive["pose"].copy()
    poses[0, 0] = np.nan
    with pytest.raises(ConfigError, match="not finite"):
        read_state(changed(written, tmp_path, pose=poses))


@settings(max_examples=30)
@given(data=st.data())
def test_any_damaged_byte_is_reported_or_harmless(data: st.DataObject, written: Path, tmp_path_factory: Any) -> None:
    content = bytearray(written.read_bytes())
    at = data.draw(st.integers(0, len(content) - 1))
    content[at] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.mktemp("damaged") / "graph.npz"
    path.write_bytes(content)
    with contextlib.suppress(ConfigError):
        read_state(path)


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04"])
def test_what_is_no_graph_is_reported(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "graph.npz"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match="graph"):
        read_state(path)


def test_pickles_are_not_opened(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, format=np.array([object()], dtype=object))
    path = tmp_path / "graph.npz"
    path.write_bytes(buffer.getvalue())
    with pytest.raises(ConfigError, match="has Python objects in `format`, which are not opened here"):
        read_state(path)
