"""The guide's desires in the Intention Workspace: added, changed and withdrawn until they are what it wishes."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from app.attention.desires import InvalidDesire, Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.modules.motivations.tour_guide.desire_changes import desire_changes
from app.modules.motivations.tour_guide.progress import Ended, Withdrawn
from app.modules.motivations.tour_guide.wishes import GO_TO, Wish


@dataclass(frozen=True, slots=True)
class Weight:
    """How much a class is desired, and how good it must be."""

    intensity: float
    utility: float


class GuideDesires:
    """Desires of ``source``, by the keys of wishes; ``weight`` gives that of a class."""

    def __init__(
        self,
        workspace: IntentionWorkspace,
        source: Source,
        weight: Callable[[str], Weight],
        log: logging.Logger,
    ) -> None:
        self._workspace = workspace
        self._source = source
        self._weight = weight
        self._log = log
        self._held: dict[str, tuple[Wish, str]] = {}
        self._spent: set[str] = set()
        self._refused: list[str] = []

    def want(self, wanted: Sequence[Wish]) -> None:
        """Desire ``wanted`` and nothing else. What has ended is not desired again while it is still wished."""
        known = [wish for wish in wanted if wish.cls in self._workspace.classes]
        self._spent &= {wish.key for wish in wanted}
        changes = desire_changes({key: wish for key, (wish, _) in self._held.items()}, known, self._spent)
        if not changes:
            return
        with self._workspace.transaction():
            for key in changes.withdraw:
                self._withdraw(key)
            for wish in changes.change:
                self._workspace.change(self._held[wish.key][1], params=wish.params)
                self._held[wish.key] = wish, self._held[wish.key][1]
            for wish in changes.add:
                self._add(wish)

    def ended(self) -> Iterator[Ended | Withdrawn]:
        """What became of desires since the last call."""
        for key in self._refused:
            yield Ended(key, False)
        self._refused = []
        for key, (wish, id_) in tuple(self._held.items()):
            try:
                report = self._workspace.report(id_)
            except UnknownDesire:
                outcome: str | None = "withdrawn"
            else:
                outcome = report.outcome if report.ended is not None else None
            if outcome is None:
                continue
            del self._held[key]
            self._spent.add(key)
            if outcome in ("done", "failed"):
                yield Ended(key, outcome == "done")
            else:
                self._log.info("its desire for %s was withdrawn by others", wish.cls)
                yield Withdrawn(key)

    def key_of(self, desire_id: str) -> Wish | None:
        """The wish whose desire has this id."""
        return next((wish for wish, id_ in self._held.values() if id_ == desire_id), None)

    def diverted(self) -> bool:
        """Whether another source wants the robot to go elsewhere, at least as much."""
        own = {id_ for _, id_ in self._held.values()}
        least = self._weight(GO_TO).intensity
        return any(
            desire.cls == GO_TO and desire.utility > 0 and desire.id not in own and desire.intensity >= least
            for desire in self._workspace.desires()
        )

    def withdraw(self) -> None:
        """Withdraw all of them."""
        with self._workspace.transaction():
            for key in tuple(self._held):
                self._withdraw(key)
        self._spent.clear()

    def _withdraw(self, key: str) -> None:
        _, id_ = self._held.pop(key)
        try:
            self._workspace.remove(id_)
        except UnknownDesire:
            self._log.debug("desire %s had left already", id_)

    def _add(self, wish: Wish) -> None:
        weight = self._weight(wish.cls)
        try:
            desire = self._workspace.add(
                wish.cls,
                intensity=weight.intensity,
                utility=weight.utility,
                source=self._source,
                params=dict(wish.params),
            )
        except InvalidDesire as refusal:
            self._log.warning("%s cannot be desired as the tour asks: %s", wish.cls, refusal)
            self._spent.add(wish.key)
            self._refused.append(wish.key)
        else:
            self._held[wish.key] = wish, desire.id


def weights(
    intensity: float, intensities: Mapping[str, float], utilities: Mapping[str, float]
) -> Callable[[str], Weight]:
    """The weight of each class: ``intensity`` and utility 1, but for those that are named."""
    return lambda cls: Weight(intensities.get(cls, intensity), utilities.get(cls, 1.0))
