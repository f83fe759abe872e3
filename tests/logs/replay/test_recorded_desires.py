"""Desires of a log had again: at their times, with their ids, but for those of the program's own modules."""

from __future__ import annotations

import logging

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, WorkspaceChange
from app.base import paths
from app.logs.replay.recorded_desires import CountedIds, RecordedDesires
from app.messages import Desire, Desires
from app.program.config import load_configuration
from app.program.desire_classes import desire_classes
from tests.logs.replay.logs import BEGIN, desire

CLASSES = desire_classes(load_configuration(paths.config_dir() / "lab.yaml"))


class Setting:
    def __init__(self) -> None:
        self.now = BEGIN
        self.ids = CountedIds()
        self.workspace = IntentionWorkspace(CLASSES, lambda: self.now, new_id=self.ids)
        self.desires = RecordedDesires(
            self.workspace, self.ids, {"ScenarioCoordinator"}, lambda: self.now, ignored={"Record"}
        )
        self.changes: list[WorkspaceChange] = []
        self.workspace.observe(self.changes.append)

    def take(self, *records: Desire) -> None:
        self.desires.take(Desires(self.now, records))

    @property
    def ids_there(self) -> list[str]:
        return [standing.id for standing in self.workspace.desires()]


@pytest.fixture
def setting() -> Setting:
    return Setting()


def test_they_come_change_and_go_as_they_did(setting: Setting) -> None:
    eyes = desire("d-3", "Telepresence", params={"max_points": 5000})
    setting.take(eyes)
    (standing,) = setting.workspace.desires()
    assert (standing.id, standing.intensity, standing.source) == ("d-3", 6.0, Source("operator", "ada"))
    assert standing.params["max_points"] == 5000
    setting.take(replace(eyes, intensity=2.0), desire("d-4", "FindQRCodes", kind="rest", name="script"))
    assert [(d.id, d.intensity) for d in setting.workspace.desires()] == [("d-3", 2.0), ("d-4", 6.0)]
    setting.take(desire("d-4", "FindQRCodes", kind="rest", name="script"))
    assert setting.ids_there == ["d-4"]
    setting.desires.take(None)
    assert setting.ids_there == []
    assert len(setting.changes) == 4  # each record is one transaction


def test_motivations_that_run_here_and_recordings_are_left_to_themselves(setting: Setting) -> None:
    setting.take(
        desire("d-1", "FindQRCodes", kind="motivation", name="ScenarioCoordinator"),
        desire("d-2", "FindQRCodes", kind="motivation", name="Explorer"),
        desire("d-3", "Record"),
    )
    assert setting.ids_there == ["d-2"]


def test_a_desire_with_an_end_ends_by_itself_and_may_be_prolonged(setting: Setting) -> None:
    mortal = desire("d-5", "FindQRCodes", expires=BEGIN + 2.0)
    setting.take(mortal)
    assert setting.workspace.next_expiry == BEGIN + 2.0
    setting.now += 1.0
    setting.take(replace(mortal, expires=BEGIN + 5.0))
    assert setting.workspace.next_expiry == BEGIN + 5.0
    setting.now = BEGIN + 5.0
    setting.workspace.expire()
    setting.take()
    assert setting.ids_there == []


def test_what_cannot_be_had_here_is_said_once(setting: Setting, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            setting.take(desire("d-6", "FlyAway"), desire("d-7", "FindQRCodes", params={"upscale": 7}))
    assert setting.ids_there == []
    assert len(caplog.records) == 2
    assert "FlyAway" in caplog.text
    # The ids that were meant for them are not taken by others.
    assert setting.workspace.add("FindQRCodes", intensity=1, utility=1, source=Source("operator", "me")).id != "d-7"


@given(st.lists(st.sets(st.integers(0, 5)), max_size=8))
def test_after_each_record_its_desires_stand_and_no_others(steps: list[set[int]]) -> None:
    setting = Setting()
    own = setting.workspace.add("Teleoperation", intensity=8, utility=1, source=Source("motivation", "Pilot")).id
    for standing in steps:
        setting.now += 1.0
        setting.take(*(desire(f"d-{n}", "FindQRCodes", created=BEGIN + n) for n in standing))
        assert set(setting.ids_there) == {own, *(f"d-{n}" for n in standing)}


def test_ids_are_the_same_in_every_run() -> None:
    one, other = CountedIds(), CountedIds()
    assert [one() for _ in range(5)] == [other() for _ in range(5)]
    assert len({one() for _ in range(100)}) == 100
