"""Rules in an Intention Workspace, without a loop: time is a number."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from itertools import count
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from app.attention.desires import DesireClass, DesireClasses, Source
from app.attention.rule_book import RobotEvent
from app.attention.rule_desires import RuleDesires
from app.attention.rule_engine import MOST_PER_S, Rule, RuleEngine, RuleEvent
from app.attention.rule_model import RuleFile
from app.attention.workspace import IntentionWorkspace
from app.messages import BatteryState, LoudNoise, Message, PerceptEvent


class Text(BaseModel):
    text: str = ""


CLASSES = DesireClasses(
    [
        DesireClass("Say", "Say", "", Text, achievement=True),
        *(DesireClass(name, name, "") for name in ("LocateFaces", "LocateVoices", "SLAM")),
    ]
)


class Play:
    """An engine with rules, and the workspace that its acts edit."""

    def __init__(self, rules: str) -> None:
        self.now = 1000.0
        numbers = count(1)
        self.workspace = IntentionWorkspace(CLASSES, lambda: self.now, new_id=lambda: f"d-{next(numbers)}")
        self.desires = RuleDesires(self.workspace, Source("motivation", "Rules", motive="rational"))
        self.engine = RuleEngine(made(rules))
        self.refused = self.desires.apply(self.engine.start(self.now, self.desired))

    @property
    def desired(self) -> set[str]:
        return {cls for cls, desire in self.workspace.strongest().items() if desire.utility > 0}

    def take(self, channel: str, message: Message) -> None:
        self.refused += self.desires.apply(self.engine.take(channel, message, self.now, self.desired))

    def face(self, change: str = "appears", subject: str = "7", kind: str = "face") -> None:
        name = f"{kind}.{change}"
        self.take("percept_events", PerceptEvent(self.now, name, kind, subject, "kinect", self.now, 0.9, None, None))

    def noise(self) -> None:
        self.take("loud_noises", LoudNoise(self.now, 40.0, -20.0))

    def battery(self, charge: float) -> None:
        self.take("battery", BatteryState(self.now, charge, 24.0, -1.0, charging=False, remaining_s=None))

    def wait(self, seconds: float) -> None:
        """Beats of 0.25 s, desires expiring as the translator makes them."""
        for _ in range(round(seconds / 0.25)):
            self.now += 0.25
            self.workspace.expire()
            self.refused += self.desires.apply(self.engine.tick(self.now, self.desired))

    def classes(self) -> list[str]:
        return sorted(desire.cls for desire in self.workspace.desires())

    def report(self, rule: str = "one") -> Any:
        return next(r for r in self.engine.reports(self.desires.by_rule()) if r.name == rule)


def made(text: str) -> tuple[Rule, ...]:
    read = RuleFile.model_validate({"rules": yaml.safe_load(text)})
    return tuple(Rule(config, "rules.yaml", 1, UTC) for config in read.rules)


def test_an_event_adds_a_desire_that_says_why_it_is_here() -> None:
    play = Play(
        "[{name: one, when: face.appears, then: [{desire: Say, intensity: 3, params: {text: 'Hello {subject}'}}]}]"
    )
    play.face("leaves")
    assert play.classes() == []
    play.wait(1)
    play.face()
    (desire,) = play.workspace.desires()
    assert (desire.cls, desire.intensity, desire.params) == ("Say", 3, {"text": "Hello 7"})
    assert desire.source == Source(
        "motivation", "Rules", rule="one", event="face.appears 7", applied=1001.0, motive="rational"
    )
    report = play.report()
    assert (report.fired, report.last_fired, report.last_event) == (1, 1001.0, "face.appears 7")
    assert report.desires == (desire.id,)
    assert report.words == "when face.appears"


def test_the_event_again_renews_keeps_or_adds_as_the_rule_says() -> None:
    for again, ids, texts in (("renew", 1, ["8"]), ("keep", 1, ["7"]), ("add", 2, ["7", "8"])):
        then = f"{{desire: Say, again: {again}, params: {{text: '{{subject}}'}}}}"
        play = Play(f"[{{name: one, when: face.appears, then: [{then}]}}]")
        play.face()
        play.face(subject="8")
        assert len(play.workspace.desires()) == ids
        assert [desire.params["text"] for desire in play.workspace.desires()] == texts
    for number in range(40):
        play.face(subject=str(number))
        play.wait(1)
    assert len(play.workspace.desires()) == 20, "one rule cannot fill the workspace"
    assert any("there already" in problem for _, problem in play.refused)


def test_conditions_of_state_and_time_hold_an_event_back() -> None:
    play = Play("""
    - name: one
      when: [face.appears, {channel: loud_noises, where: {ratio: {above: 30}}}]
      if: {undesired: LocateVoices, present: dark, hours: "22:00-06:00", days: [fri], latest: {channel: battery,
           where: {charge: {above: 0.5}}}, none: [{desired: SLAM}]}
      then: [{desire: LocateVoices, ttl_s: 1}]
    """)
    fridays_night = datetime(2026, 11, 27, 23, 30, tzinfo=UTC).timestamp()

    def light() -> None:
        play.now = fridays_night
        play.face("leaves", kind="dark")

    steps: tuple[tuple[str, Callable[[], None], int], ...] = (
        ("no battery", lambda: play.face(kind="dark"), 0),
        ("battery low", lambda: play.battery(0.2), 0),
        ("by day", lambda: play.battery(0.9), 0),
        ("all", lambda: setattr(play, "now", fridays_night), 1),
        ("after midnight it is still Friday's night", lambda: setattr(play, "now", fridays_night + 6 * 3600), 2),
        ("that is over", lambda: setattr(play, "now", fridays_night + 7 * 3600), 2),
        ("light", light, 2),
    )
    for what, prepare, fired in steps:
        prepare()
        play.wait(1)
        play.noise()
        assert play.report().fired == fired, what
    play.face(kind="dark")
    play.workspace.add("SLAM", intensity=1, utility=1, source=Source("operator", "ann"))
    play.noise()
    assert play.report().fired == 2, "what must not be is"
    assert "22:00-06:00 and fri and latest battery and neither (desired SLAM)" in play.report().words


def test_a_state_among_messages_counts_as_it_begins_and_not_again() -> None:
    play = Play("""
    - name: one
      when: {channel: battery, where: {charge: {below: 0.3}}, begins: true}
      then: [{desire: Say, again: add}]
    """)
    for charge in (0.5, 0.29, 0.28, 0.27, 0.31, 0.2):
        play.battery(charge)
    assert play.report().fired == 2


def test_events_in_a_row_count_once_in_a_while_and_never_without_end() -> None:
    play = Play("""
    - {name: one, when: face.appears, every_s: 10, then: [{desire: SLAM}]}
    - {name: two, when: face.appears, then: [{desire: SLAM}]}
    """)
    for _ in range(20):
        play.face()
        play.wait(1)
    assert play.report().fired == 2
    for _ in range(2 * MOST_PER_S):
        play.face()
    assert play.report("two").fired == 20 + MOST_PER_S
    assert "more than 50 times in a second" in play.report("two").problem


def test_a_desire_lasts_while_its_condition_holds() -> None:
    play = Play("""
    - {name: one, while: {present: dark}, begin_after_s: 1, end_after_s: 2, then: [{desire: LocateFaces, utility: 0}]}
    """)
    play.face(kind="dark", subject="kinect")
    assert play.classes() == [], "it may be a moment"
    play.wait(1)
    (desire,) = play.workspace.desires()
    assert (desire.utility, desire.source.event) == (0, "while present dark")
    play.face("leaves", kind="dark", subject="kinect")
    play.wait(1.5)
    play.face(kind="dark", subject="kinect")
    play.wait(5)
    assert play.classes() == ["LocateFaces"], "the light went on for a moment"
    assert play.report().holds
    play.workspace.remove(desire.id)
    play.wait(5)
    assert play.classes() == [], "people withdrew it: it comes with the next darkness"
    play.face("leaves", kind="dark", subject="kinect")
    play.wait(3)
    play.face(kind="dark", subject="kinect")
    play.wait(3)
    assert play.classes() == ["LocateFaces"]
    assert play.report().fired == 2


def test_desires_of_rules_are_changed_and_withdrawn_and_those_of_others_are_not() -> None:
    play = Play("""
    - {name: always, while: always, then: [{desire: SLAM, intensity: 2}]}
    - {name: more, when: face.appears, then: [{change: SLAM, intensity: 7, rule: always}]}
    - {name: less, when: face.leaves, then: [{withdraw: SLAM}]}
    """)
    others = play.workspace.add("SLAM", intensity=1, utility=1, source=Source("operator", "ann"))
    assert play.workspace.desires()[0].source.event == "always"
    play.face()
    assert [desire.intensity for desire in play.workspace.desires()] == [7, 1]
    play.face("leaves")
    assert play.workspace.desires() == (others,)


def test_a_value_that_the_event_has_not_is_said_and_nothing_is_desired() -> None:
    play = Play("[{name: one, when: face.appears, then: [{desire: Say, params: {text: '{heading}'}}, {desire: SLAM}]}]")
    play.face()
    assert play.classes() == ["SLAM"]
    assert play.report().problem == "Say: the event has no heading"


def test_zones_and_places_are_events_and_conditions() -> None:
    play = Play("""
    - {name: one, when: {event: zone.enters, where: {subject: kitchen}}, then: [{desire: SLAM}]}
    - {name: two, while: {in_zone: kitchen, at_place: [door, stove]}, then: [{desire: LocateFaces}]}
    """)
    for zone in ("hall", "kitchen"):
        event = RuleEvent(1.0, RobotEvent(1.0, "zone.enters", zone), "zone.enters", subject=zone)
        play.desires.apply(play.engine.move([event], frozenset({zone}), frozenset(), play.now, ()))
    assert play.classes() == ["SLAM"]
    play.desires.apply(play.engine.move([], frozenset({"kitchen"}), frozenset({"stove"}), play.now, ()))
    play.wait(0.25)
    assert play.classes() == ["LocateFaces", "SLAM"]


def test_other_rules_keep_what_is_as_before_and_end_what_is_not() -> None:
    one = "{name: one, while: always, then: [{desire: SLAM}]}"
    play = Play(f"[{one}, {{name: two, while: always, then: [{{desire: LocateFaces}}]}}]")
    before = {desire.cls: desire.id for desire in play.workspace.desires()}
    play.desires.apply(
        play.engine.replace(made(f"[{{name: two, while: always, then: [{{desire: LocateVoices}}]}}, {one}]"), play.now)
    )
    play.wait(0.25)
    after = {desire.cls: desire.id for desire in play.workspace.desires()}
    assert set(after) == {"SLAM", "LocateVoices"}
    assert after["SLAM"] == before["SLAM"]
    play.desires.clear()
    assert play.classes() == []


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        ("{then: [{desire: A}]}", "a `when` or a `while`"),
        ("{when: start, while: always, then: [{desire: A}]}", "a `when` or a `while`"),
        ("{when: start, begin_after_s: 1, then: [{desire: A}]}", "`begin_after_s` is of rules with `while`"),
        ("{while: always, if: {present: face}, then: [{desire: A}]}", "`if` is of rules with `when`"),
        ("{while: always, then: [{desire: A, ttl_s: 3}]}", "without ttl_s"),
        ("{while: always, then: [{withdraw: A}]}", "desires alone"),
        ("{when: start, then: [{desire: A, change: B}]}", "one of `desire`, `change` and `withdraw`"),
        ("{when: start, then: [{withdraw: A, intensity: 3}]}", "takes no `intensity`; allowed: rule"),
        ("{when: start, then: [{change: A}]}", "says what changes"),
        ("{when: start, then: [{desire: A, renewed_by: face.appears}]}", "needs a `ttl_s`"),
        ("{when: {event: start, channel: x}, then: [{desire: A}]}", "by one of them alone"),
        ("{when: {channel: x, begins: true}, then: [{desire: A}]}", "that begins to hold"),
        ("{while: {hours: '8-9'}, then: [{desire: A}]}", "two times of day"),
    ],
)
def test_a_rule_that_makes_no_sense_is_refused(rule: str, message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        made(f"[{{name: one, {rule[1:]}]")


@given(st.lists(st.sampled_from(["face", "leaves", "noise", "wait", "remove", "rules", "battery"]), max_size=25))
def test_whatever_happens_what_is_desired_is_known_and_all_of_it_can_be_withdrawn(steps: list[str]) -> None:
    rules = """
    - {name: one, while: {present: face}, end_after_s: 1, then: [{desire: LocateFaces}, {desire: SLAM}]}
    - {name: two, when: {channel: loud_noises}, then: [{desire: LocateVoices, ttl_s: 1, renewed_by: face.appears}]}
    - {name: three, when: face.leaves, then: [{desire: Say, again: add}, {withdraw: SLAM}]}
    """
    play = Play(rules)
    for step in steps:
        match step:
            case "face":
                play.face()
            case "leaves":
                play.face("leaves")
            case "noise":
                play.noise()
            case "battery":
                play.battery(0.5)
            case "wait":
                play.wait(1)
            case "rules":
                play.desires.apply(play.engine.replace(made(rules)[1:] + made(rules)[:1], play.now))
            case _ if play.workspace.desires():
                play.workspace.remove(play.workspace.desires()[0].id)
        known = sorted(each for ids in play.desires.by_rule().values() for each in ids)
        assert known == sorted(desire.id for desire in play.workspace.desires())
        classes = [cls for cls in play.classes() if cls != "Say"]
        assert len(classes) == len(set(classes)), "one action has one desire"
    play.desires.clear()
    assert play.workspace.desires() == ()
