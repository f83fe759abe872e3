"""TourGuide: the motivation that leads people on a guided tour.

    ┌──────────────────────────────────────────────────────────────────────────────────────────┐
    │ TourGuide  in   faces         Faces, m in base_link at their stamp; counted, not known    │
    │            in   persons       Persons: who has turned away; counted, not known           │
    │            in   sources       SoundSources: which way visitors are                       │
    │            in   noises        LoudNoise: claps, and calls where a voice sounds           │
    │            in   words         HeardWords                                                 │
    │            in   codes         QRCodes: those that visitors show                          │
    │            in   speech        Speech: the sentence that is said                          │
    │            in   odometry      Odometry, 100 Hz, X_OB in odom; never filtered             │
    │            in   localization  Localization, state and map                                │
    │            in   places        Places of the map                                          │
    │            in   landmarks     Landmarks, in map: where posters hang                      │
    │            in   navigation    NavigationStatus, as they come                             │
    │            in   exploitation  Exploitation of the base, 10 Hz                            │
    │            in   status        LinkStatus: the emergency stop                             │
    │            in   battery       BatteryState, 1 Hz                                         │
    │            out  progress      TourProgress, with each change                             │
    │            is the TourRunServer; states desires, and moves nothing itself                │
    └──────────────────────────────────────────────────────────────────────────────────────────┘

What it does is decided by pure functions (``transitions.py``, ``passing_time.py``, ``wishes.py``,
``perceptions.py``); all inputs but
odometry may be absent. A run is kept at each change; a program that is started again goes on with it or says why not.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace

from pydantic import Field

from app.attention.desires import SCALE
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.maps.map_service import MapService
from app.maps.places import go_to_parameters
from app.maps.poster_places import Poster, posters_of
from app.messages import (
    BatteryState,
    Exploitation,
    Faces,
    HeardWords,
    Landmarks,
    LinkStatus,
    Localization,
    LoudNoise,
    NavigationStatus,
    Odometry,
    Persons,
    Place,
    Places,
    QRCodes,
    SoundSources,
    Speech,
    TourButton,
    TourProgress,
)
from app.modules.motivations.motivation import Motivation
from app.modules.motivations.tour_guide.controls import buttons
from app.modules.motivations.tour_guide.desires import GuideDesires, weights
from app.modules.motivations.tour_guide.guided_run import GuidedRun, led_by
from app.modules.motivations.tour_guide.listening import Calls, Claps, ShownCodes, is_due, sentence_number
from app.modules.motivations.tour_guide.map_corrections import same_places, same_posters
from app.modules.motivations.tour_guide.progress import (
    Asked,
    Chosen,
    Event,
    Heard,
    Pressed,
    Progress,
    Scheduled,
    Spoken,
    View,
)
from app.modules.motivations.tour_guide.progress_message import progress_message
from app.modules.motivations.tour_guide.resumption import Resumption
from app.modules.motivations.tour_guide.run_keeper import RunKeeper
from app.modules.motivations.tour_guide.senses import Senses
from app.modules.motivations.tour_guide.wishes import DOCK, Scene, stop_of
from app.runtime.module import ModuleContext, Settings
from app.tours.model import Tour
from app.tours.run_library import RunLibrary
from app.tours.run_report import RunReport
from app.tours.run_service import TourRefused, TourRunService
from app.tours.store import TourStore

_BEAT_S = 0.2
_NOTHING = TourProgress(
    0.0, "", "", title={}, language="", languages=(), waits=False, state="idle", since=0.0, reason="", stop="",
    stop_title={}, number=0, stops=0, step=0, steps=0, text={}, sentence=0, shown=None, press={}, questions=(),
    buttons=(), question=None, people=0, farthest_m=None, presented=(), skipped=(), failures=(),
)  # fmt: skip


class TourGuideSettings(Settings):
    """Settings of TourGuide."""

    intensity: float = Field(6.0, gt=0, le=SCALE, description="of its desires")
    intensities: Mapping[str, float] = Field(
        {"Dock": 2.0}, description="of those of the classes named here; a more intense goal of others pauses the tour"
    )
    utilities: Mapping[str, float] = Field({"GoTo": 4.0}, description="desired of the classes named here; of others: 1")
    by_hand: str = Field("Teleop", description="the behavior that people drive by")
    voice: float = Field(0.5, ge=0, le=1, description="a source at least this probably speech is a voice")
    docks: bool = Field(True, description="whether it charges after a tour, where the program has a dock")


class TourGuide(Motivation):
    """Leads people on a tour."""

    title = "Tour guide"
    Settings = TourGuideSettings
    settings: TourGuideSettings

    _desires: GuideDesires
    _workspace: IntentionWorkspace
    _timeline: Timeline
    _keeper: RunKeeper

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._senses = senses = Senses(by_hand=self.settings.by_hand, voice=self.settings.voice)
        self._run: GuidedRun | None = None
        self._resumption: Resumption | None = None
        self._events: list[Event] = []
        self._claps, self._calls = Claps(), Calls()
        self._codes = ShownCodes()
        self._places: tuple[Place, ...] | None = None
        self._posters: tuple[Poster, ...] = ()
        self._beaten: float | None = None
        self._shown = _NOTHING
        self._stack = ExitStack()
        self.on(self.input("faces", Faces, capacity=8), senses.take_percepts)
        self.on(self.input("persons", Persons), senses.take_persons)
        self.on(self.input("sources", SoundSources, capacity=8), self._take_sources)
        self.on(self.input("noises", LoudNoise, capacity=8), self._take_noise)
        self.on(self.input("words", HeardWords, capacity=8), self._take_words)
        self.on(self.input("codes", QRCodes, capacity=8), self._take_codes)
        self.on(self.input("speech", Speech, capacity=8, wants="never"), self._take_speech)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True)
        self.on(self.input("localization", Localization), senses.take_localization)
        self.places = self.input("places", Places, wants="never")
        self.on(self.places, self._take_places)
        self.on(self.input("landmarks", Landmarks, wants="never"), self._take_landmarks)
        self.on(self.input("navigation", NavigationStatus, capacity=8), senses.take_navigation)
        self.on(self.input("exploitation", Exploitation), senses.take_exploitation)
        self.on(self.input("status", LinkStatus), self._take_status)
        self.on(self.input("battery", BatteryState), senses.take_battery)
        self.output_progress = self.output("progress", TourProgress)
        self.every(_BEAT_S, self._beat)

    async def start(self) -> None:
        """Take the run that was under way, if there was one, and offer control to others."""
        self._workspace = self.service(IntentionWorkspace)
        self._timeline = self.service(Timeline)
        self._keeper = RunKeeper(self.service(RunLibrary), self.compute_background, self.log)
        weight = weights(self.settings.intensity, self.settings.intensities, self.settings.utilities)
        self._desires = GuideDesires(self._workspace, self.source, weight, self.log)
        self._stack.callback(self._desires.withdraw)
        kept = await self.compute_background(self._keeper.read, self.service(TourStore))
        self._resumption = None if kept is None else Resumption(*kept)
        self._stack.callback(self.service(TourRunService).attach(self))
        # So that all know that this program leads tours.
        self.output_progress.publish(replace(_NOTHING, stamp=self.clock.now()))

    async def stop(self) -> None:
        """Withdraw all desires. The run stays kept."""
        self._stack.close()

    # --- the TourRunServer -----------------------------------------------------------------------------------------

    @property
    def tour(self) -> Tour | None:
        """The tour that is led, as its author made it."""
        return None if self._run is None else self._run.tour

    @property
    def progress(self) -> TourProgress:
        """How the tour goes."""
        return self._shown

    @property
    def report(self) -> RunReport | None:
        """What the run has been so far."""
        return None if self._run is None else self._run.report

    def start_tour(self, tour: Tour, *, language: str, waits: bool) -> None:
        """Begin ``tour``. Raises TourRefused."""
        if self._resumption is not None:
            raise TourRefused("the tour that was under way when the program ended is being resumed; wait for that")
        if self._run is not None and self._run.progress.is_running:
            raise TourRefused(f"the tour {self._run.tour.id} is under way; end it first")
        if language not in tour.languages:
            raise TourRefused(f"the tour {tour.id} is not in {language!r}; there are: {', '.join(tour.languages)}")
        if self.places.channel is not None and (latest := self.places.channel.latest) is not None:
            self._take_places(latest)
        if refusal := self._missing(tour):
            raise TourRefused(refusal)
        run = GuidedRun(tour, self._scene(tour, language, waits=waits), waits, over=self._keeper.over)
        before, self._run = self._run, run
        if not waits:
            self._look(Pressed("start"))
            if not run.progress.is_running:
                self._run = before
                self._publish()
                raise TourRefused(run.progress.reason)
        else:
            self._look()

    def press(self, button: TourButton) -> None:
        """Press ``button``. Raises TourRefused where it does nothing now."""
        run = self._running("press")
        offered = buttons(run.progress, e_stop=run.view.e_stop)
        if button not in offered:
            words = ", ".join(offered)
            raise TourRefused(f"{button} does nothing while the tour is {run.progress.state}; now there are: {words}")
        self._look(Pressed(button))
        if button == "start" and not run.progress.is_running:
            raise TourRefused(run.progress.reason)

    def choose(self, stop: str) -> None:
        """Go to ``stop``. Raises TourRefused."""
        run = self._running("choose a stop")
        stops = [each.id for each in run.tour.stops]
        if stop not in stops:
            raise TourRefused(f"the tour has no stop {stop!r}; there are: {', '.join(stops)}")
        if "skip" not in buttons(run.progress, e_stop=run.view.e_stop):
            raise TourRefused(f"no stop can be gone to while the tour is {run.progress.state}")
        self._look(Chosen(stop))

    def ask(self, question: str) -> None:
        """A visitor asks ``question``. Raises TourRefused."""
        self._running("ask")
        offered = [each.id for each in self._shown.questions]
        if question not in offered:
            words = ", ".join(offered) or "none"
            raise TourRefused(f"{question!r} is no question that can be asked now; there are: {words}")
        self._look(Asked(question))

    def dismiss(self) -> None:
        """Wait for visitors no more. Raises TourRefused while a tour is under way."""
        if self._run is not None and self._run.progress.is_running:
            raise TourRefused(f"the tour {self._run.tour.id} is under way; end it first")
        self._run = None
        self._desires.withdraw()
        self._publish()

    def _running(self, what: str) -> GuidedRun:
        if self._run is None:
            raise TourRefused(f"no tour is under way: there is nothing to {what}")
        return self._run

    def _missing(self, tour: Tour) -> str:
        """Why ``tour`` cannot be led here; empty if it can."""
        maps = self.service(MapService)
        in_use = maps.server.name if maps.available else ""
        if in_use != tour.map:
            id_, wanted = tour.id, tour.map
            if not in_use:
                return f"the tour {id_} is on the map {wanted}, and no map is loaded: load {wanted} first"
            return f"the tour {id_} is on the map {wanted}, and the map in use is {in_use}: load {wanted} first"
        known = {place.id for place in self._places or ()}
        if not any(stop.place in known for stop in tour.stops if not stop.left_out):
            return f"none of the places of the tour {tour.id} is on the map"
        return ""

    # --- what comes in ---------------------------------------------------------------------------------------------

    def _take_words(self, heard: HeardWords) -> None:
        if heard.text and not heard.unsure:
            self._events.append(Heard(heard.text))

    def _take_noise(self, noise: LoudNoise) -> None:
        self._claps.hear(noise.stamp)
        self._calls.hear(noise.stamp)

    def _take_sources(self, sources: SoundSources) -> None:
        self._senses.take_percepts(sources)
        if self._senses.voices(sources):
            self._calls.locate(sources.stamp)

    def _take_codes(self, codes: QRCodes) -> None:
        if self._run is not None:
            self._events.extend(self._codes.read(codes, self._run.progress.state))

    def _take_speech(self, speech: Speech) -> None:
        wish = self._desires.key_of(speech.desire) if speech.state == "speaking" else None
        run = self._run
        if wish is None or run is None:
            return
        before = max(run.progress.sentence - run.progress.said_from, 0)
        self._events.append(Spoken(wish.key, sentence_number(str(wish.params["text"]), speech.text, before)))

    def _take_status(self, status: LinkStatus) -> None:
        # At once: it may be released again before the next look.
        if self._senses.take_status(status) and self._run is not None:
            self._look()

    def _take_places(self, places: Places) -> None:
        if self._places is not None and same_places(self._places, places.places):
            return
        self._places = places.places
        self._renew_scene()

    def _take_landmarks(self, landmarks: Landmarks) -> None:
        posters = posters_of(landmarks)
        if posters is None or same_posters(self._posters, posters):
            return
        self._posters = posters
        self._renew_scene()

    def _renew_scene(self) -> None:
        if (run := self._run) is not None:
            run.scene = self._scene(run.tour, run.scene.language, waits=run.waits)

    def _scene(self, tour: Tour, language: str, *, waits: bool) -> Scene:
        classes, places = self._workspace.classes, self._places or ()
        return Scene(
            led_by(tour, waits=waits),
            language,
            {place.id: go_to_parameters(place) for place in places},
            frozenset(name for name, each in classes.items() if each.achievement),
            doubts={place.id: place.problem for place in places if place.problem},
            docks=self.settings.docks and DOCK in classes,
            posters=self._posters,
        )

    # --- one look --------------------------------------------------------------------------------------------------

    async def _beat(self) -> None:
        while self.odometry.connected and self.odometry.subscription.waiting:
            self._senses.take_odometry(self.odometry.subscription.receive_nowait())
        now = self.clock.now()
        if self._resumption is not None:
            await self._resume(self._resumption)
        if (run := self._run) is None:
            self._events.clear()
            self._beaten = now
            if self._resumption is None:
                await self._keeper.save(now, None)
            return
        if (clapped := self._claps.counted(now)) is not None:
            self._events.append(clapped)
        if (called := self._calls.called()) is not None:
            self._events.append(called)
        if run.waits and is_due(run.tour.schedule, now if self._beaten is None else self._beaten, now):
            self._events.append(Scheduled())
        self._beaten = now
        self._look()
        await self._keeper.save(now, run, self._senses.pose_on(run.tour.map))

    def _look(self, *events: Event) -> None:
        """See what there is, decide, and desire what follows from it."""
        run = self._run
        assert run is not None
        came, self._events = self._events, []
        before = run.progress
        run.see(self._view(run, (*self._desires.ended(), *came, *events)))
        self._desires.want(run.wishes(run.view.now))
        if (run.progress.state, run.progress.stop) != (before.state, before.stop):
            self._note(run, run.progress)
        self._keeper.expect()
        self._publish()

    def _view(self, run: GuidedRun, events: tuple[Event, ...]) -> View:
        # Where others want the robot matters only while it would go somewhere.
        going = run.progress.is_running and self._desires.diverted()
        return self._senses.view(self.clock.now(), run.scene.tour, run.progress, diverted=going, events=events)

    def _note(self, run: GuidedRun, progress: Progress) -> None:
        stop = "" if progress.state in ("idle", "inviting", "confirming") else stop_of(progress, run.tour).id
        where = f" ({stop})" if stop else ""
        why = f": {progress.reason}" if progress.reason else ""
        text = f"Tour {run.tour.id}: {progress.state.replace('_', ' ')}{where}{why}"
        data = {"tour": run.tour.id, "state": progress.state, "stop": stop, "reason": progress.reason}
        self._timeline.add("tour", run.tour.id, text, data)

    def _publish(self) -> None:
        run = self._run
        message = _NOTHING
        if run is not None:
            id_ = "" if run.report is None else run.report.run
            message = progress_message(run.progress, run.view, run.scene, run=id_, waits=run.waits)
        if replace(message, stamp=0.0) != replace(self._shown, stamp=0.0):
            self._shown = replace(message, stamp=self.clock.now())
            self.output_progress.publish(self._shown)

    # --- after a restart ----------------------------------------------------------------------------------------------

    async def _resume(self, resumption: Resumption) -> None:
        """Go on with the run that was under way once the robot knows where it is and has looked for visitors; say why
        not else."""
        if resumption.kept.progress.is_running:
            await resumption.take_map(self.service(MapService), self.clock.now())
        now, kept, tour = self.clock.now(), resumption.kept, resumption.tour
        language = tour.languages[0] if kept.report is None else kept.report.language
        run = GuidedRun(tour, self._scene(tour, language, waits=kept.waits), kept.waits, over=self._keeper.over)
        localized = self._senses.localized(tour.map) and self._places is not None
        view = self._view(run, ())
        wishes = resumption.wishes(now)
        if resumption.interrupt(view, run.scene):
            return
        if wishes:
            self._desires.want(wishes)
            if resumption.waits(now, view, localized=localized):
                return
        self._resumption, self._run = None, run
        progress = resumption.progress(now, view, run.scene, localized=localized)
        run.resume(kept, progress, view)
        if kept.progress.is_running:
            self._note(run, progress)
        self._look()
