"""The nodes of marks that come and go in the 3D view: places with nodes of their own, arrows with a text.

Names are fixed and nothing is removed, as everywhere in the scene; only what has changed is sent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

import numpy as np
import trimesh
import viser

from app.base.model_shapes import merged
from app.console.view.marks import Arrow, FaceFrame, assigned

MarkT = TypeVar("MarkT", Arrow, FaceFrame)
NodesT = TypeVar("NodesT")
#: The mesh of a mark, and its text.
MarkNodes = tuple[viser.MeshHandle, viser.LabelHandle]


def arrow_mesh() -> trimesh.Trimesh:
    """An arrow from the origin along x, 1 m long; made longer by scaling x."""
    shaft = trimesh.creation.cylinder(radius=0.03, segment=[(0, 0, 0), (0.8, 0, 0)], sections=10)
    head = trimesh.creation.cone(radius=0.085, height=0.2, sections=12)
    # Its axis z becomes x.
    head.apply_transform(np.array([[0, 0, 1, 0.8], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], np.float64))
    return merged([shaft, head])


class Marks(Generic[MarkT, NodesT]):
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


def add_mesh(scene: viser.SceneApi, name: str, mesh: trimesh.Trimesh, color: tuple[int, int, int]) -> viser.MeshHandle:
    return scene.add_mesh_simple(
        name,
        mesh.vertices,
        mesh.faces,
        color=color,
        opacity=0.9,
        side="double",
        cast_shadow=False,
        receive_shadow=False,
    )


def add_label(scene: viser.SceneApi, name: str) -> viser.LabelHandle:
    """The text of the mark ``name``."""
    # Not below its mesh: that is stretched.
    return scene.add_label(f"{name}_text", "", anchor="bottom-center", font_screen_scale=0.8)


def move_arrow(nodes: MarkNodes, before: Arrow | None, mark: Arrow) -> None:
    mesh, label = nodes
    place(mesh, before, mark)
    if before is None or before.length != mark.length:
        mesh.scale = (mark.length, 1.0, 1.0)
    if before is None or before.color != mark.color:
        mesh.color = mark.color
    if before is None or before.opacity != mark.opacity:
        mesh.opacity = mark.opacity
    if before is None or before.head != mark.head:
        label.position = np.array(mark.head)
    write(label, before, mark)


def place(mesh: viser.MeshHandle, before: MarkT | None, mark: MarkT) -> None:
    if before is None or before.position != mark.position:
        mesh.position = np.array(mark.position)
    if before is None or before.wxyz != mark.wxyz:
        mesh.wxyz = np.array(mark.wxyz)
    if before is None:
        mesh.visible = True


def write(label: viser.LabelHandle, before: MarkT | None, mark: MarkT) -> None:
    if before is None or before.text != mark.text:
        label.text = mark.text
    if before is None:
        label.visible = True


def hide(nodes: MarkNodes) -> None:
    for node in nodes:
        node.visible = False
