"""The outline of the body for planning and control, with its arms as they are now."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.base.moving_shapes import BodyOutline, Corners
from app.modules.behaviors.navigation.costmap.footprint import Footprint

#: Arms that stick out no further (m) beyond the footprint leave it as it is: those of IRL-1 at rest do so by 0.015 m,
#: and the controllers keep more clear than that.
SPARE_M = 0.03


class ArmOutline:
    """Follows the joints. :attr:`corners` is the footprint itself (the same object) while the arms rest."""

    def __init__(self, outline: BodyOutline, footprint: Corners) -> None:
        self._outline = outline
        self._usual = footprint
        self._footprint = Footprint.polygon(np.array(footprint, dtype=np.float64))
        self._positions: Mapping[str, float] | None = None
        #: The outline (m in ``base_link``, convex, counter-clockwise) at the positions taken last.
        self.corners = footprint

    @property
    def stretched(self) -> bool:
        """Whether the arms stick out beyond the footprint."""
        return self.corners is not self._usual

    def update(self, positions: Mapping[str, float]) -> bool:
        """Take joint ``positions`` (rad, m) by name; returns whether :attr:`corners` changed."""
        if self._positions is not None and not self._outline.changed(self._positions, positions):
            return False
        self._positions = positions
        before, corners = self.corners, self._outline.at(positions)
        within = bool(self._footprint.contains(np.array(corners, dtype=np.float64), SPARE_M).all())
        self.corners = self._usual if within else corners
        return self.corners != before
