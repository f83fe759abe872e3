"""Sizes of paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

Paper = Literal["a4", "letter"]

#: Width and height (mm).
PAPERS: Final[Mapping[Paper, tuple[float, float]]] = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}
