"""YAML with lines: the schema's scalars, lines of keys, and what a person reads when something is wrong."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field

from app.base import paths, yaml_source
from app.base.errors import ConfigError
from app.base.yaml_source import dotted, load_text, load_yaml, parse


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


@pytest.mark.parametrize(
    "text", ["[" * 100_000, "- " * 100_000 + "1", "{a: " * 1_500 + "1" + "}" * 1_500, "[" * 100_000 + "#\t"]
)
def test_what_is_nested_too_deeply_is_refused_and_ends_nothing(text: str) -> None:
    with pytest.raises(ConfigError, match="nested too deeply: values lie at most 64 deep"):
        load_text(text, "it")


def test_as_deep_as_may_be_is_read() -> None:
    data = load_text("[" * 64 + "]" * 64, "it").data
    for _ in range(63):
        (data,) = data
    assert data == []


BOMBS = {
    "lists": ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    + [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 12)],
    "mappings": ["a0: &a0 {k: x}"] + [f"a{i}: &a{i} {{l: *a{i - 1}, r: *a{i - 1}}}" for i in range(1, 40)],
    "merged": ["a0: &a0 {k: x}"] + [f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}, *a{i - 1}]}}" for i in range(1, 30)],
    "nested": ["&a0 x"] + [f"[&a{i} [*a{i - 1}, *a{i - 1}]]" for i in range(1, 50)],
}


@pytest.mark.parametrize("kind", BOMBS)
def test_a_few_bytes_of_aliases_do_not_become_a_mountain(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [f"- {line}" if kind == "nested" else line for line in BOMBS[kind]]

    def never(*_: object) -> None:
        raise AssertionError("something was made of it")

    monkeypatch.setattr(yaml_source, "_loaded", never)
    with pytest.raises(ConfigError, match=r"500,000 names and values .* alias \(\*name\) stands for counts") as refusal:
        load_text("\n".join(lines), "it")
    assert 1 < refusal.value.line <= len(lines)


def test_aliases_within_reason_are_read() -> None:
    lines = [*BOMBS["mappings"][:12], "desires: [*a11, *a11]"]
    found = load_text("\n".join(lines), "it").data["desires"][1]
    for side in "lrlrlrlrlrl":
        found = found[side]
    assert found == {"k": "x"}


def test_a_text_of_too_many_values_is_refused_before_anything_is_made_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(yaml_source, "_loaded", None)
    with pytest.raises(ConfigError, match="it:2: has more than 500,000 names and values"):
        load_text("a: 1\nb: [" + "x," * 500_000 + "]\n", "it")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.yaml"
    with path.open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(ConfigError, match="more than 10 MB, the most that is read"):
        load_yaml(path)
    with pytest.raises(ConfigError, match="more than 10 MB"):
        load_text("#" * 10_000_001, "it")


def test_a_pipe_in_a_files_place_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "map.yaml")
    with pytest.raises(ConfigError, match="cannot be read: is a pipe, no regular file"):
        load_yaml(tmp_path / "map.yaml")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a: 1\nrobot: " + "9" * 5_000, 2),
        ("- -0x" + "f" * 5_000, 1),
        ("a: 1\n? " + "9" * 5_000 + "\n: x", 2),
        ('{"a":\n\t' + "9" * 5_000 + "}", 2),
    ],
)
def test_a_number_of_thousands_of_digits_is_refused(text: str, line: int) -> None:
    with pytest.raises(ConfigError, match=r"a number has 500\d digits; at most 250 are read") as refusal:
        load_text(text, "it")
    assert refusal.value.line == line


def test_a_number_of_hundreds_of_digits_becomes_what_it_says() -> None:
    assert load_text("a: " + "9" * 250, "it").data == {"a": 10**250 - 1}
    with pytest.raises(ConfigError, match="radius"):
        load_text("radius: -0x" + "f" * 247, "it").validate(Wheel)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: !!int abc", "what is tagged !!int is none"),
        ("a: !!bool abc", "what is tagged !!bool is none"),
        ("a: !!float abc", "what is tagged !!float is none"),
        ("a: !!int [1]", "what is tagged !!int is none"),
        ("!!int a: 1", "what is tagged !!int is none"),
        ("a: !!timestamp 2026-01-02", "constructor for the tag 'tag:yaml.org,2002:timestamp'"),
        ("a: !!timestamp abc", "constructor for the tag 'tag:yaml.org,2002:timestamp'"),
        ("a: !!binary abc", "constructor for the tag 'tag:yaml.org,2002:binary'"),
        ("a: !!set {b, c}", "constructor for the tag 'tag:yaml.org,2002:set'"),
        ("a: !!python/object/apply:os.system [ls]", "constructor for the tag 'tag:yaml.org,2002:python/object"),
    ],
)
def test_a_tag_that_is_none_of_the_schema_is_refused(text: str, words: str) -> None:
    with pytest.raises(ConfigError, match="is not valid YAML") as refusal:
        load_text(text, "it")
    assert words in refusal.value.message
    assert refusal.value.line == 1
