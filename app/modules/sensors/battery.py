"""Battery: charge, voltage and current of the body's battery.

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ Battery          out  battery  BatteryState, 1 Hz or as the body gives it                │
└─────────────────────────────────────────────────────────────────────────────────────────┘
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import BatteryState
from app.modules.stream_module import StreamModule


class Battery(StreamModule):
    title = "Battery"
    relays = MappingProxyType({"battery": ("battery", BatteryState)})
