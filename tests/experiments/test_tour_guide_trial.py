"""The trial in virtual time: driven to its end, independent of real time, recorded without a gap."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from app.experiments.simulated import simulated_program
from app.experiments.tour_guide_trial import run
from app.logs.open import open_log

# The loop is virtual, and its drawing and hearing are meant to hold it up.
pytestmark = pytest.mark.blocking(reason="the virtual loop waits for threads by design")

SCENARIO = {
    "name": "a turn",
    "start": {"x": 11.3, "y": 1.3, "heading_deg": 90},
    "drive": [{"face": 80, "label": "aside"}],
}
KEPT = ("Hokuyo", "WheelOdometry", "Teleop", "MobileBaseControl", "ScenarioCoordinator", "Recorder")


def test_a_trial_in_virtual_time_is_recorded_at_the_rates_of_its_sensors(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HBBA_RECORDINGS", str(tmp_path))
    scenario = tmp_path / "turn.yaml"
    scenario.write_text(yaml.safe_dump(SCENARIO), encoding="utf-8")
    program = simulated_program(scenario=scenario)
    modules = {name: spec for name, spec in program.configuration.program.modules.items() if name in KEPT}
    configuration = replace(
        program.configuration, program=program.configuration.program.model_copy(update={"modules": modules})
    )
    blind = {"kinect": None, "panorama": None, "microphones": None}
    body = program.body.model_copy(update={"streams": program.body.streams.model_copy(update=blind)})
    legs: list[str] = []
    outcome, events = run(
        replace(program, configuration=configuration, body=body),
        "turn",
        lambda number, of, label: legs.append(label),
        virtual=True,
    )
    assert legs == ["aside"]
    assert 0.3 < outcome.seconds < 5
    assert outcome.world_rate == 1.0
    assert outcome.missed == 0
    assert any("Teleoperation" in event.text for event in events)
    log = open_log(tmp_path / "turn.mcap")
    try:
        channels = log.info.channels
        assert channels["scan"].count == pytest.approx(40 * log.info.duration_s, abs=3)
        assert channels["odometry"].count == pytest.approx(100 * log.info.duration_s, abs=3)
        assert log.info.duration_s >= outcome.seconds - 0.1
    finally:
        log.close()
