"""The network between the program and its pages, as it is shaped for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from app.messages.base import doc


@dataclass(frozen=True, slots=True)
class LinkReport:
    """How every stream between the program and its pages is delayed and bounded, for tests; not by the real network."""

    shaped: Annotated[bool, doc("Whether it is at all.")]
    delay_ms: Annotated[float, doc("Added to a round trip, half of it each way.")]
    jitter_ms: Annotated[float, doc("The delay varies by as much up and down.")]
    loss_percent: Annotated[float, doc("Packets that are lost and sent again.")]
    rate_mbit: Annotated[float | None, doc("Mbit/s each way; null: not bounded.")]
    text: Annotated[str, doc("The same in words; empty where nothing is shaped.")]
