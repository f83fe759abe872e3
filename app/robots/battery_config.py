"""Configuration of a simulated body's battery: ``battery`` in ``config/robots/*.yaml``."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from app.robots.config_model import ConfigModel, NotNegative, Positive, Share


class LoadConfig(ConfigModel):
    """What draws power from the battery, W."""

    idle_w: NotNegative = Field(20.0, description="electronics and motors at rest: always")
    computer_w: NotNegative = Field(15.0, description="the computer, doing nothing")
    core_w: NotNegative = Field(10.0, description="each core of it that is busy, in addition")
    sensors_w: dict[str, NotNegative] = Field({}, description="each sensor while it runs, by stream")
    efficiency: Annotated[float, Field(gt=0, le=1)] = Field(
        0.6, description="of the motors: mechanical power over electrical"
    )
    friction_n: NotNegative = Field(10.0, description="rolling resistance of the whole base")


class BatteryConfig(ConfigModel):
    """The battery and its charger."""

    capacity_wh: Positive = 480.0
    charge: Share = Field(1.0, description="at the start: share of the capacity")
    empty_v: Positive = Field(22.0, description="without a load, empty")
    full_v: Positive = Field(27.0, description="without a load, full")
    resistance_ohm: NotNegative = 0.02
    charger_w: Positive = Field(150.0, description="what a dock supplies, to the body and its battery together")
    plate_m: Positive = Field(0.275, description="of the body's charging plate ahead of base_link, m")
    rate_hz: Annotated[float, Field(gt=0, le=50)] = Field(1.0, description="of the stream")
    load: LoadConfig = LoadConfig()

    @model_validator(mode="after")
    def _voltage_rises(self) -> Self:
        if self.full_v < self.empty_v:
            raise ValueError(f"full_v ({self.full_v:g}) must not be less than empty_v ({self.empty_v:g})")
        return self
