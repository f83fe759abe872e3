"""Rules without code: from events and conditions to what is desired (docs/rules.md). Pure: time and desires are given.

The engine decides; :class:`app.attention.rule_desires.RuleDesires` edits the Intention Workspace. A rule with ``when``
applies its actions at each event of it. A rule with ``while`` desires something from the moment its condition holds to
the moment it does not; a desire that others withdraw meanwhile does not come back before that.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime, tzinfo
from typing import Any, Final

from app.attention.rule_model import DAYS, START, Action, Condition, RuleConfig, Trigger
from app.attention.rule_values import NoValue, passes, resolved
from app.messages import Message, PerceptEvent, RuleReport

#: A desire is renewed so long (s) before its end that it does not lapse between two ticks of 0.25 s.
RENEW_AHEAD_S: Final = 0.5
#: Most firings of one rule in a second of its events: one whose desires are its own events would fire for ever.
MOST_PER_S: Final = 50


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule as it is in force: what its file says, where that is, and its time zone (None: the computer's)."""

    config: RuleConfig
    file: str = ""
    line: int = 0
    zone: tzinfo | None = None

    @property
    def name(self) -> str:
        """Its name; no two rules in force share one."""
        return self.config.name


@dataclass(frozen=True, slots=True)
class RuleEvent:
    """An event: a ``message`` on ``channel``, with the ``name`` it has for rules ("" for none) and its ``subject``."""

    stamp: float
    message: Any
    name: str = ""
    channel: str = ""
    subject: str = ""

    @property
    def words(self) -> str:
        """``face.appears 3``, or the channel's name."""
        return f"{self.name} {self.subject}".rstrip() if self.name else self.channel


@dataclass(frozen=True, slots=True)
class Cause:
    """Why something is desired: the rule, its event in words, and when (s, robot's clock)."""

    rule: str
    event: str
    stamp: float


@dataclass(frozen=True, slots=True)
class Key:
    """Whose desire it is: action number ``item`` of a rule."""

    rule: str
    item: int


@dataclass(frozen=True, slots=True)
class Post:
    """Desire what ``action`` says, with ``params`` resolved."""

    key: Key
    cause: Cause
    action: Action
    params: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Withdraw:
    """The desires of ``key`` end; ``cause`` is why."""

    key: Key
    cause: Cause


@dataclass(frozen=True, slots=True)
class Edit:
    """Change or withdraw, as ``action`` says, the desires of a class that rules added."""

    cause: Cause
    action: Action
    params: Mapping[str, Any] | None


Act = Post | Withdraw | Edit


@dataclass(slots=True)
class _Renewal:
    ends: float
    params: Mapping[str, Any]
    seen: bool = False


@dataclass(slots=True)
class _State:
    """What is remembered of a rule: ``holds`` of its condition, since when it ``differs`` from what is in force."""

    fired: int = 0
    last: Cause | None = None
    holds: bool = False
    differs: float | None = None
    problem: str = ""
    began: dict[int, bool] = field(default_factory=dict)
    renewals: dict[int, _Renewal] = field(default_factory=dict)
    second: float = -math.inf
    in_second: int = 0


@dataclass(slots=True)
class _World:
    """What is known of the world: percepts that are there, by kind; newest messages; zones and places of the robot."""

    present: dict[str, set[tuple[str, str]]] = field(default_factory=dict)
    latest: dict[str, Any] = field(default_factory=dict)
    zones: frozenset[str] = frozenset()
    places: frozenset[str] = frozenset()


class RuleEngine:
    """Decides what rules do. Every method takes the time ``now`` (s, robot's clock) and the classes ``desired`` now."""

    def __init__(self, rules: Iterable[Rule] = ()) -> None:
        self._rules: tuple[Rule, ...] = tuple(rules)
        self._states = {rule.name: _State() for rule in self._rules}
        self._world = _World()

    @property
    def rules(self) -> tuple[Rule, ...]:
        """The rules in force, in their order."""
        return self._rules

    def start(self, now: float, desired: Collection[str]) -> list[Act]:
        """The program begins."""
        return self._happen(RuleEvent(now, None, START), now, desired)

    def take(self, channel: str, message: Message, now: float, desired: Collection[str]) -> list[Act]:
        """A message came on ``channel``; a percept event also has its name."""
        self._world.latest[channel] = message
        event = RuleEvent(message.stamp, message, channel=channel)
        if isinstance(message, PerceptEvent):
            there = self._world.present.setdefault(message.kind, set())
            which = (message.source, message.subject)
            if message.name.endswith(".leaves"):
                # Another sensor may be the one that misses it.
                there.difference_update({each for each in there if each[1] == message.subject})
            else:
                there.add(which)
            event = RuleEvent(message.stamp, message, message.name, channel, message.subject)
        return self._happen(event, now, desired)

    def move(
        self,
        events: Iterable[RuleEvent],
        zones: frozenset[str],
        places: frozenset[str],
        now: float,
        desired: Collection[str],
    ) -> list[Act]:
        """The robot is in ``zones`` and at ``places`` now; ``events`` say what is new of that."""
        self._world.zones, self._world.places = zones, places
        return [act for event in events for act in self._happen(event, now, desired)]

    def tick(self, now: float, desired: Collection[str]) -> list[Act]:
        """Time goes on: renewals, conditions of time, delays. To be called four times a second."""
        acts: list[Act] = []
        for rule in self._rules:
            acts += self._renew(rule, now)
        return acts + self._hold(now, desired)

    def replace(self, rules: Iterable[Rule], now: float) -> list[Act]:
        """Other rules are in force. Those that are as before keep what they desire; of others it ends first."""
        before = {rule.name: rule for rule in self._rules}
        self._rules = tuple(rules)
        kept = {
            rule.name
            for rule in self._rules
            if rule.name in before and (rule.config, rule.zone) == (before[rule.name].config, before[rule.name].zone)
        }
        self._states = {rule.name: self._states[rule.name] if rule.name in kept else _State() for rule in self._rules}
        return [
            Withdraw(Key(rule.name, item), Cause(rule.name, "its file changed", now))
            for rule in before.values()
            if rule.name not in kept
            for item in range(len(rule.config.then))
        ]

    def failed(self, rule: str, problem: str) -> None:
        """An action of ``rule`` was refused: why, in words."""
        if rule in self._states:
            self._states[rule].problem = problem

    def reports(self, desires: Mapping[str, tuple[str, ...]]) -> tuple[RuleReport, ...]:
        """Each rule as it is; ``desires`` are the ids of those that it has in the workspace, by rule."""
        found = []
        for rule in self._rules:
            state = self._states[rule.name]
            found.append(
                RuleReport(
                    name=rule.name,
                    about=rule.config.about,
                    words=rule.config.words,
                    file=rule.file,
                    line=rule.line,
                    enabled=rule.config.enabled,
                    holds=state.holds if rule.config.while_ is not None else None,
                    fired=state.fired,
                    last_fired=None if state.last is None else state.last.stamp,
                    last_event="" if state.last is None else state.last.event,
                    desires=desires.get(rule.name, ()),
                    problem=state.problem,
                )
            )
        return tuple(found)

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _happen(self, event: RuleEvent, now: float, desired: Collection[str]) -> list[Act]:
        acts: list[Act] = []
        for rule in self._active():
            state = self._states[rule.name]
            for item, action in enumerate(rule.config.then):
                renewal = state.renewals.get(item)
                if renewal is not None and action.renewed_by is not None and _matches(action.renewed_by, event):
                    renewal.seen = True
            if self._comes(rule, event) and self._may_fire(rule, event, now, desired):
                acts += self._fire(rule, Cause(rule.name, event.words, now), event.message, now)
        return acts + self._hold(now, desired)

    def _active(self) -> Iterable[Rule]:
        return (rule for rule in self._rules if rule.config.enabled)

    def _comes(self, rule: Rule, event: RuleEvent) -> bool:
        came = False
        state = self._states[rule.name]
        for number, trigger in enumerate(rule.config.when):
            if not trigger.begins:
                came |= _matches(trigger, event)
            elif trigger.channel == event.channel:
                holds = passes(event.message, trigger.where)
                came |= holds and not state.began.get(number, False)
                state.began[number] = holds
        return came

    def _may_fire(self, rule: Rule, event: RuleEvent, now: float, desired: Collection[str]) -> bool:
        state, config = self._states[rule.name], rule.config
        if config.if_ is not None and not self._so(config.if_, now, desired, rule.zone):
            return False
        if config.every_s is not None and state.last is not None and now - state.last.stamp < config.every_s:
            return False
        if now - state.second >= 1.0:
            state.second, state.in_second = now, 0
        state.in_second += 1
        if state.in_second > MOST_PER_S:
            state.problem = f"{event.words} came more than {MOST_PER_S} times in a second; the others were left out"
            return False
        return True

    def _fire(self, rule: Rule, cause: Cause, message: Any, now: float) -> list[Act]:
        state = self._states[rule.name]
        state.fired += 1
        state.last, state.problem = cause, ""
        acts: list[Act] = []
        for item, action in enumerate(rule.config.then):
            try:
                params = None if action.params is None else resolved(action.params, message)
            except NoValue as failure:
                state.problem = f"{action.cls}: {failure}"
                continue
            if action.desire is None:
                acts.append(Edit(cause, action, params))
                continue
            acts.append(Post(Key(rule.name, item), cause, action, params or {}))
            if action.renewed_by is not None and action.ttl_s is not None:
                state.renewals[item] = _Renewal(now + action.ttl_s, params or {})
        return acts

    def _renew(self, rule: Rule, now: float) -> list[Act]:
        state = self._states[rule.name]
        acts: list[Act] = []
        for item, renewal in list(state.renewals.items()):
            action = rule.config.then[item]
            if now < renewal.ends - RENEW_AHEAD_S or action.ttl_s is None or action.renewed_by is None:
                continue
            if renewal.seen:
                state.renewals[item] = _Renewal(now + action.ttl_s, renewal.params)
                cause = Cause(rule.name, f"{action.renewed_by.words} since", now)
                acts.append(Post(Key(rule.name, item), cause, action, renewal.params))
            elif now >= renewal.ends:
                del state.renewals[item]
        return acts

    def _hold(self, now: float, desired: Collection[str]) -> list[Act]:
        acts: list[Act] = []
        for rule in self._active():
            config, state = rule.config, self._states[rule.name]
            if config.while_ is None:
                continue
            so = self._so(config.while_, now, desired, rule.zone)
            if so == state.holds:
                state.differs = None
                continue
            state.differs = now if state.differs is None else state.differs
            if now - state.differs < ((config.begin_after_s if so else config.end_after_s) or 0.0):
                continue
            state.holds, state.differs = so, None
            cause = Cause(rule.name, config.words if so else f"no longer {config.words}", now)
            if so:
                acts += self._fire(rule, cause, None, now)
            else:
                acts += [Withdraw(Key(rule.name, item), cause) for item in range(len(config.then))]
        return acts

    def _so(self, condition: Condition, now: float, desired: Collection[str], zone: tzinfo | None) -> bool:
        world = self._world
        checks = (
            (condition.present, lambda name: bool(world.present.get(name))),
            (condition.desired, lambda name: name in desired),
            (condition.in_zone, lambda name: name in world.zones),
            (condition.at_place, lambda name: name in world.places),
        )
        if any(names and not any(map(holds, names)) for names, holds in checks):
            return False
        if any(world.present.get(name) for name in condition.absent):
            return False
        if any(name in desired for name in condition.undesired):
            return False
        if not _in_time(condition, now, zone):
            return False
        latest = condition.latest
        if latest is not None and not (
            latest.channel in world.latest and passes(world.latest[latest.channel], latest.where)
        ):
            return False
        return (
            all(self._so(each, now, desired, zone) for each in condition.all)
            and (not condition.any or any(self._so(each, now, desired, zone) for each in condition.any))
            and not any(self._so(each, now, desired, zone) for each in condition.none)
        )


def _matches(trigger: Trigger, event: RuleEvent) -> bool:
    if trigger.event is not None:
        return trigger.event == event.name and passes(event.message, trigger.where)
    return trigger.channel == event.channel and passes(event.message, trigger.where)


def _in_time(condition: Condition, now: float, zone: tzinfo | None) -> bool:
    """Whether ``now`` is within the hours and days of ``condition``; after midnight, hours are of the day before."""
    minutes = condition.minutes
    if minutes is None and not condition.days:
        return True
    local = datetime.fromtimestamp(now, zone)
    day, minute = local.weekday(), local.hour * 60 + local.minute
    if minutes is not None:
        begin, end = minutes
        if begin <= end:
            within = begin <= minute < end
        else:
            within = minute >= begin or minute < end
            day = (day - 1) % 7 if minute < end else day
        if not within:
            return False
    return not condition.days or DAYS[day] in condition.days
