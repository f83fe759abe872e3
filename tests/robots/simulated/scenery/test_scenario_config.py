"""Scenarios: what cannot be is refused with file, line and key; what the project ships is in order."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import soundfile

from app.base import paths
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.robots.simulated.scenery.scenario_config import load_scenario
from app.robots.simulated.scenery.scenario_state import ScenarioState

PERSON = "people:\n  - name: person 1\n    face: pilot\n    at: [1, 2]\n"


def load(folder: Path, text: str) -> ConfigError:
    file = folder / "scenario.yaml"
    file.write_text(f"name: test\n{text}", encoding="utf-8")
    with pytest.raises(ConfigError) as refused:
        load_scenario(file)
    assert refused.value.file == str(file)
    return refused.value


@pytest.mark.parametrize("name", ["lab", "trial"])
def test_what_the_project_ships_is_right(name: str) -> None:
    scenario = load_scenario(paths.config_dir() / "scenarios" / f"{name}.yaml")
    assert len(scenario.people) == 3
    assert len({person.face for person in scenario.people}) == 3


@pytest.mark.parametrize(
    ("text", "line", "key", "words"),
    [
        (PERSON.replace("pilot", "pilott"), 4, "people[0].face", "did you mean 'pilot'"),
        (PERSON + "    script: [{walk: [1, 1], say: hello}]", 6, "people[0].script[0]", "walk and say"),
        (PERSON + "    script: [{follow: 5, wait: 2}]", 6, "people[0].script[0]", "wait and follow"),
        (PERSON + "    script: [{walk: [3, 2], lag: 2}]", 6, "people[0].script[0]", "of following alone"),
        (PERSON + "    script: [{follow: 5, distance: 0.2}]", 6, "people[0].script[0].distance", "0.6"),
        (PERSON + "    script: [{speed: 1.0}]", 6, "people[0].script[0]", "exactly one of walk"),
        (PERSON + "    script:\n      - {wait: 1}\n      - {wait: -1}", 8, "people[0].script[1].wait", "greater"),
        (PERSON + "    script:\n      - {wait: 1, look: sideways}", 7, "people[0].script[0].look", "'robot'"),
        (PERSON + "    script: [{say: hello}]", 3, "people[0]", "over in an instant"),
        (PERSON + "    script: [{walk: [3, 2]}, {say: hello}]", 3, "people[0]", "over in an instant"),
        (PERSON + "    script: [{wait_for_robot: [3, 2]}, {say: hi}, {wait: 0.1}]", 3, "people[0]", "0.5 s at least"),
        (PERSON + "    hight_m: 1.7", 6, "people[0].hight_m", "did you mean 'height_m'"),
        (PERSON + PERSON.removeprefix("people:\n"), 1, "", "two people are called 'person 1'"),
        ("sounds:\n  - {name: a, kind: door, clip: door}", 3, "sounds[0]", "a place ('at') or a person"),
        ("sounds:\n  - {name: a, kind: door, clip: door, person: nobody}", 1, "", "'nobody'"),
        ("sounds:\n  - {name: a, kind: bang, clip: door, at: [0, 0, 1]}", 3, "sounds[0].kind", "'clap'"),
        ("sounds:\n  - {name: a, kind: door, clip: slam.wav, at: [0, 0, 1]}", 3, "sounds[0].clip", "no sound file"),
        ("sounds:\n  - {name: a, kind: door, clip: dor, at: [0, 0, 1]}", 3, "sounds[0].clip", "no sound 'dor'"),
        (
            "sounds:\n  - {name: a, kind: door, clip: door, at: [0, 0, 1], every_s: 2, jitter_s: 3}",
            3, "sounds[0]", "longer than every_s",
        ),
        ("drive:\n  - {go: [1, 1], pause: 2}", 3, "drive[0]", "go and pause"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_its_line(tmp_path: Path, text: str, line: int, key: str, words: str) -> None:
    error = load(tmp_path, text)
    assert (error.line, error.key) == (line, key)
    assert words in error.message


@pytest.mark.parametrize(
    "script",
    [
        "[{say: hello}, {wait: 2}]",
        "[{clap: 1}]",
        "[{follow: 5}]",
        "[{walk: [3, 2]}, {say: hello}, {walk: [1, 2]}]",
        "[{wait_for_robot: [3, 2]}, {say: hello}], repeat: false",
    ],
)
def test_a_script_that_takes_time_may_be_repeated(tmp_path: Path, script: str) -> None:
    file = tmp_path / "scenario.yaml"
    person = f"{{name: person 1, face: pilot, at: [1, 2], script: {script}}}"
    file.write_text(f"name: test\npeople: [{person}]", encoding="utf-8")
    assert load_scenario(file).people


def record(file: Path, seconds: float) -> None:
    soundfile.write(file, np.zeros(round(seconds * 8000), np.int16), 8000)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "holds no sound"), (None, "cannot be read"), (120.5, "lasts 120.5 s; 120 s are the most without a loop")],
)
def test_sound_files_that_would_not_be_heard_whole_are_refused_with_their_line(
    tmp_path: Path, seconds: float | None, words: str
) -> None:
    if seconds is None:
        (tmp_path / "long.wav").write_text("no sound")
    else:
        record(tmp_path / "long.wav", seconds)
    error = load(tmp_path, "sounds:\n  - {name: a, kind: music, clip: long.wav, at: [0, 0, 1]}")
    assert (error.line, error.key) == (3, "sounds[0].clip")
    assert words in error.message
    error = load(tmp_path, PERSON + "    script:\n      - {wait: 1}\n      - {say: long.wav}")
    assert (error.line, error.key) == (8, "people[0].script[1].say")
    assert words in error.message


def test_a_long_file_may_loop_and_one_of_two_minutes_is_kept_to_its_end(tmp_path: Path) -> None:
    record(tmp_path / "long.wav", 130)
    record(tmp_path / "fits.wav", 120)
    file = tmp_path / "scenario.yaml"
    file.write_text(
        "name: test\nsounds:\n  - {name: a, kind: music, clip: long.wav, at: [0, 0, 1], loop: true}\n"
        "  - {name: b, kind: music, clip: fits.wav, at: [0, 0, 1]}\n"
    )
    scenario_state = ScenarioState(load_scenario(file))
    scenario_state.advance(120.3, Pose2())  # with the sound's own way
    assert [cue.name for cue in scenario_state.cues] == ["a", "b"]
    scenario_state.advance(122.0, Pose2())
    assert [cue.name for cue in scenario_state.cues] == ["a"]


def test_sound_files_are_found_beside_the_scenario(tmp_path: Path) -> None:
    record(tmp_path / "hoot.wav", 0.5)
    file = tmp_path / "scenario.yaml"
    file.write_text(
        f"name: test\n{PERSON}    script: [{{say: hoot.wav}}, {{wait: 1}}, {{say: hello}}]\n"
        "sounds: [{name: owl, kind: noise, clip: hoot.wav, person: person 1}]\n"
    )
    scenario = load_scenario(file)
    assert scenario.sounds[0].clip == str(tmp_path / "hoot.wav")
    assert [step.say for step in scenario.people[0].script] == [str(tmp_path / "hoot.wav"), None, "hello"]
