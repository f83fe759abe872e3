"""What the package's modules publish."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class NearThings:
    """What one scan saw nearby: ``count`` things, the nearest at ``nearest_m`` (m), None where there is none."""

    stamp: float
    count: int
    nearest_m: float | None
