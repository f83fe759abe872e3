"""The shapes of what REST tells of the robot, its program and who watches."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from app.console.rest.models import Answer, Divisor, Request, Stamp


class InputModel(Answer):
    """A module's input and its counters since the start."""

    name: str
    channel: str
    divisor: Divisor
    received: int = Field(description="Messages offered.")
    passed: int = Field(description="... let through by the filter.")
    decimated: int = Field(description="... stopped by the filter, as wanted.")
    dropped: int = Field(description="... pushed out of a full inbox.")
    age_ms: float | None = Field(description="Age of the last message when it was taken.")


class OutputModel(Answer):
    """A module's output."""

    name: str
    channel: str | None
    divisor: Divisor
    offered: int


class ModuleModel(Answer):
    """One module, its load and its counters."""

    name: str
    title: str
    state: Literal["running", "starting", "failed", "hung", "stopped"]
    cpu: float = Field(description="Per cent of one core, over the last second.")
    cpu_budget: float | None = Field(description="What it is expected to stay under.")
    message_cpu_us: float | None = Field(description="CPU time for each message taken (µs).")
    restarts: int
    problem: str | None
    inputs: list[InputModel]
    outputs: list[OutputModel]


class ModuleList(Answer):
    """Every module, and the load of the whole process."""

    stamp: Stamp
    process_cpu: float = Field(description="Per cent of one core.")
    modules: list[ModuleModel]


class ChannelModel(Answer):
    """One channel of the table and what goes through it."""

    name: str
    title: str
    type: str
    frame: str
    rate_hz: float | None = Field(description="Nominal rate; null for a channel of events.")
    expected_hz: float | None = Field(description="Rate that attention asks for; 0 when closed, null for events.")
    measured_hz: float | None = Field(description="Messages a second over the last two seconds.")
    decimable: bool
    wanted: bool = Field(description="Whether anybody listens.")
    producer: str | None = Field(description="`Module.port`; null: fed from outside the graph.")
    published: int
    state: Literal["live", "waiting", "stale", "closed"] = Field(
        description="`stale`: older than the rate asked for allows, or its module is down. `closed`: not wanted."
    )
    age_ms: float | None = Field(description="Age of the newest message.")
    stale_after_ms: float | None = Field(description="Age beyond which it is stale; null for events and when closed.")
    subscriptions: dict[str, dict[str, Any]] = Field(description="Counters by consumer.")


class ChannelList(Answer):
    """Every channel."""

    channels: list[ChannelModel]


class Velocity(Answer):
    """Forward m/s and turn rad/s (left positive)."""

    linear_mps: float
    angular_radps: float


class GuardModel(Answer):
    """What the guard says."""

    state: str = Field(description="idle, driving, stale_command, e_stopped, sensor_failure or waiting.")
    reason: str
    e_stopped: bool
    command_age_ms: float | None
    applied: Velocity


class OdometryModel(Answer):
    """Pose in `odom` and measured velocity."""

    x: float
    y: float
    theta: float
    linear_mps: float
    angular_radps: float


class LandmarkModel(Answer):
    """A QR code found, in `odom`."""

    text: str
    x: float
    y: float
    z: float
    sigma_m: float
    sightings: int
    first_seen: float
    last_seen: float


class RobotModel(Answer):
    """The robot's state."""

    stamp: Stamp
    robot: dict[str, Any] = Field(description="Name, whether simulated, limits, footprint, cautions.")
    guard: GuardModel
    world_rate: float
    odometry: OdometryModel | None
    driver: str | None = Field(description="The operator who drives.")
    exploited: str | None = Field(description="The behavior that drives the base.")
    landmarks: list[LandmarkModel]


class EStopModel(Answer):
    """What was asked of the guard; its own word follows in GET /api/v1/robot within 50 ms."""

    e_stop: Literal["latched", "released"]
    stamp: float = Field(description="The robot's clock then (s): what a release names by `seen`.")


class LoginRequest(Request):
    """The console's token."""

    token: str = Field(max_length=512)


class SessionModel(Answer):
    """That this client may use the console."""

    authenticated: Literal[True]
    token_needed: bool


class PageModel(Answer):
    """A page on the live stream."""

    operator: str
    driving: bool
    rtt_ms: float | None = Field(description="Last round trip that the page measured.")
    late_ms: float | None = Field(description="How old its last message was when it came, at most; null: not known.")
    waits: str = Field(description="Why its driving waits, in words; empty: it does not.")
    waiting: int = Field(description="Frames that wait for it.")
    sent: int = Field(description="Frames sent.")
    replaced: int = Field(description="Frames replaced by a newer one of their kind before they could be sent.")


class LookModel(Answer):
    """A 3D view."""

    viewer: str
    lag_ms: float | None = Field(description="From the robot to the drawn frame and back, smoothed.")
    points: int = Field(description="Points it is sent of each cloud, so that the lag stays under 200 ms.")
    period_ms: float = Field(description="Time left between two updates, so that its page keeps time for its keys.")
    sent_bytes: int


class ViewerList(Answer):
    """Who watches."""

    pages: list[PageModel]
    views: list[LookModel]


class HealthModel(Answer):
    """Sign of life."""

    status: Literal["ok", "degraded"]
    stamp: Stamp
    problems: list[str] = Field(description="Modules that do not run.")
