"""RotateToHeading: turns the base in place, and keeps it turned, to a heading.

    ┌──────────────────────────────────────────────────────────────────────────────────────────┐
    │ RotateToHeading  in   odometry         Odometry, 100 Hz, X_OB in odom; never filtered    │
    │                  in   localization     Localization: X_MO, for headings on the map;      │
    │                                        may be absent                                     │
    │                  out  twist            Twist (rad/s in base_link), 10 Hz while it turns  │
    │                  out  accomplishments  Accomplishment, when the heading is reached       │
    └──────────────────────────────────────────────────────────────────────────────────────────┘

The desire is maintained: once turned, the base is turned again when the heading of the desire changes, or something
else has turned it, by more than ``begin_rad``. A heading in ``odom`` needs no map.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict
from pydantic import Field as Setting

from app.attention.desires import DesireClass
from app.base.geometry import Pose2, wrap_angle
from app.messages import Desire, Localization, Odometry, Twist
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.rotation import Rotation
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, Module, ModuleContext, Settings

#: Odometry is not turned by for longer (s).
_FRESH_S = 0.3


class RotateToHeadingParameters(BaseModel):
    """Parameters of a desire of class RotateToHeading."""

    model_config = ConfigDict(extra="forbid", title="Turn to a heading", allow_inf_nan=False)

    heading: float = Setting(ge=-7, le=7, title="Heading", description="Where to, in rad, left positive.")
    frame: Literal["odom", "map"] = Setting("odom", title="Frame", description="In which the heading is: odom or map.")
    tolerance_rad: float = Setting(
        0.1, ge=0.02, le=1, title="Turned enough", description="So many rad from the heading will do."
    )
    speed: float = Setting(0.5, gt=0, le=1, title="Speed", description="Share of the robot's greatest turn rate.")


ROTATE_TO_HEADING = DesireClass(
    name="RotateToHeading",
    title="Turn to a heading",
    description="Turn the base in place to a heading, and keep it there.",
    parameters=RotateToHeadingParameters,
)


class RotateToHeadingSettings(Settings):
    """Settings of RotateToHeading."""

    period_s: float = Setting(0.1, gt=0, le=0.2, description="one control cycle")
    begin_rad: float = Setting(0.3, gt=0, le=3, description="turned, it turns again when it is off by so much")


class RotateToHeading(Module):
    """Turns the base in place."""

    title = "Turn to a heading"
    desire_classes = (ROTATE_TO_HEADING,)
    Settings = RotateToHeadingSettings
    settings: RotateToHeadingSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, wants="if_wanted")
        self.localization = self.input("localization", Localization)
        self.twist = self.output("twist", Twist)
        self._accomplishments = AccomplishmentReporter(self, ROTATE_TO_HEADING.name)
        self.on(self.localization, self._take_localization)
        self.every(self.settings.period_s, self._cycle)
        self._fastest_radps = 0.0
        self._odometry: Odometry | None = None
        self._X_MO: Pose2 | None = None
        self._given: RotateToHeadingParameters | None = None
        self._rotation: Rotation | None = None

    async def start(self) -> None:
        """Look up the body. Raises ModuleFailed for one that does not turn."""
        description = robot_link(self).description
        self._fastest_radps = description.limits.angular_radps
        if self._fastest_radps <= 0:
            raise ModuleFailed(f"{self.name} turns the base, and {description.name} has none that turns")

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the desire's parameters; without a heading there is no desire."""
        model = RotateToHeadingParameters
        known = {key: parameters[key] for key in model.model_fields if key in parameters}
        given = model.model_validate(known) if "heading" in known else None
        if given is None:
            self._rotation = None
        elif given != self._given:
            fastest = self._fastest_radps * given.speed
            self._rotation = Rotation(fastest, tolerance_rad=given.tolerance_rad, begin_rad=self.settings.begin_rad)
        self._given = given

    def cautions(self) -> tuple[Caution, ...]:
        """Those of its reports."""
        return self._accomplishments.cautions()

    def last_word(self, port: str) -> Twist | None:
        """A stop of the base."""
        return Twist(self.clock.now(), 0.0, 0.0) if port == self.twist.name else None

    async def _take_localization(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO

    async def _cycle(self) -> None:
        # Ten times a second, not with each message.
        while self.odometry.connected and self.odometry.subscription.waiting:
            self._odometry = self.odometry.subscription.receive_nowait()
        now, given, rotation, odometry = self.clock.now(), self._given, self._rotation, self._odometry
        if given is None or rotation is None or not self.twist.filter.is_open:
            return
        X_MO = Pose2() if given.frame == "odom" else self._X_MO
        if odometry is None or X_MO is None or now - odometry.stamp > _FRESH_S:
            return
        step = rotation.step(now, wrap_angle(given.heading - X_MO.theta - odometry.X_OB.theta))
        if step.radps is not None:
            self.twist.publish(Twist(now, 0.0, step.radps))
        wanted = given.model_dump()

        def about(desire: Desire) -> bool:
            return dict(desire.params) == wanted

        if step.done:
            self._accomplishments.report("done", "", about)
        elif step.stuck:
            self._accomplishments.report("failed", "the base does not turn", about)
