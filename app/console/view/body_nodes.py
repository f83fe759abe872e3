"""The robot's body in the view: its model, articulated and half transparent.

viser's own helper gives a whole body one colour where it is to be transparent, and brings a mesh library with all of
its extras; this keeps each link's colour, and draws the shapes of one colour on one link as one mesh.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import trimesh
import viser

from app.base.geometry import Pose3
from app.base.kinematic_model import KinematicModel, load_model
from app.base.model_shapes import Color, merged, visual_shapes

OPACITY = 0.6
#: Joints that moved less (rad or m) are not sent.
LEAST_MOVE = 2e-3


class Body:
    """The body's model, read once; not for several threads. Raises ConfigError, ValueError or OSError."""

    def __init__(self, model: Path, eye: str = "") -> None:
        """``eye``: the link of the camera whose pictures people see."""
        self._model = load_model(model)
        self._eye = eye if eye in self._model.links else None
        self._joints = self._model.joints
        self._parents = {joint.child: joint.parent for joint in self._joints.values()}
        self._meshes = _merged(model)

    def add_to(self, scene: viser.SceneApi, root: str) -> BodyNodes:
        """Draw the body below the node ``root`` of ``scene``."""
        frames = {
            name: scene.add_frame(self._node(root, joint.child), show_axes=False)
            for name, joint in self._joints.items()
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
        return BodyNodes(self._model, frames)

    def eye(self, positions: Mapping[str, float]) -> Pose3 | None:
        """``X_BC`` of the camera with the joints at ``positions`` (rad, m) by name; None where there is none."""
        return None if self._eye is None else self._model.pose(self._eye, positions)

    def _node(self, root: str, link: str) -> str:
        """The scene node of a link: nested as the body is, so that moving one joint is one message."""
        chain = []
        while link in self._parents:
            chain.append(link)
            link = self._parents[link]
        return "/".join([root, *reversed(chain)])


def _merged(model: Path) -> list[tuple[str, Color, trimesh.Trimesh]]:
    """The visual shapes by link and colour, in the link's frame."""
    groups: dict[tuple[str, Color], list[trimesh.Trimesh]] = {}
    for shape in visual_shapes(model):
        groups.setdefault((shape.link, shape.color), []).append(shape.mesh)
    return [(link, color, merged(meshes)) for (link, color), meshes in groups.items()]


class BodyNodes:
    def __init__(self, model: KinematicModel, frames: dict[str, viser.FrameHandle]) -> None:
        self._model = model
        self._frames = frames
        self._positions: dict[str, float] = {}
        self._place(frames)

    def move(self, positions: Mapping[str, float]) -> bool:
        """Set joints to ``positions`` (rad, m) by name; those that did not move, or are not of this body, are left.

        Returns whether any moved.
        """
        changed = {
            name: position
            for name, position in positions.items()
            if name in self._frames and abs(position - self._positions.get(name, 0.0)) > LEAST_MOVE
        }
        self._positions |= changed
        self._place(
            name
            for name, joint in self._model.joints.items()
            if name in changed or (joint.mimic is not None and joint.mimic.joint in changed)
        )
        return bool(changed)

    def _place(self, names: Iterable[str]) -> None:
        for name in names:
            X_PC = self._model.joints[name].pose(self._model.position(name, self._positions))
            self._frames[name].wxyz = X_PC.quaternion_wxyz()
            self._frames[name].position = X_PC.translation
