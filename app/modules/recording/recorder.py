"""Recorder: channels on disk (thesis 4.4: every experiment was recorded).

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ Recorder    in   <channel>  every channel whose `log` is not `never`, or those named    │
│             out  status     RecorderStatus, 1 Hz and at every change                    │
└─────────────────────────────────────────────────────────────────────────────────────────┘

It records while the intention gives it parameters (desire class Record): into one file, or, with ``keep_minutes``,
into a ring of the last minutes. Strategies may decimate images and scans; inputs that no strategy names are recorded
completely. While it does not record, it discards its messages. The writer's thread encodes and writes; see
docs/recording.md.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from contextlib import suppress
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, BaseModel, Field

from app.attention.desires import DesireClass
from app.base.named_library import LONGEST_NAME
from app.logs.library import NAME_PATTERN, RecordingLibrary, default_name, name_or_nothing
from app.logs.log import LogError
from app.logs.manifest import Manifest
from app.logs.mcap.disk_time import DiskTime
from app.logs.mcap.file_sink import FileSink
from app.logs.mcap.open_file import OpenFile, create
from app.logs.mcap.ring import SEGMENT_S, Ring
from app.logs.mcap.writer import MEGABYTE, Limits, RecordingWriter, Sink, check_room
from app.logs.recorder_service import RecorderService, RecorderUnavailable
from app.logs.ros.encoder import Encoder
from app.messages import (
    EventKind,
    Image,
    Message,
    ModuleRecord,
    PointCloud,
    RecorderState,
    RecorderStatus,
    TimelineEvent,
)
from app.modules.recording.ring_saver import NO_RING, RingSaver
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.errors import InboxOverflow
from app.runtime.module import Module, ModuleContext, Settings
from app.runtime.ports import Input

#: Time allowed for closing a file (s); on a slower disk its thread finishes alone.
CLOSING_S = 0.4


#: Capacity (messages) for a burst after the loop was blocked; messages beyond it are counted as dropped.
INBOX = 1024
#: The same for messages of a megabyte and more.
LARGE_INBOX = 32
LARGE = (Image, PointCloud)


class EventPattern(BaseModel, frozen=True, extra="forbid"):
    """A pattern of timeline events: their kind, and their subject if one is named."""

    kind: EventKind
    subject: str | None = None

    def matches(self, event: TimelineEvent) -> bool:
        """Whether ``event`` matches."""
        return event.kind == self.kind and self.subject in (None, event.subject)


class RecorderSettings(Settings):
    """Limits of memory and disk, and the events that save a ring."""

    queue_mb: float = Field(64, gt=0, description="memory for what waits for the disk")
    queue_messages: int = Field(20_000, ge=100, description="... and so many messages at most")
    least_free_mb: float = Field(200, ge=0, description="room on the disk that is never taken")
    too_slow_after_s: float = Field(2, gt=0, description="recording ends when messages are dropped for this long")
    jpeg_quality: int = Field(90, ge=1, le=100)
    segment_s: float = Field(SEGMENT_S, gt=0, description="length of a ring's segments")
    save_ring_on: tuple[EventPattern, ...] = Field((), description="events that save a ring")
    save_after_s: float = Field(5, ge=0, description="... this long after them, so that what followed is kept too")


class RecordParameters(BaseModel, extra="forbid", title="Record"):
    name: Annotated[str, AfterValidator(name_or_nothing)] = Field(
        "",
        json_schema_extra={"pattern": NAME_PATTERN, "maxLength": LONGEST_NAME},
        title="Name",
        description="What the recording is called; empty: the date and time at which it begins.",
    )
    keep_minutes: float = Field(
        0,
        ge=0,
        le=120,
        title="Keep the last minutes",
        description="0 records everything into one file; otherwise only the last so many minutes are kept on disk, "
        "until they are saved.",
    )


RECORD = DesireClass(
    name="Record",
    title="Record",
    description="Write what the robot senses, decides and does into a log that can be replayed.",
    parameters=RecordParameters,
)


class Recorder(Module):
    title = "Recorder"
    desire_classes = (RECORD,)
    #: Opens files; tests replace it by a disk that fails.
    open_file: ClassVar[OpenFile] = staticmethod(create)
    Settings = RecorderSettings
    settings: RecorderSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.status = self.output("status", RecorderStatus)
        self._meter = context.meter
        self._lost_before = 0
        self._inputs = context.inputs
        for port in context.inputs.values():
            self.on(port, self._taker(port))
        self.every(1.0, self._publish)
        self._writer: RecordingWriter | None = None
        self._ending: list[RecordingWriter] = []
        self._reported: list[RecordingWriter] = []
        #: Whether the present recording is a ring.
        self._turns = False
        self._wanted: dict[str, Any] = {}
        #: Newest message of each state, by the state's key.
        self._standing: dict[str, tuple[str, Message]] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._saving_on_event = False
        self._detach: Callable[[], None] = lambda: None

    @classmethod
    def default_inputs(cls, channels: Mapping[str, ChannelSpec]) -> Mapping[str, str]:
        """All recordable channels, on ports of their names."""
        return {name: name for name, spec in channels.items() if spec.log != "never"}

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Take any channel, without loss while the event loop stalls for at most a second or two."""
        capacity = LARGE_INBOX if message_type in LARGE else INBOX
        port = self.input(name, message_type, capacity=capacity, lossless=True)
        self.on(port, self._taker(port))

    async def start(self) -> None:
        """Attach the service that saves the ring, and look for the ring of a killed program."""
        self._loop = asyncio.get_running_loop()
        self._library = self.service(RecordingLibrary)
        self._manifest = self.service(Manifest)
        self._table = self.service(ChannelTable)
        least_free = int(self.settings.least_free_mb * MEGABYTE)
        self._saver = RingSaver(self._library, least_free, self.log, self._meter.call)
        self._detach = self.service(RecorderService).attach(self.save_ring)
        self._keep(self._saver.rescue(), "rescue")

    async def stop(self) -> None:
        """Close the file. The segments of a ring stay on disk for the next start."""
        self._detach()
        for task in self._tasks:
            task.cancel()
        self._end(discard=False)
        # The thread finishes closing whether or not it is awaited.
        await self.compute(_join, self._ending, CLOSING_S)
        self._publish()

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Record as ``parameters`` say; stop without any."""
        if dict(parameters) == self._wanted:
            return
        before, self._wanted = self._wanted, dict(parameters)
        ring = self._ring_writer()
        keep_s = self._keep_s
        if before and ring is not None and not ring.reason and keep_s:
            ring.call(lambda sink: _keep_for(sink, keep_s))
        else:
            ended = self._writer
            # The ring is discarded only if nothing is to be recorded any more; another recording does not affect it.
            self._end(discard=not self._wanted)
            if self._wanted:
                self._begin()
                self._keep(self._rescue_after(ended), "rescue")
        self._publish()

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Log it, and go on: the status counts lost messages."""
        self.log.warning("%s", loss)

    async def save_ring(self, minutes: float | None, name: str | None) -> str:
        """See ``RecorderService.save_ring``; also raises ValueError for an invalid name."""
        writer = self._ring_writer()
        if writer is None or writer.reason:
            raise RecorderUnavailable(NO_RING)
        return await self._saver.save(writer, self.clock.now(), minutes, name)

    # --- recording ---

    @property
    def queued_bytes(self) -> int:
        """About how many bytes wait for the disk, including recordings that are closing."""
        return sum(writer.queued_bytes for writer in (*self._ending, self._writer) if writer is not None)

    @property
    def writing(self) -> bool:
        """Whether a recording is not completely on disk yet."""
        return self._writer is not None or any(not writer.over for writer in self._ending)

    @property
    def _keep_s(self) -> float:
        return 60.0 * float(self._wanted.get("keep_minutes", 0))

    def _ring_writer(self) -> RecordingWriter | None:
        return self._writer if self._turns else None

    def _begin(self) -> None:
        settings = self.settings
        limits = Limits(
            queue_bytes=int(settings.queue_mb * MEGABYTE),
            queue_messages=settings.queue_messages,
            least_free_bytes=int(settings.least_free_mb * MEGABYTE),
            too_slow_after_s=settings.too_slow_after_s,
        )
        self._turns = self._keep_s > 0
        self._lost_before = self._lost()
        at, keep_s, name = self.clock.now(), self._keep_s, str(self._wanted.get("name", ""))
        disk = DiskTime()
        open_file = disk.timed(type(self).open_file)
        self._writer = RecordingWriter(
            lambda: self._open(at, keep_s, name, open_file),
            limits,
            self.clock.now,
            on_change=self._changed_in_thread,
            charge=self._meter.call,
            disk=disk,
        )
        for channel, message in self._states().values():
            self._writer.put(at, channel, message)

    def _open(self, at: float, keep_s: float, name: str, open_file: OpenFile) -> Sink:
        # Checked before a file is made: a nearly full disk must not collect empty files, one for each try.
        least_free = int(self.settings.least_free_mb * MEGABYTE)
        check_room(self._library.folder, self._library.free_bytes(), least_free)
        if keep_s:
            return Ring(
                self._library.ring_folder, self._new_encoder, self._manifest, at, keep_s,
                state_key=self._state_key, segment_s=self.settings.segment_s, open_file=open_file,
            )  # fmt: skip
        return FileSink(self._library.candidates(name, at), self._new_encoder(), self._manifest, at, open_file)

    def _new_encoder(self) -> Encoder:
        return Encoder(self._table, self.settings.jpeg_quality)

    def _end(self, discard: bool) -> None:
        if self._writer is not None:
            self._writer.finish(discard)
            self._ending = [*(w for w in self._ending if not w.over), self._writer]
            self._reported = [w for w in self._reported if w in self._ending]
            self._writer = None

    def _taker(self, port: Input[Any]) -> Callable[[Any], Awaitable[None]]:
        async def take(message: Any) -> None:
            channel = port.channel.name if port.channel is not None else port.name
            self._take(channel, message)

        return take

    def _take(self, channel: str, message: Any) -> None:
        writer = self._writer
        if writer is not None:
            writer.put(self.clock.now(), channel, message)
            if writer.reason and writer not in self._reported:
                self._publish()
        if isinstance(message, TimelineEvent):
            self._save_on(message)
        elif (key := self._state_key(channel, message)) is not None:
            self._standing[key] = (channel, message)

    def _state_key(self, channel: str, message: Any) -> str | None:
        if not self._table[channel].latched:
            return None
        return f"{channel}/{message.module}" if isinstance(message, ModuleRecord) else channel

    def _states(self) -> dict[str, tuple[str, Message]]:
        """The newest state of each channel, also from before this instance: a log begins with the whole state."""
        states = dict(self._standing)
        for port in self._inputs.values():
            if port.channel is not None and (latest := port.channel.latest) is not None:
                key = self._state_key(port.channel.name, latest)
                if key is not None:
                    states[key] = (port.channel.name, latest)
        return states

    # --- status ---

    def _changed_in_thread(self) -> None:
        with suppress(RuntimeError):  # the loop is closed: the status has no subscriber any more
            self._loop.call_soon_threadsafe(self._publish)

    def _publish(self) -> None:
        for writer in (*self._ending, self._writer):
            if writer is not None and writer.reason and writer not in self._reported:
                self._reported.append(writer)
                self.log.error("recording stopped: %s", writer.reason)
        self.status.publish(self._describe())

    def _describe(self) -> RecorderStatus:
        now = self.clock.now()
        writer = self._writer or next((w for w in reversed(self._ending) if not w.over), None)
        sink = None if writer is None else writer.sink
        state: RecorderState = "ring" if self._turns else "recording"
        if writer is None or writer.reason:
            state = "idle" if writer is None else "stopped"
        return RecorderStatus(
            stamp=now,
            state=state,
            name="" if sink is None else sink.name,
            began=0.0 if writer is None else writer.began,
            duration_s=0.0 if writer is None else writer.duration_s,
            bytes=0 if sink is None else sink.bytes,
            messages=0 if sink is None else sink.messages,
            dropped=0 if writer is None else writer.dropped + self._lost() - self._lost_before,
            queued_bytes=0 if writer is None else writer.queued_bytes,
            reason="" if writer is None else writer.reason,
        )

    def _lost(self) -> int:
        """Number of messages dropped by full inboxes, since the start."""
        return sum(port.subscription.statistics().dropped for port in self._inputs.values() if port.connected)

    # --- saving ---

    def _save_on(self, event: TimelineEvent) -> None:
        if self._saving_on_event or self._ring_writer() is None:
            return
        if any(pattern.matches(event) for pattern in self.settings.save_ring_on):
            self._saving_on_event = True
            self._keep(self._save_after(event), "save the ring")

    async def _rescue_after(self, ended: RecordingWriter | None) -> None:
        """Save ended rings, including ``ended`` once its thread has finished."""
        if ended is not None:
            await asyncio.to_thread(ended.join)
        await self._saver.rescue()

    async def _save_after(self, event: TimelineEvent) -> None:
        try:
            await self.clock.sleep(self.settings.save_after_s)
            subject = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "-" for c in event.subject)
            await self.save_ring(None, f"{default_name(event.stamp)}-{event.kind}-{subject}"[:100])
        except (RecorderUnavailable, LogError) as error:
            self.log.warning("the ring could not be saved after %r: %s", event.text, error)
        finally:
            self._saving_on_event = False

    def _keep(self, work: Coroutine[Any, Any, None], name: str) -> None:
        task = asyncio.create_task(self._metered(work), name=f"{self.name}.{name}")
        self._tasks.add(task)
        task.add_done_callback(self._kept)

    def _kept(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            # A bug beside the recording, which goes on.
            self.log.error("%s failed", task.get_name(), exc_info=error)


def _join(writers: list[RecordingWriter], timeout_s: float) -> None:
    give_up_at = time.monotonic() + timeout_s
    for writer in writers:
        writer.join(max(0.0, give_up_at - time.monotonic()))


def _keep_for(sink: Sink, seconds: float) -> None:
    if isinstance(sink, Ring):
        sink.keep_s = seconds
