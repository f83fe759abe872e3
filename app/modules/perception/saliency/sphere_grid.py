"""The grid of directions around the head that feature maps and the sphere share. Pure.

Rows go from the top down, columns from azimuth +π to -π, as on the page's strip of all directions: ahead is in the
middle. The axes are those of ``odom``, so that the grid stays with the room while the robot turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class SphereGrid:
    """Cells of ``step_rad``, all around and up to ``top_rad`` over and under level.

    Raises ValueError where not a whole number of cells goes around.
    """

    step_rad: float = math.radians(3.0)
    top_rad: float = math.radians(48.0)

    def __post_init__(self) -> None:
        around = 2 * math.pi / self.step_rad
        if abs(around - round(around)) > 1e-6:
            raise ValueError(f"cells of {math.degrees(self.step_rad):g}° do not fit into a full turn")

    @property
    def columns(self) -> int:
        return round(2 * math.pi / self.step_rad)

    @property
    def rows(self) -> int:
        return 2 * round(self.top_rad / self.step_rad)

    @property
    def azimuths(self) -> NDArray[np.float64]:
        """Of the columns' middles (columns,) rad, left positive."""
        return np.asarray(math.pi - (np.arange(self.columns) + 0.5) * self.step_rad, np.float64)

    @property
    def elevations(self) -> NDArray[np.float64]:
        """Of the rows' middles (rows,) rad, up positive."""
        return np.asarray((0.5 * self.rows - np.arange(self.rows) - 0.5) * self.step_rad, np.float64)

    def directions(self) -> NDArray[np.float64]:
        """Unit vectors (rows, columns, 3) of the cells' middles."""
        level = np.cos(self.elevations)[:, None]
        up = np.broadcast_to(np.sin(self.elevations)[:, None], (self.rows, self.columns))
        return np.stack((level * np.cos(self.azimuths), level * np.sin(self.azimuths), up), axis=-1)

    def finer(self, parts: int) -> SphereGrid:
        """The grid with ``parts`` x ``parts`` cells for each of this one."""
        return SphereGrid(self.step_rad / parts, self.top_rad)

    def turned(self, values: NDArray[np.float32], heading: float) -> NDArray[np.float32]:
        """``values`` (rows, columns) of this grid in axes turned by ``heading`` (rad, left positive), to the nearest
        column."""
        return np.roll(values, round(heading / self.step_rad), axis=1)
