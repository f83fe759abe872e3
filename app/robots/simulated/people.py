"""The people's bodies in MuJoCo: one kinematic ("mocap") body a limb, posed from what the stage says.

Such bodies weigh nothing and follow no forces: physics only feels the upright cylinder around each person, which the
robot can bump into. The laser sees legs, cameras see everything.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from app.robots.simulated import figure, gait
from app.robots.simulated.actor import Actor
from app.robots.simulated.faces import FACES
from app.robots.simulated.gait import Joint
from app.robots.simulated.scenario_config import Color
from app.robots.simulated.world import OUT_OF_REACH_GROUP, ROBOT_CONTACT, WORLD_CONTACT, WORLD_GROUP

LIMBS = (
    "trunk", "head", "left_thigh", "left_shin", "left_upper_arm", "left_forearm",
    "right_thigh", "right_shin", "right_upper_arm", "right_forearm",
)  # fmt: skip
HIDDEN_GROUP = 4
"""Neither the cameras nor the laser look at it."""
TRUNK_RADIUS_SHARE = 0.13


@dataclass(frozen=True, slots=True)
class _Shape:
    limb: str
    mesh: figure.Mesh
    color: Color | None
    group: int = OUT_OF_REACH_GROUP


def add_people(spec: mujoco.MjSpec, actors: Sequence[Actor], seed: int) -> None:
    """Add the bodies of ``actors`` to the world's specification, posed as they are now."""
    for number, actor in enumerate(actors):
        _add(spec, actor, number, np.random.default_rng([seed, number]))


def _add(spec: mujoco.MjSpec, actor: Actor, number: int, rng: np.random.Generator) -> None:
    prefix = f"person{number}/"
    poses = limb_poses(actor)
    bodies = {
        limb: spec.worldbody.add_body(name=prefix + limb, mocap=True, pos=pose[:3], quat=pose[3:])
        for limb, pose in zip(LIMBS, poses, strict=True)
    }
    for index, shape in enumerate(_shapes(actor)):
        name = f"{prefix}{shape.limb}{index}"
        mesh = spec.add_mesh(
            name=name,
            uservert=(actor.height_m * shape.mesh.vertices).ravel(),
            userface=shape.mesh.faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        look: dict[str, object] = {"rgba": [*(c / 255 for c in shape.color), 1.0]} if shape.color else {}
        if shape.mesh.texture is not None:
            mesh.usertexcoord = shape.mesh.texture.ravel()
            _add_skin(spec, name, figure.head_texture(actor.config.face, rng))
            look["material"] = name
        bodies[shape.limb].add_geom(
            name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, group=shape.group,
            contype=0, conaffinity=0, mass=0.0, **look,
        )  # fmt: skip
    half = actor.height_m / 2
    bodies["trunk"].add_geom(
        name=prefix + "contact", type=mujoco.mjtGeom.mjGEOM_CYLINDER, group=HIDDEN_GROUP, mass=0.0,
        size=[TRUNK_RADIUS_SHARE * actor.height_m, 0.98 * half, 0.0], pos=[0, 0, half - gait.HIP_SHARE * 2 * half],
        contype=WORLD_CONTACT, conaffinity=ROBOT_CONTACT,
    )  # fmt: skip


def _add_skin(spec: mujoco.MjSpec, name: str, pixels: NDArray[np.uint8]) -> None:
    height, width, _ = pixels.shape
    image = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=3)
    image.data = np.ascontiguousarray(pixels).tobytes()
    material = spec.add_material(name=name, specular=0.05, shininess=0.2, emission=0.1)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


def _shapes(actor: Actor) -> list[_Shape]:
    look, wear = FACES[actor.config.face], actor.config
    shapes = [
        _Shape("trunk", figure.lathe(figure.TORSO, 16), wear.shirt),
        _Shape("trunk", figure.lathe(figure.HIPS, 14), wear.trousers),
        _Shape("head", figure.lathe(figure.NECK_RINGS), look.skin),
        _Shape("head", figure.head(wear.face), None),
    ]
    for side in ("left", "right"):
        shapes += [
            _Shape(f"{side}_thigh", figure.lathe(figure.THIGH_RINGS), wear.trousers, WORLD_GROUP),
            _Shape(f"{side}_shin", figure.lathe(figure.SHIN_RINGS), wear.trousers, WORLD_GROUP),
            _Shape(f"{side}_shin", figure.lathe(figure.SHOE_RINGS), wear.shoes),
            _Shape(f"{side}_upper_arm", figure.lathe(figure.UPPER_ARM_RINGS, 10), wear.shirt),
            _Shape(f"{side}_forearm", figure.lathe(figure.FOREARM_RINGS, 10), wear.shirt),
            _Shape(f"{side}_forearm", figure.lathe(figure.HAND_RINGS, 10), look.skin),
        ]
    return shapes


class People:
    """Poses the bodies of ``actors`` in a compiled model."""

    def __init__(self, model: mujoco.MjModel, actors: Sequence[Actor]) -> None:
        self._actors = tuple(actors)
        ids = [
            int(model.body_mocapid[model.body(f"person{number}/{limb}").id])
            for number in range(len(self._actors))
            for limb in LIMBS
        ]
        self._ids = np.array(ids, dtype=np.intp).reshape(len(self._actors), len(LIMBS))

    def pose(self, data: mujoco.MjData) -> None:
        """Put every limb where the actors are now; physics takes it up with its next step."""
        for ids, actor in zip(self._ids, self._actors, strict=True):
            poses = limb_poses(actor)
            data.mocap_pos[ids] = poses[:, :3]
            data.mocap_quat[ids] = poses[:, 3:]


def limb_poses(actor: Actor) -> NDArray[np.float64]:
    """Poses of ``LIMBS`` in the world (10, 7): place of the upper joint (m) and quaternion (w, x, y, z)."""
    return _placed(gait.joints(actor.posture), actor)


def _placed(frames: dict[str, Joint], actor: Actor) -> NDArray[np.float64]:
    poses = np.empty((len(LIMBS), 7))
    c, s = math.cos(actor.heading), math.sin(actor.heading)
    for row, limb in zip(poses, LIMBS, strict=True):
        frame = frames[limb]
        x, y, z = (actor.height_m * v for v in frame.at)
        half_yaw, half_pitch = (actor.heading + frame.yaw) / 2, frame.pitch / 2
        cy, sy, cp, sp = math.cos(half_yaw), math.sin(half_yaw), math.cos(half_pitch), math.sin(half_pitch)
        row[:] = (actor.x + c * x - s * y, actor.y + s * x + c * y, z, cy * cp, -sy * sp, cy * sp, sy * cp)
    return poses
