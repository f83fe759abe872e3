"""Requests about the shaped link, checked as they come in."""

from __future__ import annotations

from pydantic import Field

from app.console.rest.models import Request


class LinkChange(Request):
    """How the link is shaped from now on; members left out shape nothing."""

    delay_ms: float = Field(
        0.0, ge=0, le=5000, description="Added to a round trip, half of it each way.", examples=[300]
    )
    jitter_ms: float = Field(0.0, ge=0, description="The delay varies by as much; at most the delay.", examples=[50])
    loss_percent: float = Field(0.0, ge=0, le=50, description="Packets that are lost and sent again.", examples=[2])
    rate_mbit: float | None = Field(None, ge=0.064, le=10_000, description="Mbit/s each way; null: not bounded.")
