"""The wish that the face shows an emotion: a desire of class Express that gives way to every other one of its class."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

from app.attention.desires import Source
from app.attention.workspace import IntentionWorkspace, WorkspaceChange
from app.messages import Emotion, ShownEmotion

EXPRESS: Final = "Express"
INTENSITY: Final = 0.5
"""Of the desire: less than people or tours ask for anything with."""
EXPRESSIONS: Final[Mapping[Emotion, tuple[str, float]]] = MappingProxyType(
    {"joy": ("happy", 1.0), "anger": ("angry", 1.0), "sadness": ("sad", 1.0), "fear": ("sad", 0.5)}
)
"""By emotion, the expression, and the share of it. The face of IRL-1 has none of fear: raised brows, half of those of
sadness, are the nearest."""


class FaceWish:
    """States the desire in ``workspace``, by ``source``, from :meth:`start` to :meth:`stop`.

    There is none while another desire of the class is there, be it weaker or one that inhibits the class: what is
    desired explicitly counts alone, from the moment it comes. A desire that was withdrawn by others is not stated again
    before another emotion shows, or none.
    """

    def __init__(self, workspace: IntentionWorkspace, source: Source) -> None:
        self._workspace = workspace
        self._source = source
        self._shown: ShownEmotion | None = None
        self._id: str | None = None
        #: The emotion whose desire was withdrawn by others.
        self._unwanted: Emotion | None = None
        self._end: Callable[[], None] | None = None

    @property
    def desire(self) -> str:
        """Id of the desire; empty: there is none."""
        return self._id or ""

    def start(self) -> None:
        """Follow other desires."""
        if EXPRESS in self._workspace.classes:
            self._end = self._workspace.observe(self._take)

    def stop(self) -> None:
        """Withdraw the desire."""
        self.show(None)
        if self._end is not None:
            self._end()
            self._end = None

    def show(self, shown: ShownEmotion | None) -> None:
        """Wish that the face shows ``shown``; None: nothing."""
        self._shown = shown
        if shown is None or shown.emotion != self._unwanted:
            self._unwanted = None
        self._settle()

    def _take(self, change: WorkspaceChange) -> None:
        if self._id is not None and any(removal.desire.id == self._id for removal in change.removed):
            self._id = None
            self._unwanted = None if self._shown is None else self._shown.emotion
        if any(desire.cls == EXPRESS for desire in (*change.added, *(each.desire for each in change.removed))):
            self._settle()

    def _settle(self) -> None:
        if self._end is None:
            return
        shown = self._shown
        others = any(desire.cls == EXPRESS and desire.id != self._id for desire in self._workspace.desires())
        if shown is None or others or shown.emotion == self._unwanted:
            stated, self._id = self._id, None
            if stated is not None:
                self._workspace.remove(stated)
            return
        expression, share = EXPRESSIONS[shown.emotion]
        params = {"expression": expression, "strength": share * shown.strength}
        if self._id is None:
            self._id = self._workspace.add(
                EXPRESS, intensity=INTENSITY, utility=1.0, source=self._source, params=params
            ).id
        elif self._workspace.get(self._id).params != self._workspace.classes[EXPRESS].validated(params):
            self._workspace.change(self._id, params=params)
