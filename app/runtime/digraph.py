"""Functions on plain directed graphs: circles, and by how much filters slow down what comes after them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter

#: A channel that feeds another's producer, and φ of the filter between.
Feed = tuple[str, float]

_MOST_STEPS = 1000
"""Limit of the search: the number of paths may double with each channel on a cycle."""


def find_cycle(followers: Mapping[str, Collection[str]]) -> list[str] | None:
    """A cycle of the directed graph ``followers`` as a path whose last node is its first, or None."""
    try:
        TopologicalSorter({node: sorted(followers[node]) for node in sorted(followers)}).prepare()
    except CycleError as error:
        cycle: list[str] = error.args[1]
        return cycle[::-1]
    return None


def slowdowns(own: Mapping[str, float], feeds: Mapping[str, Sequence[Feed]]) -> dict[str, float]:
    """The greatest product of divisors (from 1 to infinity) on any path upstream from each channel in ``own``.

    ``own`` is φ of the output a channel comes from; ``feeds`` what sets its producer's pace. A path ends at a
    channel that is not in ``own``, and before it would visit a channel twice. Takes time linear in the number of feeds,
    but for channels on circles, each of which takes at most a fixed number of steps.
    """
    # Followed from the sources down, then back from the ends up: what neither reaches is on a circle, or between two.
    above = {channel: [feed for feed, _ in feeds.get(channel, ()) if feed in own] for channel in own}
    below: dict[str, list[str]] = {channel: [] for channel in own}
    for channel, sources in above.items():
        for feed in sources:
            below[feed].append(channel)
    first = _peeled(above, below, frozenset(own))
    last = _peeled(below, above, frozenset(own) - frozenset(first))
    found: dict[str, float] = {}

    def settle(channel: str) -> None:
        ways = [phi * found.get(feed, 1.0) for feed, phi in feeds.get(channel, ())]
        found[channel] = own[channel] * max(ways, default=1.0)

    for channel in first:
        settle(channel)
    circling = frozenset(own) - frozenset(first) - frozenset(last)
    found |= {channel: _longest(channel, own, feeds, found) for channel in own if channel in circling}
    for channel in reversed(last):
        settle(channel)
    return found


def _peeled(
    before: Mapping[str, Sequence[str]], after: Mapping[str, Sequence[str]], nodes: frozenset[str]
) -> list[str]:
    """``nodes`` in layers: those without a predecessor among ``nodes``, then those whose predecessors are all in
    earlier layers, and so on."""
    waits = {node: sum(other in nodes for other in before[node]) for node in nodes}
    order = [node for node, count in waits.items() if not count]
    for node in order:
        for other in after[node]:
            if other in waits:
                waits[other] -= 1
                if not waits[other]:
                    order.append(other)
    return order


def _longest(
    start: str, own: Mapping[str, float], feeds: Mapping[str, Sequence[Feed]], known: Mapping[str, float]
) -> float:
    """The greatest product on any path upstream from ``start`` that repeats no channel; ``known``: those found."""
    best = own[start]
    path: dict[str, tuple[float, Iterator[Feed]]] = {start: (own[start], iter(feeds.get(start, ())))}
    for _ in range(_MOST_STEPS):
        if not path:
            break
        product, rest = path[next(reversed(path))]
        feed, phi = next(rest, (None, 1.0))
        if feed is None:
            path.popitem()
            continue
        product *= phi
        if feed in path or feed in known or feed not in own:
            best = max(best, product * (1.0 if feed in path else known.get(feed, 1.0)))
        else:
            path[feed] = (product * own[feed], iter(feeds.get(feed, ())))
            best = max(best, product * own[feed])
    return best
