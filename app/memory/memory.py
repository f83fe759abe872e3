"""What the robot remembers: EM-ART's layers, with the desires that led to the accomplishment of each episode."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from app.memory.deeds import Deed, learned_deeds
from app.memory.em_art import Closed, EMArt, Parameters, Pattern, Perceived
from app.memory.kept import Kept, Update
from app.messages import Desire


@dataclass(frozen=True, slots=True)
class Limits:
    """At most so many ``episodes`` and ``events`` are kept, and none closed last more than ``kept_s`` (s) ago."""

    episodes: int
    events: int
    kept_s: float


class Memory:
    """Not for use from several threads at once."""

    def __init__(self, kept: Kept, limits: Limits, parameters: Parameters | None = None) -> None:
        """With what was ``kept``."""
        self.art = EMArt(parameters, events=kept.events, episodes=kept.episodes)
        self._limits = limits
        self._deeds = dict(kept.deeds)
        self._changed: set[int] = set()
        self._used: dict[str, Desire] = {}
        self._led: dict[str, Desire] = {}
        self._accomplished = False

    @property
    def deeds(self) -> Mapping[int, tuple[Deed, ...]]:
        """Desires that led to accomplishments, by episode."""
        return self._deeds

    def perceive(self, pattern: Pattern, emotion: float | None = None) -> Perceived:
        """Take an input; see :meth:`EMArt.perceive`."""
        return self.art.perceive(pattern, emotion)

    def use(self, desires: Mapping[str, Desire]) -> None:
        """``desires``, by key, are at work in the episode under way."""
        self._used.update(desires)

    def accomplish(self) -> None:
        """Something that was desired is done: all that was at work so far in this episode led to it."""
        self._accomplished = True
        self._led.update(self._used)

    def close(self, now: float, emotion: float | None = None) -> Closed | None:
        """The episode under way is over at ``now`` (s): it is learned; None: there was none."""
        led, accomplished = self._led, self._accomplished
        self._reset()
        closed = self.art.close(now, emotion)
        if closed is not None:
            rate = 1.0 if closed.new else self.art.parameters.learning_rate
            self._deeds[closed.episode] = learned_deeds(
                self._deeds.get(closed.episode, ()), led, rate, accomplished=accomplished
            )
            self._changed.add(closed.episode)
        self.bound(now)
        return closed

    def abandon(self) -> None:
        """Nothing is learned of the episode under way."""
        self._reset()
        self.art.abandon()

    def bound(self, now: float) -> None:
        """Forget what is beyond the limits at ``now`` (s)."""
        limits = self._limits
        for episode in self.art.bound(episodes=limits.episodes, events=limits.events, since=now - limits.kept_s):
            self._deeds.pop(episode, None)

    def forget(self, episode: int) -> bool:
        """Remove an episode; whether there was one."""
        self._deeds.pop(episode, None)
        return self.art.forget(episode)

    def forget_all(self) -> None:
        """Remove everything, what is under way among it."""
        self._reset()
        self._deeds.clear()
        self.art.forget_all()

    def take_update(self) -> Update:
        """What is to be kept since the last call."""
        changed, self._changed = self._changed, set()
        return Update(self.art.take_changes(), {each: self._deeds[each] for each in changed if each in self._deeds})

    def _reset(self) -> None:
        self._used, self._led, self._accomplished = {}, {}, False
