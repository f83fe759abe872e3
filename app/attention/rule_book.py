"""The rules' files: read, checked against desire classes and channels, and read again when they change."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from zoneinfo import ZoneInfo

from app.attention.desires import DesireClasses, InvalidDesire
from app.attention.rule_engine import Rule
from app.attention.rule_model import PERCEPT_CHANGES, START, WHERE_EVENTS, Action, RuleConfig, RuleFile, Trigger
from app.attention.rule_values import InvalidTest, check_place, check_test, places_of
from app.base.errors import ConfigError
from app.base.yaml_source import Document, load_yaml, suggestion
from app.messages import PerceptEvent

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class RobotEvent:
    """What an event of the program's begin, of a zone or of a place has: ``subject``, the name of zone or place."""

    stamp: float
    name: str
    subject: str = ""


@dataclass(frozen=True, slots=True)
class RuleTerms:
    """What rules may speak of: the desire classes, the type of each channel, and the kinds of percepts."""

    classes: DesireClasses
    channels: Mapping[str, type[Any]]
    percepts: Collection[str]


#: The state of a file: when it was changed, its size and number. None: it cannot be read.
_Signature = tuple[int, int, int] | None


class RuleBook:
    """The files of rules of a program: a service of it.

    Not for use from several threads at a time; it reads files, so it belongs into one beside the loop once the program
    runs.
    """

    def __init__(self, files: Sequence[Path] = ()) -> None:
        self.files: Final = tuple(files)
        self._read: tuple[_Signature, ...] = ()

    def load(self, terms: RuleTerms) -> tuple[Rule, ...]:
        """The rules of all files, checked. Raises ConfigError with file and line."""
        self._read = self._signatures()
        return load_rules(self.files, terms)

    def changed(self) -> bool:
        """Whether a file is another one than when it was read last."""
        return self._signatures() != self._read

    def _signatures(self) -> tuple[_Signature, ...]:
        return tuple(_signature(file) for file in self.files)


def load_rules(files: Iterable[Path], terms: RuleTerms | None) -> tuple[Rule, ...]:
    """The rules of all ``files`` in their order; without ``terms`` only their form is checked. Raises ConfigError with
    file and line."""
    found: dict[str, Rule] = {}
    documents: list[tuple[Document, RuleFile]] = []
    for file in files:
        document = load_yaml(file)
        read = document.validate(RuleFile)
        documents.append((document, read))
        zone = None if read.timezone is None else ZoneInfo(read.timezone)
        for number, config in enumerate(read.rules):
            at: KeyPath = ("rules", number)
            if (before := found.get(config.name)) is not None:
                message = f"{config.name!r} is the name of another rule, in {before.file}:{before.line}"
                raise document.error(message, (*at, "name"))
            found[config.name] = Rule(config, file.name, document.line(at), zone)
    if terms is not None:
        for document, read in documents:
            for number, config in enumerate(read.rules):
                _Checker(document, ("rules", number), terms, found).check(config)
    return tuple(found.values())


def waited_for(rules: Iterable[Rule]) -> Iterator[tuple[Rule, str]]:
    """Each rule with each channel that it waits for or looks at, percept events and places not counted."""
    for rule in rules:
        for _, trigger in rule.config.triggers():
            if trigger.channel is not None:
                yield rule, trigger.channel
        for condition in rule.config.conditions():
            if condition.latest is not None:
                yield rule, condition.latest.channel


@dataclass(frozen=True, slots=True)
class _Checker:
    """Checks the words of one rule; every error has the line of the word."""

    document: Document
    at: KeyPath
    terms: RuleTerms
    rules: Collection[str]

    def check(self, config: RuleConfig) -> None:
        for path, trigger in config.triggers():
            self._trigger(path, trigger)
        for name, key in (("if", config.if_), ("while", config.while_)):
            for condition in () if key is None else key.parts():
                for kind in (*condition.present, *condition.absent):
                    self._known(kind, self.terms.percepts, "kind of percept", (name,))
                for cls in (*condition.desired, *condition.undesired):
                    self._known(cls, self.terms.classes, "desire class", (name,))
                if condition.latest is not None:
                    kind_of = self._channel(condition.latest.channel, (name, "latest", "channel"))
                    self._where(kind_of, condition.latest.where, (name, "latest", "where"))
        for number, action in enumerate(config.then):
            self._action(("then", number), action, config)

    def _trigger(self, path: KeyPath, trigger: Trigger) -> None:
        if trigger.channel is not None:
            kind = self._channel(trigger.channel, (*path, "channel"))
        else:
            name = trigger.event or ""
            percept, _, change = name.rpartition(".")
            kind = PerceptEvent
            if name == START or name in WHERE_EVENTS:
                kind = RobotEvent
            elif change not in PERCEPT_CHANGES or percept not in self.terms.percepts:
                known = [f"{each}.{change}" for each in self.terms.percepts for change in PERCEPT_CHANGES]
                self._known(name, [START, *WHERE_EVENTS, *known], "event", path)
        self._where(kind, trigger.where, (*path, "where"))

    def _where(self, kind: Any, where: Mapping[str, Any], path: KeyPath) -> None:
        try:
            check_test(kind, where)
        except InvalidTest as failure:
            raise self._error(failure.message, (*path, *failure.path)) from None

    def _channel(self, name: str, path: KeyPath) -> Any:
        self._known(name, self.terms.channels, "channel", path)
        return self.terms.channels[name]

    def _action(self, path: KeyPath, action: Action, config: RuleConfig) -> None:
        if action.rule is not None:
            self._known(action.rule, self.rules, "rule", (*path, "rule"))
        if action.cls not in self.terms.classes:
            if not action.optional:
                self._known(action.cls, self.terms.classes, "desire class", (*path, action.key))
            return
        if action.params is not None:
            self._params((*path, "params"), action, config)
        elif action.desire is not None:
            self._valid(path, action, {})

    def _params(self, path: KeyPath, action: Action, config: RuleConfig) -> None:
        params = action.params or {}
        taken = list(places_of(params))
        if not taken:
            self._valid(path, action, params)
            return
        if config.while_ is not None:
            raise self._error(f"{{{taken[0]}}}: a rule with `while` has no event whose fields it could take", path)
        model = self.terms.classes[action.cls].parameters
        if model.model_config.get("extra") != "allow":
            allowed = [info.alias or name for name, info in model.model_fields.items()]
            for key in params:
                self._known(key, allowed, f"parameter of {action.cls}", (*path, key))
        for dotted in taken:
            for trigger in config.when:
                kind = self.terms.channels[trigger.channel] if trigger.channel is not None else _type_of(trigger)
                try:
                    check_place(kind, dotted)
                except InvalidTest as failure:
                    raise self._error(f"{{{dotted}}}: {trigger.words} {failure.message}", path) from None

    def _valid(self, path: KeyPath, action: Action, params: Mapping[str, Any]) -> None:
        try:
            self.terms.classes[action.cls].validated(params)
        except InvalidDesire as failure:
            inside = failure.field.removeprefix("params.").split(".")[0]
            raise self._error(f"{failure.field}: {failure.message}", (*path, inside)) from None

    def _known(self, name: str, known: Iterable[str], what: str, path: KeyPath) -> None:
        names = list(known)
        if name not in names:
            raise self._error(f"there is no {what} {name!r}; {suggestion(name, names)}", path)

    def _error(self, message: str, path: KeyPath) -> ConfigError:
        key = (*self.at, *path)
        where = ".".join(str(part) for part in path if not isinstance(part, int))
        return self.document.error(f"{where}: {message}", key)


def _type_of(trigger: Trigger) -> type[Any]:
    own = trigger.event == START or trigger.event in WHERE_EVENTS
    return RobotEvent if own else PerceptEvent


def _signature(file: Path) -> _Signature:
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
