from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.messages import Twist
from app.runtime.digraph import Feed, find_cycle, slowdowns
from app.runtime.filter import CLOSED
from app.runtime.freshness import commanded_divisors
from app.runtime.module import Module, ModuleContext
from tests.runtime.conftest import GraphBuilder

divisors = st.one_of(st.integers(1, 5).map(float), st.just(CLOSED))
names = st.integers(0, 5).map(str)


@given(st.dictionaries(st.integers(0, 6).map(str), st.sets(st.integers(0, 6).map(str))))
def test_a_cycle_is_found_exactly_when_there_is_one(followers: dict[str, set[str]]) -> None:
    cycle = find_cycle(followers)
    if cycle is not None:
        assert cycle[0] == cycle[-1]
        assert all(after in followers.get(before, ()) for before, after in itertools.pairwise(cycle))
        return
    # No cycle: taking away the nodes that follow nothing, again and again, must leave none.
    rest = {node: {f for f in after if f in followers} for node, after in followers.items()}
    while leaves := {node for node, after in rest.items() if not after}:
        rest = {node: after - leaves for node, after in rest.items() if node not in leaves}
    assert rest == {}


def test_a_path_as_long_as_you_like_has_no_cycle_until_its_end_is_joined() -> None:
    followers = {str(n): [str(n + 1)] for n in range(5000)}
    assert find_cycle(followers) is None
    cycle = find_cycle({**followers, "5000": ["0"]})
    assert cycle is not None
    assert len(cycle) == 5002


# --- slowdowns ---


def by_definition(
    own: Mapping[str, float], feeds: Mapping[str, Sequence[Feed]], channel: str, above: frozenset[str]
) -> float:
    """The slowest of all ways up, each of which comes by no channel twice."""
    if channel not in own or channel in above:
        return 1.0
    ways = (phi * by_definition(own, feeds, feed, above | {channel}) for feed, phi in feeds.get(channel, ()))
    return own[channel] * max(ways, default=1.0)


@given(st.dictionaries(names, divisors), st.dictionaries(names, st.lists(st.tuples(names, divisors), max_size=3)))
def test_the_slowest_way_counts_as_by_definition_also_round_circles(
    own: dict[str, float], feeds: dict[str, list[Feed]]
) -> None:
    assert slowdowns(own, feeds) == {c: by_definition(own, feeds, c, frozenset()) for c in own}


@given(st.permutations(range(30)))
def test_the_order_in_which_channels_are_named_changes_nothing(order: list[int]) -> None:
    """Ten layers of three: 59,049 ways lead up from each channel of the last."""
    layers = {n: [(str(m), 2.0) for m in range(n // 3 * 3 - 3, n // 3 * 3)] if n >= 3 else [] for n in range(30)}
    found = slowdowns({str(n): 1.0 for n in order}, {str(n): layers[n] for n in order})
    assert found == {str(n): 2.0 ** (n // 3) for n in range(30)}


def test_many_paths_round_a_circle_take_bounded_time_and_give_no_less_than_one_of_them() -> None:
    everyone = {str(n): [(str(m), 2.0) for m in range(60) if m != n] for n in range(60)}
    found = slowdowns(dict.fromkeys(everyone, 1.0), everyone)
    assert all(divisor >= 2.0 for divisor in found.values())


class Relay(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.numbers = self.input("numbers", Twist)
        self.out = self.output("out", Twist)


def test_a_chain_longer_than_the_interpreter_recurses_is_built_and_followed(build: GraphBuilder) -> None:
    count = 1100
    modules = {
        f"M{n}": (Relay, {"numbers": f"c{n - 1}" if n else "source"}, {"out": f"c{n}"}) for n in reversed(range(count))
    }
    channels = {"source": {"external": True}, **{f"c{n}": {} for n in reversed(range(count))}}
    graph = build(modules, channels)
    graph.channels[f"c{count - 1}"].subscribe("end")
    graph.filters.apply({"M0.numbers": 2, "M500.numbers": 3})
    assert commanded_divisors(graph)[f"c{count - 1}"] == pytest.approx(6)
