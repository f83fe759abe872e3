"""The program's own configuration goes by its name, from any folder."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from app import cli
from app.base import paths
from app.base.errors import ConfigError
from app.commands import doctor
from app.commands.packaged import Kind, config_file, config_names

CONFIG = paths.config_dir()


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """As from a wheel: the working folder holds no ``config/``."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("named", "kind", "file"),
    [
        ("jackal", "program", "jackal.yaml"),
        ("jackal.yaml", "program", "jackal.yaml"),
        ("config/jackal.yaml", "program", "jackal.yaml"),
        ("config/jackal", "program", "jackal.yaml"),
        ("./config/jackal.yaml", "program", "jackal.yaml"),
        ("webcam", "robot", "robots/webcam.yaml"),
        ("webcam.yaml", "robot", "robots/webcam.yaml"),
        ("robots/webcam.yaml", "robot", "robots/webcam.yaml"),
        ("config/robots/webcam.yaml", "robot", "robots/webcam.yaml"),
        ("walkers", "scenario", "scenarios/walkers.yaml"),
        ("irl1", "array", "arrays/irl1.yaml"),
        ("webcam", "configuration", "webcam.yaml"),
        ("robots/webcam", "configuration", "robots/webcam.yaml"),
        ("config/robots/jackal.urdf", "configuration", "robots/jackal.urdf"),
        ("walkers", "configuration", "scenarios/walkers.yaml"),
    ],
)
def test_a_name_and_a_path_of_the_documentation_are_found(named: str, kind: Kind, file: str) -> None:
    assert config_file(named, kind) == CONFIG / file


def test_a_file_of_ones_own_comes_first(elsewhere: Path) -> None:
    (elsewhere / "config").mkdir()
    (elsewhere / "config" / "jackal.yaml").touch()
    (elsewhere / "jackal").touch()
    assert config_file("config/jackal.yaml", "program") == Path("config/jackal.yaml")
    assert config_file("jackal", "program") == Path("jackal")
    assert config_file(Path("jackal.yaml"), "program") == CONFIG / "jackal.yaml"


def test_a_folder_of_that_name_is_no_configuration(elsewhere: Path) -> None:
    (elsewhere / "webcam").mkdir()
    assert config_file("webcam", "robot") == CONFIG / "robots" / "webcam.yaml"


def test_what_is_not_a_plain_file_can_be_read_too(elsewhere: Path) -> None:
    os.mkfifo(elsewhere / "mine")
    assert config_file("mine", "program") == Path("mine")


def test_the_names_are_those_of_the_files() -> None:
    assert config_names("program") == ["jackal", "lab", "serial_base", "stretch", "turtlebot4", "webcam"]
    assert config_names("robot") == [
        "irl1_holonomic",
        "irl1_tr",
        "jackal",
        "serial_base",
        "stretch",
        "turtlebot4",
        "webcam",
    ]
    assert {"lab", "robots/jackal", "scenarios/lab", "worlds/lab"} <= set(config_names("configuration"))
    for kind in ("program", "robot", "scenario", "array", "configuration"):
        for name in config_names(kind):
            assert config_file(name, kind).is_file()


@pytest.mark.parametrize(
    ("named", "kind", "message"),
    [
        (
            "jakcal",
            "program",
            "there is no program jakcal; did you mean 'jackal'? Allowed: a file, or one of: ",
        ),
        (
            "channels",
            "program",
            "there is no program channels; a file, or one of: jackal, lab, serial_base, stretch, turtlebot4, webcam",
        ),
        (
            "config/robots/webcan.yaml",
            "robot",
            "did you mean 'webcam'? Allowed: a file, or one of: irl1_holonomic, irl1_tr, jackal",
        ),
        ("/no/such/jackal.yaml", "program", "there is no program /no/such/jackal.yaml; did you mean 'jackal'?"),
        (".", "robot", "there is no robot ."),
    ],
)
def test_a_wrong_name_is_one_sentence_with_those_there_are(named: str, kind: Kind, message: str) -> None:
    with pytest.raises(ConfigError) as refused:
        config_file(named, kind, "--option")
    assert str(refused.value).startswith("--option: ")
    assert message in str(refused.value)
    assert ("those of a package are known once it is installed" in str(refused.value)) == (kind == "program")


@pytest.mark.parametrize(
    ("command", "code", "words"),
    [
        (["check", "jackal", "robots/webcam", "config/scenarios/lab.yaml"], 0, "(program)|program, no mistake found"),
        (["check", "jakcal"], 2, "there is no configuration jakcal; did you mean 'jackal'?"),
        (["run", "--robot", "webcan"], 2, "hbba run: --robot: there is no robot webcan; did you mean 'webcam'?"),
        (["run", "--config", "jakcal"], 2, "hbba run: --config: there is no program jakcal; did you mean 'jackal'?"),
        (
            ["run", "--scenario", "wlakers"],
            2,
            "--scenario: there is no scenario wlakers; did you mean 'walkers'? ",
        ),
        (["run", "--robot", "webcam", "--camera", "gone.mp4"], 2, "--camera: there is no file or folder gone.mp4"),
        (["run", "--robot", "config/robots/webcam.yaml", "--scenario", "lab"], 2, "is for the simulated world"),
        (["run", "--config", "jackal", "--camera", "0"], 2, "is for a body of devices"),
        (["calibrate", "--config", "jakcal", "gone.mcap"], 2, "hbba calibrate: --config: there is no program jakcal"),
        (["experiment", "barn", "--config", "jakcal"], 2, "--config: there is no program jakcal"),
        (["experiment", "goals", "--config", "jakcal"], 2, "--config: there is no program jakcal"),
        (["experiment", "trial", "--config", "jakcal"], 2, "--config: there is no program jakcal"),
        (["experiment", "overload", "--config", "jakcal"], 2, "--config: there is no program jakcal"),
        (["detect", "voices", __file__, "--array", "irl2"], 2, "--array: there is no array irl2; did you mean 'irl1'?"),
    ],
)
def test_every_command_takes_names(
    command: list[str], code: int, words: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HBBA_REFERENCE_DATA", "not-here")  # a name is checked before the data that are asked for
    assert cli.main(command) == code
    said = capsys.readouterr()
    assert any(word in said.out + said.err for word in words.split("|"))


def test_what_doctor_advises_works_in_any_folder() -> None:
    for finding in (doctor.cameras(), doctor.audio()):
        assert "--robot webcam;" in finding.remedy
