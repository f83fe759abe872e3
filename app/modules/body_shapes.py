"""The shapes of a body that its actuator groups move, read from its model."""

from __future__ import annotations

from app.base.collision_shapes import load_collision_shapes
from app.base.kinematic_model import load_model
from app.base.moving_shapes import MovingShapes
from app.link import RobotDescription


def moving_shapes(body: RobotDescription) -> MovingShapes:
    """The collision shapes that the joints of the body's groups move. Reads files; raises ConfigError for a model that
    cannot be read, or has meshes for collision shapes."""
    joints = tuple(joint.name for group in body.groups.values() for joint in group.joints)
    return MovingShapes(load_model(body.model_path), load_collision_shapes(body.model_path), joints)
