"""YAML with lines: the schema's scalars, lines of keys, and what a person reads when something is wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field

from app import paths, yaml_source
from app.errors import ConfigError
from app.yaml_source import dotted, load_text, load_yaml, parse


class Wheel(BaseModel):
    model_config = ConfigDict(extra="forbid")

    radius: float = Field(gt=0)


class Robot(BaseModel):
    model_config = ConfigDict(extra="forbid")

    name: str
    wheels: list[Wheel] = []
    spare: Wheel | None = None
    by_side: dict[str, Wheel] = {}
    drive: str = Field("two", pattern="^(two|four)$")


def test_scalars_follow_the_core_schema() -> None:
    text = "{a: off, b: no, c: 12:30, d: 1e3, e: .inf, f: true, g: null, h: 007, i: 2026-01-02, j: 0x1f, k: -1.5}"
    data = load_text(text, "x").data
    assert data == {
        "a": "off",
        "b": "no",
        "c": "12:30",
        "d": 1000.0,
        "e": float("inf"),
        "f": True,
        "g": None,
        "h": 7,
        "i": "2026-01-02",
        "j": 31,
        "k": -1.5,
    }


def test_lines_point_at_keys_and_items() -> None:
    document = load_text("a:\n  - x: 1\n  - y:\n      z: 2\nb: 3\n", "f.yaml")
    assert document.line(("a", 0, "x")) == 2
    assert document.line(("a", 1, "y", "z")) == 4
    assert document.line(("b",)) == 5
    assert document.line(("a", 1, "missing")) == 3, "a key that is not there points at its owner"
    assert document.line(()) == 1


def test_merge_keys_and_anchors() -> None:
    document = load_text("base: &b {p: 1}\nuse:\n  <<: *b\n  q: 2\n", "f")
    assert document.data["use"] == {"p": 1, "q": 2}
    assert document.line(("use", "p")) == 1


def test_text_with_control_characters_is_no_yaml() -> None:
    with pytest.raises(ConfigError, match="is not valid YAML"):
        load_text("a: \x00 b", "f.yaml")


def test_json_with_tabs_and_empty_text() -> None:
    assert load_text('{\n\t"a": [1, 2.5, null, false]\n}', "x.json").data == {"a": [1, 2.5, None, False]}
    assert load_text("", "x").data is None


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("a: 1\na: 2\n", 2, "twice"),
        ("a: [1, 2\nb: 3\n", 2, "not valid YAML"),
        ("a: &x [*x]\n", 1, "contains itself"),
        ("? [1, 2]\n: 3\n", 1, "a key must be"),
        ("0x10: 1\n16: 2\n", 2, "twice"),
    ],
)
def test_broken_text(text: str, line: int, words: str) -> None:
    with pytest.raises(ConfigError, match=words) as caught:
        load_text(text, "f.yaml")
    assert (caught.value.file, caught.value.line) == ("f.yaml", line)
    assert str(caught.value).startswith(f"f.yaml:{line}: ")


@pytest.mark.parametrize(
    ("text", "line", "key", "words"),
    [
        ("wheels: []\n", 1, "name", "is missing"),
        ("nme: x\n", 1, "nme", "did you mean 'name'"),
        ("name: x\nwheels:\n  - radius: 0.1\n  - radius: -1\n", 4, "wheels[1].radius", "greater than 0, not -1"),
        ("name: x\nspare:\n  radus: 1\n  radius: 1\n", 3, "spare.radus", "did you mean 'radius'"),
        ("name: x\nby_side:\n  left:\n    radius: 1\n    color: red\n", 5, "by_side.left.color", "allowed: radius"),
        ("name: x\nwheels:\n  - {radius: big}\n", 3, "wheels[0].radius", "not 'big'"),
        ("hello\n", 1, "", "should be a mapping (name: value lines), not 'hello'"),
        ("name: x\nspare: [1]\n", 2, "spare", "spare: should be a mapping (name: value lines), not a list"),
        ("name: x\nwheels: {}\n", 2, "wheels", "wheels: should be a list, not a mapping"),
        ("name: 3\n", 1, "name", "name: should be text, not 3"),
        ("name: x\ndrive: legs\n", 2, "drive", "drive: should be one of two, four, not 'legs'"),
        (f"{'o' * 200}\n", 1, "", f"not '{'o' * 77}…'"),
    ],
)
def test_parse_names_file_line_key_and_what_is_allowed(
    tmp_path: Path, text: str, line: int, key: str, words: str
) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        parse(path, Robot)
    assert (caught.value.file, caught.value.line, caught.value.key) == (str(path), line, key)
    assert words in caught.value.message


def test_parse_a_good_file(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text("name: irl\nwheels: [{radius: 0.1}]\n")
    assert parse(path, Robot) == Robot(name="irl", wheels=[Wheel(radius=0.1)])


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="No such file"):
        load_yaml(tmp_path / "none.yaml")
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="UTF-8"):
        load_yaml(tmp_path / "binary.yaml")


def test_dotted() -> None:
    assert dotted(("strategies", 3, "costs", "cpu")) == "strategies[3].costs.cpu"


@pytest.mark.parametrize("path", sorted(paths.config_dir().rglob("*.yaml")), ids=lambda path: path.name)
def test_both_loaders_read_the_programs_own_files_alike(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert yaml_source._is_flat(text)
    quick, plain = (
        yaml_source._loaded(loader, text, path.name) for loader in (yaml_source._QuickLoader, yaml_source._CoreLoader)
    )
    assert quick.data == plain.data
    assert quick.lines == plain.lines


DATA = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(DATA, st.booleans())
def test_both_loaders_read_anything_alike(data: Any, flow: bool) -> None:
    text = yaml.safe_dump(data, default_flow_style=flow, allow_unicode=True)
    quick, plain = (
        yaml_source._loaded(loader, text, "it") for loader in (yaml_source._QuickLoader, yaml_source._CoreLoader)
    )
    assert quick.data == plain.data
    assert quick.lines == plain.lines


@pytest.mark.parametrize("text", ["[" * 100_000, "- " * 100_000 + "1", "{a: " * 1_500 + "1" + "}" * 1_500])
def test_what_is_nested_too_deeply_is_refused_and_ends_nothing(text: str) -> None:
    with pytest.raises(ConfigError, match="nested too deeply"):
        load_text(text, "it")
