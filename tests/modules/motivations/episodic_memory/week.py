"""A robot that leads tours and remembers, in virtual time: TourGuide as in ``led_lab``, EpisodicMemory beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.attention.reports import desires_report
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.memory.service import MemoryService
from app.memory.store import MemoryStore
from app.messages import (
    Desires,
    EmotionState,
    HeardWords,
    IntentionReport,
    Localization,
    MemoryState,
    PerceptEvent,
    Persons,
    Places,
)
from app.tours.model import Tour
from tests.modules.fakes import Bench, drain
from tests.modules.motivations.tour_guide.led_lab import LedLab

MODULE = "app.modules.motivations.episodic_memory.episodic_memory:EpisodicMemory"
INPUTS = {
    "events": PerceptEvent,
    "persons": Persons,
    "localization": Localization,
    "places": Places,
    "words": HeardWords,
    "desires": Desires,
    "intention": IntentionReport,
    "emotions": EmotionState,
}
#: Behaviors that command something, by their desire class.
ACTS = ("GoTo", "Say")


def memory_bench(
    store: MemoryStore,
    workspace: IntentionWorkspace,
    timeline: Timeline,
    service: MemoryService,
    **settings: Any,
) -> Bench:
    """EpisodicMemory in a graph of its own, with these services."""
    return Bench(
        MODULE,
        inputs=INPUTS,
        outputs={"memory": MemoryState},
        settings={"enabled": True, **settings},
        services={
            MemoryStore: store,
            IntentionWorkspace: workspace,
            Timeline: timeline,
            MemoryService: service,
        },
    )


def fulfilled(now: float, classes: tuple[str, ...]) -> IntentionReport:
    """An intention that gives these classes what they desire."""
    return IntentionReport(
        now, (), classes, omega=0.0, bound=0.0, use={}, filters={}, proven=True, solve_ms=0.0, relaxed=(), reasons={},
        parameters={}, desires={},
    )  # fmt: skip


class RememberingLab(LedLab):
    """A LedLab whose robot also remembers, in ``folder``."""

    def __init__(self, folder: Path, tour: Tour, places: Mapping[str, Pose2]) -> None:
        super().__init__(folder, tour, places)
        self.memory = memory_bench(MemoryStore(folder / "memory"), self.workspace, self.timeline, MemoryService())
        #: Every state of memory, in order.
        self.remembered: list[MemoryState] = []
        self._there: frozenset[str] = frozenset()

    async def __aenter__(self) -> RememberingLab:
        await self.memory.__aenter__()
        self._states = self.memory.listen("memory")
        await super().__aenter__()
        return self

    async def __aexit__(self, *error: object) -> None:
        await super().__aexit__(*error)
        await self.memory.__aexit__(*error)

    def hear(self, text: str) -> None:
        super().hear(text)
        now = self.bench.clock.now()
        heard = HeardWords(
            now, text, False, confidence=1.0, likeliest=text, direction=(1, 0, 0), words=(text,), language="en"
        )
        self.memory.feed("words", heard)

    async def _step(self) -> None:
        await super()._step()
        now, feed = self.bench.clock.now(), self.memory.feed
        feed("places", Places(now, self.places))
        feed("localization", self._localized(now))
        there = frozenset(str(face.track) for face in self._faces())
        for track in there ^ self._there:
            name = "face.appears" if track in there else "face.leaves"
            feed("events", PerceptEvent(now, name, "face", track, "kinect", now, 0.9, None, None))
        self._there = there
        strongest = self.workspace.strongest()
        exploited = tuple(strongest[cls].id for cls in ACTS if cls in strongest)
        feed("desires", desires_report(self.workspace, now, exploited))
        feed("intention", fulfilled(now, tuple(strongest)))
        self.remembered += drain(self._states)
