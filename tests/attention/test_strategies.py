"""What a part of a program keeps of a table of strategies."""

from __future__ import annotations

from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from app.attention.strategies import Resource, Strategy, StrategyTable, exclusive, trimmed

MODULES = ("Eye", "Ear", "Leg")
TABLES = st.lists(
    st.builds(
        lambda cls, filters, parameters: ("", cls, filters, parameters),
        st.sampled_from(("See", "Hear")),
        st.dictionaries(st.sampled_from([f"{m}.{p}" for m in MODULES for p in ("in", "out")]), st.integers(1, 3)),
        st.sets(st.sampled_from(MODULES)),
    ),
    max_size=6,
).map(
    lambda rows: StrategyTable(
        tuple(
            Strategy(f"s{n}", cls, 1.0, filters=filters, parameters={m: {"x": 1} for m in sorted(parameters)})
            for n, (_, cls, filters, parameters) in enumerate(rows)
        ),
        {"cpu": Resource("cpu", 10)},
    )
)


def excluded(table: StrategyTable) -> set[tuple[str, str]]:
    """Pairs that can never be selected together: by a common filter, or by a resource of which there is 1."""
    return {
        (one.name, other.name)
        for one, other in combinations(table.strategies, 2)
        if exclusive(one, other)
        or any(
            one.costs.get(name, 0) + other.costs.get(name, 0) > resource.capacity
            for name, resource in table.resources.items()
        )
    }


@given(TABLES, st.sets(st.sampled_from(MODULES)))
def test_a_part_of_a_program_keeps_what_it_can_serve(table: StrategyTable, there: set[str]) -> None:
    part = trimmed(table, dict.fromkeys(there, ("in", "out")))
    for strategy in part.strategies:
        whole = table[strategy.name]
        assert strategy.filters == {n: phi for n, phi in whole.filters.items() if n.partition(".")[0] in there}
        assert set(strategy.parameters) == set(whole.parameters) & there
    kept = {strategy.name for strategy in part.strategies}
    for strategy in table.strategies:
        lost_all = bool(strategy.filters) and not any(n.partition(".")[0] in there for n in strategy.filters)
        assert (strategy.name in kept) == (not lost_all)
    # Exactly those that excluded each other still do.
    assert excluded(part) == {pair for pair in excluded(table) if set(pair) <= kept}
