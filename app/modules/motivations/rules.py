"""Rules: the motivation whose desires are written as rules, without code (docs/rules.md).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Rules  in   ...     any message: each channel that rules wait for or look at             │
    │        out  rules   RulesReport, when a rule applies and when files change               │
    │        edits desires in the Intention Workspace                                          │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Its rules are those of the program's ``rules``. Percept events, the pose, zones and places are known by their types. No
input wants its channel: no perception is kept awake for its events. The files are looked at once a second; an edit that
is right is in force at once, one that is not leaves the rules in force as they are, and the report and the timeline say
so.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from app.attention.rule_book import RuleBook, RuleTerms, waited_for
from app.attention.rule_desires import RuleDesires
from app.attention.rule_engine import Act, Rule, RuleEngine, RuleEvent
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.errors import ConfigError
from app.messages import PERCEPT_KINDS, Localization, Message, PerceptEvent, PerceptKind, Places, RulesReport, Zones
from app.modules.motivations.motivation import Motivation
from app.modules.motivations.whereabouts import Whereabouts
from app.runtime.channel_table import ChannelTable
from app.runtime.module import Caution, ModuleContext, Settings

#: Messages of a channel that may wait.
_CAPACITY = 64
_BEAT_S = 0.25
#: Files are looked at every so many beats.
_LOOK_BEATS = 4
#: Kept over restarts: the rules in force, and why their files are not.
_IN_FORCE = "in_force"


class RulesSettings(Settings):
    """Settings of Rules: none but the program's ``rules``."""


class Rules(Motivation):
    title = "Rules"
    Settings = RulesSettings
    settings: RulesSettings

    _workspace: IntentionWorkspace
    _timeline: Timeline
    _desires: RuleDesires

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.report = self.output("rules", RulesReport)
        self.every(_BEAT_S, self._beat)
        self._engine = RuleEngine()
        self._problem = ""
        self._loaded: tuple[Rule, ...] = ()
        self._beats = 0
        self._published: tuple[object, ...] = ()
        self._pose: Localization | None = None
        self._zones: Zones | None = None
        self._places: Places | None = None
        self._where = Whereabouts()

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Take any message."""
        port = self.input(name, message_type, capacity=_CAPACITY, wants="never")
        self.on(port, partial(self._take, name))

    def check_wiring(self) -> None:
        """Read the rules. Raises ConfigError with file and line. A graph without a program has none to check."""
        if RuleBook in self._context.services:
            self._loaded = self.service(RuleBook).load(self._terms())

    def cautions(self) -> tuple[Caution, ...]:
        """Channels that rules wait for in vain."""
        ports = self._context.inputs.values()
        wired = {port.channel.name for port in ports if port.channel is not None}
        types = {port.message_type for port in ports}
        found = []
        for rule, channel in waited_for(self._loaded):
            if channel not in wired:
                text = f"the rule {rule.name!r} waits for {channel}, which is no input of {self.name}"
                found.append(Caution("A rule waits in vain", f"{text}: name it under inputs"))
        named = [trigger.event or "" for rule in self._loaded for _, trigger in rule.config.triggers()]
        conditions = [condition for rule in self._loaded for condition in rule.config.conditions()]
        percepts = any(condition.present or condition.absent for condition in conditions) or any(
            name.endswith((".appears", ".leaves", ".changes")) and not name.startswith("zone.") for name in named
        )
        for needed, kind, what in (
            (percepts, PerceptEvent, "percepts"),
            (any(n.startswith("zone.") for n in named) or any(c.in_zone for c in conditions), Zones, "zones"),
            (any(n.startswith("place.") for n in named) or any(c.at_place for c in conditions), Places, "places"),
        ):
            if needed and kind not in types:
                text = f"rules speak of {what}, and no input of {self.name} is a channel of type {kind.__name__}"
                found.append(Caution("A rule waits in vain", text))
        return tuple(found)

    async def start(self) -> None:
        """Put the rules in force."""
        self._workspace = self.service(IntentionWorkspace)
        self._timeline = self.service(Timeline)
        self._desires = RuleDesires(self._workspace, self.source)
        if not self._loaded:  # an instance after a restart: the rules in force stay, whatever their files are by now
            self._loaded, self._problem = self.persistent.get(_IN_FORCE, ((), ""))
        if not self._loaded:
            await self._reload()
        self._keep()
        self._engine = RuleEngine(self._loaded)
        self._apply(self._engine.start(self.clock.now(), self._desired()))

    async def stop(self) -> None:
        """Withdraw what rules desire."""
        if hasattr(self, "_desires"):
            self._desires.clear()

    def _terms(self) -> RuleTerms:
        table = self.service(ChannelTable)
        types = {name: spec.message_type for name, spec in table.items()}
        declared = (getattr(kind, "percept_kind", None) for kind in types.values())
        kinds = {*PERCEPT_KINDS, *(kind.name for kind in declared if isinstance(kind, PerceptKind))}
        return RuleTerms(self.service(IntentionWorkspace).classes, types, sorted(kinds))

    def _take(self, port: str, message: Message) -> None:
        match message:
            case Localization():
                self._pose = message
            case Zones():
                self._zones = message
            case Places():
                self._places = message
        channel = self._context.inputs[port].channel
        assert channel is not None, "a message came by it"
        self._apply(self._engine.take(channel.name, message, self.clock.now(), self._desired()))

    async def _beat(self) -> None:
        self._beats += 1
        if self._beats % _LOOK_BEATS == 0 and await self.compute(self.service(RuleBook).changed):
            await self._reload()
        now = self.clock.now()
        acts = self._moved(now)
        acts += self._engine.tick(now, self._desired())
        self._apply(acts)
        self._publish()

    def _moved(self, now: float) -> list[Act]:
        if self._pose is None or self._pose.state == "lost":
            return []
        pose, self._pose = self._pose, None
        zones = () if self._zones is None else self._zones.zones
        places = () if self._places is None else self._places.places
        self._where, events = self._where.moved(pose.stamp, pose.X_MB.x, pose.X_MB.y, zones, places)
        names = {place.id: place.name for place in places}
        at = self._where.places | {names[each] for each in self._where.places}
        happened = [RuleEvent(each.stamp, each, each.name, subject=each.subject) for each in events]
        return self._engine.move(happened, self._where.zones, at, now, self._desired())

    async def _reload(self) -> None:
        try:
            rules = await self.compute(self.service(RuleBook).load, self._terms())
        except ConfigError as mistake:
            self._problem = str(mistake)
            self._keep()
            self.log.error("the rules stay as they were: %s", mistake)
            self._timeline.add("rule", "rules", f"The rules stay as they were: {mistake}", {"problem": str(mistake)})
            return
        self._loaded, self._problem = rules, ""
        self._keep()
        self._timeline.add("rule", "rules", f"{len(rules)} rules are in force, read again", {"problem": ""})
        with self._workspace.transaction():
            self._apply(self._engine.replace(rules, self.clock.now()))
            self._apply(self._engine.tick(self.clock.now(), self._desired()))

    def _keep(self) -> None:
        self.persistent[_IN_FORCE] = self._loaded, self._problem

    def _apply(self, acts: Iterable[Act]) -> None:
        acts = list(acts)
        if not acts:
            return
        for rule, problem in self._desires.apply(acts):
            self._engine.failed(rule, problem)
            self._timeline.add("rule", rule, f"Rule {rule!r} was not followed: {problem}", {"problem": problem})

    def _desired(self) -> frozenset[str]:
        return frozenset(cls for cls, desire in self._workspace.strongest().items() if desire.utility > 0)

    def _publish(self) -> None:
        rules = self._engine.reports(self._desires.by_rule())
        if (rules, self._problem) != self._published:
            self._published = (rules, self._problem)
            files = tuple(file.name for file in self.service(RuleBook).files)
            self.report.publish(RulesReport(self.clock.now(), rules, files, self._problem))
