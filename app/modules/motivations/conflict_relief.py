"""What Distress does about conflicts of behaviors: it says so, and inhibits what is outdone while that lasts."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from app.attention.desires import SCALE, Source
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import Desires, Exploitation, IntentionReport
from app.modules.motivations.conflicts import Conflict, ConflictLog, in_vain

#: The inhibiting desire leaves by itself after so long (s), and is renewed in half of that.
_EXPIRES_S = 30.0


@dataclass(slots=True)
class _Measure:
    """``inhibiting``: id of the desire; empty: the class cannot be inhibited, it was only said."""

    conflict: Conflict
    inhibiting: str


class ConflictRelief:
    """Acts on ``workspace`` and ``timeline``, by ``source``, once a conflict has lasted for ``after_s`` (s).

    The class that is outdone is inhibited, which frees what it costs, until its rival moves the group no more, or no
    other desire for the class is there. Security desires are not inhibited. ``hands``: behaviors by which people move
    the robot, which are no rivals.
    """

    def __init__(
        self,
        workspace: IntentionWorkspace,
        timeline: Timeline,
        source: Source,
        after_s: float,
        hands: Collection[str] = (),
    ) -> None:
        self._workspace = workspace
        self._timeline = timeline
        self._source = source
        self._after_s = after_s
        self._hands = frozenset(hands)
        self._log = ConflictLog()
        self._desires: Desires | None = None
        self._intention: IntentionReport | None = None
        #: By class that is outdone.
        self._measures: dict[str, _Measure] = {}

    def take(self, report: Exploitation) -> None:
        """An arbiter reports."""
        if report.behavior not in self._hands:
            self._log.take(report)

    def take_desires(self, desires: Desires) -> None:
        """What is desired, and what of it is exploited."""
        self._desires = desires

    def take_intention(self, intention: IntentionReport) -> None:
        """What is intended."""
        self._intention = intention

    def supervise(self, now: float) -> None:
        """Act: to be called several times a second."""
        lasting = self._log.lasting(now)
        for cls, measure in list(self._measures.items()):
            # What is inhibited commands no more: the conflict lasts while its rival moves the group.
            rival = measure.conflict
            goes_on = self._log.moves(rival.winner, rival.group, now) if measure.inhibiting else rival in lasting
            if goes_on and self._is_desired(cls):
                self._renew(cls, measure, now)
            else:
                self._end(cls)
        if self._desires is None or self._intention is None:
            return
        ids = set(self._desires.exploited)
        exploited = {desire.cls for desire in self._desires.desires if desire.id in ids}
        for cls, conflict in in_vain(lasting, self._after_s, self._intention, exploited).items():
            if cls not in self._measures and self._is_desired(cls):
                self._begin(cls, conflict, lasting[conflict])

    def restore(self) -> None:
        """Inhibit nothing."""
        for cls in list(self._measures):
            self._end(cls, quietly=True)

    def _begin(self, cls: str, conflict: Conflict, lasted_s: float) -> None:
        security = self._workspace.strongest()[cls].security
        inhibiting = "" if security else self._inhibit(cls)
        self._measures[cls] = _Measure(conflict, inhibiting)
        who = f"{conflict.outdone} has been outdone by {conflict.winner} for {lasted_s:.0f} s ({conflict.group})"
        text = f"Distress: {who}; inhibits {cls}" if inhibiting else f"Distress: {who}; {cls} is security and stays"
        self._timeline.add("exploitation", cls, text, _data(cls, conflict, in_vain=True))

    def _inhibit(self, cls: str) -> str:
        return self._workspace.add(cls, intensity=SCALE, utility=0.0, ttl=_EXPIRES_S, source=self._source).id

    def _renew(self, cls: str, measure: _Measure, now: float) -> None:
        if not measure.inhibiting:
            return
        try:
            expires = self._workspace.get(measure.inhibiting).expires
        except UnknownDesire:
            # A person withdrew it, who wants it so until the conflict is over.
            return
        if expires is not None and expires - now <= _EXPIRES_S / 2:
            self._workspace.change(measure.inhibiting, ttl=_EXPIRES_S)

    def _end(self, cls: str, *, quietly: bool = False) -> None:
        measure = self._measures.pop(cls)
        if not measure.inhibiting:
            return
        try:
            self._workspace.remove(measure.inhibiting)
        except UnknownDesire:
            return
        if not quietly:
            text = f"Distress is over: {cls} is inhibited no more"
            self._timeline.add("exploitation", cls, text, _data(cls, measure.conflict, in_vain=False))

    def _is_desired(self, cls: str) -> bool:
        return any(
            desire.cls == cls and desire.utility > 0 and desire.source != self._source
            for desire in self._workspace.desires()
        )


def _data(cls: str, conflict: Conflict, *, in_vain: bool) -> dict[str, object]:
    return {
        "classes": [cls],
        "group": conflict.group,
        "winner": conflict.winner,
        "outdone": conflict.outdone,
        "in_vain": in_vain,
    }
