"""The experiment with a head that turns, in virtual time: figures of its guard, and a picture of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import pytest

from app.experiments.body.experiment import document, run
from app.experiments.body.report import plot, table
from app.experiments.simulated import simulated_program

# The loop is virtual, and its world is meant to hold it up.
pytestmark = pytest.mark.blocking(reason="the virtual loop waits for the world by design")

KEPT = ("Hokuyo", "WheelOdometry", "Teleop", "MobileBaseControl", "ScenarioCoordinator", "LookAt", "HeadControl")
PLAY = """
seconds: 4
stop: 2
cues:
  - {at: 0.5, class: LookAt, params: {x: -1, y: 2, z: 1.2, frame: base_link}}
"""


def test_the_guards_figures_of_a_head_that_is_stopped_while_it_turns(tmp_path: Path) -> None:
    program = simulated_program()
    modules = {name: spec for name, spec in program.configuration.program.modules.items() if name in KEPT}
    configuration = replace(
        program.configuration, program=program.configuration.program.model_copy(update={"modules": modules})
    )
    blind = {"kinect": None, "panorama": None, "microphones": None}
    body = program.body.model_copy(update={"streams": program.body.streams.model_copy(update=blind)})
    file = tmp_path / "play.yaml"
    file.write_text(PLAY, encoding="utf-8")
    parts: list[float] = []
    result = run(replace(program, configuration=configuration, body=body), file, parts.append, virtual=True)
    groups = {each["group"]: each for each in document(result)["groups"]}
    head = groups["head"]
    assert head["behaviors_s"]["LookAt"] > 1.0
    assert head["guard_s"]["moving"] > 1.0
    assert head["guard_s"]["holding"] > 1.5
    assert 0.8 < head["speed_of_limit"] < 1.1
    assert head["beyond_limit"] < 0.002
    assert 0.05 < head["rest_after_stop_s"] < 0.5
    assert groups["base"]["behaviors_s"] == {}
    assert parts[-1] == 1.0
    assert "| head | LookAt" in table(result)
    plot(result, tmp_path / "body.png")
    assert cv2.imread(str(tmp_path / "body.png")).shape[1] > 1000
