"""The people's bodies in MuJoCo: one kinematic ("mocap") body per limb, posed by the scenario's state.

Such bodies have no mass and follow no forces: only the upright cylinder around each person has contacts, so that the
robot can touch it. The laser sees legs, cameras see everything.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from app.robots.simulated.scenery import gait, person_mesh
from app.robots.simulated.scenery.actor import Actor
from app.robots.simulated.scenery.gait import LimbJoint
from app.robots.simulated.scenery.textures import Texture
from app.robots.simulated.world import CAMERA_GROUP, ROBOT_CONTACT, WORLD_CONTACT
from app.robots.simulated.world_config import Color

LIMBS = (
    "trunk", "head", "left_thigh", "left_shin", "left_upper_arm", "left_forearm",
    "right_thigh", "right_shin", "right_upper_arm", "right_forearm",
)  # fmt: skip
LASER_GROUP, CONTACT_GROUP = 4, 3
"""Seen by the laser alone (plain shapes in the legs: a ray is tested against them sooner than against a mesh), and by
nothing at all.
"""
TRUNK_RADIUS_SHARE, LEG_RADIUS_SHARE = 0.13, 0.032


def add_people(spec: mujoco.MjSpec, actors: Sequence[Actor], seed: int, *, textured: bool = True) -> None:
    """Add the bodies of ``actors`` to the world's specification, posed as they are now. ``textured``: with their faces
    and clothes, which cameras alone can see."""
    for number, actor in enumerate(actors):
        _add(spec, actor, number, np.random.default_rng([seed, number]) if textured else None)


def _add(spec: mujoco.MjSpec, actor: Actor, number: int, rng: np.random.Generator | None) -> None:
    prefix, height, wear = f"person{number}/", actor.height_m, actor.config
    material = spec.add_material(name=prefix + "skin", specular=0.05, shininess=0.2, emission=0.1)
    if rng is not None:
        clothes: dict[person_mesh.PaletteColor, Color] = {
            "shirt": wear.shirt, "trousers": wear.trousers, "shoes": wear.shoes,
        }  # fmt: skip
        _paint(spec, material, person_mesh.skin(wear.face, clothes, rng))
    meshes = _meshes(wear.face)
    for limb, pose in zip(LIMBS, limb_poses(actor), strict=True):
        name, mesh = prefix + limb, meshes[limb]
        body = spec.worldbody.add_body(name=name, mocap=True, pos=pose[:3], quat=pose[3:])
        spec.add_mesh(
            name=name, uservert=(height * mesh.vertices).ravel(), userface=mesh.faces.ravel(),
            usertexcoord=mesh.texture.ravel(), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )  # fmt: skip
        body.add_geom(
            name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, material=prefix + "skin",
            group=CAMERA_GROUP, contype=0, conaffinity=0, mass=0.0,
        )  # fmt: skip
        if limb.endswith("shin"):
            half = gait.SHIN * height / 2
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[LEG_RADIUS_SHARE * height, half, 0.0], pos=[0.0, 0.0, -half],
                group=LASER_GROUP, contype=0, conaffinity=0, mass=0.0,
            )  # fmt: skip
        if limb == "trunk":
            half = 0.49 * height
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[TRUNK_RADIUS_SHARE * height, half, 0.0],
                pos=[0.0, 0.0, half - gait.HIP_SHARE * height], group=CONTACT_GROUP, mass=0.0,
                contype=WORLD_CONTACT, conaffinity=ROBOT_CONTACT,
            )  # fmt: skip


def _paint(spec: mujoco.MjSpec, material: mujoco.MjsMaterial, pixels: Texture) -> None:
    height, width, _ = pixels.shape
    name = material.name
    image = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=3)
    image.data = np.ascontiguousarray(pixels).tobytes()
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


def _meshes(face: str) -> dict[str, person_mesh.Mesh]:
    shin = person_mesh.joined(
        person_mesh.lathe(person_mesh.SHIN_RINGS, "trousers"), person_mesh.lathe(person_mesh.SHOE_RINGS, "shoes")
    )
    forearm = person_mesh.joined(
        person_mesh.lathe(person_mesh.FOREARM_RINGS, "shirt"), person_mesh.lathe(person_mesh.HAND_RINGS, "skin", 6)
    )
    trunk = person_mesh.joined(
        person_mesh.lathe(person_mesh.TORSO, "shirt", 12), person_mesh.lathe(person_mesh.HIPS, "trousers", 12)
    )
    return {
        "trunk": trunk,
        "head": person_mesh.joined(person_mesh.lathe(person_mesh.NECK_RINGS, "skin"), person_mesh.head(face)),
        **dict.fromkeys(("left_thigh", "right_thigh"), person_mesh.lathe(person_mesh.THIGH_RINGS, "trousers", 10)),
        **dict.fromkeys(("left_upper_arm", "right_upper_arm"), person_mesh.lathe(person_mesh.UPPER_ARM_RINGS, "shirt")),
        **dict.fromkeys(("left_shin", "right_shin"), shin),
        **dict.fromkeys(("left_forearm", "right_forearm"), forearm),
    }


class PersonBodies:
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
        """Set every limb to the actors' current pose, effective with the next step of the physics."""
        for ids, actor in zip(self._ids, self._actors, strict=True):
            poses = limb_poses(actor)
            data.mocap_pos[ids] = poses[:, :3]
            data.mocap_quat[ids] = poses[:, 3:]


def limb_poses(actor: Actor) -> NDArray[np.float64]:
    """Poses of ``LIMBS`` in the world (10, 7): place of the upper joint (m) and quaternion (w, x, y, z)."""
    return _placed(gait.joints(actor.posture), actor)


def _placed(frames: dict[str, LimbJoint], actor: Actor) -> NDArray[np.float64]:
    c, s, height = math.cos(actor.heading), math.sin(actor.heading), actor.height_m
    poses = []
    for limb in LIMBS:
        frame = frames[limb]
        x, y, z = frame.at
        x, y, z = height * x, height * y, height * z
        half_yaw, half_pitch = (actor.heading + frame.yaw) / 2, frame.pitch / 2
        cy, sy, cp, sp = math.cos(half_yaw), math.sin(half_yaw), math.cos(half_pitch), math.sin(half_pitch)
        poses.append((actor.x + c * x - s * y, actor.y + s * x + c * y, z, cy * cp, -sy * sp, cy * sp, sy * cp))
    return np.array(poses)
