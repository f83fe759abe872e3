"""Desires of a log had again: what operators and other programs wanted then, they want now, at the recorded times."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Collection
from typing import get_args

from app.attention.desires import InvalidDesire, Source, SourceKind, UnknownDesireClass
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import Desire, Desires

log = logging.getLogger("hbba.replay")


class CountedIds:
    """Ids of desires that are the same in every run: those of the log where it gives them, else counted."""

    def __init__(self) -> None:
        self._count = 0
        self.next: str | None = None

    def __call__(self) -> str:
        """The id for the next desire; another at each call."""
        given, self.next = self.next, None
        if given is not None:
            return given
        self._count += 1
        return f"d-{self._count:010x}"


class RecordedDesires:
    """Keeps the recorded desires in ``workspace``, without those of the program's own ``modules``.

    ``ids`` is the source of the workspace's ids. Desires of ``ignored`` classes are skipped.
    """

    def __init__(
        self,
        workspace: IntentionWorkspace,
        ids: CountedIds,
        modules: Collection[str],
        now: Callable[[], float],
        ignored: Collection[str] = (),
    ) -> None:
        self._workspace = workspace
        self._ids = ids
        self._modules = frozenset(modules)
        self._now = now
        self._ignored = frozenset(ignored)
        #: Desires now in the workspace: by id in the log, as recorded, with the id here.
        self._standing: dict[str, tuple[Desire, str]] = {}
        self._refused: set[str] = set()

    def take(self, record: Desires | None) -> None:
        """Make it so that the desires of ``record`` stand, and no others of the log; None: none."""
        wanted = {d.id: d for d in (record.desires if record is not None else ()) if self._is_foreign(d)}
        with self._workspace.transaction():
            for gone in [log_id for log_id in self._standing if log_id not in wanted]:
                self._remove(gone)
            for desire in sorted(wanted.values(), key=lambda d: d.created):
                before = self._standing.get(desire.id)
                if before is None:
                    self._add(desire)
                elif before[0] != desire:
                    self._change(before[1], desire)

    def _is_foreign(self, desire: Desire) -> bool:
        own = desire.source.kind == "motivation" and desire.source.name in self._modules
        return not own and desire.cls not in self._ignored

    def _ttl(self, desire: Desire) -> float | None:
        return None if desire.expires is None else desire.expires - self._now()

    def _add(self, desire: Desire) -> None:
        ttl = self._ttl(desire)
        if ttl is not None and ttl <= 0:
            return
        kind = desire.source.kind if desire.source.kind in get_args(SourceKind) else "operator"
        self._ids.next = desire.id
        try:
            added = self._workspace.add(
                desire.cls,
                intensity=desire.intensity,
                utility=desire.utility,
                security=desire.security,
                params=desire.params,
                source=Source(kind, desire.source.name, motive=desire.source.motive),
                ttl=ttl,
            )
        except (UnknownDesireClass, InvalidDesire) as failure:
            self._refuse(desire, failure)
            return
        finally:
            self._ids.next = None
        self._standing[desire.id] = (desire, added.id)

    def _change(self, own_id: str, desire: Desire) -> None:
        ttl = self._ttl(desire)
        try:
            if ttl is not None and ttl <= 0:
                self._remove(desire.id)
                return
            self._workspace.change(
                own_id,
                intensity=desire.intensity,
                utility=desire.utility,
                security=desire.security,
                params=desire.params,
                ttl=ttl,
            )
        except UnknownDesire:  # it expired here, but not in the log
            del self._standing[desire.id]
            self._add(desire)
            return
        except InvalidDesire as failure:
            self._refuse(desire, failure)
            return
        self._standing[desire.id] = (desire, own_id)

    def _remove(self, log_id: str) -> None:
        _, own_id = self._standing.pop(log_id)
        with contextlib.suppress(UnknownDesire):  # it expired by itself, as it did then
            self._workspace.remove(own_id)

    def _refuse(self, desire: Desire, failure: Exception) -> None:
        if desire.id not in self._refused:
            self._refused.add(desire.id)
            log.warning("the log's desire for %s cannot be had in this program: %s", desire.cls, failure)
