"""InertialSensor: turning, acceleration and tilt of the body, as its inertial sensor feels them.

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ InertialSensor   out  imu  Imu, as the body gives it, along base_link's axes (rad/s, m/s2) │
└─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing. Nothing drives by it yet: it is there to be seen, recorded, and for modules to come.
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import Imu
from app.modules.stream_module import StreamModule


class InertialSensor(StreamModule):
    title = "Inertial sensor"
    relays = MappingProxyType({"imu": ("imu", Imu)})
