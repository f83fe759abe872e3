"""From the desires that the guide has to those that it wants: what to add, change and withdraw. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from app.modules.motivations.tour_guide.wishes import Wish


@dataclass(frozen=True, slots=True)
class DesireChanges:
    """Wishes to add, those whose desire changes its parameters, and keys of those to withdraw."""

    add: tuple[Wish, ...] = ()
    change: tuple[Wish, ...] = ()
    withdraw: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.add or self.change or self.withdraw)


def desire_changes(held: Mapping[str, Wish], wanted: Iterable[Wish], spent: Collection[str]) -> DesireChanges:
    """What leads from ``held``, by key, to ``wanted``; keys in ``spent`` have ended and are not desired again."""
    wishes = {wish.key: wish for wish in wanted if wish.key not in spent}
    same = {key for key, wish in wishes.items() if key in held and held[key].cls == wish.cls}
    return DesireChanges(
        tuple(wish for key, wish in wishes.items() if key not in same),
        tuple(wish for key, wish in wishes.items() if key in same and dict(wish.params) != dict(held[key].params)),
        tuple(key for key in held if key not in same),
    )
