"""EpisodicMemory: the motivation that remembers episodes and expects what followed before.

    ┌─────────────────────────────────────────────────────────────────────────────────────────────┐
    │ EpisodicMemory  in   events        PerceptEvent: codes, faces                                │
    │                 in   persons       Persons, m in odom                                        │
    │                 in   localization  Localization: at which place                              │
    │                 in   places        Places of the map                                         │
    │                 in   words         HeardWords                                                │
    │                 in   desires       Desires: exploited, accomplished                          │
    │                 in   intention     IntentionReport: classes fulfilled                        │
    │                 in   emotions      EmotionState                                              │
    │                 out  memory        MemoryState, with each change                             │
    │                 is the MemoryServer; edits desires of the classes `raises`                   │
    └─────────────────────────────────────────────────────────────────────────────────────────────┘

What it learns and recognizes is decided by EM-ART (:mod:`app.memory`). All inputs may be absent, and none makes its
source work. An episode ends with silence, and where the robot comes to another place. While one is recognized, it
desires what led to its accomplishment before. Off, it takes nothing in, and deletes the file that there is.
"""

from __future__ import annotations

import asyncio
import contextlib
from contextlib import ExitStack
from dataclasses import replace
from typing import Any, Final

from app.attention.desires import SCALE
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.memory.deeds import Bounds, raised
from app.memory.em_art import Changes, Parameters, Perceived, Recognized
from app.memory.kept import Kept, Update
from app.memory.memory import Limits, Memory
from app.memory.service import MemoryRefused, MemoryService, UnknownEpisode
from app.memory.short_term import MOVED_S, is_silent, notable
from app.memory.store import MemoryStore, StoreBusy, StoreUnreadable
from app.messages import (
    AnticipatedEvent,
    Desires,
    EmotionState,
    EpisodeSummary,
    HeardWords,
    IntentionReport,
    Localization,
    MemoryReport,
    MemoryState,
    PerceptEvent,
    Persons,
    Places,
)
from app.modules.motivations.episodic_memory.describing import (
    MOST_ANTICIPATED,
    MOST_UNDER_WAY,
    event_message,
    report,
    summaries,
)
from app.modules.motivations.episodic_memory.raising import Raised
from app.modules.motivations.episodic_memory.scene import Scene, Senses
from app.modules.motivations.episodic_memory.settings import EpisodicMemorySettings
from app.modules.motivations.motivation import Motivation
from app.runtime.module import Input, ModuleContext

_BEAT_S: Final = 0.5
_DAY_S: Final = 86_400.0
#: Old episodes are looked for so often (s), and ten times in the time that they are kept.
_BOUND_S: Final = 3600.0
#: So many updates wait for a disk that refuses.
_MOST_WAITING: Final = 100
_NOTHING: Final = Update(Changes((), (), (), ()))


class EpisodicMemory(Motivation):
    """Remembers episodes."""

    title = "Episodic memory"
    Settings = EpisodicMemorySettings
    settings: EpisodicMemorySettings

    _memory: Memory
    _store: MemoryStore
    _timeline: Timeline
    _raised: Raised

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        settings = self.settings
        self._scene = scene = Scene(
            Senses(
                near_m=settings.near_m,
                person_m=settings.person_m,
                objects=settings.objects,
                people=settings.people,
                acts=settings.acts,
                identity=settings.identity,
                stays_s=120.0,
            )
        )
        events = self.input("events", PerceptEvent, capacity=32, wants="never")
        persons = self.input("persons", Persons, wants="never")
        localization = self.input("localization", Localization, wants="never")
        places = self.input("places", Places, wants="never")
        words = self.input("words", HeardWords, capacity=8, wants="never")
        desires = self.input("desires", Desires, capacity=32, wants="never")
        intention = self.input("intention", IntentionReport, wants="never")
        emotions = self.input("emotions", EmotionState, wants="never")
        self.output_memory = self.output("memory", MemoryState)
        self._bounds = Bounds(
            most=settings.most,
            boost=settings.boost,
            least=settings.least,
            count=settings.most_desires,
            scale=SCALE,
        )
        #: What there is, since when it has been so, and what of it has been input.
        self._there: frozenset[tuple[str, str]] = frozenset()
        self._since = 0.0
        self._not_before = 0.0
        self._input: frozenset[tuple[str, str]] = frozenset()
        self._silent_since: float | None = None
        self._recognized: Recognized | None = None
        self._bounded = 0.0
        self._waiting: list[Update] = []
        self._problem = ""
        self._writes = True
        #: Whether the disk refused the last update.
        self._refused = False
        self._episodes: tuple[EpisodeSummary, ...] = ()
        self._shown: MemoryState | None = None
        #: One at a time reads and changes the memory, whose work is done in the module's thread.
        self._lock = asyncio.Lock()
        self._stack = ExitStack()
        self._opened = False
        if not settings.enabled:
            # What comes in is taken, so that none waits, and forgotten.
            ports: tuple[Input[Any], ...] = (events, persons, localization, places, words, desires, intention, emotions)
            for port in ports:
                self.on(port, _ignore)
            return
        self.on(events, scene.take_event)
        self.on(persons, scene.take_persons)
        self.on(localization, scene.take_localization)
        self.on(places, scene.take_places)
        self.on(words, scene.take_words)
        self.on(desires, self._take_desires)
        self.on(intention, scene.take_intention)
        self.on(emotions, scene.take_emotions)
        self.every(_BEAT_S, self._beat)

    async def start(self) -> None:
        """Read what is kept; or, off, delete it."""
        self._store = self.service(MemoryStore)
        self._opened = True
        self._timeline = self.service(Timeline)
        self._raised = Raised(self.service(IntentionWorkspace), self.source, self.log, self.clock.now)
        self._stack.callback(self._raised.withdraw)
        if not self.settings.enabled:
            await self._switch_off()
            return
        kept = await self.compute_background(self._read)
        settings = self.settings
        limits = Limits(settings.most_episodes, settings.most_events, settings.kept_days * _DAY_S)
        self._memory = Memory(kept, limits, Parameters(habit=settings.habit))
        # The numbers of persons are those of one run of the program.
        self._memory.art.forget_items("person", lambda item: item.startswith("person "))
        self._bounded = self.clock.now()
        self._memory.bound(self._bounded)
        if self._problem:
            self._report_problem()
        await self._keep()
        self._stack.callback(self.service(MemoryService).attach(self))
        self._publish()

    async def stop(self) -> None:
        """Withdraw all desires. The episode under way is not kept."""
        self._stack.close()
        if self._opened:
            await self.compute_background(self._store.close)

    # --- the MemoryServer ------------------------------------------------------------------------------------------

    async def report(self) -> MemoryReport:
        """All that is remembered."""
        async with self._lock:
            return report(self._memory, self.clock.now())

    async def forget(self, episode: int) -> None:
        """Remove one episode. Raises UnknownEpisode, MemoryRefused."""
        async with self._lock:
            if not self._memory.forget(episode):
                raise UnknownEpisode(f"no episode has the number {episode}: it may have been forgotten")
            self._timeline.add("memory", str(episode), f"Episode {episode} is deleted")
            await self._forgotten()

    async def forget_all(self) -> None:
        """Remove all that is remembered. Raises MemoryRefused."""
        async with self._lock:
            self._memory.forget_all()
            self._timeline.add("memory", "all", "All episodes are deleted")
            await self._forgotten()

    async def _forgotten(self) -> None:
        self._without_forgotten()
        await self._keep()
        self._publish()
        if self._waiting:
            raise MemoryRefused(f"it is forgotten, and still in the file: {self._problem}")

    # --- what comes in ---------------------------------------------------------------------------------------------

    async def _take_desires(self, message: Desires) -> None:
        async with self._lock:
            if self._scene.take_desires(message):
                self._use()
                self._memory.accomplish()

    async def _beat(self) -> None:
        now = self.clock.now()
        async with self._lock:
            pattern, left = self._scene.look(now)
            if left:
                await self._close(now, "the robot is at another place")
                # What was elsewhere is no part of what begins here.
                self._not_before = now + MOVED_S
            there = notable(pattern)
            if there != self._there:
                self._there, self._since = there, now
            self._input &= there
            silent = is_silent(pattern)
            if silent and self._silent_since is None:
                self._silent_since = now
            elif not silent:
                self._silent_since = None
            if self._silent_since is not None and now - self._silent_since >= self.settings.silence_s:
                await self._close(now, "no one and nothing is there")
            elif self._settled(now) and not silent and not there <= self._input:
                self._input = there
                perceived = await self.compute(self._memory.perceive, pattern, self._scene.emotion)
                self._perceived(perceived)
            self._use()
            self._desire()
            if now - self._bounded >= min(_BOUND_S, self.settings.kept_days * _DAY_S / 10):
                self._bounded = now
                self._memory.bound(now)
                self._without_forgotten()
                await self._keep()
        self._publish()

    # --- inside ----------------------------------------------------------------------------------------------------

    def _settled(self, now: float) -> bool:
        return now - self._since >= self.settings.settle_s and now >= self._not_before

    def _use(self) -> None:
        if self._memory.art.under_way:
            self._memory.use(self._scene.at_work(self.settings.raises, self._raised.others))

    def _perceived(self, perceived: Perceived) -> None:
        if perceived.anticipated:
            text = f"What was expected has come: event {perceived.event}"
            self._timeline.add("memory", "expected", text, {"event": perceived.event})
        self._recognize(perceived.recognized)

    def _recognize(self, found: Recognized | None) -> None:
        before, self._recognized = self._recognized, found
        if found is not None and (before is None or before.episode != found.episode):
            times = self._memory.art.episodes[found.episode].times
            this = f"This is like episode {found.episode}"
            text = f"{this}, which has happened once" if times == 1 else f"{this}, which has happened {times} times"
            data = {"episode": found.episode, "match": round(found.match, 3)}
            self._timeline.add("memory", str(found.episode), text, data)

    def _without_forgotten(self) -> None:
        """What is recognized and expected may have been forgotten."""
        if self._recognized is not None:
            self._recognize(self._memory.art.recognized())
            self._desire()

    def _desire(self) -> None:
        found = self._recognized
        if found is None:
            self._raised.make(0, ())
            return
        deeds = self._memory.deeds.get(found.episode, ())
        wishes = raised(found.episode, deeds, self._raised.others, self.settings.raises, self._bounds)
        self._raised.make(found.episode, wishes)

    async def _close(self, now: float, why: str) -> None:
        if not self._memory.art.under_way:
            return
        self._input, self._recognized = frozenset(), None
        self._raised.withdraw()
        closed = await self.compute(self._memory.close, now, self._scene.emotion)
        if closed is None:
            return
        id_ = closed.episode
        text = f"A new episode, {id_}, is over: {why}" if closed.new else f"Episode {id_} is over again: {why}"
        self._timeline.add("memory", str(id_), text, {"new": closed.new})
        await self._keep()

    async def _switch_off(self) -> None:
        try:
            if await self.compute_background(self._store.delete):
                text = "Memory is off: what was remembered is deleted"
                self._timeline.add("memory", "off", text)
        except OSError as failure:
            self._problem = f"what was remembered cannot be deleted: {failure}"
            self.log.warning("%s", self._problem)
        self._shown = MemoryState(
            self.clock.now(),
            on=False,
            problem=self._problem,
            under_way=(),
            recognized=None,
            match=0.0,
            anticipated=(),
            raised=(),
            episodes=(),
            episode_count=0,
            event_count=0,
        )
        self.output_memory.publish(self._shown)

    # --- the disk --------------------------------------------------------------------------------------------------

    def _read(self) -> Kept:
        """In a thread."""
        try:
            return self._store.read()
        except StoreUnreadable as failure:
            with contextlib.suppress(FileNotFoundError):
                aside = self._store.set_aside()
                self._problem = f"{failure}; it is set aside as {aside.name}, and memory begins empty"
            return Kept()
        except (StoreBusy, OSError) as failure:
            self._problem = f"{failure}; nothing is kept until the program is started again"
            self._writes = False
            return Kept()

    async def _keep(self) -> None:
        """Write what has changed; what the disk refuses waits for the next time."""
        self._episodes = summaries(self._memory)
        update = self._memory.take_update()
        if not self._writes:
            return
        if update != _NOTHING:
            self._waiting = [*self._waiting, update][-_MOST_WAITING:]
        try:
            while self._waiting:
                await self.compute_background(self._store.keep, self._waiting[0])
                self._waiting.pop(0)
                if self._refused:
                    self._refused, self._problem = False, ""
        except (OSError, StoreBusy, StoreUnreadable) as failure:
            problem = f"what is remembered cannot be kept: {failure}"
            if not self._refused:
                self._refused, self._problem = True, problem
                self._report_problem()

    def _report_problem(self) -> None:
        self.log.warning("%s", self._problem)
        self._timeline.add("memory", "file", self._problem[:1].upper() + self._problem[1:])

    def _publish(self) -> None:
        """Publish what there is, if it is not what was published last."""
        art, found = self._memory.art, self._recognized
        anticipated = () if found is None else found.anticipated[:MOST_ANTICIPATED]
        state = MemoryState(
            0.0,
            on=True,
            problem=self._problem,
            under_way=tuple(event_message(art.events[each]) for each in art.under_way[-MOST_UNDER_WAY:]),
            recognized=None if found is None else found.episode,
            match=0.0 if found is None else round(found.match, 3),
            anticipated=tuple(
                AnticipatedEvent(event_message(art.events[each.event]), round(each.weight, 3)) for each in anticipated
            ),
            raised=self._raised.standing,
            episodes=self._episodes,
            episode_count=len(art.episodes),
            event_count=len(art.events),
        )
        if state != self._shown:
            self._shown = state
            self.output_memory.publish(replace(state, stamp=self.clock.now()))


def _ignore(_: object) -> None:
    """Nothing is remembered."""
