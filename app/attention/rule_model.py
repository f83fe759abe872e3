"""The language of rules, as files have it (docs/rules.md): events, conditions, and what is then desired."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final, Literal, Self
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from app.attention.desires import SCALE

#: The event of a program that begins, of a zone and of a place; all others are of percepts.
START: Final = "start"
WHERE_EVENTS: Final = ("zone.enters", "zone.leaves", "place.reached", "place.left")
#: The condition that always holds, in files and in words.
ALWAYS: Final = "always"
PERCEPT_CHANGES: Final = ("appears", "leaves", "changes")
_HOURS = re.compile(r"([01]\d|2[0-3]):([0-5]\d)-([01]\d|2[0-3]):([0-5]\d)")
DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
Day = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]
Seconds = Annotated[float, Field(gt=0, le=1e7)]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)


class Trigger(_Model):
    """An event: one by its name, or a message on a channel; of either, those that pass ``where``."""

    event: str | None = Field(None, description="face.appears, zone.enters, start …")
    channel: str | None = Field(None, description="a channel that is an input of the module")
    where: dict[str, Any] = Field(default_factory=dict, description="tests on its fields")
    begins: bool = Field(False, description="of a channel: only as `where` begins to hold, not with each message")

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.event is None) == (self.channel is None):
            raise ValueError("an event is named by `event` or by `channel`, and by one of them alone")
        if self.begins and (self.channel is None or not self.where):
            raise ValueError("`begins` is of a channel, with the `where` that begins to hold")
        return self

    @property
    def words(self) -> str:
        """The event as people read it."""
        return self.event or f"{self.channel}"


def _trigger(value: Any) -> Any:
    return {"event": value} if isinstance(value, str) else value


def _listed(value: Any) -> Any:
    return [_trigger(each) for each in value] if isinstance(value, list) else [_trigger(value)]


OneTrigger = Annotated[Trigger, BeforeValidator(_trigger)]
Triggers = Annotated[tuple[Trigger, ...], BeforeValidator(_listed)]


class Latest(_Model):
    """The newest message of a channel passes ``where``."""

    channel: str
    where: dict[str, Any] = Field(min_length=1)


def _names(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Names = Annotated[tuple[str, ...], BeforeValidator(_names)]


class Condition(_Model):
    """What is so now: every member must hold; a list of names is one of them."""

    present: Names = Field((), description="kinds of percepts of which one is there: face, dark …")
    absent: Names = Field((), description="kinds of percepts of which none is there")
    desired: Names = Field((), description="desire classes of which one is desired")
    undesired: Names = Field((), description="desire classes of which none is desired")
    in_zone: Names = Field((), description="names of zones of the map that the robot may be in")
    at_place: Names = Field((), description="ids or names of places of the map that the robot may be at")
    hours: str | None = Field(None, description="time of day, as 08:00-18:30; it may pass midnight")
    days: tuple[Day, ...] = Field((), description="days of the week: mon … sun")
    latest: Latest | None = Field(None, description="of a channel")
    all: tuple[Condition, ...] = ()
    any: tuple[Condition, ...] = ()
    none: tuple[Condition, ...] = ()

    @field_validator("hours")
    @classmethod
    def _times(cls, value: str | None) -> str | None:
        if value is not None and not _HOURS.fullmatch(value):
            raise ValueError("should be two times of day, as 08:00-18:30")
        return value

    @property
    def minutes(self) -> tuple[int, int] | None:
        """Begin and end of ``hours`` in minutes since midnight."""
        found = None if self.hours is None else _HOURS.fullmatch(self.hours)
        return None if found is None else (int(found[1]) * 60 + int(found[2]), int(found[3]) * 60 + int(found[4]))

    @property
    def words(self) -> str:
        """The condition as people read it."""
        said = [f"{name} {', '.join(names)}" for name in _LISTS if (names := getattr(self, name))]
        said += [self.hours] if self.hours else []
        said += [", ".join(self.days)] if self.days else []
        said += [f"latest {self.latest.channel}"] if self.latest else []
        for name, word in (("all", " and "), ("any", " or "), ("none", " nor ")):
            if parts := getattr(self, name):
                joined = f"({word.join(each.words for each in parts)})"
                said.append(f"neither {joined}" if name == "none" else joined)
        return " and ".join(said) or ALWAYS

    def parts(self) -> tuple[Condition, ...]:
        """It, and all conditions within it."""
        inside = (*self.all, *self.any, *self.none)
        return (self, *(part for each in inside for part in each.parts()))


_LISTS = ("present", "absent", "desired", "undesired", "in_zone", "at_place")


class Action(_Model):
    """What follows: a ``desire`` is added, or the rules' desires of a class are changed or withdrawn."""

    desire: str | None = Field(None, description="a desire of this class is added")
    change: str | None = Field(None, description="desires of this class that rules added are changed")
    withdraw: str | None = Field(None, description="desires of this class that rules added are withdrawn")
    rule: str | None = Field(None, description="of change and withdraw: only those of this rule")
    intensity: float | None = Field(None, gt=0, le=SCALE)
    utility: float | None = Field(None, ge=0, le=SCALE, description="desired utility; 0 inhibits the class")
    security: bool | None = Field(None, description="must be fulfilled")
    params: dict[str, Any] | None = Field(None, description="as the class declares them; {field} takes the event's")
    ttl_s: Seconds | None = Field(None, description="the desire expires after so long")
    renewed_by: OneTrigger | None = Field(None, description="shortly before it expires: for ttl_s more, if this came")
    again: Literal["renew", "keep", "add"] = Field("renew", description="the desire is there, and the event comes")
    optional: bool = Field(False, description="left out where the program has no such class")

    @model_validator(mode="after")
    def _one(self) -> Self:
        named = [name for name in ("desire", "change", "withdraw") if getattr(self, name) is not None]
        if len(named) != 1:
            raise ValueError("one of `desire`, `change` and `withdraw` says what follows")
        given = self.model_fields_set - {named[0], "optional"}
        if wrong := sorted(given - _TAKES[named[0]]):
            raise ValueError(f"`{named[0]}` takes no `{wrong[0]}`; allowed: {', '.join(sorted(_TAKES[named[0]]))}")
        if named[0] == "change" and not given - {"rule"}:
            raise ValueError("`change` says what changes: intensity, utility, security, params or ttl_s")
        if self.renewed_by is not None and self.ttl_s is None:
            raise ValueError("`renewed_by` needs a `ttl_s`")
        return self

    @property
    def cls(self) -> str:
        """The desire class it is about."""
        return self.desire or self.change or self.withdraw or ""

    @property
    def key(self) -> str:
        """The name of the key that holds the class."""
        return "desire" if self.desire is not None else "change" if self.change is not None else "withdraw"


_VALUES = {"intensity", "utility", "security", "params", "ttl_s"}
_TAKES = {"desire": _VALUES | {"renewed_by", "again"}, "change": _VALUES | {"rule"}, "withdraw": {"rule"}}


def _condition(value: Any) -> Any:
    return {} if value == ALWAYS else value


class RuleConfig(_Model):
    """One rule: ``when`` an event comes, or ``while`` a condition holds, something is desired."""

    name: str = Field(min_length=1, max_length=80)
    about: str = Field("", max_length=400, description="what it is for, in words")
    when: Triggers = Field((), description="an event, or several of which one is enough")
    if_: Condition | None = Field(None, alias="if", description="of when: what must be so")
    every_s: Seconds | None = Field(None, description="of when: at most once in so long")
    while_: Annotated[Condition, BeforeValidator(_condition)] | None = Field(
        None, alias="while", description="as long as this holds, or always"
    )
    begin_after_s: Seconds | None = Field(None, description="of while: only once it has held so long")
    end_after_s: Seconds | None = Field(None, description="of while: until it has not held for so long")
    then: tuple[Action, ...] = Field(min_length=1)
    enabled: bool = True

    @model_validator(mode="after")
    def _sort(self) -> Self:
        if bool(self.when) == (self.while_ is not None):
            raise ValueError("a rule has a `when` or a `while`, and one of them alone")
        given = self.model_fields_set
        if self.when and (wrong := given & {"begin_after_s", "end_after_s"}):
            raise ValueError(f"`{min(wrong)}` is of rules with `while`")
        if self.while_ is not None:
            if wrong := given & {"if_", "every_s"}:
                raise ValueError(f"`{min(wrong).rstrip('_')}` is of rules with `when`")
            for action in self.then:
                if action.desire is None or action.model_fields_set & {"ttl_s", "again"}:
                    raise ValueError("a rule with `while` has desires alone, without ttl_s and again: they end with it")
        return self

    @property
    def words(self) -> str:
        """When it applies, as people read it."""
        if self.while_ is not None:
            words = self.while_.words
            return words if words == ALWAYS else f"while {words}"
        said = " or ".join(trigger.words for trigger in self.when)
        return f"when {said}" + (f", if {self.if_.words}" if self.if_ is not None else "")

    def triggers(self) -> tuple[tuple[tuple[str | int, ...], Trigger], ...]:
        """Every event that it names, with the path to it; one that is alone has the path of its key."""
        when = [(("when", number), each) for number, each in enumerate(self.when)]
        renewing = [
            (("then", number, "renewed_by"), action.renewed_by)
            for number, action in enumerate(self.then)
            if action.renewed_by is not None
        ]
        return (*when, *renewing)

    def conditions(self) -> tuple[Condition, ...]:
        """Every condition, and those within them."""
        return tuple(part for each in (self.if_, self.while_) if each is not None for part in each.parts())


class RuleFile(_Model):
    """One file of rules."""

    timezone: str | None = Field(None, description="of `hours` and `days`, as Europe/Paris; none: the computer's")
    rules: tuple[RuleConfig, ...]

    @field_validator("timezone")
    @classmethod
    def _known(cls, value: str | None) -> str | None:
        if value is not None:
            try:
                ZoneInfo(value)
            except (ZoneInfoNotFoundError, ValueError, OSError):
                raise ValueError("there is no such time zone; they are named as Europe/Paris") from None
        return value
