"""The nodes of forces on the body: an arrow each, with its newtons."""

from __future__ import annotations

import viser

from app.console.view.mark_nodes import MarkNodes, Marks, add_label, add_mesh, arrow_mesh, hide, move_arrow
from app.console.view.marks import MOST_FORCES, VIOLET, Arrow, force_marks
from app.messages import ExternalForces


class Forces:
    """Forces on the body, drawn on ``client`` below its node ``root``, the ``base_link``."""

    def __init__(self, client: viser.ClientHandle, root: str) -> None:
        self._scene = client.scene
        self._root = root
        self._arrows: Marks[Arrow, MarkNodes] = Marks(MOST_FORCES, self._add, move_arrow, hide)

    def draw(self, felt: ExternalForces | None) -> int:
        """Bring it up to what is felt; returns how many arrows changed."""
        return self._arrows.draw(force_marks(felt))

    def _add(self, number: int) -> MarkNodes:
        name = f"{self._root}/force_{number}"
        return add_mesh(self._scene, name, arrow_mesh(), VIOLET), add_label(self._scene, name)
