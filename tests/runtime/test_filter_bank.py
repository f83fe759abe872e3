from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.runtime.filter import CLOSED, RateFilter
from app.runtime.filter_bank import FilterBank, Pin
from tests.runtime.wired import WIRED, Build

divisors = st.one_of(st.integers(1, 5), st.just(CLOSED))
names = st.sampled_from(["a", "b", "c", "d"])


@given(st.fixed_dictionaries(dict.fromkeys("abcd", divisors)), st.dictionaries(names, divisors))
def test_apply_changes_exactly_what_differs_and_opens_before_it_closes(
    before: dict[str, float], wanted: dict[str, float]
) -> None:
    bank = FilterBank()
    order: list[tuple[float, float]] = []
    for name, divisor in before.items():
        bank.add(name, RateFilter(divisor, lambda was, now: order.append((was, now))))
    changed = bank.apply(wanted)
    assert bank.divisors() == {**before, **wanted}
    assert changed == {n: (before[n], d) for n, d in wanted.items() if d != before[n]}
    closing = [now > was for was, now in order]
    assert closing == sorted(closing)
    assert len(order) == len(changed)


@given(st.dictionaries(names, divisors), st.sampled_from([("x", 1.0, KeyError), ("a", 0.5, ValueError)]))
def test_a_set_of_filters_with_one_mistake_changes_nothing(
    wanted: dict[str, float], mistake: tuple[str, float, type[Exception]]
) -> None:
    bank = FilterBank()
    for name in "abcd":
        bank.add(name, RateFilter(2))
    wrong_name, wrong_divisor, error = mistake
    with pytest.raises(error):
        bank.apply({**wanted, wrong_name: wrong_divisor})
    assert set(bank.divisors().values()) == {2}


def test_an_unknown_filter_is_named_with_those_there_are() -> None:
    bank = FilterBank()
    for name in ("A.numbers", "B.others"):
        bank.add(name, RateFilter())
    with pytest.raises(KeyError, match=r"no filter 'A\.number'; did you mean 'A\.numbers'\? there are: A\.numbers"):
        bank.apply({"A.number": 1})
    with pytest.raises(KeyError, match=r"no filter 'C\.sums'; there are: A\.numbers, B\.others"):
        bank.apply({"C.sums": 1})


def test_a_pinned_filter_is_not_changed_by_others(build: Build) -> None:
    filters = build(*WIRED).filters
    filters.pin("B.numbers", Pin(4, offset=2))
    assert filters.apply({"B.numbers": 1, "A.numbers": 2}) == {"A.numbers": (1, 2)}
    assert filters.divisors()["B.numbers"] == 4
    filters.pin("B.numbers", Pin(3))
    assert filters.divisors()["B.numbers"] == 3
    with pytest.raises(ValueError, match="offset"):
        filters.pin("B.numbers", Pin(3, offset=-1))
    with pytest.raises(KeyError, match="no filter"):
        filters.pin("B.letters", Pin(3))


def test_what_may_not_be_decimated_is_pinned_open_or_closed(build: Build) -> None:
    modules, channels = WIRED
    filters = build(modules, {**channels, "n": {"decimable": False}}).filters
    for name in ("A.numbers", "B.numbers"):
        with pytest.raises(ValueError, match=f"the channel of {name} may not be decimated: 1 or off, not 2"):
            filters.pin(name, Pin(2))
        assert (filters.divisors()[name], set(filters.pinned())) == (1, set())
    for divisor in (CLOSED, 1):
        filters.pin("B.numbers", Pin(divisor))
        assert filters.divisors()["B.numbers"] == divisor
    filters.pin("B.relayed", Pin(2))


@given(st.integers(1, 5), st.integers(0, 6), st.integers(1, 5))
def test_a_delay_counts_from_the_first_opening_and_only_once(divisor: int, offset: int, later: int) -> None:
    bank, rate_filter = FilterBank(), RateFilter(CLOSED)
    bank.add("M.p", rate_filter)
    bank.delay(offset)
    assert not any(rate_filter.offer() for _ in range(10))
    bank.apply({"M.p": divisor})
    passed = [number for number in range(40) if rate_filter.offer()]
    assert passed == list(range(offset, 40, divisor))
    bank.apply({"M.p": CLOSED})
    bank.apply({"M.p": later})
    assert rate_filter.offer()


def test_a_delay_leaves_open_and_pinned_filters_alone() -> None:
    bank = FilterBank()
    opened, pinned = RateFilter(1), RateFilter(CLOSED)
    bank.add("M.open", opened)
    bank.add("M.pinned", pinned)
    bank.pin("M.pinned", Pin(2, offset=1))
    bank.delay(5)
    assert opened.offer()
    assert [pinned.offer() for _ in range(4)] == [False, True, False, True]
    with pytest.raises(ValueError, match="a number of messages from 0, not -1"):
        bank.delay(-1)


def test_a_filter_that_is_given_back_obeys_again(build: Build) -> None:
    filters = build(*WIRED).filters
    filters.pin("B.numbers", Pin(4))
    assert set(filters.pinned()) == {"B.numbers"}
    filters.unpin("B.numbers", 2)
    filters.unpin("A.numbers", 7)  # never pinned
    assert (filters.divisors()["B.numbers"], filters.divisors()["A.numbers"]) == (2, 1)
    assert filters.apply({"B.numbers": 3}) == {"B.numbers": (2, 3)}
