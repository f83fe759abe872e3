"""Files of rules: what is refused, with file and line."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

import pytest
from pydantic import BaseModel, ConfigDict

from app.attention.desires import DesireClass, DesireClasses
from app.attention.rule_book import RuleBook, RuleTerms, load_rules, waited_for
from app.base.errors import ConfigError
from app.messages import BatteryState, LoudNoise, SoundSources, TimelineEvent


class Where(BaseModel):
    model_config = ConfigDict(extra="forbid")
    x: float
    name: Literal["here", "there"] = "here"


TERMS = RuleTerms(
    DesireClasses([DesireClass("GoTo", "Go to", "", Where), DesireClass("SLAM", "SLAM", "")]),
    {"battery": BatteryState, "loud_noises": LoudNoise, "sound_sources": SoundSources, "events": TimelineEvent},
    ("face", "dark"),
)
GOOD = """\
timezone: Europe/Paris
rules:
  - name: one
    when: [face.appears, zone.enters, start, {channel: events, where: {kind: accomplishment, data: {outcome: done}}}]
    if: {hours: "08:00-18:00", latest: {channel: battery, where: {charge: {above: 0.5}}}}
    then:
      - {desire: GoTo, params: {x: 3}}
  - name: two
    when: {channel: loud_noises}
    then: [{desire: SLAM, ttl_s: 5, renewed_by: {channel: sound_sources}}, {change: GoTo, rule: one, intensity: 3},
           {desire: Unknown, optional: true}, {desire: GoTo, params: {x: "{ratio}"}}]
"""


def written(folder: Path, text: str, name: str = "rules.yaml") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def test_rules_are_read_with_their_lines(tmp_path: Path) -> None:
    rules = load_rules([written(tmp_path, GOOD)], TERMS)
    assert [(rule.name, rule.file, rule.line, str(rule.zone)) for rule in rules] == [
        ("one", "rules.yaml", 3, "Europe/Paris"),
        ("two", "rules.yaml", 8, "Europe/Paris"),
    ]
    assert {channel for _, channel in waited_for(rules)} == {"events", "battery", "loud_noises", "sound_sources"}


@pytest.mark.parametrize(
    ("before", "after", "line", "message"),
    [
        ("face.appears", "fase.appears", 4, "there is no event 'fase.appears'; did you mean 'face.appears'"),
        ("face.appears", "face.appear", 4, "there is no event"),
        ("{kind: accomp", "{kimd: accomp", 4, "when.where.kimd: unknown field; did you mean 'kind'"),
        ("channel: battery", "channel: batery", 5, "there is no channel 'batery'; did you mean 'battery'"),
        ("charge: {above", "charg: {above", 5, "did you mean 'charge'"),
        ("above: 0.5", "above: lots", 5, "must be a number, not 'lots'"),
        ("desire: GoTo, params: {x: 3}", "desire: GoTwo", 7, "there is no desire class 'GoTwo'; did you mean 'GoTo'"),
        ("{x: 3}", "{x: far}", 7, "params.x"),
        ("{x: 3}", "{y: 3}", 7, "params.y"),
        ("{desire: GoTo, params: {x: 3}}", "{desire: GoTo}", 7, "params.x"),
        ("x: 3", 'x: "{confidence}"', 7, "{confidence}: zone.enters unknown field"),
        ("rule: one", "rule: on", 10, "there is no rule 'on'; did you mean 'one'"),
        ("{ratio}", "{loudness}", 11, "{loudness}: loud_noises unknown field"),
        ("name: two", "name: one", 8, "'one' is the name of another rule, in rules.yaml:3"),
        ("ttl_s: 5", "ttl: 5", 10, "unknown key"),
        ("Europe/Paris", "Europe/Atlantis", 1, "there is no such time zone"),
        ("rules:", "rules: {", 3, "is not valid YAML"),
    ],
)
def test_each_mistake_is_said_where_it_is(tmp_path: Path, before: str, after: str, line: int, message: str) -> None:
    assert before in GOOD
    file = written(tmp_path, GOOD.replace(before, after, 1))
    with pytest.raises(ConfigError) as mistake:
        load_rules([file], TERMS)
    assert message in str(mistake.value)
    assert (mistake.value.file, mistake.value.line) == (str(file), line)


def test_two_files_share_no_name_and_may_speak_of_each_other(tmp_path: Path) -> None:
    one = written(tmp_path, GOOD)
    other = written(tmp_path, "rules: [{name: x, when: start, then: [{withdraw: SLAM, rule: two}]}]", "more.yaml")
    assert [rule.name for rule in load_rules([other, one], TERMS)] == ["x", "one", "two"]
    other.write_text("rules: [{name: two, when: start, then: [{desire: SLAM}]}]")
    with pytest.raises(ConfigError, match=r"another rule, in rules\.yaml:8"):
        load_rules([one, other], TERMS)


def test_a_file_that_changes_vanishes_or_comes_back_is_noticed(tmp_path: Path) -> None:
    file = written(tmp_path, GOOD)
    book = RuleBook([file])
    assert len(book.load(TERMS)) == 2
    assert not book.changed()
    os.utime(file, ns=(1, 1))
    assert book.changed()
    file.unlink()
    assert book.changed()
    with pytest.raises(ConfigError, match="cannot be read"):
        book.load(TERMS)
    assert not book.changed(), "it was looked at, and said to be absent"
    written(tmp_path, GOOD)
    assert book.changed()
