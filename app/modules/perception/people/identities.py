"""Identities of persons over interruptions: by where a person can have gone meanwhile, and by the colours of the torso.

A person lost for a short time may be the one who appears within reach, unless a wall is between. Later only colours
identify, so an identity without colours is forgotten. Where two identities fit, neither is taken: the person is unsure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.people.torso_color import distance

Vector = NDArray[np.float64]
Histogram = NDArray[np.float32]
Passable = Callable[[Vector, Vector], bool]


@dataclass(frozen=True, slots=True)
class IdentityRules:
    """When two perceptions are of one person. ``colors``: whether colours count at all."""

    colors: bool = True
    #: Speed (m/s) with which somebody unseen moves at most, and the distance (m) beyond it.
    reach_mps: float = 1.5
    reach_m: float = 0.6
    #: ... of somebody in the same colours: the place last known may be of a track that had left the person.
    reach_alike_m: float = 1.6
    #: So long (s) place alone identifies.
    gap_s: float = 8.0
    #: Distances of histograms (0 to 1) of the same person at most, of different ones at least, and between two
    #: candidates at least.
    same: float = 0.4
    different: float = 0.55
    apart: float = 0.1
    #: Histograms of a track before they count.
    samples: int = 3
    #: An identity is kept so long (s), and so many are.
    keep_s: float = 3600.0
    most: int = 50


@dataclass(slots=True)
class Colors:
    """A mean histogram and of how many it is; ``most``: so many at most count, so that it follows the light."""

    most: int
    samples: int = 0
    mean: Histogram | None = None

    def add(self, histogram: Histogram) -> None:
        """Take one more."""
        self.samples += 1
        weight = 1 / min(self.samples, self.most)
        mean = histogram if self.mean is None else self.mean + weight * (histogram - self.mean)
        self.mean = np.asarray(mean, np.float32)

    def distance(self, other: Colors, samples: int) -> float | None:
        """From ``other``, None while one of both is of fewer than ``samples``."""
        if self.mean is None or other.mean is None or min(self.samples, other.samples) < samples:
            return None
        return distance(self.mean, other.mean)


@dataclass(slots=True)
class Identity:
    """A person known by ``number``: last seen at ``stamp``, ``at`` (2,) m, in these ``colors``."""

    number: int
    stamp: float
    at: Vector
    colors: Colors
    #: Whether it was lost beside somebody else, who may be it.
    crossed: bool = False
    #: Where and when colours agreed with it last, None before; place alone may have been wrong since.
    agreed: tuple[float, Vector] | None = None
    #: Numbers of those who were seen at the same time, in their own colours.
    together: set[int] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class Appearance:
    """A person who appeared at ``stamp``, ``at`` (2,) m, and is ``here`` (2,) m ``now``, in these ``colors``."""

    stamp: float
    at: Vector
    colors: Colors
    now: float
    here: Vector


def identify(
    seen: Appearance, missing: Iterable[Identity], rules: IdentityRules, passable: Passable | None
) -> Identity | Literal["new", "unsure"]:
    """Which of the identities ``missing`` (those that nobody in view has) the person ``seen`` is.

    ``passable(a, b)``: whether no known wall is between two places; None: place alone identifies nobody, for there were
    several who may have come here.
    """
    colored = rules.colors and seen.colors.samples >= rules.samples
    near: list[Identity] = []
    alike: list[tuple[float, Identity]] = []
    possible: list[Identity] = []
    for identity in sorted(missing, key=lambda i: i.number):
        gap_s = max(0.0, seen.stamp - identity.stamp)
        far = seen.colors.distance(identity.colors, rules.samples) if rules.colors else None
        most_m = rules.reach_alike_m if far is not None and far <= rules.same else rules.reach_m
        reached = _reached((seen.stamp, seen.at), (identity.stamp, identity.at), most_m, rules.reach_mps)
        last = identity.agreed
        if not reached and (last is None or not _reached((seen.now, seen.here), last, most_m, rules.reach_mps)):
            continue
        if far is not None and far >= rules.different:
            continue
        alone = not (rules.colors and identity.crossed and identity.colors.samples >= rules.samples)
        within = reached and alone and passable is not None and gap_s <= rules.gap_s and passable(identity.at, seen.at)
        if within:
            near.append(identity)
        if far is not None and far <= rules.same:
            alike.append((far, identity))
        elif far is not None or (rules.colors and not colored and identity.colors.samples >= rules.samples):
            possible.append(identity)
    if alike:
        return _of_alike(sorted(alike, key=lambda pair: (pair[0], pair[1].number)), near, rules)
    if len(near) == 1:
        return near[0]
    if len(near) > 1 or possible:
        return "unsure"
    return "new" if colored or passable is not None else "unsure"


def _reached(seen: tuple[float, Vector], last: tuple[float, Vector], most_m: float, most_mps: float) -> bool:
    """Whether who was at ``last`` (stamp, place) can be where another is ``seen``."""
    return math.dist(seen[1], last[1]) <= most_m + most_mps * max(0.0, seen[0] - last[0])


def _of_alike(
    alike: list[tuple[float, Identity]], near: list[Identity], rules: IdentityRules
) -> Identity | Literal["unsure"]:
    best = [identity for far, identity in alike if far - alike[0][0] < rules.apart]
    nearest = [identity for identity in best if any(identity is other for other in near)]
    if len(best) > 1 and nearest:
        best = nearest
    if len(best) > 1 and not any(a.number in b.together for a in best for b in best):
        # Alike, and never seen together: one person, who was numbered twice.
        return min(best, key=lambda identity: identity.number)
    return best[0] if len(best) == 1 else "unsure"


def pruned(identities: Iterable[Identity], now: float, rules: IdentityRules) -> list[Identity]:
    """Those of ``identities``, all unseen, that can still be recognized at ``now``, the newest first to be kept."""
    kept = [
        identity
        for identity in identities
        if now - identity.stamp <= rules.gap_s
        or (rules.colors and identity.colors.samples >= rules.samples and now - identity.stamp <= rules.keep_s)
    ]
    return sorted(sorted(kept, key=lambda i: i.stamp)[-rules.most :], key=lambda i: i.number)
