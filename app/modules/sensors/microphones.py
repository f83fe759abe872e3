"""Microphones: the array around the torso, all sampled together (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Microphones    out  audio  Audio, 8 channels, 48 kHz, 16 bit, frames of 512, in base_link│
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes nothing: the body's stream ``microphones`` is published unchanged, and only while a subscription is open. Sound
may not be decimated: an input for it is open or closed (thesis 4.2.4).
"""

from __future__ import annotations

from types import MappingProxyType

from app.messages import Audio
from app.modules.stream_module import StreamModule


class Microphones(StreamModule):
    title = "Microphones"
    relays = MappingProxyType({"audio": ("microphones", Audio)})
