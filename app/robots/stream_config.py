"""Configuration of a simulated body's drive and streams: ``base`` and ``streams`` in ``config/robots/*.yaml``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from app.robots.config_model import ConfigModel, NotNegative, Positive


class BaseConfig(ConfigModel):
    """Drive of the base, and its errors.

    A ``differential`` drive turns its two wheels. A ``holonomic`` one moves at any velocity in the plane, by forces at
    the floor; its wheels are those of the model, and roll freely. It measures its motion in ``odometry`` with the
    errors of radius and track as those of length and turn.

    ``wheel_radius_m`` and ``track_m`` are the nominal values that odometry computes with. The errors are fractions of
    them (1-sigma, drawn once per start from the seed); ``slip`` is the 1-sigma fraction by which each wheel slips,
    wandering with the distance it rolls; ``encoder_ticks`` counts one turn of a wheel.
    """

    drive: Literal["differential", "holonomic"] = "differential"
    left_wheel_joint: str = "left_wheel_joint"
    right_wheel_joint: str = "right_wheel_joint"
    wheel_radius_m: Positive = 0.10
    track_m: Positive = 0.44
    radius_error: NotNegative = 0.003
    track_error: NotNegative = 0.006
    slip: NotNegative = 0.004
    encoder_ticks: Annotated[int, Field(ge=16)] = 8192


class OdometryConfig(ConfigModel):
    """Stream ``odometry``."""

    rate_hz: Positive = 100.0


class JointsConfig(ConfigModel):
    """Stream ``joints``: measured with ``noise_rad`` and ``noise_nm`` (1-sigma; m and N where prismatic)."""

    rate_hz: Positive = 30.0
    noise_rad: NotNegative = 0.0005
    noise_nm: NotNegative = 0.05


class HokuyoConfig(ConfigModel):
    """Stream ``hokuyo``: a UTM-30LX read over its forward 180 degrees (thesis 4.2)."""

    rate_hz: Positive = 40.0
    link: str = "hokuyo_link"
    rays: Annotated[int, Field(ge=2)] = 720
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 180.0
    range_min_m: NotNegative = 0.1
    range_max_m: Positive = 30.0
    noise_m: NotNegative = 0.01
    sweep_s: NotNegative = Field(default=0.0125, description="time from the first ray to the last")


class KinectConfig(ConfigModel):
    """Stream ``kinect``: colour with registered depth (thesis 4.2).

    Depth noise is ``noise_floor_m + noise_slope * (z - 0.4)^2`` (1-sigma, m; Nguyen, Izadi and Lovell 2012);
    depths are quantised as the sensor's disparity is, ``quantum_m`` at 1 m and growing with z^2 (Khoshelham and
    Elberink 2012); ``baseline_m`` between projector and camera makes the shadows beside near things.
    """

    rate_hz: Positive = 15.0
    link: str = "kinect_optical_frame"
    width: Annotated[int, Field(ge=16, le=1920)] = 640
    height: Annotated[int, Field(ge=16, le=1080)] = 480
    fov_deg: tuple[float, float] = (57.0, 43.0)
    range_min_m: Positive = 0.4
    range_max_m: Positive = 5.0
    noise_floor_m: NotNegative = 0.0012
    noise_slope: NotNegative = 0.0019
    quantum_m: Positive = 0.00285
    baseline_m: NotNegative = 0.075
    color_noise: NotNegative = Field(default=2.0, description="1-sigma, grey levels")


class PanoramicCameraConfig(ConfigModel):
    """Stream ``panorama``: colour of the full hemisphere in front, through an equidistant fisheye (thesis 4.2).

    The lens stretches the circle to fill the sensor, as panomorph lenses do: ``fov_deg`` are the full horizontal and
    vertical fields of view along the image's middle lines.
    """

    rate_hz: Positive = 10.0
    link: str = "panorama_optical_frame"
    width: Annotated[int, Field(ge=16, le=4096)] = 1024
    height: Annotated[int, Field(ge=16, le=4096)] = 768
    fov_deg: tuple[Annotated[float, Field(gt=0, le=180)], Annotated[float, Field(gt=0, le=180)]] = (180.0, 180.0)
    color_noise: NotNegative = Field(default=2.0, description="1-sigma, grey levels")


class MicrophonesConfig(ConfigModel):
    """Stream ``microphones``: frames of samples taken together (thesis 4.2).

    ``positions`` (m) are in ``link``. ``noise_db`` is a microphone's own noise, ``sensitivity_db`` the level at 1 m of
    a talker of ordinary loudness (65 dB SPL there), both in dB of full scale. ``fans_db`` and ``wheels_db`` are the
    levels there of the robot's fans, and of its wheels at 0.4 m/s. ``shadow``: whether the torso is modelled as a rigid
    sphere with the microphones on its surface; without it they are in a free field.
    """

    rate: Annotated[int, Field(ge=8000, le=192000)] = 48000
    frame_samples: Annotated[int, Field(ge=64, le=8192)] = 512
    link: str = "torso_link"
    positions: Annotated[tuple[tuple[float, float, float], ...], Field(min_length=1, max_length=32)] = (
        (0.085, 0.11, 0.46), (0.085, -0.11, 0.46), (-0.085, -0.11, 0.46), (-0.085, 0.11, 0.46),
        (0.085, 0.11, 0.25), (0.085, -0.11, 0.25), (-0.085, -0.11, 0.25), (-0.085, 0.11, 0.25),
    )  # fmt: skip
    noise_db: float = -75.0
    fans_db: float = -62.0
    wheels_db: float = -52.0
    sensitivity_db: float = -32.0
    shadow: bool = True


class LoudspeakerConfig(ConfigModel):
    """The robot's loudspeaker, ``position`` (m) in ``link``; ``gain_db`` is its level at 1 m for a full-scale sound."""

    link: str = "torso_link"
    position: tuple[float, float, float] = (0.1, 0.0, 0.36)
    gain_db: float = -20.0


class StatusConfig(ConfigModel):
    """Streams ``status`` and, where configuration turns it on, ``ground_truth``."""

    rate_hz: Positive = 20.0


class StreamsConfig(ConfigModel):
    """Every stream of the body; null for a missing sensor."""

    odometry: OdometryConfig = OdometryConfig()
    joints: JointsConfig = JointsConfig()
    status: StatusConfig = StatusConfig()
    kinect: KinectConfig | None = KinectConfig()
    hokuyo: HokuyoConfig | None = HokuyoConfig()
    panorama: PanoramicCameraConfig | None = None
    microphones: MicrophonesConfig | None = None
