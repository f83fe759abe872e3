from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.attention.desires import DesireClass, DesireClasses, Source
from app.attention.rule_book import RuleBook
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.messages import PERCEPT_KINDS, Localization, LoudNoise, PerceptEvent, Place, Places, RulesReport, Zone, Zones
from app.modules.motivations.whereabouts import Whereabouts, distance_outside_m
from app.modules.perception.percept_events import DEFAULTS
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain

MODULE = "app.modules.motivations.rules:Rules"
CLASSES = DesireClasses(DesireClass(name, name, "") for name in ("SLAM", "LocateFaces", "LocateVoices"))
PORTS: Mapping[str, type[Any]] = {
    "percept_events": PerceptEvent,
    "loud_noises": LoudNoise,
    "localization": Localization,
    "zones": Zones,
    "places": Places,
}
SLAM = "{name: map, while: always, then: [{desire: SLAM}]}"


class Play:
    """The module with a file of rules of its own."""

    def __init__(self, folder: Path, rules: str, ports: Mapping[str, type[Any]] = PORTS) -> None:
        self.file = folder / "rules.yaml"
        self.write(rules)
        self.workspace = IntentionWorkspace(CLASSES, lambda: self.bench.clock.now())
        self.timeline = Timeline(100, lambda: self.bench.clock.now())
        table = ChannelTable(
            {name: ChannelSpec.model_validate({"type": kind.__name__}) for name, kind in PORTS.items()}
        )
        services = {
            IntentionWorkspace: self.workspace,
            Timeline: self.timeline,
            RuleBook: RuleBook([self.file]),
            ChannelTable: table,
        }
        self.bench = Bench(MODULE, inputs=ports, outputs={"rules": RulesReport}, services=services)
        self.reports = self.bench.listen("rules")

    def write(self, rules: str) -> None:
        self.file.write_text(f"rules: [{rules}]", encoding="utf-8")
        # The clock of a disk may be coarse.
        self._written = getattr(self, "_written", 0) + 1
        os.utime(self.file, ns=(self._written, self._written))

    @property
    def report(self) -> RulesReport:
        """The newest."""
        return drain(self.reports)[-1]

    @property
    def classes(self) -> list[str]:
        return sorted(desire.cls for desire in self.workspace.desires())


def test_rules_desire_from_start_to_stop_and_say_what_they_did(tmp_path: Path) -> None:
    hear = "{name: hear, when: {channel: loud_noises}, then: [{desire: LocateVoices, ttl_s: 5}]}"
    play = Play(tmp_path, f"{SLAM}, {hear}")

    async def main() -> None:
        async with play.bench as bench:
            assert play.classes == ["SLAM"]
            await bench.clock.sleep(3)
            heard = bench.clock.now()
            bench.feed("loud_noises", LoudNoise(heard, 40.0, -20.0))
            await bench.settle()
            desire = play.workspace.strongest()["LocateVoices"]
            assert desire.source == Source(
                "motivation", "Tested", "hear", "loud_noises", applied=heard, motive="rational"
            )
            await bench.clock.sleep(0.3)
            rules = {rule.name: rule for rule in play.report.rules}
            assert (rules["hear"].fired, rules["hear"].last_fired) == (1, heard)
            assert rules["hear"].desires == (desire.id,)
            assert rules["map"].holds
            await bench.clock.sleep(10)
            play.workspace.expire()
            await bench.clock.sleep(0.3)
            assert {rule.name: rule.desires for rule in play.report.rules}["hear"] == ()
        assert play.classes == []

    run_virtual(main())


@pytest.mark.blocking(reason="the test writes the file")
def test_an_edit_is_in_force_within_a_second_and_a_broken_one_changes_nothing(tmp_path: Path) -> None:
    play = Play(tmp_path, SLAM)

    async def main() -> None:
        async with play.bench as bench:
            (slam,) = play.workspace.desires()
            play.write(f"{SLAM}, {{name: faces, while: always, then: [{{desire: LocateFace}}]}}")
            await bench.clock.sleep(1.5)
            assert play.workspace.desires() == (slam,)
            report = play.report
            assert "rules.yaml:1: then.desire: there is no desire class 'LocateFace'" in report.problem
            assert [rule.name for rule in report.rules] == ["map"]
            (event,) = play.timeline.query(kinds={"rule"})
            assert "The rules stay as they were" in event.text
            play.write(f"{SLAM}, {{name: faces, while: always, then: [{{desire: LocateFaces}}]}}")
            await bench.clock.sleep(1.5)
            assert play.classes == ["LocateFaces", "SLAM"]
            assert play.workspace.get(slam.id) == slam, "the rule that is as before keeps its desire"
            assert play.report.problem == ""
            play.file.unlink()
            await bench.clock.sleep(1.5)
            assert play.classes == ["LocateFaces", "SLAM"]
            assert "cannot be read" in play.report.problem
            assert len(play.timeline.query(kinds={"rule"})) == 3, "each is said once"

    run_virtual(main())


@pytest.mark.blocking(reason="the test writes the file")
def test_a_restart_doubles_nothing_and_a_broken_file_takes_nothing_away(tmp_path: Path) -> None:
    play = Play(tmp_path, SLAM)

    async def main() -> None:
        async with play.bench as bench:
            play.write("nonsense")
            await bench.clock.sleep(1.5)
            bench.feed("percept_events", "no event")  # makes it fail
            await bench.clock.sleep(5)
            assert bench.supervisor.states["Tested"].restarts == 1
            assert play.classes == ["SLAM"]
            assert "rules.yaml" in play.report.problem

    run_virtual(main())


def test_wrong_rules_are_refused_before_anything_starts_and_vain_ones_are_warned_of(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"rules\.yaml:1: .*no desire class 'SLAMM'"):
        Play(tmp_path, SLAM.replace("M}", "MM}"))
    when = "when: [{channel: loud_noises}, face.appears], if: {in_zone: a, at_place: b}"
    vain = f"{{name: vain, {when}, then: [{{desire: SLAM}}]}}"
    play = Play(tmp_path, vain, ports={"localization": Localization})
    texts = [caution.text for caution in play.bench.slot.module.cautions()]
    assert [
        next(word for word in ("loud_noises", "percepts", "zones", "places") if word in text) for text in texts
    ] == [
        "loud_noises",
        "percepts",
        "zones",
        "places",
    ]
    assert not Play(tmp_path, vain).bench.slot.module.cautions()


def test_rules_know_the_kinds_of_percepts_that_there_are() -> None:
    assert set(PERCEPT_KINDS) == set(DEFAULTS)


SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])


def test_the_robot_comes_into_zones_and_to_places(tmp_path: Path) -> None:
    rules = """{name: zone, while: {in_zone: kitchen}, then: [{desire: LocateFaces}]},
               {name: place, when: {event: place.reached, where: {subject: p-1}}, then: [{desire: LocateVoices}]},
               {name: gone, when: place.left, then: [{withdraw: LocateVoices}]}"""
    play = Play(tmp_path, rules)

    async def main() -> None:
        async with play.bench as bench:
            now = bench.clock.now()
            bench.feed("zones", Zones(now, (Zone("kitchen", "slow", SQUARE, 0.5),)))
            bench.feed("places", Places(now, (Place("p-1", "stove", 3.0, 3.0, 0.0),)))
            for x, y, state, classes in (
                (-1.0, 1.0, "tracking", []),
                (1.0, 1.0, "lost", []),
                (1.0, 1.0, "tracking", ["LocateFaces"]),
                (3.0, 2.6, "tracking", ["LocateFaces", "LocateVoices"]),
                (3.0, 2.3, "tracking", ["LocateFaces", "LocateVoices"]),
                (3.0, -0.05, "tracking", ["LocateFaces"]),
                (3.0, -0.2, "tracking", []),
            ):
                pose = Localization(
                    bench.clock.now(), Pose2(0, 0, 0), Pose2(x, y, 0), np.eye(3), state=state, overlap=1.0, map="lab"
                )
                bench.feed("localization", pose)
                await bench.clock.sleep(0.5)
                assert play.classes == classes, (x, y)

    run_virtual(main())


def test_a_border_is_crossed_for_good_or_not_at_all() -> None:
    assert distance_outside_m(SQUARE, 2.0, 2.0) == 0
    assert distance_outside_m(SQUARE, 7.0, 8.0) == pytest.approx(5.0)
    zones, where, crossed = (Zone("a", "slow", SQUARE, 1.0),), Whereabouts(), []
    for x in (-0.02, 0.02, -0.02, 0.02, -0.09, -0.2, -0.05, 0.01):
        where, events = where.moved(1.0, x, 2.0, zones, ())
        crossed += [event.name for event in events]
    assert crossed == ["zone.enters", "zone.leaves", "zone.enters"]
