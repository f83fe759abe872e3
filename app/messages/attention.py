"""What attention publishes: desires, the intention in force and its reasons, lanes, events of the timeline.

Recorded as any message; no module acts on it. A class with a field ``cls`` is a Struct, for its JSON has a member
``class``. A closed filter's φ is inf.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from app.messages.base import Stamp, doc
from app.messages.emotions import Modulation

SourceKind = Literal["motivation", "operator", "rest"]
#: Kinds of motivations (EMIB; thesis 2.1.2).
Motive = Literal["instinctive", "rational", "emotional"]
ReasonState = Literal["fulfilled", "degraded", "unfulfilled", "inhibited"]
LaneState = Literal["fulfilled", "degraded", "unfulfilled", "inhibited", "undesired", "needed"]
EventKind = Literal[
    "desire",
    "intention",
    "filter",
    "exploitation",
    "restart",
    "overload",
    "guard",
    "solver",
    "capacity",
    "module",
    "stale",
    "goal",
    "percept",
    "battery",
    "accomplishment",
    "tour",
    "rule",
    "memory",
    "emotion",
]
#: What a behavior reports of a desire.
Accomplished = Literal["done", "failed"]
#: What became of a desire: what a behavior reported last; else why it left the Intention Workspace.
DesireOutcome = Literal["done", "failed", "withdrawn", "expired"]

Divisor = Annotated[float, doc("φ: one message in φ passes; null: none passes.", nullable=True)]


@dataclass(frozen=True, slots=True)
class Source:
    """The author of a desire: a motivation of the robot, an operator at the console or a REST client, by name; of a
    motivation that goes by rules, the rule, its event and the time."""

    kind: SourceKind
    name: str
    rule: Annotated[str, doc("The rule that it came by; empty: by none.")] = ""
    event: Annotated[str, doc("What made the rule apply, in words; empty without a rule.")] = ""
    applied: Annotated[float | None, doc("When the rule applied (robot's clock, s); null without a rule.")] = None
    motive: Annotated[
        Motive | None,
        doc(
            "Of a motivation, its kind: `instinctive` (what the robot itself needs), `rational` (its task) or "
            "`emotional` (conflicts, feelings); null: it is no motivation, or says none."
        ),
    ] = None


class Desire(Struct, frozen=True, rename={"cls": "class"}):
    """One desire of the Intention Workspace."""

    id: Annotated[str, Meta(examples=["d-3f0c81a2b4"])]
    cls: Annotated[str, Meta(examples=["FindQRCodes"])]
    intensity: Annotated[float, Meta(description="How much it is desired, over 0 and at most 8.", examples=[8])]
    utility: Annotated[float, Meta(description="Utility desired, 0 to 8; 0 inhibits the class.", examples=[4])]
    security: Annotated[bool, doc("Whether it must be fulfilled.")]
    params: Annotated[Mapping[str, Any], doc("Parameters as the class declares them.")]
    source: Source
    created: Stamp
    expires: Annotated[float | None, doc("When it expires (robot's clock, s); null: never.")] = None
    modulation: Annotated[
        Modulation | None, doc("What an emotion adds to its intensity (docs/emotions.md); null: nothing.")
    ] = None


@dataclass(frozen=True, slots=True)
class Accomplishment:
    """A behavior's report that what a desire asks for is done, or that it cannot be done."""

    stamp: Stamp
    desire_id: Annotated[str, Meta(examples=["d-3f0c81a2b4"])]
    behavior: Annotated[str, doc("Name of the module that reports it.")]
    outcome: Accomplished
    reason: Annotated[str, doc("In words: what was reached, or why it cannot be; may be empty.")] = ""


class DesireReport(Desire, frozen=True, rename={"cls": "class"}):
    """A desire, and what became of it."""

    outcome: Annotated[
        DesireOutcome | None,
        doc("What a behavior reported last; without a report, why it left; null: nothing became of it yet."),
    ] = None
    behavior: Annotated[str, doc("Name of the module that reported the outcome; empty: none did.")] = ""
    reason: Annotated[str, doc("Of the report, in words.")] = ""
    ended: Annotated[float | None, doc("When it left (robot's clock, s); null: it is still desired.")] = None


@dataclass(frozen=True, slots=True)
class DesireProgress:
    """Whether a desire is intended and exploited now, and since when it has been so, or not."""

    id: Annotated[str, doc("Of the desire.")]
    intended: Annotated[bool, doc("It is the strongest of its class, and attention selected a strategy for it.")]
    exploited: Annotated[
        bool, doc("A behavior's commands for it pass its arbiter; of a perception: what was selected for it works.")
    ]
    intended_since: Annotated[
        float | None, doc("Since when `intended` is what it is (robot's clock, s); null: since it came.")
    ] = None
    exploited_since: Annotated[float | None, doc("The same of `exploited`.")] = None


@dataclass(frozen=True, slots=True)
class Desires:
    """Every desire in the Intention Workspace, in the order they came."""

    stamp: Stamp
    desires: tuple[Desire, ...]
    exploited: Annotated[
        tuple[str, ...],
        doc(
            "Ids of those that a behavior serves by commands that its arbiter lets through now, or for which a "
            "perception works."
        ),
    ] = ()
    accomplishments: Annotated[
        tuple[Accomplishment, ...], doc("The last report on each of `desires` on which there is one.")
    ] = ()
    ended: Annotated[tuple[DesireReport, ...], doc("The last that left, at most 5, the newest first.")] = ()
    progress: Annotated[
        tuple[DesireProgress, ...], doc("Of each of `desires`; empty in recordings of older programs.")
    ] = ()


@dataclass(frozen=True, slots=True)
class Alternative:
    """A change that would serve a desire better: more of a resource, or no desire for another class."""

    kind: Literal["capacity", "without"]
    utility: Annotated[float, doc("The utility that the class would get.")]
    resource: Annotated[str, doc("Of `capacity`: the resource; else empty.")] = ""
    amount: Annotated[float, doc("Of `capacity`: how much more of it.")] = 0.0
    unit: str = ""
    without: Annotated[str, doc("Of `without`: the other class; else empty.")] = ""


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a desired class gets what it gets."""

    state: ReasonState
    utility: Annotated[float, doc("The utility it gets.")]
    wanted: Annotated[float, doc("The utility desired.")]
    best: Annotated[float, doc("The most that any selection could give it.")]
    text: Annotated[str, doc("The reason in words.")]
    alternatives: tuple[Alternative, ...] = ()
    searched: Annotated[bool, doc("Whether the search for alternatives was complete.")] = True
    remark: Annotated[str, doc("What lessens the utility that its strategies produce now; empty: nothing.")] = ""


class SelectedStrategy(Struct, frozen=True, rename={"cls": "class"}):
    """A strategy at work."""

    name: str
    cls: str
    utility: float
    filters: Mapping[str, Divisor]
    costs: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class ResourceUse:
    """What is used of a resource."""

    used: float
    capacity: float
    unit: str


@dataclass(frozen=True, slots=True)
class Asked:
    """What the strongest desire of a class asked for, when the problem was solved."""

    intensity: Annotated[float, doc("With what an emotion added.")]
    utility: float
    security: bool
    modulation: Annotated[Modulation | None, doc("What an emotion added to the intensity; null: nothing.")] = None


@dataclass(frozen=True, slots=True)
class ChangedStrategy:
    """What attention reckons with of a strategy."""

    name: str
    utility: Annotated[float, doc("Less than declared while a perception works badly.")]
    costs: Annotated[Mapping[str, float], doc("What it uses of each resource.")]


@dataclass(frozen=True, slots=True)
class OmegaWeights:
    """What Ω is made of: intensity·i of what is fulfilled, utility·v of what serves it, spare for each unit left of a
    resource."""

    intensity: Annotated[float, doc("Of the intensities of fulfilled desires; 1 in the thesis.")] = 1.0
    utility: Annotated[float, doc("Of produced utilities; 1 in the thesis.")] = 1.0
    spare: Annotated[float, doc("Of each unit of `spare_of` that is left; 0 in the thesis.")] = 0.0
    spare_of: Annotated[str, doc("The resource.")] = ""


@dataclass(frozen=True, slots=True)
class IntentionReport:
    """The intention at work: what was selected, what follows from it, and why. Published when it is put in force, and
    again once its reasons are complete."""

    stamp: Stamp
    strategies: tuple[SelectedStrategy, ...]
    fulfilled: Annotated[tuple[str, ...], doc("Classes whose strongest desire is fulfilled.")]
    omega: Annotated[float, doc("Ω, what the selection is worth (thesis, equation 4.9).")]
    bound: Annotated[
        float,
        doc("No selection can be worth more; equal to `omega` when proven, null where none is known.", nullable=True),
    ]
    use: Mapping[str, ResourceUse]
    filters: Annotated[Mapping[str, Divisor], doc("φ of every filter that attention controls.")]
    proven: Annotated[bool, doc("Whether no better selection exists.")]
    solve_ms: float
    relaxed: Annotated[tuple[str, ...], doc("Security desires that could not be kept.")]
    reasons: Annotated[Mapping[str, Reason], doc("By desired class.")]
    parameters: Annotated[Mapping[str, Mapping[str, Any]], doc("What each module was handed.")]
    desires: Annotated[Mapping[str, str], doc("Id of the strongest desire of each class that it answers.")]
    asked: Annotated[
        Mapping[str, Asked], doc("By class, what that desire asked for; empty in recordings of older programs.")
    ] = field(default_factory=dict)
    previous: Annotated[tuple[str, ...], doc("Strategies that were selected before; of equals, they stay.")] = ()
    changed: Annotated[
        tuple[ChangedStrategy, ...],
        doc("Strategies that cost or produce otherwise than in the table that the program began with."),
    ] = ()
    weights: Annotated[OmegaWeights, doc("What Ω is made of.")] = OmegaWeights()


class LaneRow(Struct, frozen=True, rename={"cls": "class"}):
    """A desire class: how much it is desired, what attention gives it, and why."""

    cls: str
    intensity: Annotated[float | None, doc("Of its strongest desire; null: there is none.")]
    utility: Annotated[float | None, doc("Desired by that; null: there is none.")]
    rate: Annotated[
        float | None,
        doc("Messages let through over messages offered, in the last second; 0 when closed, null: none was offered."),
    ]
    divisor: Divisor
    divisors: Annotated[Mapping[str, Divisor], doc("By filter, `Module.port`, of its strategies at work.")]
    state: LaneState
    text: str


@dataclass(frozen=True, slots=True)
class Lanes:
    """20 times a second: one row for each desire class, in a fixed order."""

    stamp: Stamp
    rows: tuple[LaneRow, ...]


@dataclass(frozen=True, slots=True)
class TimelineEvent:
    """One event of the timeline; ``data`` is JSON as it is."""

    id: Annotated[int, doc("Grows by one from 1.")]
    stamp: Stamp
    kind: EventKind
    subject: Annotated[str, doc("What it is about: a desire class, a module, a filter.")]
    text: Annotated[str, doc("One sentence.")]
    data: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class RuleReport:
    """A rule by which something is desired (docs/rules.md), and what it did."""

    name: str
    about: Annotated[str, doc("What it is for, in words; may be empty.")]
    words: Annotated[str, doc("When it applies, in words.")]
    file: Annotated[str, doc("The file that it is in.")]
    line: Annotated[int, doc("Its line there, from 1.")]
    enabled: bool
    holds: Annotated[bool | None, doc("Of a rule with `while`: whether it applies now; null of others.")]
    fired: Annotated[int, doc("How often it applied.")]
    last_fired: Annotated[float | None, doc("When it applied last (robot's clock, s); null: never.")]
    last_event: Annotated[str, doc("What made it apply then, in words.")]
    desires: Annotated[tuple[str, ...], doc("Ids of the desires that there are by it.")]
    problem: Annotated[str, doc("Why something it should have done was not done, when it applied last.")] = ""


@dataclass(frozen=True, slots=True)
class RulesReport:
    """The rules in force, in their order; published when one applies, and when their files change."""

    stamp: Stamp
    rules: tuple[RuleReport, ...]
    files: Annotated[tuple[str, ...], doc("The files that they are read from.")] = ()
    problem: Annotated[
        str, doc("Why the files, as they are now, are not in force: file, line and mistake; empty: they are.")
    ] = ""


@dataclass(frozen=True, slots=True)
class Scale:
    """The ends of the scales of desires."""

    intensity: float
    utility: float


@dataclass(frozen=True, slots=True)
class DesireClassReport:
    """What can be desired."""

    name: Annotated[str, Meta(examples=["FindQRCodes"])]
    title: str
    description: str
    schema: Annotated[dict[str, Any], Meta(title="JsonSchema", description="JSON Schema of `params`.")]
    served: Annotated[
        bool, doc("Whether a strategy of this program's modules serves it; else no desire for it is fulfilled.")
    ]
    achievement: Annotated[bool, doc("Whether a desire for it leaves by itself once it is accomplished.")]


class StrategyReport(Struct, frozen=True, rename={"cls": "class"}):
    """One way to serve a desire class."""

    name: str
    cls: str
    utility: Annotated[float, doc("Produced utility v, over 0 and at most 8, as attention reckons now.")]
    requires: Annotated[Mapping[str, float], doc("Utility needed of other classes.")]
    filters: Annotated[Mapping[str, Divisor], doc("φ by `Module.port`.")]
    parameters: Annotated[
        Mapping[str, Mapping[str, Any]], doc("What modules are handed while it is selected, by module.")
    ]
    costs: Annotated[Mapping[str, float], doc("What it uses of each resource, as attention reckons now.")]
    selected: bool
    declared: Annotated[str | None, doc("File and line.")]
    declared_costs: Annotated[Mapping[str, float], doc("As declared there, or calibrated on this computer.")]
    declared_utility: Annotated[float, doc("As declared there: `utility` is less while a perception works badly.")]


@dataclass(frozen=True, slots=True)
class ResourceReport:
    """What strategies share."""

    name: Annotated[str, Meta(examples=["cpu"])]
    capacity: Annotated[float, Meta(description="How much of it attention may give now.", examples=[120])]
    declared: Annotated[float, doc("Its capacity in configuration.")]
    used: Annotated[float, doc("What the intention at work uses of it.")]
    budget: Annotated[float, doc("As it was set last; `capacity` is less while others press on the computer.")]
    unit: str
    description: str
