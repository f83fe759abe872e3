"""How many connections the console bears, and which gives way to a new one.

A connection without a request yet, or whose request is not whole, costs its client nothing. So while there is no room,
the one that has waited longest is closed. A client that sends its request at once, as browsers do, is not kept out by
connections that wait.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Protocol

from app.base.errors import ConfigError
from app.console.access.auth import is_loopback
from app.console.access.login_attempts import origin_of

if sys.platform != "win32":
    import resource

MOST_CONNECTIONS = 512
#: Of one address; of this computer, where every client behind a proxy seems to come from, as many as of all.
MOST_OF_ONE = 128
#: Never taken by WebSockets, so that REST is there, the emergency stop among it.
KEPT_FOR_REQUESTS = 32
#: Files, pipes and sockets that the program needs besides, at most.
NEEDED_DESCRIPTORS = 96
#: A view of the scene takes a socket, and two more to viser.
DESCRIPTORS_A_CONNECTION = 3
FEWEST_CONNECTIONS = 2 * KEPT_FOR_REQUESTS
#: More than all of this takes is not asked of the system.
_WANTED_DESCRIPTORS = 4096


def most_connections() -> int:
    """How many connections this process may hold, having raised its own limit of open files as far as it may.

    Raises ConfigError where they are too few to serve a single client.
    """
    if sys.platform == "win32":
        return MOST_CONNECTIONS  # sockets are no files there
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = _WANTED_DESCRIPTORS if hard == resource.RLIM_INFINITY else min(hard, _WANTED_DESCRIPTORS)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
        soft = wanted
    return connections_within(_WANTED_DESCRIPTORS if soft == resource.RLIM_INFINITY else soft)


def connections_within(descriptors: int) -> int:
    """How many connections a process may hold that may open ``descriptors`` files. Raises ConfigError for too few."""
    fewest = NEEDED_DESCRIPTORS + DESCRIPTORS_A_CONNECTION * FEWEST_CONNECTIONS
    if descriptors < fewest:
        raise ConfigError(
            f"the program needs {fewest} file descriptors and may open {descriptors}: raise the limit, as with "
            "`ulimit -n 1024`"
        )
    return min(MOST_CONNECTIONS, (descriptors - NEEDED_DESCRIPTORS) // DESCRIPTORS_A_CONNECTION)


class Visitor(Protocol):
    """A connection."""

    @property
    def address(self) -> str:
        """Where it comes from, without the port."""

    @property
    def waits(self) -> bool:
        """Whether it holds its place without having asked for anything, or without taking what it asked for."""

    def give_way(self) -> None:
        """End now."""


class Visitors:
    """All connections: at most ``most``, and of one address beyond this computer ``most_of_one``."""

    def __init__(self, most: int = MOST_CONNECTIONS, most_of_one: int = MOST_OF_ONE) -> None:
        self._most = most
        self._most_of_one = most_of_one
        #: In the order in which they came, or were last served: the one that has waited longest comes first.
        self._visitors: dict[Visitor, None] = {}
        self._sockets: dict[Visitor, None] = {}
        self._of: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self._visitors) + len(self._sockets)

    def enter(self, visitor: Visitor) -> bool:
        """A connection was made; False where there is no room, though others give way."""
        origin = origin_of(visitor.address)
        if self._of.get(origin, 0) >= self._limit_of(visitor) and not self.make_room(
            lambda other: origin_of(other.address) == origin
        ):
            return False
        if len(self) >= self._most and not self.make_room():
            return False
        self._visitors[visitor] = None
        self._of[origin] = self._of.get(origin, 0) + 1
        return True

    def served(self, visitor: Visitor) -> None:
        """It was answered, and waits from now on."""
        if visitor in self._visitors:
            del self._visitors[visitor]
            self._visitors[visitor] = None

    def becomes_socket(self, visitor: Visitor, socket: Visitor) -> bool:
        """``visitor`` goes on as the WebSocket ``socket``; False where there are enough of these: then it has left."""
        if visitor not in self._visitors or len(self._sockets) >= self._most - KEPT_FOR_REQUESTS:
            self.leave(visitor)
            return False
        del self._visitors[visitor]
        self._sockets[socket] = None
        return True

    def leave(self, visitor: Visitor) -> None:
        if visitor in self._visitors:
            del self._visitors[visitor]
        elif visitor in self._sockets:
            del self._sockets[visitor]
        else:
            return
        origin = origin_of(visitor.address)
        self._of[origin] -= 1
        if self._of[origin] == 0:
            del self._of[origin]

    def make_room(self, among: Callable[[Visitor], bool] = lambda _: True) -> bool:
        """End the connection that has waited longest; False where none waits."""
        longest = next((visitor for visitor in self._visitors if visitor.waits and among(visitor)), None)
        if longest is None:
            return False
        self.leave(longest)
        longest.give_way()
        return True

    def _limit_of(self, visitor: Visitor) -> int:
        return self._most if is_loopback(visitor.address) else self._most_of_one
