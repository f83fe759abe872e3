"""WheelOdometry: pose of the base by its wheels, and joint positions (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ WheelOdometry    out  odometry  Odometry, 100 Hz, X_OB in odom (m, rad), twist in base   │
    │                  out  joints    JointState, 30 Hz or as the body gives them (rad, m)     │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing; both streams always run, since ego-motion and safety need them without a gap.
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import JointState, Odometry
from app.modules.stream_module import StreamModule


class WheelOdometry(StreamModule):
    title = "Wheel odometry"
    relays = MappingProxyType({"odometry": ("odometry", Odometry), "joints": ("joints", JointState)})
