"""Which connections are let in, and which are closed for them."""

from __future__ import annotations

import resource
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.errors import ConfigError
from app.console.access.connection_limits import (
    FEWEST_CONNECTIONS,
    KEPT_FOR_REQUESTS,
    MOST_CONNECTIONS,
    Visitors,
    connections_within,
    most_connections,
)


@dataclass(eq=False)
class Guest:
    address: str = "127.0.0.1"
    waits: bool = True
    gone: list[bool] = field(default_factory=list)

    def give_way(self) -> None:
        self.gone.append(True)


def test_who_has_waited_longest_gives_way() -> None:
    visitors = Visitors(3)
    first, second, third, fourth, fifth = (Guest() for _ in range(5))
    for guest in (first, second, third):
        assert visitors.enter(guest)
    visitors.served(first)
    second.waits = False
    assert visitors.enter(fourth)
    assert visitors.enter(fifth)
    assert [bool(guest.gone) for guest in (first, second, third, fourth, fifth)] == [True, False, True, False, False]
    visitors.leave(first)  # as its connection's end says, later
    assert len(visitors) == 3


def test_busy_connections_do_not_give_way() -> None:
    visitors = Visitors(2)
    busy = [Guest(waits=False), Guest(waits=False)]
    for guest in busy:
        visitors.enter(guest)
    assert not visitors.enter(Guest())
    visitors.leave(busy[0])
    assert visitors.enter(Guest())


def test_one_address_takes_its_own_places_alone_but_this_computer_may_have_all() -> None:
    visitors = Visitors(10, 2)
    other, own = Guest("192.0.2.9"), [Guest("192.0.2.1") for _ in range(3)]
    visitors.enter(other)
    for guest in own:
        assert visitors.enter(guest)
    assert [bool(guest.gone) for guest in (other, *own)] == [False, True, False, False]
    for guest in own:
        guest.waits = False
    assert not visitors.enter(Guest("192.0.2.1"))
    for _ in range(7):
        assert visitors.enter(Guest("127.0.0.1", waits=False))
    assert not other.gone


def test_websockets_never_give_way_and_leave_room() -> None:
    most = KEPT_FOR_REQUESTS + 2
    visitors = Visitors(most)
    sockets = [Guest(waits=False) for _ in range(3)]
    taken = []
    for socket in sockets:
        guest = Guest(waits=False)
        assert visitors.enter(guest)
        taken.append(visitors.becomes_socket(guest, socket))
    assert taken == [True, True, False]
    assert len(visitors) == 2
    for _ in range(2 * most):
        assert visitors.enter(Guest())
    assert not sockets[0].gone
    visitors.leave(sockets[0])
    visitors.leave(sockets[0])
    guest = Guest(waits=False)
    visitors.enter(guest)
    assert visitors.becomes_socket(guest, sockets[2])


@given(st.lists(st.tuples(st.sampled_from("eslw"), st.integers(0, 30)), max_size=200))
def test_there_are_never_more_than_allowed(steps: list[tuple[str, int]]) -> None:
    visitors = Visitors(8, 3)
    guests = [Guest(f"192.0.2.{number % 5}", waits=number % 3 > 0) for number in range(31)]
    inside: list[Guest] = []
    for step, number in steps:
        guest = guests[number]
        if step == "e" and guest not in inside and visitors.enter(guest):
            guest.gone.clear()
            inside.append(guest)
        elif step == "s":
            visitors.served(guest)
        elif step == "l" and guest in inside:
            visitors.leave(guest)
            inside.remove(guest)
        elif step == "w":
            guest.waits = not guest.waits
        inside = [guest for guest in inside if not guest.gone]
        assert len(visitors) == len(inside) <= 8
        assert all(count <= 3 for count in Counter(guest.address for guest in inside).values())


@pytest.mark.parametrize(("descriptors", "most"), [(1024, 309), (4096, MOST_CONNECTIONS), (288, FEWEST_CONNECTIONS)])
def test_there_are_no_more_connections_than_descriptors_for_them(descriptors: int, most: int) -> None:
    assert connections_within(descriptors) == most


def test_too_few_descriptors_are_refused_with_how_many_are_needed() -> None:
    with pytest.raises(ConfigError, match=r"needs 288 file descriptors and may open 287: .*ulimit -n 1024"):
        connections_within(287)


def test_the_limit_is_raised_as_far_as_it_may() -> None:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (300, before[1]))
        assert most_connections() == connections_within(min(before[1], 4096))
        assert resource.getrlimit(resource.RLIMIT_NOFILE)[0] == min(before[1], 4096)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


def test_a_program_that_may_open_too_few_files_says_so_and_ends() -> None:
    command = f"ulimit -n 60; exec {sys.executable} -P -m app.cli run --port 0"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.splitlines() == [
        "hbba run: the program needs 288 file descriptors and may open 60: raise the limit, as with `ulimit -n 1024`"
    ]
