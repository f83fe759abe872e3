"""What the closed-loop experiment measures, and how it judges: pure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

#: Over the budget by no more than this is within it, on the average of so long (s): of one picture and the next, one
#: has a face in it, and what strategies cost is an average, too.
WITHIN: Final = 1.05
AVERAGED_S: Final = 2.0


@dataclass(frozen=True, slots=True)
class Sample:
    """The robot at ``t`` (s since the run's begin): ``used`` CPU of the modules at work for strategies over the last
    second and its ``budget`` now (% of one core), the ``share`` that pressure leaves, ``waiting`` of the program's
    threads, and φ by filter of those at work."""

    t: float
    used: float
    budget: float
    share: float
    waiting: float
    divisors: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Phase:
    """A part of a run, from ``begins`` to ``ends`` (s), in which something is wrong, or is right again."""

    name: str
    begins: float
    ends: float


@dataclass(frozen=True, slots=True)
class RunResult:
    """One run: its ``kind``, whether the loop was ``closed``, its ``phases`` and ``samples``; ``periods`` (s) of the
    planner's commands while it drove; ``restarts`` of modules; what ``others`` took of the computer (% of one core),
    and how fast the world was."""

    kind: str
    closed: bool
    phases: tuple[Phase, ...]
    samples: tuple[Sample, ...]
    periods: tuple[float, ...]
    restarts: int
    others: float
    world_rate: float


@dataclass(frozen=True, slots=True)
class Judgement:
    """Of one phase: ``settled_s`` after its begin the CPU kept within its budget (inf: never), ``left`` how
    often φ changed in the second half, ``over`` the mean of used CPU over the budget there."""

    phase: Phase
    settled_s: float
    left: int
    over: float


def judge(result: RunResult, phase: Phase) -> Judgement:
    """How ``phase`` of ``result`` went."""
    within = [s for s in result.samples if phase.begins <= s.t <= phase.ends]
    if not within:
        return Judgement(phase, math.inf, 0, math.nan)
    late = [s for s in within if s.t >= (phase.begins + phase.ends) / 2]
    ratios = [s.used / s.budget for s in late if s.budget > 0]
    over = float(np.mean(ratios)) if ratios else math.nan
    return Judgement(phase, settled(within) - phase.begins, changes(late), over)


def settled(samples: Sequence[Sample]) -> float:
    """The time from which on each average of :data:`AVERAGED_S` is within the budget; inf: none."""
    found = math.inf
    for number, sample in enumerate(samples):
        ahead = [s for s in samples[number:] if s.t < sample.t + AVERAGED_S]
        if sum(s.used for s in ahead) > WITHIN * sum(s.budget for s in ahead):
            found = math.inf
        elif found == math.inf:
            found = sample.t
    return found


def changes(samples: Sequence[Sample]) -> int:
    """How often φ changed."""
    return sum(a.divisors != b.divisors for a, b in itertools.pairwise(samples))


def back_s(result: RunResult, before: Phase, relief: float) -> float:
    """How long (s) after ``relief`` φ of no perception was more than at the end of ``before``; inf: never."""
    old = [s for s in result.samples if s.t < before.ends]
    if not old:
        return math.inf
    wanted = old[-1].divisors
    for sample in result.samples:
        if sample.t >= relief and all(sample.divisors.get(name, math.inf) <= phi for name, phi in wanted.items()):
            return sample.t - relief
    return math.inf


def period_p99_ms(result: RunResult) -> float:
    """The planner's period, 99th percentile (ms); NaN if it never drove."""
    return 1e3 * float(np.percentile(result.periods, 99)) if result.periods else math.nan
