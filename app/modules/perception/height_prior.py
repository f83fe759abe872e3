"""Height prior: distance of a face or mouth by the distribution of people's heights, the height Gaussian (thesis 4.2).

A camera without depth, and microphones, measure only the direction of a person's face or mouth. Most people stand, and
the spread of their heights is small enough to bound the distance along that direction.

*Figures.* Adults of the United States, 20 years and more, measured barefoot 2015-2018: men 1.753 m, women 1.613 m in
the mean, standard deviations about 0.075 m and 0.070 m from the percentiles (Fryar, Carroll, Gu, Afful and Ogden,
*Anthropometric Reference Data for Children and Adults*, Vital and Health Statistics 3(46), 2021). Half of each gives
mean 1.683 m and σ = √((0.075² + 0.070²) / 2 + 0.07²) = 0.101 m; shoes add 0.027 m. So height ~ N(1.71 m, 0.10 m).
Eyes are at 0.936 of it and the chin at 0.870 (Drillis and Contini 1966, in Winter, *Biomechanics and Motor Control of
Human Movement*, figure 4.1). The lips part about 0.043 m above the chin: 0.896. The middle of the face, midway
between eyes and mouth, is at 0.916. A simulated world that draws people from other figures tests this prior.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Part = Literal["eyes", "face", "mouth"]

#: Height of a part over the floor, as a share of the person's.
SHARES: dict[Part, float] = {"eyes": 0.936, "face": 0.916, "mouth": 0.896}


@dataclass(frozen=True, slots=True)
class HeightPrior:
    """Prior of people's heights and distances. Lengths in metres.

    ``others``: share of people who sit, bend, or are children; their faces are uniform between ``lowest_m`` and
    ``highest_m`` above the floor.
    """

    mean_m: float = 1.71
    sigma_m: float = 0.10
    nearest_m: float = 0.5
    farthest_m: float = 8.0
    others: float = 0.02
    lowest_m: float = 0.6
    highest_m: float = 2.2

    def part(self, part: Part) -> tuple[float, float]:
        """Mean and standard deviation (m) of the height of a ``part`` above the floor."""
        return SHARES[part] * self.mean_m, SHARES[part] * self.sigma_m


STANDING = HeightPrior()

#: Evidence (1/m, integrated over ranges) below which a ray cannot meet a face.
IMPOSSIBLE = 1e-6


def range_from_height(
    direction: Sequence[float],
    origin_height_m: float,
    part: Part = "face",
    *,
    elevation_sigma: float = 0.0,
    people: HeightPrior = STANDING,
) -> tuple[float, float]:
    """Mean and standard deviation (m) of the distance along a ray to a person's ``part``.

    ``direction`` (3,) is the ray in axes whose z points up (``base_link`` of a robot on a level floor), of any length;
    ``origin_height_m`` is the height of the ray's origin above the floor; ``elevation_sigma`` (rad) is the standard
    deviation of the ray's elevation.

    It is the posterior of the range r, uniform over ``nearest_m`` to ``farthest_m`` a priori, given that
    the part's height z₀ + r sin ε is Gaussian for most people, N(μ, σ), and uniform for the others::

        p(r) ∝ (1 - o) N(z₀ + r sin ε; μ, σ) + o U(z₀ + r sin ε; lowest, highest),    nearest ≤ r ≤ farthest

    Its first part is a Gaussian about (μ - z₀) / sin ε of deviation σ / |sin ε|, cut off at both ends; so the deviation
    grows as the ray nears the horizontal, up to the uniform distribution's, 7.5 m / √12 = 2.2 m. Where no standing
    person can be (a ray that falls from above face height), the second part dominates. A ray that meets no face (∫ p <
    10⁻⁶ before normalization) gives the prior. Raises ValueError for a direction of length zero.
    """
    length = math.hypot(*direction)
    if not length > 0:
        raise ValueError("direction has no length")
    rise = direction[2] / length
    mean, sigma = people.part(part)
    range_m, range_sigma_m = _posterior(mean - origin_height_m, sigma, rise, origin_height_m, people)
    if elevation_sigma > 0:
        # An error of the elevation shifts the height by range times angle, as a wider spread of heights would.
        sigma = math.hypot(sigma, range_m * elevation_sigma)
        return _posterior(mean - origin_height_m, sigma, rise, origin_height_m, people)
    return range_m, range_sigma_m


def _posterior(above: float, sigma: float, rise: float, origin: float, people: HeightPrior) -> tuple[float, float]:
    parts = (
        (1 - people.others, _of_gaussian(above, sigma, rise, people.nearest_m, people.farthest_m)),
        (people.others, _of_uniform(people.lowest_m - origin, people.highest_m - origin, rise, people)),
    )
    total = sum(share * evidence for share, (evidence, _, _) in parts)
    if not total > IMPOSSIBLE:
        return _uniform(people.nearest_m, people.farthest_m)
    mean = sum(share * evidence * m for share, (evidence, m, _) in parts) / total
    variance = sum(share * evidence * (s * s + (m - mean) ** 2) for share, (evidence, m, s) in parts) / total
    return mean, math.sqrt(variance)


def _of_gaussian(above: float, sigma: float, rise: float, low: float, high: float) -> tuple[float, float, float]:
    """Evidence, mean and deviation of a range in ``low`` to ``high`` whose ``rise`` is Gaussian."""
    a, b = sorted(((low * rise - above) / sigma, (high * rise - above) / sigma))
    if b - a < 1e-3:
        # A level ray has one height at all ranges: it carries no information, and the quotients below would cancel.
        return (high - low) * _density(a) / sigma, *_uniform(low, high)
    mass = _mass(a, b)
    if not mass / abs(rise) > 1e-3 * IMPOSSIBLE:
        return 0.0, 0.0, 0.0
    first = (_density(a) - _density(b)) / mass
    second = 1 + (a * _density(a) - b * _density(b)) / mass
    mean = (above + sigma * first) / rise
    deviation = sigma * math.sqrt(max(0.0, second - first * first)) / abs(rise)
    return mass / abs(rise), mean, deviation


def _of_uniform(lowest: float, highest: float, rise: float, people: HeightPrior) -> tuple[float, float, float]:
    """The same for a height uniform between ``lowest`` and ``highest`` above the origin."""
    low, high = people.nearest_m, people.farthest_m
    if abs(rise) > 1e-9:
        first, last = sorted((lowest / rise, highest / rise))
        low, high = max(low, first), min(high, last)
    elif not lowest <= 0 <= highest:
        return 0.0, 0.0, 0.0
    if not high > low:
        return 0.0, 0.0, 0.0
    return (high - low) / (highest - lowest), *_uniform(low, high)


def _uniform(low: float, high: float) -> tuple[float, float]:
    return (low + high) / 2, (high - low) / math.sqrt(12)


def _density(x: float) -> float:
    return math.exp(-0.5 * x * x) / math.sqrt(2 * math.pi)


def _mass(a: float, b: float) -> float:
    """Probability mass of the standard Gaussian between a ≤ b, without cancellation in its tails."""
    if a > 0:
        a, b = -b, -a
    return 0.5 * (math.erfc(-b / math.sqrt(2)) - math.erfc(-a / math.sqrt(2)))
