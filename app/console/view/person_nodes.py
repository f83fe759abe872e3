"""The nodes of what is perceived of people: sound arrows, framed faces, a flash for a loud noise.

Names are fixed and nothing is removed, as everywhere in the scene; only what has changed is sent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

import numpy as np
import trimesh
import viser

from app.console.view.marks import (
    MOST_ARROWS,
    MOST_FACES,
    Arrow,
    FaceFrame,
    Flash,
    arrow_marks,
    assigned,
    face_marks,
    flash_mark,
)
from app.console.view.shapes import merged
from app.messages import PlacedPercepts

_FACE_COLOR = (70, 225, 140)
_FLASH_COLOR = (255, 214, 90)
_FACE_M = (0.30, 0.36)
_BAR_M = 0.035
_RING_M = (0.55, 0.68)

MarkT = TypeVar("MarkT", Arrow, FaceFrame)
NodesT = TypeVar("NodesT")


def arrow_mesh() -> trimesh.Trimesh:
    """An arrow from the origin along x, 1 m long; made longer by scaling x."""
    shaft = trimesh.creation.cylinder(radius=0.03, segment=[(0, 0, 0), (0.8, 0, 0)], sections=10)
    head = trimesh.creation.cone(radius=0.085, height=0.2, sections=12)
    # Its axis z becomes x.
    head.apply_transform(np.array([[0, 0, 1, 0.8], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], np.float64))
    return merged([shaft, head])


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


class _Marks(Generic[MarkT, NodesT]):
    """A fixed number of places, each with nodes of its own, made when first needed, for marks that come and go."""

    def __init__(
        self,
        places: int,
        add: Callable[[int], NodesT],
        move: Callable[[NodesT, MarkT | None, MarkT], None],
        hide: Callable[[NodesT], None],
    ) -> None:
        self._places = places
        self._add = add
        self._move: Callable[[NodesT, MarkT | None, MarkT], None] = move
        self._hide = hide
        self._nodes: dict[int, NodesT] = {}
        #: The percept at each place; None while it is hidden.
        self._shown: dict[int, MarkT | None] = {}
        self._assigned: dict[int, int] = {}

    def draw(self, marks: Mapping[int, MarkT]) -> int:
        """Show ``marks`` by track and hide all else; returns how many changed."""
        self._assigned = assigned(self._assigned, marks.keys(), self._places)
        changed = 0
        for track, mark in marks.items():
            place = self._assigned[track]
            before = self._shown.get(place)
            if mark == before:
                continue
            if place not in self._nodes:
                self._nodes[place] = self._add(place)
            self._move(self._nodes[place], before, mark)
            self._shown[place] = mark
            changed += 1
        for place in self._nodes.keys() - self._assigned.values():
            if self._shown[place] is not None:
                self._hide(self._nodes[place])
                self._shown[place] = None
                changed += 1
        return changed


class People:
    """People as perceived, drawn on ``client`` below the node ``world``; the flash is around the robot."""

    def __init__(self, client: viser.ClientHandle, world: str) -> None:
        self._scene = client.scene
        self._world = world
        self._arrows: _Marks[Arrow, tuple[viser.MeshHandle, viser.LabelHandle]] = _Marks(
            MOST_ARROWS, self._add_arrow, _move_arrow, _hide
        )
        self._faces: _Marks[FaceFrame, tuple[viser.MeshHandle, viser.LabelHandle]] = _Marks(
            MOST_FACES, self._add_face, _move_face, _hide
        )
        self._ring: viser.MeshHandle | None = None
        self._flash: Flash | None = None

    def draw(self, perceived: PlacedPercepts) -> int:
        """Bring it up to what is perceived; returns how many marks changed."""
        return (
            self._arrows.draw(arrow_marks(perceived))
            + self._faces.draw(face_marks(perceived))
            + self._draw_flash(flash_mark(perceived))
        )

    def _add_arrow(self, place: int) -> tuple[viser.MeshHandle, viser.LabelHandle]:
        return self._mesh(f"{self._world}/sound_{place}", arrow_mesh(), (255, 0, 0)), self._label(f"sound_{place}")

    def _add_face(self, place: int) -> tuple[viser.MeshHandle, viser.LabelHandle]:
        return self._mesh(f"{self._world}/face_{place}", frame_mesh(), _FACE_COLOR), self._label(f"face_{place}")

    def _mesh(self, name: str, mesh: trimesh.Trimesh, color: tuple[int, int, int]) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            name,
            mesh.vertices,
            mesh.faces,
            color=color,
            opacity=0.9,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _label(self, name: str) -> viser.LabelHandle:
        # Not below its mesh: that is stretched.
        return self._scene.add_label(f"{self._world}/{name}_text", "", anchor="bottom-center", font_screen_scale=0.8)

    def _draw_flash(self, flash: Flash | None) -> int:
        before, self._flash = self._flash, flash
        if flash == before:
            return 0
        if flash is None:
            assert self._ring is not None
            self._ring.visible = False
            return 1
        if self._ring is None:
            self._ring = self._mesh("/noise", ring_mesh(), _FLASH_COLOR)
        self._ring.scale = (flash.scale, flash.scale, 1.0)
        self._ring.opacity = flash.opacity
        if before is None:
            self._ring.visible = True
        return 1


def _move_arrow(nodes: tuple[viser.MeshHandle, viser.LabelHandle], before: Arrow | None, mark: Arrow) -> None:
    mesh, label = nodes
    _place(mesh, before, mark)
    if before is None or before.length != mark.length:
        mesh.scale = (mark.length, 1.0, 1.0)
    if before is None or before.color != mark.color:
        mesh.color = mark.color
    if before is None or before.opacity != mark.opacity:
        mesh.opacity = mark.opacity
    if before is None or before.head != mark.head:
        label.position = np.array(mark.head)
    _write(label, before, mark)


def _move_face(nodes: tuple[viser.MeshHandle, viser.LabelHandle], before: FaceFrame | None, mark: FaceFrame) -> None:
    mesh, label = nodes
    _place(mesh, before, mark)
    if before is None or before.position != mark.position:
        x, y, z = mark.position
        label.position = np.array((x, y, z + _FACE_M[1] / 2 + 0.05))
    _write(label, before, mark)


def _place(mesh: viser.MeshHandle, before: MarkT | None, mark: MarkT) -> None:
    if before is None or before.position != mark.position:
        mesh.position = np.array(mark.position)
    if before is None or before.wxyz != mark.wxyz:
        mesh.wxyz = np.array(mark.wxyz)
    if before is None:
        mesh.visible = True


def _write(label: viser.LabelHandle, before: MarkT | None, mark: MarkT) -> None:
    if before is None or before.text != mark.text:
        label.text = mark.text
    if before is None:
        label.visible = True


def _hide(nodes: tuple[viser.MeshHandle, viser.LabelHandle]) -> None:
    for node in nodes:
        node.visible = False
