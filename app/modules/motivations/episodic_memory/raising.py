"""The desires that memory adds to the Intention Workspace, and withdraws."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Final

from app.attention.desires import Desire, InvalidDesire, Source, UnknownDesireClass
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.memory.deeds import Raise
from app.messages import RaisedDesire

#: A desire of memory's leaves by itself after so long (s), and is renewed in half of that.
TTL_S: Final = 30.0


@dataclass(frozen=True, slots=True)
class _Standing:
    desire: str
    episode: int
    wish: Raise


class Raised:
    """Makes the desires of memory those that are wished for. What others withdraw is not desired again until
    :meth:`withdraw`."""

    def __init__(
        self, workspace: IntentionWorkspace, author: Source, log: logging.Logger, now: Callable[[], float]
    ) -> None:
        """``now`` gives the robot's clock (s)."""
        self._workspace = workspace
        self._now = now
        self._author = author
        self._log = log
        self._standing: dict[str, _Standing] = {}
        self._refused: set[str] = set()

    @property
    def others(self) -> tuple[Desire, ...]:
        """All desires but memory's own."""
        own = {each.desire for each in self._standing.values()}
        return tuple(desire for desire in self._workspace.desires() if desire.id not in own)

    @property
    def standing(self) -> tuple[RaisedDesire, ...]:
        """Memory's own desires."""
        return tuple(
            RaisedDesire(each.desire, each.wish.deed.cls, each.wish.intensity, each.episode, each.wish.why)
            for each in self._standing.values()
        )

    def make(self, episode: int, wishes: Iterable[Raise]) -> None:
        """Desire ``wishes``, because ``episode`` is recognized, and nothing else."""
        wanted = {wish.deed.key: wish for wish in wishes}
        if not wanted and not self._standing:
            return
        with self._workspace.transaction():
            for key, standing in tuple(self._standing.items()):
                if key not in wanted or standing.episode != episode:
                    self._remove(key)
            for key, wish in wanted.items():
                if key in self._standing:
                    self._keep(key, wish)
                elif key not in self._refused:
                    self._add(key, episode, wish)

    def withdraw(self) -> None:
        """Desire nothing."""
        with self._workspace.transaction():
            for key in tuple(self._standing):
                self._remove(key)
        self._refused.clear()

    def _add(self, key: str, episode: int, wish: Raise) -> None:
        deed = wish.deed
        try:
            added = self._workspace.add(
                deed.cls,
                intensity=wish.intensity,
                utility=wish.utility,
                params=deed.params,
                source=replace(self._author, name=f"{self._author.name}, episode {episode}"),
                ttl=TTL_S,
            )
        except (UnknownDesireClass, InvalidDesire) as failure:
            # It was learned by another version of the program.
            self._log.info("%s is not desired as in episode %d: %s", deed.cls, episode, failure)
            self._refused.add(key)
            return
        self._standing[key] = _Standing(added.id, episode, wish)

    def _keep(self, key: str, wish: Raise) -> None:
        standing = self._standing[key]
        try:
            desire = self._workspace.get(standing.desire)
            expires = desire.expires
            due = expires is None or expires - self._now() <= TTL_S / 2
            if due or wish.intensity != standing.wish.intensity or wish.utility != standing.wish.utility:
                self._workspace.change(standing.desire, intensity=wish.intensity, utility=wish.utility, ttl=TTL_S)
                self._standing[key] = _Standing(standing.desire, standing.episode, wish)
        except UnknownDesire:
            del self._standing[key]
            self._refused.add(key)

    def _remove(self, key: str) -> None:
        standing = self._standing.pop(key)
        try:
            self._workspace.remove(standing.desire)
        except UnknownDesire:
            self._refused.add(key)
