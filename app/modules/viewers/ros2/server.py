"""Ros2Server: the program's channels as topics of ROS 2; and where it is allowed, desires and goals from there.

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ Ros2Server    in   <channel>  every channel whose `log` is not `never`                  │
└─────────────────────────────────────────────────────────────────────────────────────────┘

Topics and types are those of a recording (docs/recording-format.md), under ``/hbba``. A channel is wanted, and its
messages are encoded, only while one of its topics has a subscriber. rclpy is in a process of its own
(:mod:`app.modules.viewers.ros2.process`), which this module starts and which passes on bytes alone. ROS 2 knows no
login: what it may ask for is off until ``commands`` is set; see docs/ros2.md.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Annotated, Any

from pydantic import Field

from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.logs.ros import typestore
from app.logs.ros.encoder import Encoder
from app.logs.ros.live.blank import blank
from app.logs.ros.live.graph import Discovery, environment
from app.logs.ros.record import Record
from app.messages import Localization, NavigationReport
from app.modules.viewers.channel_server import ChannelServer
from app.modules.viewers.ros2 import desires, navigate
from app.modules.viewers.ros2.desires import add_desire, remove_desire
from app.modules.viewers.ros2.drawing import PlaceRecords, Transforms, drawn
from app.modules.viewers.ros2.graph_process import GraphProcess, GraphProcessFailed
from app.modules.viewers.ros2.navigate import NavigateToPose
from app.modules.viewers.ros2.protocol import Answer, Call, Open, Publish, Service, Shown, Topic, ToProgram
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, ModuleContext, Settings

FEEDBACK_S = 0.5
#: In :class:`ShownTopics`, the graph is one viewer.
_GRAPH = 0
#: By these the goals that are pursued are followed.
_OF_GOALS = (Localization, NavigationReport)
_NAME = r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*"
Name = Annotated[str, Field(pattern=f"^{_NAME}$", max_length=100)]


class Ros2ServerSettings(Settings):
    namespace: Name = Field("hbba", description="before its topics, and before its services for desires")
    domain: int | None = Field(None, ge=0, le=232, description="ROS_DOMAIN_ID; null: the environment's, else 0")
    discovery: Discovery = Field("environment", description="how far it is found")
    transforms: Transforms = Field("map", description="on /tf: none, map (odom in map), or all of the robot's, too")
    jpeg_quality: int = Field(80, ge=1, le=100)
    commands: bool = Field(False, description="whether anybody in the domain may add desires, and give goals")
    action: Name = Field("navigate_to_pose", description="name of the action by which goals are given")


class Ros2Server(ChannelServer):
    title = "Topics for ROS 2"
    Settings = Ros2ServerSettings
    settings: Ros2ServerSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._process: GraphProcess | None = None
        self._goals: NavigateToPose | None = None
        self._serving: list[tuple[Service, Callable[[int, Any], Any | None]]] = []
        self._report: NavigationReport | None = None
        self._X_MB: Pose2 | None = None
        self._stack = ExitStack()
        self.every(FEEDBACK_S, self._tell)
        self.shown: frozenset[str] = frozenset()
        """The topics that have a subscriber."""
        self.left_out = 0
        """Messages that the process could not take in time."""

    def cautions(self) -> tuple[Caution, ...]:
        """Who may drive."""
        if not self.settings.commands:
            return ()
        text = "every program in this domain of ROS 2 may add desires and send the robot to places: there is no login"
        return (Caution("Others in the ROS 2 domain can give goals", text),)

    async def start(self) -> None:
        """Join the graph. Raises ModuleFailed where ROS 2 is not here."""
        self.prepare(self.settings.jpeg_quality, drawn(self.settings.transforms))
        self._places = PlaceRecords()
        self._offered = self._all_topics()
        self._numbers = {topic.name: number for number, topic in enumerate(self._offered)}
        if self.settings.commands:
            self._offer_services(await self.compute(navigate.definitions))
        open = Open(
            self.settings.namespace.replace("/", "_"),
            self.settings.domain,
            typestore.added(),
            tuple(self._offered),
            tuple(service for service, _ in self._serving),
        )
        try:
            self._process, ready = await GraphProcess.start(open, environment(self.settings.discovery))
        except GraphProcessFailed as failure:
            raise ModuleFailed(f"the graph of ROS 2 cannot be joined: {failure}") from None
        for name, why in ready.left_out[:1]:
            self.log.warning("%d topics and services are left out, %s among them: %s", len(ready.left_out), name, why)
        self._process.ended.add_done_callback(self._on_end)
        self._process.listen(self._take)
        self.log.info("the program is in the graph of ROS 2 as /%s", open.node)

    async def stop(self) -> None:
        """Leave the graph; goals that came from there are withdrawn."""
        if self._goals is not None:
            self._goals.end()
        self._stack.close()
        process, self._process = self._process, None
        if process is not None:
            process.ended.remove_done_callback(self._on_end)
            await process.close()
        self.rest()

    @property
    def process_id(self) -> int | None:
        """Id of the process in the graph, None while there is none."""
        return None if self._process is None else self._process.process_id

    # --- what is offered ---

    def _all_topics(self) -> list[Topic]:
        latched = {name for name in self._ports if self._table[name].latched}
        found = [
            Topic(self._named(topic), kind, bool(self._topics.channels_of(topic) & latched))
            for topic, kind in self._topics.types.items()
        ]
        if self._description is not None:
            found.append(Topic(self._named(self._description.topic), self._description.type, latched=True))
        return found + (list(navigate.topics(self.settings.action)) if self.settings.commands else [])

    def _named(self, topic: str) -> str:
        """The name in the graph of a recording's ``topic``."""
        return topic if topic == "/tf" else f"/{self.settings.namespace}{topic}"

    def _offer_services(self, definitions: tuple[tuple[str, str], ...]) -> None:
        workspace = self.service(IntentionWorkspace)
        goals = NavigateToPose(workspace, self.clock.now, self._answer, self._publish_status, self.log)
        self._goals = goals
        self._stack.callback(workspace.observe(lambda _: goals.look()))
        prefix = f"/{self.settings.namespace}/"
        send, cancel, result = navigate.services(self.settings.action)
        self._serving = [
            (_renamed(desires.ADD, prefix), lambda _, request: add_desire(workspace, request)),
            (_renamed(desires.REMOVE, prefix), lambda _, request: remove_desire(workspace, request)),
            (send, lambda _, request: goals.send_goal(request)),
            (cancel, lambda _, request: goals.cancel(request)),
            (result, goals.get_result),
        ]
        for name, text in definitions:
            typestore.add(name, text)
        for service, _ in self._serving:
            typestore.add(f"{service.type}_Request", service.request)
            typestore.add(f"{service.type}_Response", service.response)

    # --- from the graph ---

    def _take(self, message: ToProgram) -> None:
        if isinstance(message, Shown):
            name = self._offered[message.topic].name
            self._follow(name, message.readers)
            self.shown = self.shown | {name} if message.readers else self.shown - {name}
        elif isinstance(message, Call):
            try:
                self._called(message)
            except Exception as error:  # noqa: BLE001  # what is wrong here is this module's failure, not the loop's
                self.fail(error)

    def _called(self, call: Call) -> None:
        service, serve = self._serving[call.service]
        try:
            request = typestore.deserialise(f"{service.type}_Request", call.data)
        except ValueError as error:
            self.log.warning("a call of %s could not be read, and is refused: %s", service.name, error)
            self._answer(call.call, blank(f"{service.type}_Response"))
            return
        response = serve(call.call, request)
        if response is not None:
            self._answer(call.call, response)

    def _answer(self, call: int, response: Any) -> None:
        if self._process is not None:
            self._process.send(Answer(call, _cdr(response)))

    def _follow(self, name: str, readers: int) -> None:
        topic = self._recorded.get(name)
        if topic is None:
            return
        if not readers:
            for channel in self._topics.unsubscribe(_GRAPH, topic):
                self._demand(channel)
            return
        for channel in self._topics.subscribe(_GRAPH, topic):
            self._demand(channel)
        if self._description is not None and topic == self._description.topic:
            self._send(self._description)
        for channel, latest in self.standing(topic):
            self._publish(self._records(self.new_encoder(), channel, latest))

    @property
    def _recorded(self) -> Mapping[str, str]:
        """The recording's topic by its name in the graph."""
        names = [*self._topics.types, *(() if self._description is None else (self._description.topic,))]
        return {self._named(topic): topic for topic in names}

    def _demand(self, channel: str) -> None:
        followed = self._goals is not None and self._goals.pursued
        of_goals = self._table[channel].message_type in _OF_GOALS
        self._ports[channel].subscription.demand(self._topics.encoded(channel) or (followed and of_goals))

    def _on_end(self, ended: asyncio.Future[str]) -> None:
        self.fail(ModuleFailed(f"left the graph of ROS 2: {ended.result()}"))

    # --- to the graph ---

    def note(self, message: Any) -> None:
        """Where the robot is, and how its way goes, is for those whose goals are pursued."""
        if isinstance(message, Localization):
            self._X_MB = message.X_MB
            if self._goals is not None:
                self._goals.X_MO = message.X_MO
        elif isinstance(message, NavigationReport):
            self._report = message

    async def show(self, name: str, message: Any) -> None:
        """Encode it beside the loop, and send it."""
        self._publish(await self.compute(self._records, self._encoder, name, message))

    def _records(self, encoder: Encoder, name: str, message: Any) -> list[Record]:
        """What of ``message`` goes to the graph."""
        records = encoder.encode(name, message)
        if isinstance(message, Localization):
            records = [*records, *self._places.encode(name, message)]
        allowed = self._topics.topics_of(name)
        return [record for record in records if record.topic in allowed]

    def _publish(self, records: list[Record]) -> None:
        for record in records:
            self._send(record)

    def _send(self, record: Record) -> None:
        self._put(self._numbers[self._named(record.topic)], bytes(record.data))

    def _put(self, topic: int, data: bytes) -> None:
        process = self._process
        if process is None or process.is_behind:
            self.left_out += 1
            return
        process.send(Publish(topic, data))

    def _publish_status(self) -> None:
        if self._goals is None or self._process is None:
            return
        for channel in self._ports:
            if self._table[channel].message_type in _OF_GOALS:
                self._demand(channel)
        self._put(self._numbers[navigate.topics(self.settings.action)[1].name], _cdr(self._goals.status()))

    def _tell(self) -> None:
        if self._goals is not None and (feedback := self._goals.feedback(self._report, self._X_MB)) is not None:
            self._put(self._numbers[navigate.topics(self.settings.action)[0].name], _cdr(feedback))


def _renamed(service: Service, prefix: str) -> Service:
    return Service(prefix + service.name, service.type, service.request, service.response)


def _cdr(message: Any) -> bytes:
    return bytes(typestore.store().serialize_cdr(message, message.__msgtype__, little_endian=True))
