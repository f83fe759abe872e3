"""The whole program put together from its configuration: link, modules, attention.

The console and the commands see the program only through this file. Everything is built, and every mistake in the
configuration found, before anything starts.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import AsyncExitStack
from functools import partial
from pathlib import Path
from types import TracebackType

from app.attention.lanes import LaneMonitor, LaneSampler
from app.attention.rule_book import RuleBook
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace, random_id
from app.base import paths
from app.link import LinkFailed, RobotLink
from app.logs.library import RecordingLibrary, default_folder
from app.logs.manifest import Manifest
from app.logs.recorder_service import RecorderService
from app.maps.library import MapLibrary
from app.maps.library import default_folder as default_maps_folder
from app.maps.map_service import MapService
from app.maps.place_service import PlaceService
from app.maps.route_service import RouteService
from app.memory.service import MemoryService
from app.memory.store import MemoryStore
from app.memory.store import default_folder as default_memory_folder
from app.messages import Accomplishment, BatteryState, Confidence, Exploitation, LoadReport, PerceptEvent, PerceptKind
from app.program.attachments import snapshot, with_table
from app.program.attention_setup import attend, load_table, make_translator, power_budget, unserved
from app.program.battery_watch import BatteryWatch
from app.program.body_restart import BodyRestarter
from app.program.config import Configuration, load_configuration
from app.program.desire_classes import desire_classes
from app.program.exploitation_watch import ExploitationWatch
from app.program.load_control import LoadControl
from app.program.module_meter import ModuleMeter
from app.program.nodes import ProgramNodes
from app.program.self_report import SelfReport
from app.program.timeline_feed import TimelineFeed
from app.remote.hub import NodeHub
from app.robots.factory import Body, create_link, load_body
from app.runtime.channel import Channel
from app.runtime.channel_table import ChannelTable
from app.runtime.clock import Clock, RealClock
from app.runtime.filter_bank import Pin
from app.runtime.freshness import FreshnessWatch
from app.runtime.graph import Graph
from app.runtime.load import LoadMeter
from app.runtime.replay_clock import ReplayClock
from app.runtime.supervisor import Supervisor
from app.runtime.watchdog import LoopWatchdog
from app.tours.library import TourLibrary
from app.tours.library import default_folder as default_tours_folder
from app.tours.run_library import RunLibrary
from app.tours.run_library import default_folder as default_runs_folder
from app.tours.run_service import TourRunService
from app.tours.store import TourStore

log = logging.getLogger("hbba.system")

LOAD_WINDOW_S = 1.0


class System:
    """A robot program: ``async with System.from_file(path) as system: ...``."""

    def __init__(
        self,
        configuration: Configuration,
        *,
        link: RobotLink | None = None,
        body: Body | None = None,
        clock: Clock | None = None,
        pins: Mapping[str, Pin] | None = None,
        recordings: RecordingLibrary | None = None,
        maps: MapLibrary | None = None,
        tours: TourStore | None = None,
        runs: RunLibrary | None = None,
        memory: MemoryStore | None = None,
        new_id: Callable[[], str] = random_id,
        partial: bool = False,
        reproducible: bool = False,
        recorded: Collection[str] = (),
        nodes: bool = False,
    ) -> None:
        """Build everything; ``link`` and ``clock`` replace the configured body and the real clock.

        ``body`` describes ``link`` where its file does not; recordings carry it. ``pins`` fixes filters
        (``Module.port``) against all strategies. ``recordings`` is the library of recordings, by default the user's
        folder; so are ``maps``, ``tours`` and ``runs``, of which the default resumes no tour that was under way when
        another program ended. ``memory`` is the file of what is remembered, by default none. ``new_id`` makes the ids
        of desires. ``partial``: strategies may name modules that do not exist, and are used without them.
        ``reproducible``: nothing may depend on the speed of this computer, so that two runs in virtual time are equal:
        the solver finds the optimum without a time limit and reports no solve time, the watchdog of the loop is off, no
        load is reported. ``recorded``: channels that come from a recording, so that the program does not publish on
        them what it knows of itself. ``nodes``: the computers that the configuration declares may join. Raises
        ConfigError.
        """
        self._reproducible = reproducible
        real = RealClock()
        self.clock: Clock = clock or real
        self.nodes = ProgramNodes(configuration, self.clock) if nodes and configuration.program.nodes else None
        if self.nodes is not None:
            configuration = self.nodes.configuration
        program = configuration.program
        self.config = configuration
        #: Paces work for people, which goes on while a recording is paused; else the robot's clock itself.
        self.pace: Clock = self.clock.pace if isinstance(self.clock, ReplayClock) else self.clock
        self.link = link or create_link(load_body(configuration.path(program.robot)), real.offset)
        self.classes = desire_classes(configuration)
        self.workspace = IntentionWorkspace(self.classes, self.clock.now, new_id=new_id)
        self.timeline = Timeline(program.attention.history, self.clock.now)
        self.recordings = recordings or RecordingLibrary(default_folder())
        self.recorder = RecorderService()
        self.maps = maps or MapLibrary(default_maps_folder())
        self.map = MapService()
        self.tours = tours or TourStore(TourLibrary(default_tours_folder(), paths.config_dir() / "tours"))
        self.places = PlaceService()
        self.runs = runs or RunLibrary(default_runs_folder(), resumes=False)
        self.tour_run = TourRunService()
        self.memory = MemoryService()
        self.routes = RouteService()
        services: dict[type[object], object] = {
            RobotLink: self.link,
            IntentionWorkspace: self.workspace,
            Timeline: self.timeline,
            RecordingLibrary: self.recordings,
            RecorderService: self.recorder,
            MapLibrary: self.maps,
            MapService: self.map,
            TourStore: self.tours,
            PlaceService: self.places,
            RunLibrary: self.runs,
            TourRunService: self.tour_run,
            MemoryStore: memory or MemoryStore(default_memory_folder(), keeps=False),
            MemoryService: self.memory,
            RouteService: self.routes,
            ChannelTable: ChannelTable(configuration.channels),
            RuleBook: RuleBook([configuration.path(file) for file in program.rules]),
        }
        if self.nodes is not None:
            services[NodeHub] = self.nodes.hub
        self.graph = Graph(
            clock=self.clock,
            channels=configuration.channels,
            modules=program.modules,
            services=services,
            error=configuration.wiring_error,
        )
        self.table = load_table(configuration, self.graph, self.classes, nodes=self.nodes, partial=partial)
        #: Warnings about the configuration.
        self.cautions = attend(configuration, self.graph, self.table)
        if not partial:  # else modules and their strategies are left out on purpose
            self.cautions += unserved(configuration, self.graph, self.table, self.classes)
        for name, pin in (pins or {}).items():
            self.graph.filters.pin(name, pin)
        self.supervisor = Supervisor(self.graph.modules, self.clock, self.pace)
        meters = {name: slot.context.meter for name, slot in self.graph.modules.items()}
        self.freshness = FreshnessWatch(self.graph, self.supervisor.states)
        self.load = LoadMeter(meters, self.clock.now)
        self._modules = ModuleMeter(self.graph.modules, self.supervisor, self.load)
        self.watchdog = LoopWatchdog(meters)
        power = power_budget(configuration, self.table)
        self.translator = make_translator(
            configuration,
            self.graph,
            self.table,
            workspace=self.workspace,
            timeline=self.timeline,
            clock=self.clock,
            power=power,
            partial=partial,
            reproducible=reproducible,
        )
        manifest = snapshot(configuration, self.graph, self.link.description.name, body)
        services[Manifest] = with_table(manifest, self.translator.problem())
        #: Attention's closed loop; None where it is open.
        self.control = self._load_control()
        self._battery = BatteryWatch(self.timeline, power, self.translator.set_capacity)
        self._lanes = None if "lanes" in recorded else self._lane_monitor()
        self.body_restarter = BodyRestarter(self.link, self.supervisor, self._renew_state, self.timeline, self.clock)
        self._stack = AsyncExitStack()
        self._tasks: list[asyncio.Task[None]] = []
        own = {name: channel for name, channel in self.graph.channels.items() if name not in recorded}
        self._report = SelfReport(own, self.clock.now, self.graph.filters.divisors)
        self._feed = TimelineFeed(
            self.timeline,
            {n: spec.cpu_budget for n, spec in program.modules.items() if spec.cpu_budget is not None},
            self._percept_kinds(),
        )
        self.exploitation = ExploitationWatch(
            self.graph,
            self.workspace,
            self.translator,
            self._feed,
            self.clock.now,
            idle_after_s=program.attention.idle_after_s,
        )

    @classmethod
    def from_file(cls, path: Path) -> System:
        """The program that the configuration file at ``path`` describes. Raises ConfigError."""
        return cls(load_configuration(path))

    async def __aenter__(self) -> System:
        """Bring the body up, then attention, then the modules. Raises LinkFailed, having released everything."""
        async with AsyncExitStack() as stack:
            for caution in self.cautions:
                log.warning("%s", caution)
            stack.push_async_callback(self.link.stop)
            await self.link.start()
            self.body_restarter.up()
            self.supervisor.observe(self._feed.module)
            self.supervisor.observe(self._report.module)
            self._report.open(self.workspace, self.translator, self.timeline, self.exploitation)
            stack.callback(self._report.close)
            stack.callback(self.link.attach("status", self._feed.guard))
            for channel in self.graph.channels.values():
                if channel.message_type is PerceptEvent:
                    stack.callback(channel.observe(self._feed.percept))
                if channel.message_type is Confidence and self.control is not None:
                    producer = self.graph.producers[channel.name].partition(".")[0]
                    stack.callback(channel.observe(partial(self.control.hear, producer)))
                if channel.message_type is Accomplishment:
                    stack.callback(channel.observe(self.workspace.accomplish))
            if not self._reproducible:
                await stack.enter_async_context(self.watchdog)
            if self.nodes is not None:
                await stack.enter_async_context(self.nodes.hub)
                stack.callback(self.nodes.observe(self.translator.set_capacity))
            await stack.enter_async_context(self.supervisor)
            for name, coroutine in {
                "translator": self.translator.run(),
                "sampling": self._sample(),
                **{
                    name: self._follow_exploitation(channel)
                    for name, channel in self.graph.channels.items()
                    if channel.message_type is Exploitation
                },
                **{
                    name: self._follow_battery(channel)
                    for name, channel in self.graph.channels.items()
                    if channel.message_type is BatteryState
                },
                **({} if self._lanes is None else {"lanes": self._lanes.run()}),
                **({} if self.control is None else {"closed loop": self.control.run()}),
            }.items():
                task = asyncio.create_task(coroutine, name=name)
                self._tasks.append(task)
                stack.push_async_callback(_cancelled, task)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the modules, then the wheels, then the body."""
        await self._stack.aclose()

    async def reset(self, jump: Callable[[], None]) -> None:
        """Stop every module, clear all state, call ``jump``, which moves clock and body, and start all modules.

        Desires that modules did not add, budgets and measured costs stay. Returns when the modules are about to start.
        """
        await self.supervisor.stop_modules()
        self._clear_state()
        self.timeline.clear()
        self.workspace.clear_ended()
        jump()
        self._report.again()
        self.supervisor.start_modules()

    def _renew_state(self) -> None:
        self._clear_state()
        self._report.again()

    def _clear_state(self) -> None:
        self.graph.reset()
        self.freshness.reset()
        self._feed.reset()
        self.exploitation.clear()
        self._battery.reset()
        if self.control is not None:
            self.control.reset()
        if self._lanes is not None:
            self._lanes.reset()

    def exploited(self) -> tuple[str, ...]:
        """Ids of the desires that are exploited now."""
        return self.exploitation.exploited()

    async def keep_going(self) -> Exception:
        """As :meth:`wait_failed`, but restarts a body that failed if it can be restarted, unless it fails again and
        again."""
        while True:
            failure = await self.wait_failed()
            if not isinstance(failure, LinkFailed) or not self.link.description.restartable:
                return failure
            final = await self.body_restarter.restart(failure)
            if final is not None:
                return final

    async def wait_failed(self) -> Exception:
        """Wait until the program cannot go on, and return the reason.

        LinkFailed, with a message for people, when the body is lost; any other exception is a bug in a task beside the
        modules (modules are restarted): to stop is safer than to run without attention.
        """
        body = asyncio.create_task(self.link.wait_failed(), name="body's failure")
        try:
            await asyncio.wait({body, *self._tasks}, return_when=asyncio.FIRST_COMPLETED)
            if body.done():
                return body.result()
            ended = next(task for task in self._tasks if task.done())
            error = ended.exception()
            return error if isinstance(error, Exception) else RuntimeError(f"{ended.get_name()} ended by itself")
        finally:
            body.cancel()

    def _load_control(self) -> LoadControl | None:
        settings = self.config.program.attention.closed_loop
        # What follows the speed of this computer cannot be repeated, nor is a replay's load that of the robot.
        if settings is None or self._reproducible or isinstance(self.clock, ReplayClock):
            return None
        return LoadControl(
            settings,
            self.graph,
            translator=self.translator,
            timeline=self.timeline,
            watchdog=self.watchdog,
            clock=self.clock,
        )

    def _lane_monitor(self) -> LaneMonitor | None:
        channel = self.graph.channels.get("lanes")
        if channel is None:
            return None
        sampler = LaneSampler(self.graph, self.classes, self.table.strategies)
        return LaneMonitor(channel, sampler, self.workspace, self.translator, now=self.clock.now, pace=self.pace)

    def _percept_kinds(self) -> Iterator[PerceptKind]:
        for channel in self.graph.channels.values():
            kind = getattr(channel.message_type, "percept_kind", None)
            if isinstance(kind, PerceptKind):
                yield kind

    async def _sample(self) -> None:
        while True:
            await self.pace.sleep(LOAD_WINDOW_S)
            if not self._reproducible:
                self._sample_load()
            if self.nodes is not None and (costs := self.nodes.measured()):
                self.translator.set_costs(costs, "messages to nodes are of another size than reckoned")
            self._feed.freshness(self.freshness.sample(self.clock.now()))
            self.exploitation.sample()

    def _sample_load(self) -> None:
        before, load = self.load.latest.stamp, self.load.sample()
        if self.pace is self.clock:  # budgets are of the robot's time
            self._feed.load(load)
        if load.stamp != before:  # time goes on
            budget, modules = self.translator.capacities.get("cpu"), self._modules.sample()
            loop = None if self.control is None else self.control.report()
            process = round(load.process, 2)
            self._report.load(LoadReport(load.stamp, load.window_s, process, budget, modules=modules, loop=loop))

    async def _follow_exploitation(self, channel: Channel[Exploitation]) -> None:
        async for message in channel.subscribe("timeline"):
            self.exploitation.take(message)

    async def _follow_battery(self, channel: Channel[BatteryState]) -> None:
        async for state in channel.subscribe("battery watch"):
            self._battery.take(state)


async def _cancelled(task: asyncio.Task[None]) -> None:
    """Cancel ``task`` and wait for its end; :meth:`System.wait_failed` returns a failure of its own."""
    task.cancel()
    await asyncio.wait({task})
