"""Messages of sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """One frame of a camera, with its registered depth where the camera has one.

    ``color`` (H, W, 3) uint8, RGB. ``depth`` (H, W) uint16, millimetres along the optical axis, 0 = no measurement;
    None for a camera without depth. ``frame`` names the camera. ``X_BC`` is the pose of the optical frame in
    ``base_link`` at ``stamp``, from the joints as measured then.
    """

    stamp: float
    frame: str
    color: NDArray[np.uint8]
    depth: NDArray[np.uint16] | None
    camera: CameraModel | FisheyeModel
    X_BC: Pose3


@dataclass(frozen=True, slots=True, eq=False)
class LaserScan:
    """One sweep of a planar laser.

    ``ranges`` (N,) float32 m, +inf = nothing within ``range_max``; ``intensities`` (N,) float32, arbitrary unit.
    Ray i points at ``angle_min + i * angle_increment`` (rad, about z of the laser's frame, x forward). ``stamp`` is
    the time of the first ray, the last comes ``duration_s`` later. ``X_BL``: pose of the laser in ``base_link``.
    """

    stamp: float
    frame: str
    ranges: NDArray[np.float32]
    intensities: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    duration_s: float
    X_BL: Pose3


@dataclass(frozen=True, slots=True, eq=False)
class Audio:
    """A frame of sound of one or more channels, sampled together.

    ``samples`` (N, C) int16, full scale 32768; ``rate`` samples per second. ``stamp`` is the time of the first of them,
    ``first_sample`` its number since the source began: where a frame's is not the last one's plus its length, samples
    were lost between. ``p_BM`` (C, 3) float64 m: the microphones in ``base_link``; (0, 3) for sound of no place there
    (an operator's voice). ``frame`` names the source.
    """

    stamp: float
    frame: str
    samples: NDArray[np.int16]
    rate: int
    first_sample: int
    p_BM: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Imu:
    """Motion as an inertial sensor feels it, where it is, along the axes of ``base_link``.

    ``angular_velocity`` (x, y, z) rad/s; ``specific_force`` (x, y, z) m/s2, the acceleration less gravity: (0, 0, 9.8)
    of a robot that stands level. ``attitude``: quaternion (x, y, z, w) of ``base_link`` in a level frame whose heading
    is arbitrary; None of a sensor that gives none. Covariances (3, 3) row by row, along the same axes, that of the
    attitude (rad2) along those that the sensor has for it; None where it does not say them. ``frame`` names the sensor.
    """

    stamp: float
    frame: str
    angular_velocity: tuple[float, float, float]
    specific_force: tuple[float, float, float]
    attitude: tuple[float, float, float, float] | None = None
    angular_velocity_covariance: tuple[float, ...] | None = None
    specific_force_covariance: tuple[float, ...] | None = None
    attitude_covariance: tuple[float, ...] | None = None


@dataclass(frozen=True, slots=True)
class Odometry:
    """Wheel odometry: ``X_OB``, the pose of ``base_link`` in ``odom`` (drifts), and the measured twist in B."""

    stamp: float
    X_OB: Pose2
    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0


@dataclass(frozen=True, slots=True)
class JointState:
    """Measured joints: ``positions[i]`` (rad, or m where prismatic) of joint ``names[i]``.

    ``efforts[i]`` is what its motor exerts (N m, or N), without what compensates the weight that it carries; empty
    where the body does not measure it.
    """

    stamp: float
    names: tuple[str, ...]
    positions: tuple[float, ...]
    efforts: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """True pose of ``base_link`` in the simulated ``world``: for tests and experiments only, never for a module."""

    stamp: float
    X_WB: Pose2
    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0


@dataclass(frozen=True, slots=True)
class PersonTruth:
    """Place of a simulated person: feet ``x``, ``y`` (m) in the world, ``heading`` (rad) they look along.

    ``mouth`` (m) in the world; ``height_m`` of the whole person.
    """

    name: str
    x: float
    y: float
    heading: float
    height_m: float
    mouth: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class SoundTruth:
    """A sounding source: ``kind`` (``speech``, ``clap``, ``door``, ``steps``, ``music``, ``alarm`` …).

    ``p_WS`` (m) is its place in the world, ``began`` (robot's clock, s) when its first sample left there; ``active``
    whether it is louder now than its own pauses; ``person``: the name of its person, "" for none.
    """

    name: str
    kind: str
    person: str
    p_WS: tuple[float, float, float]
    began: float
    active: bool


@dataclass(frozen=True, slots=True)
class SceneTruth:
    """Who and what else is in the simulated world: for tests and experiments only, never for a module."""

    stamp: float
    people: tuple[PersonTruth, ...]
    sounds: tuple[SoundTruth, ...]
