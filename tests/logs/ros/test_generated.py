"""Definitions out of dataclasses: any message, also one that is invented tomorrow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from msgspec import Struct
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.logs.ros import typestore
from app.logs.ros.generated import UnrecordableType, generated
from app.messages import read_only
from app.messages.base import Stamp, doc
from tests.logs.ros.messages import same


@dataclass(frozen=True, slots=True)
class Smell:
    """Something nested."""

    name: str
    ppm: float


class Owner(Struct, frozen=True, rename={"cls": "class"}):
    """Something nested that has a name in JSON which Python keeps for itself."""

    cls: str
    noses: Mapping[str, Smell]


@dataclass(frozen=True, slots=True, eq=False)
class NoseReport:
    """One of everything that a field may be, with descriptions and without."""

    stamp: Stamp
    sniffs: Annotated[int, doc("Since the start.")]
    blocked: bool
    state: Literal["clean", "dirty"]
    raw: bytes
    p_BN: tuple[float, float, float] | None
    strongest: Smell | None
    smells: tuple[Smell, ...]
    words: tuple[Annotated[str, doc("What it smells like.")], ...]
    flags: tuple[bool, bool]
    counts: tuple[int, ...]
    spectrum: NDArray[np.float32]
    mask: NDArray[np.bool_] | None
    X_BN: Pose3
    X_OB: Pose2
    note: str | None
    seen: float | None
    gains: Mapping[str, float]
    owners: Mapping[str, Owner]
    more: Mapping[str, Any]
    settings: Mapping[str, Mapping[str, Any]]


FULL = NoseReport(
    1_790_000_000.123456, -5, True, "dirty", b"\0\xff", (1.0, float("inf"), -0.0), Smell("café", 3.5),
    (Smell("a", 1.0), Smell("", 2.0)), ("x", "ÿ", ""), (True, False), (1, -(2**63), 2**63 - 1),
    read_only(np.arange(6, dtype=np.float32).reshape(2, 3)), read_only(np.array([True, False])),
    Pose3.from_translation_rpy((1, 2, 3), (0.1, 0.2, 0.3)), Pose2(1.0, 2.0, 9.0), "a note", 4.5,
    {"left": 0.5, "": float("inf")}, {"é": Owner("dog", {"a": Smell("b", 1.0)}), "x": Owner("", {})},
    {"a": [1, None, {"b": "ÿ"}]}, {"Nose": {"depth": 2}, "Ear": {}},
)  # fmt: skip
EMPTY = NoseReport(
    1_790_000_000.0, 0, False, "clean", b"", None, None, (), (), (False, True), (),
    read_only(np.zeros((0, 4), np.float32)), None, Pose3.identity(), Pose2(), None, None, {}, {}, {}, {},
)  # fmt: skip


@pytest.mark.parametrize("message", [FULL, EMPTY])
def test_every_kind_of_field_comes_back(message: NoseReport) -> None:
    made = generated(NoseReport)
    assert same(made.decode(made.encode(message)), message)


def test_the_definition_says_what_is_in_it() -> None:
    first, *rest = typestore.definition(generated(NoseReport).type).split("=" * 80 + "\n")
    assert first.splitlines() == [
        "builtin_interfaces/Time stamp", "int64 sniffs", "bool blocked", "string state", "uint8[] raw",
        "bool has_p_bn", "float64[3] p_bn", "bool has_strongest", "tests_msgs/Smell strongest",
        "tests_msgs/Smell[] smells", "string[] words", "bool[2] flags", "int64[] counts",
        "float32[] spectrum", "uint32[] spectrum_shape", "bool has_mask", "bool[] mask", "uint32[] mask_shape",
        "hbba_msgs/Pose3 x_bn", "hbba_msgs/Pose2 x_ob", "bool has_note", "string note", "bool has_seen",
        "float64 seen", "hbba_msgs/Float64Entry[] gains", "tests_msgs/OwnerEntry[] owners", "string more",
        "hbba_msgs/StringEntry[] settings",
    ]  # fmt: skip
    assert "MSG: tests_msgs/Smell\nstring name\nfloat64 ppm\n" in rest
    assert "MSG: tests_msgs/OwnerEntry\nstring key\ntests_msgs/Owner value\n" in rest
    assert {part.splitlines()[0] for part in rest} == {
        "MSG: builtin_interfaces/Time", "MSG: tests_msgs/Smell", "MSG: hbba_msgs/Pose3", "MSG: hbba_msgs/Pose2",
        "MSG: hbba_msgs/Float64Entry", "MSG: hbba_msgs/StringEntry", "MSG: tests_msgs/Owner",
        "MSG: tests_msgs/OwnerEntry", "MSG: tests_msgs/SmellEntry",
    }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Untyped:
    stamp: float
    anything: Any


@dataclass(frozen=True, slots=True)
class Either:
    stamp: float
    which: int | str


@dataclass(frozen=True, slots=True)
class Mixed:
    stamp: float
    pair: tuple[int, str]


@dataclass(frozen=True, slots=True)
class Ragged:
    stamp: float
    rows: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True)
class Sparse:
    stamp: float
    gains: Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class AnyArray:
    stamp: float
    array: NDArray[Any]


@dataclass(frozen=True, slots=True)
class Twins:
    stamp: float
    X_BC: float
    x_bc: float


@pytest.mark.parametrize(
    ("cls", "what"),
    [
        (Untyped, "Untyped.anything"), (Either, "Either.which"), (Mixed, "Mixed.pair"), (Ragged, "Ragged.rows"),
        (Sparse, "Sparse.gains"), (AnyArray, "AnyArray.array"), (Twins, "two fields of Twins"),
    ],
)  # fmt: skip
def test_what_ros_cannot_say_is_refused_by_name(cls: type[Any], what: str) -> None:
    with pytest.raises(UnrecordableType, match=what):
        generated(cls)


def test_damaged_bytes_are_a_value_error() -> None:
    made = generated(NoseReport)
    data = made.encode(FULL)
    for length in (0, 3, 10, len(data) // 2):
        with pytest.raises(ValueError, match="no tests_msgs/msg/NoseReport: "):
            made.decode(data[:length])
