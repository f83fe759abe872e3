"""What was seen of one run of a tour, what is wrong with it, and a summary of many. No world, no clock."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from app.rehearsal.observer import LEFT_BEHIND_S, STANDS

#: A stop is reached within these (m, rad), and an arm points within this (deg).
STOP_M, STOP_RAD, POINTING_DEG = 0.3, 0.2, 10.0
#: A tour that is over ends so.
OVER = "the tour is over"
#: States in which it waits for visitors, or drives back for them.
WAITS = frozenset({"waiting", "searching"})
#: States in which visitors are not led.
_NOT_LED = STANDS | {"inviting", "confirming", "parting", "going_home"}


@dataclass(frozen=True, slots=True)
class Sample:
    """Where all were ``at_s`` after the begin, on the map (m, rad): the robot, and each visitor; ``state`` of the
    guide."""

    at_s: float
    robot: tuple[float, float, float]
    people: tuple[tuple[float, float], ...]
    state: str

    @property
    def apart_m(self) -> tuple[float, ...]:
        """The distance of each visitor from the robot (m)."""
        return tuple(math.dist(self.robot[:2], place) for place in self.people)


@dataclass(frozen=True, slots=True)
class Arrival:
    """A stop as the robot arrived there: so far from its place (m), and turned away from its heading (rad)."""

    stop: str
    off_m: float
    off_rad: float


@dataclass(frozen=True, slots=True)
class SaidText:
    """A text of the tour: said to its end (``ended``), or interrupted, for a ``reason`` ("": none is known)."""

    text: str
    ended: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class TourResult:
    """One run of a tour, by the truth.

    ``arrivals``: one a stop that was reached; ``presented``, ``stops``: how many were presented, and are to be.
    ``pointed_deg``: how far each pointing was off as it was over; ``to_point``: how many there are in what was
    presented. ``unsaid``: sentences of presented stops that were never said. ``left_behind_s``: the longest time that a
    visitor was farther than ``wait_m`` (m) from a robot that went on; ``farthest_m``: the farthest that one was while
    led. ``touched``: how often the body touched anything; ``people_m``: the least distance from its outline to a
    person's trunk. ``cpu_share``: the greatest share of attention's CPU budget that was given out. ``asked``,
    ``answered``: questions. ``waits``, ``waited_s``: for visitors, looking back among them. ``wall_s``, ``cpu_s``: real
    time, and that of the processor.
    """

    seed: int
    outcome: str
    duration_s: float
    driven_m: float
    stops: int
    presented: int
    arrivals: tuple[Arrival, ...]
    texts: tuple[SaidText, ...]
    unsaid: tuple[str, ...]
    pointed_deg: tuple[float, ...]
    to_point: int
    wait_m: float
    left_behind_s: float
    farthest_m: float
    touched: int
    people_m: float | None
    cpu_share: float
    asked: int
    answered: int
    waits: int
    waited_s: float
    failures: tuple[str, ...]
    wall_s: float
    cpu_s: float
    trace: tuple[Sample, ...] = ()

    @property
    def problems(self) -> tuple[str, ...]:
        """All that is wrong with the run, in words; none: it is as it should be."""
        return tuple(_problems(self))

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)


def _problems(r: TourResult) -> Iterator[str]:
    if r.outcome != OVER:
        yield f"it ended otherwise: {r.outcome}"
    if r.presented < r.stops:
        yield f"{r.presented} of {r.stops} stops were presented"
    for arrival in r.arrivals:
        if arrival.off_m > STOP_M or abs(arrival.off_rad) > STOP_RAD:
            yield f"{arrival.stop}: {arrival.off_m:.2f} m and {abs(arrival.off_rad):.2f} rad off"
    yield from (f"interrupted for no known reason: {said.text}" for said in r.texts if not (said.ended or said.reason))
    yield from (f"never said: {text}" for text in r.unsaid)
    if len(r.pointed_deg) < r.to_point:
        yield f"pointed {len(r.pointed_deg)} of {r.to_point} times"
    yield from (f"pointed {off:.0f}° beside" for off in r.pointed_deg if off > POINTING_DEG)
    if r.left_behind_s > LEFT_BEHIND_S:
        yield f"a visitor was farther than {r.wait_m:g} m for {r.left_behind_s:.1f} s, and the robot went on"
    if r.touched:
        yield f"touched something {r.touched} times"
    if r.cpu_share > 1.0 + 1e-9:
        yield f"attention gave out {100 * r.cpu_share:.0f} % of its CPU budget"
    if r.answered < r.asked:
        yield f"{r.answered} of {r.asked} questions were answered"
    yield from r.failures


def left_behind_s(samples: Sequence[Sample], wait_m: float) -> float:
    """The longest time (s) one visitor was farther than ``wait_m`` (m) from a robot that neither waited nor stood."""
    longest = 0.0
    for number in range(len(samples[0].people) if samples else 0):
        since: float | None = None
        for sample in samples:
            if sample.state in _NOT_LED or sample.apart_m[number] <= wait_m:
                since = None
                continue
            since = sample.at_s if since is None else since
            longest = max(longest, sample.at_s - since)
    return longest


def farthest_m(samples: Sequence[Sample]) -> float:
    """The farthest that a visitor was from the robot (m) while it led."""
    return max((away for each in samples if each.state not in _NOT_LED for away in each.apart_m), default=0.0)


def waits(samples: Sequence[Sample]) -> tuple[int, float]:
    """How often and how long (s) in all it waited for visitors."""
    count, waited_s = 0, 0.0
    for before, after in itertools.pairwise(samples):
        count += after.state in WAITS and before.state not in WAITS
        waited_s += after.at_s - before.at_s if before.state in WAITS else 0.0
    return count, waited_s


@dataclass(frozen=True, slots=True)
class TourSummary:
    """Summary of many runs; None where there is none. ``good``: runs without a problem."""

    runs: int
    good: int
    stops_presented: int
    stops: int
    worst_off_m: float | None
    worst_off_rad: float | None
    texts: int
    interrupted: int
    worst_pointed_deg: float | None
    longest_left_behind_s: float
    touched: int
    least_people_m: float | None
    most_cpu_share: float
    mean_duration_s: float | None

    @classmethod
    def of(cls, results: Sequence[TourResult]) -> TourSummary:
        """The summary of ``results``."""
        arrivals = [arrival for result in results for arrival in result.arrivals]
        people = [result.people_m for result in results if result.people_m is not None]
        return cls(
            runs=len(results),
            good=sum(not result.problems for result in results),
            stops_presented=sum(result.presented for result in results),
            stops=sum(result.stops for result in results),
            worst_off_m=max((arrival.off_m for arrival in arrivals), default=None),
            worst_off_rad=max((abs(arrival.off_rad) for arrival in arrivals), default=None),
            texts=sum(len(result.texts) for result in results),
            interrupted=sum(not said.ended for result in results for said in result.texts),
            worst_pointed_deg=max((off for result in results for off in result.pointed_deg), default=None),
            longest_left_behind_s=max((result.left_behind_s for result in results), default=0.0),
            touched=sum(result.touched for result in results),
            least_people_m=min(people, default=None),
            most_cpu_share=max((result.cpu_share for result in results), default=0.0),
            mean_duration_s=sum(r.duration_s for r in results) / len(results) if results else None,
        )

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)
