"""``hbba solve``: answers for people and machines, mistakes in one sentence."""

from __future__ import annotations

import argparse
import io
import json
import re
from pathlib import Path
from typing import Any

import pytest

from app import paths
from app.commands import solve
from app.console.rest.goal import INTENSITY, UTILITY
from app.errors import ConfigError

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLES = DOCS / "examples"


def hbba_solve(*arguments: str) -> int:
    parser = argparse.ArgumentParser()
    solve.add_parser(parser.add_subparsers())
    return solve.run(parser.parse_args(["solve", *arguments]))


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert hbba_solve(*arguments, "--json") == 0
    return json.loads(capsys.readouterr().out)  # type: ignore[no-any-return]


def names(found: dict[str, Any]) -> list[str]:
    return [strategy["name"] for strategy in found["strategies"]]


def test_first_thesis_example(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, str(EXAMPLES / "thesis-4.2.5.yaml"))
    assert names(found) == ["slam", "go-to"]
    assert (found["omega"], found["proven"], found["fulfilled"]) == (16, True, ["GoTo"])
    assert found["parameters"] == {"PlanAndFollowPath": {"x": 0, "y": 10, "theta": 0}}, "the more intense desire's"


def test_second_thesis_example(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, str(EXAMPLES / "thesis-4.3.3.yaml"))
    assert names(found) == ["slam", "go-to", "locate-faces-2"]
    assert found["omega"] == 28
    assert found["use"] == {"cpu": {"used": 80, "capacity": 100, "unit": "% of one core"}}
    assert found["filters"]["FaceDetector.images"] == 2
    reason = found["reasons"]["LocateFaces"]
    assert (reason["state"], reason["utility"], reason["best"]) == ("degraded", 4, 8)
    assert reason["alternatives"] == [
        {"kind": "capacity", "utility": 8, "resource": "cpu", "amount": 10, "unit": "% of one core"},
        {"kind": "without", "utility": 8, "without": "GoTo"},
    ]


def test_tour_guide_example_with_its_table_in_another_file(capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, str(EXAMPLES / "tour-guide.yaml"))
    assert found["omega"] == 82
    assert found["use"]["cpu"]["used"] == 98
    assert found["filters"]["PlanAndFollowPath.twist"] is None


def test_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba_solve(str(EXAMPLES / "thesis-4.3.3.yaml")) == 0
    text = capsys.readouterr().out
    documented = (DOCS / "solve.md").read_text().split("Ω = 28", 1)[1].split("…", 1)[0]
    for line in documented.splitlines()[1:]:
        assert line.strip() in text, "what the documentation shows is what is printed"
    assert "FaceDetector.images      φ 2" in text


def test_plain_terminals(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solve, "_speaks_unicode", lambda: False)
    hbba_solve(str(EXAMPLES / "tour-guide.yaml"))
    text = capsys.readouterr().out
    assert text.isascii()
    assert "####" in text


def test_standard_input_and_json(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    problem = {
        "strategies": [{"name": "a", "class": "A", "utility": 2, "filters": {"M.x": None}}],
        "desires": [{"class": "A", "intensity": 1}, {"class": "B", "intensity": 8, "security": True}],
    }
    monkeypatch.setattr("sys.stdin", io.StringIO(json.dumps(problem, indent="\t")))
    found = answer(capsys, "-")
    assert names(found) == ["a"]
    assert found["filters"] == {"M.x": None}
    assert found["relaxed"] == ["B"]
    monkeypatch.setattr("sys.stdin", io.StringIO(json.dumps(problem)))
    hbba_solve("-")
    assert "Security CANNOT be kept for B" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("desires:\n  - class: A\n    intensity: 9\n", 3, "less than or equal to 8, not 9"),
        ("desires:\n  - class: A\n    intensty: 2\n", 3, "did you mean 'intensity'"),
        ("desires:\n  - class: A\n    intensity: 0.0001\n", 3, "3 decimals"),
        ("strategies:\n  - {name: a, class: A, utility: 1, costs: {cpu: 1}}\n", 2, "unknown resource 'cpu'"),
        ("strategies:\n  - {name: a, class: A, utility: 1, requires: {B: 1}}\n", 2, "unknown class 'B'"),
        ("tables:\n  - nowhere.yaml\n", 2, "no file 'nowhere.yaml'"),
        ("selected: [x]\n", 1, "unknown strategy 'x'"),
        ("- 1\n", 1, "should be a mapping (name: value lines), not a list"),
        ("desires: [\n", 2, "not valid YAML"),
    ],
)
def test_mistakes(tmp_path: Path, text: str, line: int, words: str) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=re.escape(words)) as caught:
        hbba_solve(str(path))
    assert (caught.value.file, caught.value.line) == (str(path), line)


def test_arguments() -> None:
    with pytest.raises(ConfigError, match="name the file"):
        hbba_solve()
    with pytest.raises(ConfigError, match="greater than 0"):
        hbba_solve("x.yaml", "--time-limit", "0")
    with pytest.raises(ConfigError, match="No such file"):
        hbba_solve("nowhere.yaml")


def test_schema(capsys: pytest.CaptureFixture[str]) -> None:
    """The schema accepts the examples and refuses what the reader refuses."""
    jsonschema = pytest.importorskip("jsonschema")
    from app.yaml_source import load_text, load_yaml

    assert hbba_solve("--schema") == 0
    schema = json.loads(capsys.readouterr().out)
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)
    for path in sorted(EXAMPLES.glob("t*.yaml")):
        validator.validate(load_yaml(path).data)
    strategy = "strategies: [{name: a, class: A, utility: 1, filters: {M.x: %s}}]"
    for value, good in (("1", True), ("off", True), ("null", True), ("0", False), ("fast", False), ("1.5", False)):
        assert validator.is_valid(load_text(strategy % value, "x").data) is good
    assert not validator.is_valid({"desires": [{"class": "A", "intensity": 9}]})
    assert not validator.is_valid({"desire": []})


def test_a_sound_does_not_take_the_planner_from_peoples_goal_in_the_lab(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor does the goal take anybody's all: the others get less."""
    others = {"FindQRCodes": 8, "LocateFaces": 8, "DetectNoises": 8, "SLAM": 8, "Telepresence": 4, "LocateVoices": 8}
    desires = [{"class": cls, "intensity": intensity, "utility": 1} for cls, intensity in others.items()]
    goal = {"class": "GoTo", "intensity": INTENSITY, "utility": UTILITY, "params": {"x": 4, "y": -1}}
    table = str(paths.config_dir() / "strategies" / "lab.yaml")
    for wanted in (desires[:-1], desires):
        path = tmp_path / "way.json"
        path.write_text(json.dumps({"desires": [goal, *wanted], "tables": [table]}))
        found = answer(capsys, str(path))
        assert any(name.startswith("plan-and-") for name in names(found))
        assert set(found["fulfilled"]) == {"GoTo", *(desire["class"] for desire in wanted)}
