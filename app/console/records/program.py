"""The program: modules, channels, health, and who watches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from app.messages import ModuleReport, SubscriptionCounters
from app.messages.base import Stamp, doc
from app.runtime.freshness import FreshnessState

RoleName = Literal["spectator", "operator", "supervisor"]


@dataclass(frozen=True, slots=True)
class ModuleList:
    """Every module, and the load of the whole process."""

    stamp: Stamp
    process_cpu: Annotated[float, doc("Per cent of one core.")]
    modules: tuple[ModuleReport, ...]


@dataclass(frozen=True, slots=True)
class SourceState:
    """Freshness of a channel: its measured and its expected rate."""

    channel: str
    state: FreshnessState
    age_ms: float | None
    rate_hz: float | None
    expected_hz: float | None


@dataclass(frozen=True, slots=True)
class ChannelReport:
    """One channel of the table and what goes through it."""

    name: str
    title: str
    type: str
    frame: str
    rate_hz: Annotated[float | None, doc("Nominal rate; null for a channel of events.")]
    expected_hz: Annotated[float | None, doc("Rate that attention asks for; 0 when closed, null for events.")]
    measured_hz: Annotated[float | None, doc("Messages a second over the last two seconds.")]
    decimable: bool
    wanted: Annotated[bool, doc("Whether anything listens.")]
    producer: Annotated[str | None, doc("`Module.port`; null: fed from outside the graph.")]
    published: int
    state: Annotated[
        FreshnessState,
        doc("`stale`: older than the rate asked for allows, or its module is down. `closed`: not wanted."),
    ]
    age_ms: Annotated[float | None, doc("Age of the newest message.")]
    stale_after_ms: Annotated[float | None, doc("Age beyond which it is stale; null for events and when closed.")]
    subscriptions: Annotated[Mapping[str, SubscriptionCounters], doc("Counters by consumer.")]


@dataclass(frozen=True, slots=True)
class ChannelList:
    """Every channel."""

    channels: tuple[ChannelReport, ...]


@dataclass(frozen=True, slots=True)
class Health:
    """Health of the program."""

    status: Literal["ok", "degraded"]
    stamp: Stamp
    problems: Annotated[tuple[str, ...], doc("Modules that do not run, and what else is wrong.")]


@dataclass(frozen=True, slots=True)
class Session:
    """That this client may use the console."""

    authenticated: Literal[True]
    token_needed: bool
    role: Annotated[RoleName, doc("What it may do here.")]


@dataclass(frozen=True, slots=True)
class SceneAddress:
    """Where a page takes the 3D view for a frame from."""

    url: Annotated[str | None, doc("On its own port; null: from the console's, at `viser/`.")]


@dataclass(frozen=True, slots=True)
class ScenePoint:
    """What a point of a 3D view shows."""

    kind: Annotated[
        Literal["poster", "wall", "seen", "floor", "nothing"],
        doc("`poster`: one that was found; `wall`: of the map; `seen`: by the depth camera; `nothing`: the sky."),
    ]
    frame: Annotated[Literal["map", "odom"], doc("`odom` while it is not known where the robot is on the map.")]
    x: Annotated[float | None, doc("In m, as `y` and `z`: of a poster its middle; null: nothing is there.")]
    y: float | None
    z: Annotated[float | None, doc("Above the floor.")]
    text: Annotated[str | None, doc("What the poster says.")]
    landmark: Annotated[int | None, doc("The poster's `id`, which it keeps on its map.")]


@dataclass(frozen=True, slots=True)
class PageReport:
    """A page on the live stream."""

    operator: str
    driving: bool
    rtt_ms: Annotated[float | None, doc("Last round trip that the page measured.")]
    late_ms: Annotated[float | None, doc("How old its last message was when it came, at most; null: not known.")]
    waits: Annotated[str, doc("Why its driving waits, in words; empty: it does not.")]
    waiting: Annotated[int, doc("Frames that wait for it.")]
    sent: Annotated[int, doc("Frames sent.")]
    replaced: Annotated[int, doc("Frames replaced by a newer one of their kind before they could be sent.")]


@dataclass(frozen=True, slots=True)
class ViewReport:
    """A 3D view."""

    viewer: str
    lag_ms: Annotated[float | None, doc("From the robot to the drawn frame and back, smoothed.")]
    points: Annotated[int, doc("Points it is sent of each cloud, so that the lag stays under 200 ms.")]
    period_ms: Annotated[float, doc("Time left between two updates, so that its page keeps time for its keys.")]
    sent_bytes: int


@dataclass(frozen=True, slots=True)
class ViewerList:
    """Connected pages and 3D views."""

    pages: tuple[PageReport, ...]
    views: tuple[ViewReport, ...]
