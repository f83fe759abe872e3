"""The nodes of what is perceived of people: sound arrows, framed faces, a flash for a loud noise.

Names are fixed and nothing is removed, as everywhere in the scene; only what has changed is sent.
"""

from __future__ import annotations

import numpy as np
import trimesh
import viser

from app.base.model_shapes import merged
from app.console.view.mark_nodes import (
    MarkNodes,
    Marks,
    add_label,
    add_mesh,
    arrow_mesh,
    hide,
    move_arrow,
    place,
    write,
)
from app.console.view.marks import (
    MOST_ARROWS,
    MOST_FACES,
    Arrow,
    FaceFrame,
    Flash,
    arrow_marks,
    face_marks,
    flash_mark,
)
from app.messages import PlacedPercepts

_FACE_COLOR = (70, 225, 140)
_FLASH_COLOR = (255, 214, 90)
_FACE_M = (0.30, 0.36)
_BAR_M = 0.035
_RING_M = (0.55, 0.68)


def frame_mesh() -> trimesh.Trimesh:
    """A frame of four bars in the plane of y and z, around the origin."""
    width, height = _FACE_M
    bars = []
    for side in (-1, 1):
        upright = trimesh.creation.box((_BAR_M, _BAR_M, height + _BAR_M))
        upright.apply_translation((0, side * width / 2, 0))
        across = trimesh.creation.box((_BAR_M, width + _BAR_M, _BAR_M))
        across.apply_translation((0, 0, side * height / 2))
        bars += [upright, across]
    return merged(bars)


def ring_mesh() -> trimesh.Trimesh:
    """A flat ring around the origin, just over the floor."""
    ring = trimesh.creation.annulus(r_min=_RING_M[0], r_max=_RING_M[1], height=0.01, sections=40)
    ring.apply_translation((0, 0, 0.03))
    return merged([ring])


class People:
    """People as perceived, drawn on ``client`` below the node ``world``; the flash is around the robot."""

    def __init__(self, client: viser.ClientHandle, world: str) -> None:
        self._scene = client.scene
        self._world = world
        self._arrows: Marks[Arrow, MarkNodes] = Marks(MOST_ARROWS, self._add_arrow, move_arrow, hide)
        self._faces: Marks[FaceFrame, MarkNodes] = Marks(MOST_FACES, self._add_face, _move_face, hide)
        self._ring: viser.MeshHandle | None = None
        self._flash: Flash | None = None

    def draw(self, perceived: PlacedPercepts) -> int:
        """Bring it up to what is perceived; returns how many marks changed."""
        return (
            self._arrows.draw(arrow_marks(perceived))
            + self._faces.draw(face_marks(perceived))
            + self._draw_flash(flash_mark(perceived))
        )

    def _add_arrow(self, number: int) -> MarkNodes:
        name = f"{self._world}/sound_{number}"
        return add_mesh(self._scene, name, arrow_mesh(), (255, 0, 0)), add_label(self._scene, name)

    def _add_face(self, number: int) -> MarkNodes:
        name = f"{self._world}/face_{number}"
        return add_mesh(self._scene, name, frame_mesh(), _FACE_COLOR), add_label(self._scene, name)

    def _draw_flash(self, flash: Flash | None) -> int:
        before, self._flash = self._flash, flash
        if flash == before:
            return 0
        if flash is None:
            assert self._ring is not None
            self._ring.visible = False
            return 1
        if self._ring is None:
            self._ring = add_mesh(self._scene, "/noise", ring_mesh(), _FLASH_COLOR)
        self._ring.scale = (flash.scale, flash.scale, 1.0)
        self._ring.opacity = flash.opacity
        if before is None:
            self._ring.visible = True
        return 1


def _move_face(nodes: MarkNodes, before: FaceFrame | None, mark: FaceFrame) -> None:
    mesh, label = nodes
    place(mesh, before, mark)
    if before is None or before.position != mark.position:
        x, y, z = mark.position
        label.position = np.array((x, y, z + _FACE_M[1] / 2 + 0.05))
    write(label, before, mark)
