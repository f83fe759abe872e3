"""The robot's body in the view: its URDF, articulated and half transparent.

viser's own helper gives a whole body one colour where it is to be transparent; this keeps each link's, and draws the
shapes of one colour on one link as one mesh.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import viser
import yourdfpy
from viser.transforms import SO3

OPACITY = 0.6
#: Joints that moved less (rad or m) are not sent.
LEAST_MOVE = 2e-3


class Body:
    """The body's model, read once; not for several threads. Raises ValueError or OSError for a model that cannot be."""

    def __init__(self, model: Path) -> None:
        self._urdf = yourdfpy.URDF.load(model, build_scene_graph=True, load_meshes=True)
        self._parents = {joint.child: joint.parent for joint in self._urdf.joint_map.values()}
        self._meshes = self._merged()

    def add_to(self, scene: viser.SceneApi, root: str) -> BodyNodes:
        """Draw the body below the node ``root`` of ``scene``."""
        frames = {
            joint.name: scene.add_frame(self._node(root, joint.child), show_axes=False)
            for joint in self._urdf.joint_map.values()
        }
        for number, (link, color, mesh) in enumerate(self._meshes):
            scene.add_mesh_simple(
                f"{self._node(root, link)}/shape_{number}",
                mesh.vertices,
                mesh.faces,
                color=color,
                opacity=OPACITY,
                cast_shadow=False,
                receive_shadow=False,
            )
        return BodyNodes(self._urdf, frames)

    def _node(self, root: str, link: str) -> str:
        """The scene node of a link: nested as the body is, so that moving one joint is one message."""
        chain = []
        while link in self._parents:
            chain.append(link)
            link = self._parents[link]
        return "/".join([root, *reversed(chain)])

    def _merged(self) -> list[tuple[str, tuple[int, int, int], trimesh.Trimesh]]:
        """The visual shapes by link and colour, in the link's frame."""
        groups: dict[tuple[str, tuple[int, int, int]], list[trimesh.Trimesh]] = {}
        scene = self._urdf.scene
        for name, geometry in scene.geometry.items():
            link = scene.graph.transforms.parents[name]
            mesh = geometry.copy()
            mesh.apply_transform(self._urdf.get_transform(name, link))
            red, green, blue = (int(value) for value in np.asarray(mesh.visual.main_color)[:3])
            groups.setdefault((link, (red, green, blue)), []).append(mesh)
        merged = []
        for (link, color), meshes in groups.items():
            mesh = trimesh.util.concatenate(meshes)
            assert isinstance(mesh, trimesh.Trimesh)
            merged.append((link, color, mesh))
        return merged


class BodyNodes:
    """One drawing of the body."""

    def __init__(self, urdf: Any, frames: dict[str, viser.FrameHandle]) -> None:
        self._urdf = urdf
        self._frames = frames
        self._positions: dict[str, float] = {}
        urdf.update_cfg(np.zeros(urdf.num_actuated_joints))
        self._place(frames)

    def move(self, positions: Mapping[str, float]) -> None:
        """Set joints to ``positions`` (rad, m) by name; those that did not move, or are not of this body, are left."""
        changed = {
            name: position
            for name, position in positions.items()
            if name in self._frames and abs(position - self._positions.get(name, 0.0)) > LEAST_MOVE
        }
        if changed:
            self._positions |= changed
            self._urdf.update_cfg(changed)
            self._place(changed)

    def _place(self, names: Mapping[str, Any]) -> None:
        for name in names:
            joint = self._urdf.joint_map[name]
            X_PC = self._urdf.get_transform(joint.child, joint.parent)
            self._frames[name].wxyz = SO3.from_matrix(X_PC[:3, :3]).wxyz
            self._frames[name].position = X_PC[:3, 3]
