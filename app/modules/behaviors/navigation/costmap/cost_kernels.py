"""Compiled kernels: cost per metre from distances. Layers, settings and units as in ``inflation``."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math

import numpy as np

from app.base.compiled import kernel

_UNKNOWN, _AT_OCCUPIED, _AT_KEEP_OUT, _AT_TEMPORARY = 8, 16, 32, 64
_PRICES = "float64, float64, float64, float64"


@kernel(f"float64(float64, float64, boolean, {_PRICES})")
def price(clearance, share, unknown, lethal, reach, closeness, unknown_cost) -> float:
    """Cost of a metre at ``clearance`` (m)."""
    if clearance < lethal:
        return math.inf
    cost: float = 1.0 / max(share, 0.02)
    if clearance < reach:
        near = (reach - clearance) / (reach - lethal)
        cost += closeness * near * near
    if unknown:
        cost += unknown_cost
    return cost


@kernel(f"void(float32[:,:], float32[:,:], float32[:,:], uint8[:,:], float32[:,:], float32[:,:], {_PRICES})")
def lay(distances, zone, share, layers, clearance, cost, lethal, reach, closeness, unknown_cost) -> None:
    """Fill ``clearance`` and ``cost``, and set the layers each cell is too near to, from ``distances`` to occupied
    cells.

    All arrays (H, W); ``zone`` (distances to keep-out zones) and ``share`` are (0, 0) without zones.
    """
    rows, columns = distances.shape
    zoned, slow = zone.size > 0, share.size > 0
    for i in range(rows):
        for j in range(columns):
            layer = int(layers[i, j]) & ~(_AT_OCCUPIED | _AT_KEEP_OUT)
            here = distances[i, j]
            if here < lethal:
                layer |= _AT_OCCUPIED
            if zoned and zone[i, j] < reach:
                if zone[i, j] < lethal:
                    layer |= _AT_KEEP_OUT
                here = min(here, zone[i, j])
            here = min(here, np.float32(reach))
            layers[i, j] = layer
            clearance[i, j] = here
            cost[i, j] = price(
                here, share[i, j] if slow else 1.0, (layer & _UNKNOWN) != 0, lethal, reach, closeness, unknown_cost
            )


@kernel(f"void(float32[:,:], float32[:,:], uint8[:,:], float32[:,:], float32[:,:], {_PRICES})")
def overlay(distances, share, layers, clearance, cost, lethal, reach, closeness, unknown_cost) -> None:
    """Merge ``distances`` (H, W) to transient obstacles into a field of the map's obstacles."""
    rows, columns = distances.shape
    slow = share.size > 0
    for i in range(rows):
        for j in range(columns):
            here = distances[i, j]
            if here >= reach:
                continue
            if here < lethal:
                layers[i, j] = int(layers[i, j]) | _AT_TEMPORARY
            if here < clearance[i, j]:
                clearance[i, j] = here
                unknown = (layers[i, j] & _UNKNOWN) != 0
                cost[i, j] = price(here, share[i, j] if slow else 1.0, unknown, lethal, reach, closeness, unknown_cost)
