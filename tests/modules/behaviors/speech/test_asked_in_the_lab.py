"""A question in the simulated lab: the robot asks, a person answers, and the desire ends with the word."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from app.attention.desires import Source
from app.base import paths
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import DesireReport, HeardWords
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.speech.config import EspeakConfig
from tests.modules.behaviors.speech.test_heard_in_the_lab import Babble

MODULES = ("Microphones", "WheelOdometry", "Loudspeaker", "Say", "WordRecognizer", "Ask")
#: A visitor before the robot, who answers when the question of 2 s has been asked, and again for when the robot asks
#: again: espeak-ng never says a word twice alike, and one of ten is not recognized for sure.
SCENARIO = """
name: an answer
start: {x: 11.3, y: 1.3, heading_deg: 90}
people:
  - name: visitor
    face: visitor
    at: [11.0, 2.8]
    heading_deg: -80
    shirt: [74, 92, 132]
    trousers: [60, 56, 50]
    repeat: false
    script:
      - {wait: 6.0, look: robot}
      - {say: "kitchen .", look: robot}
      - {wait: 6.0, look: robot}
      - {say: "kitchen .", look: robot}
      - {wait: 6.0, look: robot}
      - {say: "kitchen .", look: robot}
      - {wait: 600, look: robot}
"""


@pytest.mark.slow
def test_a_question_is_answered_by_a_person(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("pocketsphinx")
    pytest.importorskip("espeakng_loader")
    monkeypatch.setattr(EspeakConfig, "make", lambda _: Babble())
    (tmp_path / "answer.yaml").write_text(SCENARIO)
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    modules = {name: spec for name, spec in configuration.program.modules.items() if name in MODULES}
    configuration = replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)

    async def script(run: WorldRun) -> tuple[DesireReport, list[HeardWords]]:
        heard: list[HeardWords] = []
        run.system.graph.channels["heard_words"].observe(heard.append)
        workspace, clock = run.system.workspace, run.system.clock
        params = {"question": "Which room?", "words": "kitchen, library, workshop", "wait_s": 10}
        asked = workspace.add("Ask", intensity=8, utility=1, params=params, source=Source("rest", "test")).id
        while workspace.report(asked).outcome is None:
            await clock.sleep(0.1)
        return workspace.report(asked), heard

    scenario = body.model_copy(update={"scenario": tmp_path / "answer.yaml"})
    report, heard = run_in_world(configuration, scenario, script, microphones=True)
    assert (report.outcome, report.reason) == ("done", "kitchen"), heard
    assert [words.text for words in heard if not words.unsure] == ["kitchen"]
    assert {words.likeliest for words in heard} == {"kitchen"}
    x, y, _ = heard[-1].direction
    # 1.5 m ahead and 0.3 m to the left.
    assert math.degrees(math.atan2(y, x)) == pytest.approx(11.3, abs=6)
