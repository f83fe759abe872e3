"""Numbers of a YAML file replaced; what is beside them stays."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.errors import ConfigError
from app.base.yaml_edit import replace_numbers, replaced
from app.base.yaml_source import load_text

TEXT = """# ü: an array
body_m: 0.17      # the torso
positions:
  - [0.1, -0.2, 3]   # left
  -
    - 1e-3
    - 5
    - .5
more: {positions: [[1, 2]], name: "x"}
"""


@given(st.lists(st.floats(-10, 10), min_size=4, max_size=4))
def test_only_the_numbers_change(values: list[float]) -> None:
    paths = [("positions", 0, 1), ("positions", 1, 2), ("more", "positions", 0, 0), ("body_m",)]
    numbers = {path: f"{value:.4f}" for path, value in zip(paths, values, strict=True)}
    after = replaced(TEXT, numbers, "x")
    first, second, third, body = (float(number) for number in numbers.values())
    assert load_text(after, "x").data == {
        "body_m": body,
        "positions": [[0.1, first, 3], [0.001, 5, second]],
        "more": {"positions": [[third, 2]], "name": "x"},
    }
    for number, old in zip(numbers.values(), ("-0.2", ".5", "[[1", "0.17"), strict=True):
        after = after.replace("[[" + number if old == "[[1" else number, old, 1)
    assert after.splitlines()[0] == TEXT.splitlines()[0]
    assert after.count("#") == TEXT.count("#")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a: [x]", "x:1: there is no number here to be replaced"),
        ("b: 1", "there is no number here to be replaced"),
        ("a: [true]", "there is no number here to be replaced"),
        ("a: [", "is not valid YAML"),
        ("", "there is no number here to be replaced"),
    ],
)
def test_what_has_no_such_number_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        replaced(text, {("a", 0): "2"}, "x")


def test_what_an_alias_would_change_elsewhere_is_refused() -> None:
    with pytest.raises(ConfigError, match="write each out"):
        replaced("a: [&n 1, *n]", {("a", 0): "2", ("a", 1): "3"}, "x")
    with pytest.raises(ConfigError, match="by hand"):
        replaced("a: &list [1]\nb: *list", {("a", 0): "2"}, "x")


def test_a_file_is_written_wholly_or_not_at_all(tmp_path: Path) -> None:
    file = tmp_path / "array.yaml"
    file.write_text(TEXT, encoding="utf-8")
    file.chmod(0o640)
    link = tmp_path / "link.yaml"
    link.symlink_to(file)
    replace_numbers(link, {("body_m",): "0.2000"})
    assert link.is_symlink()
    assert file.read_text(encoding="utf-8") == TEXT.replace("0.17", "0.2000")
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    with pytest.raises(ConfigError, match=r"link\.yaml:3: there is no number"):
        replace_numbers(link, {("body_m",): "0.3", ("positions",): "1"})
    assert "0.2000" in file.read_text(encoding="utf-8")
    (tmp_path / ".array.yaml.new").mkdir()
    with pytest.raises(ConfigError, match="cannot be written"):
        replace_numbers(file, {("body_m",): "0.3"})
    assert "0.2000" in file.read_text(encoding="utf-8")
    with pytest.raises(ConfigError, match="cannot be"):
        replace_numbers(tmp_path / "none.yaml", {("body_m",): "0.3"})
