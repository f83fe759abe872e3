"""The thesis's strategies and problems (chapter 4), and an exhaustive search that knows only its equations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

from app.attention.desires import Desire, Source
from app.attention.problem import SelectionProblem
from app.attention.strategies import Strategy

SOURCE = Source("motivation", "ScenarioCoordinator")


def desire(cls: str, intensity: float, utility: float = 1, *, security: bool = False) -> Desire:
    return Desire(f"d-{cls}", cls, intensity, utility, security, {}, SOURCE, 0.0)


def problem(
    desires: Iterable[Desire],
    strategies: tuple[Strategy, ...],
    capacities: Mapping[str, float],
    previous: Iterable[str] = (),
) -> SelectionProblem:
    return SelectionProblem({d.cls: d for d in desires}, strategies, dict(capacities), frozenset(previous))


# Tableau 4.4; names are the thesis's numbers.
TABLE_4_4 = (
    *(
        Strategy(str(n), "FindQRCodes", v, filters={"QRCodeDetector.images": phi}, costs={"cpu": cpu})
        for n, phi, v, cpu in ((1, 1, 8, 80), (2, 2, 4, 40), (3, 4, 2, 20), (4, 8, 1, 10))
    ),
    *(
        Strategy(str(n), "LocateFaces", v, filters={"FaceDetector.images": phi}, costs={"cpu": cpu})
        for n, phi, v, cpu in ((5, 1, 8, 60), (6, 2, 4, 30), (7, 4, 2, 15), (8, 8, 1, 8))
    ),
    Strategy("9", "DetectNoises", 8, filters={"LoudNoiseDetector.audio": 1}),
    Strategy("10", "LocateVoices", 8, filters={"VoiceLocalizer.audio": 1}, costs={"cpu": 60}),
    Strategy("11", "SLAM", 8, filters={"SLAM2D.scans": 40}, costs={"cpu": 20}),
    Strategy("12", "Teleoperation", 8, filters={"Teleop.twist": 1}),
    Strategy(
        "13",
        "GoTo",
        8,
        requires={"SLAM": 1},
        filters={"PlanAndFollowPath.scans": 1, "PlanAndFollowPath.twist": 1},
        costs={"cpu": 30},
    ),
)
CPU = {"cpu": 100.0}


@dataclass(frozen=True)
class Found:
    """One optimum by exhaustion: its criteria, greatest first, and what it selects and fulfils."""

    rank: tuple[Fraction | tuple[int, ...], ...]
    strategies: tuple[str, ...]
    fulfilled: frozenset[str]

    @property
    def omega(self) -> Fraction:
        assert isinstance(self.rank[0], Fraction)
        return self.rank[0]


def fits(p: SelectionProblem, chosen: tuple[Strategy, ...], fulfilled: frozenset[str]) -> bool:
    """Equations 4.4 to 4.7 and 4.10, as printed, and the implied exclusion of strategies sharing a filter."""
    exact = Fraction
    classes = {s.cls for s in p.strategies} | set(p.desires) | {c for s in p.strategies for c in s.requires}
    for cls in classes:
        wanted = p.desires.get(cls)
        produced = sum((exact(str(s.utility)) for s in chosen if s.cls == cls), exact(0))
        required = sum((exact(str(s.requires.get(cls, 0))) for s in chosen), exact(0))
        f = int(cls in fulfilled)
        if wanted is None:
            good = produced - required >= 0 and f == 0
        elif wanted.utility > 0:
            good = produced - required >= f * exact(str(wanted.utility)) and (not wanted.security or f == 1)
        else:
            good = produced == 0 and required == 0 and f == 0
        if not good:
            return False
    for resource, capacity in p.capacities.items():
        if sum((exact(str(s.costs.get(resource, 0))) for s in chosen), exact(0)) > exact(str(capacity)):
            return False
    return not any(
        one.cls == other.cls and set(one.filters) & set(other.filters) for one, other in combinations(chosen, 2)
    )


def omega(p: SelectionProblem, chosen: tuple[Strategy, ...], fulfilled: frozenset[str]) -> Fraction:
    """Equation 4.9."""
    return sum((Fraction(str(p.desires[c].intensity)) for c in fulfilled if c in p.desires), Fraction(0)) + sum(
        (Fraction(str(s.utility)) for s in chosen if s.cls in fulfilled), Fraction(0)
    )


def every_solution(p: SelectionProblem) -> Iterator[tuple[tuple[Strategy, ...], frozenset[str]]]:
    """All (A, F) that satisfy the constraints: all subsets of strategies, all subsets of the desired classes."""
    classes = [c for c, d in p.desires.items() if d.utility > 0]
    for size in range(len(p.strategies) + 1):
        for chosen in combinations(p.strategies, size):
            if any(sum(s.costs.get(r, 0) for s in chosen) > m + 1e-6 for r, m in p.capacities.items()):
                continue
            for count in range(len(classes) + 1):
                for group in combinations(classes, count):
                    if fits(p, chosen, frozenset(group)):
                        yield chosen, frozenset(group)


def exhaust(p: SelectionProblem) -> Found | None:
    """The optimum in the documented order of ties, by trying everything; None if the constraints allow nothing."""
    best: Found | None = None
    for chosen, fulfilled in every_solution(p):
        worth = sum(
            (
                Fraction(str(p.desires[s.cls].intensity)) * Fraction(str(s.utility))
                for s in chosen
                if s.cls in fulfilled
            ),
            Fraction(0),
        )
        names = tuple(s.name for s in chosen)
        rank = (
            omega(p, chosen, fulfilled),
            worth,
            Fraction(-sum(name not in p.previous for name in names)),
            -sum((Fraction(str(s.costs.get("cpu", 0))) for s in chosen), Fraction(0)),
            Fraction(-len(chosen)),
            tuple(-int(s not in chosen) for s in p.strategies),
        )
        if best is None or rank > best.rank:
            best = Found(rank, names, fulfilled)
    return best
