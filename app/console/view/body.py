"""The robot's body in the view: its URDF, articulated and half transparent.

viser's own helper gives a whole body one colour where it is to be transparent; this keeps each link's, and draws the
shapes of one colour on one link as one mesh.
"""

from __future__ import annotations

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
    """The articulated body below the scene node ``root``; not for several threads."""

    def __init__(self, scene: viser.SceneApi, model: Path, root: str) -> None:
        self._urdf = yourdfpy.URDF.load(model, build_scene_graph=True, load_meshes=True)
        self._root = root
        self._positions: dict[str, float] = {}
        self._frames = {
            joint.name: scene.add_frame(self._node(joint.child), show_axes=False)
            for joint in self._urdf.joint_map.values()
        }
        for joint in self._urdf.joint_map.values():
            self._place(joint)
        for number, (link, color, mesh) in enumerate(self._meshes()):
            scene.add_mesh_simple(
                f"{self._node(link)}/shape_{number}",
                mesh.vertices,
                mesh.faces,
                color=color,
                opacity=OPACITY,
                flat_shading=False,
                cast_shadow=False,
                receive_shadow=False,
            )

    def move(self, positions: dict[str, float]) -> None:
        """Set joints to ``positions`` (rad, m) by name; those that did not move, or are not of this body, are left."""
        changed = {
            name: position
            for name, position in positions.items()
            if name in self._frames and abs(position - self._positions.get(name, 0.0)) > LEAST_MOVE
        }
        if not changed:
            return
        self._positions |= changed
        self._urdf.update_cfg(changed)
        for name in changed:
            self._place(self._urdf.joint_map[name])

    def _place(self, joint: Any) -> None:
        X_PC = self._urdf.get_transform(joint.child, joint.parent)
        frame = self._frames[joint.name]
        frame.wxyz = SO3.from_matrix(X_PC[:3, :3]).wxyz
        frame.position = X_PC[:3, 3]

    def _node(self, link: str) -> str:
        """The scene node of a link: nested as the body is, so that moving one joint is one message."""
        chain = []
        parents = {joint.child: joint.parent for joint in self._urdf.joint_map.values()}
        while link in parents:
            chain.append(link)
            link = parents[link]
        return "/".join([self._root, *reversed(chain)])

    def _meshes(self) -> list[tuple[str, tuple[int, int, int], trimesh.Trimesh]]:
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
