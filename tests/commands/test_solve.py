"""``hbba solve``: answers for people and machines, mistakes in one sentence."""

from __future__ import annotations

import argparse
import io
import json
import re
from pathlib import Path
from typing import Any

import pytest

from app.attention.variants import Variants
from app.base import paths
from app.base.errors import ConfigError
from app.commands import solve
from app.console.rest.goal import INTENSITY, UTILITY
from tests.patience import PATIENCE_S

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLES = DOCS / "examples"


def hbba_solve(*arguments: str) -> int:
    """Run the command; a computer that is busy with other things has time enough, unless a limit is given."""
    parser = argparse.ArgumentParser()
    solve.add_parser(parser.add_subparsers())
    if not any(argument.startswith("--time-limit") for argument in arguments):
        arguments = (*arguments, "--time-limit", str(PATIENCE_S))
    return solve.run(parser.parse_args(["solve", *arguments]))


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert hbba_solve(*arguments, "--json") == 0
    return json.loads(capsys.readouterr().out)


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
        {"kind": "capacity", "utility": 8, "resource": "cpu", "amount": 10, "unit": "% of one core", "without": ""},
        {"kind": "without", "utility": 8, "resource": "", "amount": 0, "unit": "", "without": "GoTo"},
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


def test_the_format_documented_is_read_as_it_is_written(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    written = (DOCS / "solve.md").read_text().split("```yaml\n", 1)[1].split("```", 1)[0]
    monkeypatch.chdir(EXAMPLES)
    monkeypatch.setattr("sys.stdin", io.StringIO(written))
    assert names(answer(capsys, "-")) == ["find-qr-codes-1"], "Ω is that of fewer, and it is selected now"


def test_every_command_documented_answers(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(DOCS.parent)
    commands = re.findall(r"hbba solve (docs/\S+\.yaml)", (DOCS / "solve.md").read_text())
    assert "docs/examples/lab.yaml" in commands
    for file in commands:
        assert set(answer(capsys, file)["fulfilled"]) >= {"GoTo", "LocateFaces"}


FAMILY = """
resources: {cpu: {capacity: 100}}
families:
  - names: slam-{phi}
    class: SLAM
    phis: [1, 2]
    utility: {at_1: 8, per_doubling: 1}
    filters: {SLAM2D.scans: phi}
strategies: [{name: go, class: GoTo, utility: 8, %s}, {name: b, class: B, utility: 8}]
desires: [{class: %s, intensity: 1}]
"""


@pytest.mark.parametrize(
    ("requires", "desired", "selected"),
    [
        ("requires: {SLAM: 1}", "GoTo", ["go", "slam-1"]),
        ("requires: {}", "B", ["b"]),
        ("requires: {}", "SLAM", ["slam-1"]),
    ],
)
def test_families_serve_undesired_classes_too(
    requires: str,
    desired: str,
    selected: list[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(FAMILY % (requires, desired)))
    assert names(answer(capsys, "-")) == selected


def said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, problem: str, *more: str) -> str:
    monkeypatch.setattr("sys.stdin", io.StringIO(problem))
    assert hbba_solve("-", *more) == 0
    return capsys.readouterr().out


def test_unserved_and_unused_classes_are_reported_at_the_top(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "Nothing is desired: a problem says under `desires`" in said(capsys, monkeypatch, "")
    table = "strategies: [{name: a, class: Aaa, utility: 8}]\n"
    text = said(capsys, monkeypatch, table + "desires: [{class: Aab, intensity: 1}]")
    assert "\nNo strategy serves Aab (did you mean 'Aaa'?).\n" in text
    assert "unfulfilled: no strategy serves this class" in text
    text = said(capsys, monkeypatch, table + "desires: [{class: Nowhere, intensity: 1, security: true}]")
    assert "Security CANNOT be kept for Nowhere: no strategy serves them." in text


def test_names_do_not_steer_the_terminal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    problem = r"""
resources: {"c\u001bpu": {capacity: 10, unit: "\u0007"}}
strategies: [{name: "\u001b[31mred\u202e\n", class: "A\nB", utility: 1, costs: {"c\u001bpu": 1}}]
desires: [{class: "A\nB", intensity: 1, params: {"\u009b": "\u001b]0;x"}}]
"""
    text = said(capsys, monkeypatch, problem)
    assert all(character.isprintable() or character == "\n" for character in text)
    assert r"\x1b[31mred\u202e\n" in text
    assert r"fulfilled: A\nB" in text


def test_what_could_not_be_explained_in_time_is_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Each variant would take longer than there is time.
    monkeypatch.setattr("app.attention.variants.Variants._solved", cut_off)
    found = answer(capsys, str(EXAMPLES / "thesis-4.3.3.yaml"))
    assert found["unexplained"] == ["LocateFaces"]
    assert hbba_solve(str(EXAMPLES / "thesis-4.3.3.yaml")) == 0
    text = capsys.readouterr().out
    assert "There was no time to find all that would help LocateFaces; a greater --time-limit gives more." in text
    monkeypatch.undo()
    assert answer(capsys, str(EXAMPLES / "thesis-4.3.3.yaml"))["unexplained"] == []


def cut_off(variants: Variants, *_: object) -> None:
    variants.missing = True


def test_a_selection_is_printed_before_its_reasons_are_known(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("app.attention.reasons.explain", interrupted)
    with pytest.raises(KeyboardInterrupt):
        hbba_solve(str(EXAMPLES / "thesis-4.3.3.yaml"))
    assert "locate-faces-2" in capsys.readouterr().out


def test_a_file_that_takes_longer_to_read_than_there_is_time_is_given_up(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def read(path: str, most: int) -> None:
        while True:
            pass

    # What is imported by name in the meantime would keep the patched function: this one nobody imports from there.
    monkeypatch.setattr("app.base.yaml_source.read_plain", read)
    assert hbba_solve("endless.yaml", "--time-limit", "0.05") == 1
    assert capsys.readouterr().err == (
        "hbba solve: the time was over before endless.yaml was read; try a greater --time-limit\n"
    )


@pytest.mark.parametrize("limit", ["0", "-1", "nan", "inf", "1e9", "soon", ""])
def test_a_time_limit_that_cannot_be_is_refused_in_words(limit: str) -> None:
    with pytest.raises(ConfigError, match="must be a number of seconds greater than 0 and at most 86400, not"):
        hbba_solve("x.yaml", f"--time-limit={limit}")


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
        ("strategies:\n  - {name: a, class: A, utility: 1, costs: {c: -5}}\n", 2, "costs.c: should be greater than or"),
        (
            "strategies:\n  - {name: a, class: A, utility: 1, costs: {c: .nan}}\n",
            2,
            "costs.c: should be a finite",
        ),
        (
            "strategies:\n  - {name: a, class: A, utility: 1, costs: {c: lots}}\n",
            2,
            "costs.c: should be a valid",
        ),
        (
            "strategies:\n  - {name: a, class: A, utility: 1, costs: {c: {calibrated: 1}}}\n",
            2,
            "costs.c.calibrated: unknown key",
        ),
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
    with pytest.raises(ConfigError, match="No such file"):
        hbba_solve("nowhere.yaml")


def test_schema(capsys: pytest.CaptureFixture[str]) -> None:
    """The schema accepts the examples and refuses what the reader refuses."""
    jsonschema = pytest.importorskip("jsonschema")
    from app.base.yaml_source import load_text, load_yaml

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
    """Nor does the goal take all of another: the others get less."""
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
