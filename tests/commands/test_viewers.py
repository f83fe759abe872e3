"""The option that serves viewers of others."""

from __future__ import annotations

import socket
from dataclasses import replace

import pytest

from app import cli
from app.base import paths
from app.commands import viewers
from app.commands.viewers import NAME, with_ros2, with_viewers
from app.program.config import Configuration, load_configuration
from app.program.system import System


@pytest.fixture(scope="module")
def lab() -> Configuration:
    return load_configuration(paths.config_dir() / "lab.yaml")


def test_no_viewers_change_nothing(lab: Configuration) -> None:
    assert with_viewers(lab, None) is lab


def test_the_server_takes_every_recorded_channel_and_wants_none(lab: Configuration) -> None:
    pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
    system = System(with_viewers(lab, 0))
    inputs = system.graph.modules[NAME].context.inputs
    recorded = {name for name, spec in lab.channels.items() if spec.log != "never"}
    assert set(inputs) <= recorded
    assert {"kinect", "scan", "map", "intention"} <= set(inputs)
    assert not inputs["kinect"].subscription.demands


def test_a_taken_port_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert cli.main(["run", "--foxglove", str(port), "--log-level", "error"]) == 2
    error = capsys.readouterr().err
    assert f"port {port} of 127.0.0.1 is taken" in error
    assert "--foxglove" in error


def test_without_the_package_the_remedy_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(viewers, "find_spec", lambda _: None)
    assert cli.main(["run", "--foxglove"]) == 2
    assert "pip install 'hbba[foxglove]'" in capsys.readouterr().err


@pytest.mark.parametrize("port", ["-1", "65536", "many"])
def test_a_port_is_a_number(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["run", f"--foxglove={port}"])
    assert "must be a whole number from 0 to 65535" in capsys.readouterr().err


def test_in_the_graph_of_ros_2_are_topics_and_where_it_is_asked_for_commands(
    lab: Configuration, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert with_ros2(lab, None) is lab
    monkeypatch.setattr(viewers, "find_spec", lambda _: None)
    assert cli.main(["run", "--ros2"]) == 2
    assert "pip install 'hbba[ros2]'" in capsys.readouterr().err
    monkeypatch.setattr(viewers, "find_spec", lambda _: object())
    for offered, commands in (("topics", False), ("commands", True)):
        program = with_ros2(lab, offered).program
        assert program.modules["Ros2Server"].settings["commands"] is commands
    spec = program.modules["Ros2Server"].model_copy(update={"settings": {"namespace": "robots/one", "commands": True}})
    named = replace(lab, program=program.model_copy(update={"modules": {**program.modules, "Ros2Server": spec}}))
    system = System(with_ros2(named, "topics"))
    module = system.graph.modules["Ros2Server"].module
    assert (module.settings.model_dump()["namespace"], module.cautions()) == ("robots/one", ())
    assert not system.graph.modules["Ros2Server"].context.inputs["kinect"].subscription.demands
