"""The selection problem and its answer, as values (thesis 4.2.5 and 4.3.3).

Maximise  Ω = Σ_k i'_k f_k + Σ_k Σ_s f_k a_s v_sk   (4.9)   over a_s, f_k in {0, 1}, subject to

====  ==============  =====================================================  =====
γ1    u'_k > 0        Σ_s a_s (v_sk - l_sk) ≥ f_k u'_k                       (4.4)
γ2    u'_k = 0        Σ_s a_s v_sk = 0  and  Σ_s a_s l_sk = 0  (f_k = 0)     (4.5)
γ3    u'_k undefined  Σ_s a_s (v_sk - l_sk) ≥ 0  and  f_k = 0                (4.6)
γ4    z'_k = 1        f_k = 1                                                (4.7)
γ5    resource j      Σ_s a_s c_sj ≤ m_j, and exclusive strategies           (4.10)
====  ==============  =====================================================  =====

An inhibited class has f_k = 0, so that its intensity does not count in Ω; with z' = 1 it is inhibited all the same.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from app.attention.desires import Desire
from app.attention.prepared import PreparedTable, prepare
from app.attention.strategies import Strategy
from app.messages import Reason


@dataclass(frozen=True, slots=True)
class Weights:
    """Weights in Ω, all 1 and 0 in the thesis: Ω = Σ intensity·i f + Σ utility·f a v + spare·(m_j - Σ a c_j).

    ``spare`` is what a unit of resource j left unused is worth: it must be small, or nothing is ever done. ``spare_of``
    names that resource; "": the thrift resource. Without such a resource there is no such term.
    """

    intensity: float = 1.0
    utility: float = 1.0
    spare: float = 0.0
    spare_of: str = ""


@dataclass(frozen=True, slots=True)
class SelectionProblem:
    """One selection problem.

    ``desires`` holds the strongest desire of each class; ``strategies`` the table in order; ``capacities`` the m_j;
    ``previous`` the strategies selected now (ties keep them); ``thrift`` the resource that decides ties (by default the
    first one); ``prepared`` the table in whole numbers, if it is computed already.
    """

    desires: Mapping[str, Desire]
    strategies: tuple[Strategy, ...]
    capacities: Mapping[str, float]
    previous: frozenset[str] = frozenset()
    weights: Weights = Weights()
    thrift: str = "cpu"
    prepared: PreparedTable | None = field(default=None, compare=False, repr=False)

    @property
    def table(self) -> PreparedTable:
        """The table in whole numbers: ``prepared`` if it is of these strategies. Raises InvalidProblem."""
        known = self.prepared
        return known if known is not None and known.strategies is self.strategies else prepare(self.strategies)

    def with_table(self) -> SelectionProblem:
        """The same problem with its table computed, so that variants of it need not. Raises InvalidProblem."""
        table = self.table
        return self if table is self.prepared else replace(self, prepared=table)

    def without(self, cls: str) -> SelectionProblem:
        """The same problem without the desire of ``cls``."""
        return replace(self, desires={name: desire for name, desire in self.desires.items() if name != cls})

    def with_capacity(self, resource: str, capacity: float) -> SelectionProblem:
        """The same problem had ``resource`` another capacity."""
        return replace(self, capacities={**self.capacities, resource: capacity})


@dataclass(frozen=True, slots=True)
class Selection:
    """The answer to a problem.

    ``strategies`` is A, names in table order; ``fulfilled`` is F, classes in table order; ``omega`` is Ω (4.9);
    ``bound`` no selection can exceed (equal to ``omega`` when ``proven``); ``use`` the amount used of each resource;
    ``relaxed`` the classes whose security desires could not be kept, most intense first; ``reasons`` is empty until
    explained.
    """

    strategies: tuple[str, ...]
    fulfilled: tuple[str, ...]
    omega: float
    bound: float
    use: Mapping[str, float]
    proven: bool
    solve_time_s: float = 0.0
    relaxed: tuple[str, ...] = ()
    reasons: Mapping[str, Reason] = field(default_factory=dict)


def produced(problem: SelectionProblem, selected: Collection[str], cls: str) -> float:
    """Σ_s a_s v_sk: the utility that the selected strategies produce for ``cls``."""
    names = frozenset(selected)
    return sum(s.utility for s in problem.strategies if s.cls == cls and s.name in names)


def assess(problem: SelectionProblem, selected: Collection[str], *, relaxed: Collection[str] = ()) -> Selection | None:
    """The strategies ``selected`` as a Selection (not proven), or None if they break γ1–γ5 or 4.9.

    γ4 does not apply to the classes in ``relaxed``.
    """
    wanted = frozenset(selected)
    chosen = [s for s in problem.strategies if s.name in wanted]
    # A table that was prepared for other strategies is of no use.
    problem = problem if problem.prepared is None else problem.with_table()
    return assess_chosen(problem, chosen, relaxed=relaxed) if len(chosen) == len(wanted) else None


def assess_chosen(
    problem: SelectionProblem,
    chosen: Sequence[Strategy],
    *,
    relaxed: Collection[str] = (),
    bound: float | None = float("inf"),
    started: float | None = None,
) -> Selection | None:
    """As :func:`assess`, of strategies in table order. ``bound`` is of Ω, None where they are proven to be the optimum;
    ``started`` (of ``time.perf_counter``) when their search began."""
    use = dict.fromkeys(problem.capacities, 0.0)
    for strategy in chosen:
        for resource, cost in strategy.costs.items():
            use[resource] += cost
    for resource, capacity in problem.capacities.items():
        use[resource] = amount = round(use[resource], 3)
        if amount > capacity:
            return None
    made: dict[str, float] = {}
    needed: dict[str, float] = {}
    taken: set[tuple[str, str]] = set()
    for strategy in chosen:
        filters = {(strategy.cls, name) for name in strategy.filters}
        if not taken.isdisjoint(filters):
            return None
        taken |= filters
        made[strategy.cls] = made.get(strategy.cls, 0.0) + strategy.utility
        for cls, amount in strategy.requires.items():
            if amount > 0:
                needed[cls] = needed.get(cls, 0.0) + amount
    fulfilled: list[str] = []
    omega = 0.0
    known = problem.prepared.members if problem.prepared is not None else (s.cls for s in problem.strategies)
    for cls in dict.fromkeys([*known, *problem.desires, *needed]):
        desire = problem.desires.get(cls)
        if desire is not None and desire.utility == 0:
            if cls in made or cls in needed:
                return None
            continue
        cover = round(made.get(cls, 0.0) - needed.get(cls, 0.0), 3)
        if cover < 0:
            return None
        if desire is None:
            continue
        if cover >= desire.utility:
            fulfilled.append(cls)
            omega += problem.weights.intensity * desire.intensity
            omega += problem.weights.utility * made.get(cls, 0.0)
        elif desire.security and cls not in relaxed:
            return None
    if problem.weights.spare:
        spare = spare_resource(problem)
        if spare is not None:
            omega += problem.weights.spare * (problem.capacities[spare] - use[spare])
    omega = round(omega, 6)
    return Selection(
        tuple([s.name for s in chosen]),
        tuple(fulfilled),
        omega=omega,
        bound=omega if bound is None else max(omega, bound),
        use=use,
        proven=bound is None,
        solve_time_s=0.0 if started is None else time.perf_counter() - started,
        relaxed=tuple(relaxed),
    )


def thrift_resource(problem: SelectionProblem) -> str | None:
    """The resource that ties are decided by: ``problem.thrift`` if it exists, else the first, else None."""
    return problem.thrift if problem.thrift in problem.capacities else next(iter(problem.capacities), None)


def spare_resource(problem: SelectionProblem) -> str | None:
    """The resource whose unused part counts in Ω with the weight ``spare``; None if there is no such resource."""
    named = problem.weights.spare_of
    if named:
        return named if named in problem.capacities else None
    return thrift_resource(problem)
