"""What the guide knows: its inputs, and how far a run of a tour is. Frozen values.

    idle → inviting → confirming → leading ⇄ waiting ⇄ searching
                                      ↓ ↘ blocked, lost
                                   turning → presenting ⇄ answering
                                                  ⇅ listening
    the last stop, an end or no visitor left → parting → going_home → idle

Any of them but idle may be paused, and goes on from there.
"""

from __future__ import annotations

from dataclasses import dataclass

from app.messages import TourButton, TourState
from app.modules.motivations.tour_guide.company import NOBODY, Company
from app.tours.codes import CarriedText

State = TourState
Button = TourButton


@dataclass(frozen=True, slots=True)
class Ended:
    """The desire of the wish ``key`` ended: what it asks for is ``done``, or has failed."""

    key: str
    done: bool


@dataclass(frozen=True, slots=True)
class Withdrawn:
    """Another client withdrew the desire of the wish ``key``."""

    key: str


@dataclass(frozen=True, slots=True)
class Pressed:
    """A button was pressed."""

    button: Button


@dataclass(frozen=True, slots=True)
class Chosen:
    """The operator sends the tour to the stop ``stop`` (its id)."""

    stop: str


@dataclass(frozen=True, slots=True)
class Asked:
    """A visitor pressed the question ``question`` (its id)."""

    question: str


@dataclass(frozen=True, slots=True)
class Heard:
    """A word or phrase was recognized."""

    phrase: str


@dataclass(frozen=True, slots=True)
class CodeRead:
    """A QR code that somebody shows was read: its ``text``."""

    text: str


@dataclass(frozen=True, slots=True)
class Clapped:
    """So many claps were heard in a row."""

    times: int


@dataclass(frozen=True, slots=True)
class Called:
    """Somebody called out."""


@dataclass(frozen=True, slots=True)
class Spoken:
    """The sentence ``sentence`` (from 0) of the text of the wish ``key`` begins."""

    key: str
    sentence: int


@dataclass(frozen=True, slots=True)
class Scheduled:
    """The tour's time has come."""


Event = Ended | Withdrawn | Pressed | Chosen | Asked | Heard | CodeRead | Clapped | Called | Spoken | Scheduled


@dataclass(frozen=True, slots=True)
class View:
    """What the guide sees at ``now`` (robot's clock, s).

    ``people``: how many are seen; ``farthest_m``, ``nearest_m``: the distance of the farthest of them, and of the
    nearest; ``near``: how many are within
    ``begin.within_m`` of the tour; ``speaking``: whether a voice is heard there; ``driven_m``: what the base has
    driven since the program began; ``towards``: the heading (rad in odom) of visitors, or of where they are looked for,
    None while unknown; ``stuck_since``: since when (s) the way to the goal is no shorter, None while it is;
    ``found``: how many were seen since it looks for them, who may be out of view now, the farthest ``found_m`` (m)
    away; ``others``, ``others_m``, ``others_nearest_m``: the same of persons whose face is not seen, by their legs;
    ``behind``: the heading (rad in odom) along the way that it came; ``looked_s``: how long (s) it has been
    turned to where it looks for visitors; ``back``: x, y (m) on the map of where it saw all of them last, None where
    that is here or unknown; ``astray_m``: driving back, how far it is from the way that it came; ``X_MB``: x, y,
    heading (m, rad) on the tour's map, None while unknown; ``battery``: share of a full charge, None where the body
    does not say; ``docked``: whether it charges; ``by_hand``: it goes where others want it.
    """

    now: float
    people: int = 0
    farthest_m: float = 0.0
    nearest_m: float = 0.0
    near: int = 0
    speaking: bool = False
    driven_m: float = 0.0
    towards: float | None = None
    stuck_since: float | None = None
    found: int = 0
    found_m: float = 0.0
    others: int = 0
    others_m: float = 0.0
    others_nearest_m: float = 0.0
    behind: float | None = None
    looked_s: float = 0.0
    back: tuple[float, float] | None = None
    astray_m: float = 0.0
    X_MB: tuple[float, float, float] | None = None
    battery: float | None = None
    docked: bool = False
    e_stop: bool = False
    by_hand: bool = False
    localized: bool = True
    events: tuple[Event, ...] = ()

    @property
    def faces(self) -> int:
        """How many faces are seen, or were since it looks for them."""
        return max(self.people, self.found)

    @property
    def there(self) -> int:
        """How many are there, with a face or without."""
        return self.faces + self.others

    @property
    def there_m(self) -> float:
        """The distance (m) of the farthest of them."""
        return max(self.farthest_m, self.found_m, self.others_m)

    @property
    def next_m(self) -> float:
        """The distance (m) of the nearest that is seen."""
        seen = [each for each, count in ((self.nearest_m, self.people), (self.others_nearest_m, self.others)) if count]
        return min(seen, default=0.0)


@dataclass(frozen=True, slots=True)
class Failure:
    """Something on this run failed: at which stop (its id), and what."""

    stop: str
    what: str


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is.

    ``since``: when ``state`` began (s); ``entry`` numbers states and steps as they begin, so that no outcome of an
    older one is taken for one of this. ``stop`` and ``step`` are indices; ``ended`` the keys of wishes of this step
    that ended; ``attempt`` counts tries of what failed. ``resume``: the state before a pause; ``to_press``: whether a
    press is needed to go on; ``pause_spoken``: whether a word will do. ``sentence``: of the step's text, the one that
    is said; ``said_from``: the one that its wish begins with. ``company``: who comes along; ``back``: where (m on the
    map) it drives for those who are missing; ``gone_since``, ``near_since``: since when none is seen or heard, and
    enough are near (s). ``question``: index of the one that is answered, ``listened``: the step to go back to from
    there. ``invites``: whether people who are near begin a tour; those who came along, or declined, leave first.
    ``towards``: the heading (rad in odom) that it turns to where it faces visitors; ``stuck_since`` as in View.
    ``carried``: what a code has it say, at the stop that it leads to, or where it listens.
    ``excuse``: key of what it says of its pause, of going on without all, or of the tour's end. ``homed``: it came
    home, and it was not moved since. ``held``: the emergency stop was pressed, and nobody has pressed to go on since:
    no tour begins. ``reason``: in words, why it is in this state.
    """

    state: State = "idle"
    since: float = 0.0
    entry: int = 0
    stop: int = 0
    step: int = 0
    ended: frozenset[str] = frozenset()
    attempt: int = 0
    slow: bool = False
    sentence: int = 0
    said_from: int = 0
    resume: State = "idle"
    to_press: bool = False
    pause_spoken: bool = False
    company: Company = NOBODY
    back: tuple[float, float] | None = None
    gone_since: float | None = None
    near_since: float | None = None
    invites: bool = True
    question: int = 0
    listened: int = 0
    skipped: tuple[int, ...] = ()
    presented: tuple[str, ...] = ()
    failures: tuple[Failure, ...] = ()
    towards: float | None = None
    stuck_since: float | None = None
    carried: CarriedText | None = None
    excuse: str = ""
    homed: bool = False
    held: bool = False
    reason: str = ""

    @property
    def is_running(self) -> bool:
        """Whether a tour is under way."""
        return self.state != "idle"
