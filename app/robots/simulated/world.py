"""The world's builder: a pure function from a WorldConfig to a MuJoCo specification.

Walls are boxes whose local z is the wall's normal, because MuJoCo lays a flat texture along a box's local x and y.
Everything of the world is geometry group 0, or 2 where only cameras see it; contacts are between robot and world alone.
"""

from __future__ import annotations

import math
import zlib
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.simulated.scenery.furniture import Part, Vector, furnish
from app.robots.simulated.scenery.textures import Texture, poster_page, texture
from app.robots.simulated.world_config import (
    CODE_RISE_M,
    LETTER_HEIGHT_M,
    LETTER_WIDTH_M,
    CylindersConfig,
    DoorConfig,
    ObjectConfig,
    PosterConfig,
    WallConfig,
    WorldConfig,
)

WORLD_GROUP, CAMERA_GROUP = 0, 2
WORLD_CONTACT, ROBOT_CONTACT = 2, 1
_LOOSE_CONTACT = WORLD_CONTACT | ROBOT_CONTACT
TIMESTEP_S = 0.002
#: Contact of a loose thing: between two fingers it does not turn (condim 4), nor creep out of them (solimp).
_GRASPABLE = {"priority": 1, "condim": 4, "friction": [1.0, 0.02, 0.0001], "solimp": [0.999, 0.9999, 0.001, 0.5, 2.0]}
_SHAPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "ellipsoid": mujoco.mjtGeom.mjGEOM_ELLIPSOID,
}
_BASEBOARD: Vector = (0.33, 0.31, 0.30)
_FRAME: Vector = (0.40, 0.27, 0.17)
_LEAF = "door"


def build_world(config: WorldConfig, *, textured: bool = True) -> mujoco.MjSpec:
    """The world without a robot. The same configuration gives the same world. ``textured``: with what is painted on its
    surfaces, which a camera alone sees, and which is most of the time that building takes."""
    spec = mujoco.MjSpec()
    spec.modelname = config.name
    spec.option.timestep = TIMESTEP_S
    # Not an implicit integrator: it damps the drives after solving the contacts, so that the wheels would slip
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.visual.quality.offsamples = 0
    spec.visual.quality.shadowsize = 0
    spec.visual.quality.numquads = 1  # lights are directional: finer faces would look the same
    spec.visual.quality.numslices = 16
    spec.visual.quality.numstacks = 8
    spec.visual.map.znear = 0.05
    spec.visual.map.zfar = 60.0
    spec.stat.extent = 1.0  # so that znear and zfar are metres
    spec.visual.headlight.ambient = [config.ambient] * 3
    spec.visual.headlight.diffuse = [0.12] * 3
    spec.visual.headlight.specular = [0.0] * 3
    for light in config.lights:
        spec.worldbody.add_light(
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            dir=light.direction,
            diffuse=[light.strength] * 3,
            specular=[0.15 * light.strength] * 3,
            castshadow=False,
        )
    _Builder(spec, config, textured).build()
    return spec


class _Builder:
    def __init__(self, spec: mujoco.MjSpec, config: WorldConfig, textured: bool) -> None:
        self._spec = spec
        self._config = config
        self._textured = textured

    def build(self) -> None:
        self._materials()
        # Front shapes first, since shapes are drawn in this order: a hidden pixel costs a third
        for number, item in enumerate(self._config.objects):
            self._object(number, item)
        for number, cylinders in enumerate(self._config.cylinders):
            self._cylinders(number, cylinders)
        for number, poster in enumerate(self._config.posters):
            self._poster(number, poster)
        for wall in self._config.walls:
            self._wall(wall)
        self._floors()

    def _materials(self) -> None:
        for name, material in self._config.materials.items():
            if self._textured:
                # zlib.crc32, because hash() of a string differs from process to process
                self._add_texture(name, texture(material, self._config.seed ^ zlib.crc32(name.encode())))
            repeat = [1 / material.tile_m[0], 1 / material.tile_m[1]] if material.tile_m else [1.0, 1.0]
            self._add_material(name, repeat, material.tile_m is not None, material.shine, material.glow)

    def _add_texture(self, name: str, pixels: Texture) -> None:
        height, width, _ = pixels.shape
        image = self._spec.add_texture(
            name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=3
        )
        image.data = np.ascontiguousarray(pixels).tobytes()

    def _add_material(
        self, name: str, repeat: list[float], uniform: bool, shine: float = 0.0, glow: float = 0.0
    ) -> None:
        material = self._spec.add_material(
            name=name, texrepeat=repeat, texuniform=uniform, specular=shine, shininess=0.3, emission=glow
        )
        if self._textured:
            material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name

    def _geom(
        self, part: Part, X_WP: Pose3, name: str = "", *, body: mujoco.MjsBody | None = None, mass_kg: float = 0.0
    ) -> None:
        """Add ``part``, of a piece at ``X_WP``: to the building, or with ``mass_kg`` to a loose ``body`` there."""
        half = [s / 2 for s in part.size]
        size = [half[0], half[2], 0.0] if part.shape == "cylinder" else half
        X_PG = Pose3.from_translation_rpy(part.at, part.rpy)
        X_WG = X_WP @ X_PG if body is None else X_PG
        look: dict[str, Any] = (
            {"material": part.material} if isinstance(part.material, str) else {"rgba": [*part.material, 1.0]}
        )
        if body is not None:
            look |= {"mass": mass_kg} | _GRASPABLE
        solid = (WORLD_CONTACT, ROBOT_CONTACT) if body is None else (_LOOSE_CONTACT, _LOOSE_CONTACT)
        (body or self._spec.worldbody).add_geom(
            name=name,
            type=_SHAPES[part.shape],
            size=size,
            pos=X_WG.translation,
            quat=X_WG.quaternion_wxyz(),
            group=WORLD_GROUP,
            contype=solid[0] if part.solid else 0,
            conaffinity=solid[1] if part.solid else 0,
            **look,
        )

    def _floors(self) -> None:
        width, depth = self._config.size
        middle = [width / 2, depth / 2, 0.0]
        half = [width / 2, depth / 2, 1.0]
        self._spec.worldbody.add_geom(
            name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=half, pos=middle, material=self._config.floor,
            group=WORLD_GROUP, contype=WORLD_CONTACT, conaffinity=ROBOT_CONTACT, friction=[0.9, 0.005, 0.0001],
        )  # fmt: skip
        if self._config.ceiling:
            self._spec.worldbody.add_geom(
                name="ceiling", type=mujoco.mjtGeom.mjGEOM_PLANE, size=half, quat=[0.0, 1.0, 0.0, 0.0],
                pos=[width / 2, depth / 2, self._config.wall_height], material=self._config.ceiling,
                group=WORLD_GROUP, contype=0, conaffinity=0,
            )  # fmt: skip
        for number, area in enumerate(self._config.areas):
            (x0, y0), (x1, y1) = area.start, area.end
            self._spec.worldbody.add_geom(  # a millimetre above the floor, and without contact: a look, not a step
                name=f"area{number}", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[abs(x1 - x0) / 2, abs(y1 - y0) / 2, 1.0],
                pos=[(x0 + x1) / 2, (y0 + y1) / 2, 0.001 + 0.0005 * number], material=area.material,
                group=WORLD_GROUP, contype=0, conaffinity=0,
            )  # fmt: skip

    def _wall(self, wall: WallConfig) -> None:
        (x0, y0), (x1, y1) = wall.start, wall.end
        X_WS = Pose3.from_translation_rpy((x0, y0, 0.0), (0.0, 0.0, math.atan2(y1 - y0, x1 - x0)))
        height, thick = self._config.wall_height, wall.thickness
        cut = 0.0
        for door in sorted(wall.doors, key=lambda d: d.at):
            self._wall_piece(wall, X_WS, cut, door.at - door.width / 2)
            cut = door.at + door.width / 2
            lintel = height - door.height
            self._geom(
                Part("box", (door.at, 0, height - lintel / 2), (door.width, lintel, thick), wall.material, _UPRIGHT),
                X_WS,
            )
            self._door(wall, door, X_WS)
        self._wall_piece(wall, X_WS, cut, wall.length_m)

    def _wall_piece(self, wall: WallConfig, X_WS: Pose3, start: float, end: float) -> None:
        if end - start < 1e-6:
            return
        height, thick, middle = self._config.wall_height, wall.thickness, (start + end) / 2
        size = (end - start, height, thick)
        self._geom(Part("box", (middle, 0, height / 2), size, wall.material, _UPRIGHT), X_WS)
        board = (end - start, thick + 0.024, 0.09)
        self._geom(Part("box", (middle, 0, 0.045), board, _BASEBOARD, solid=False), X_WS)

    def _door(self, wall: WallConfig, door: DoorConfig, X_WS: Pose3) -> None:
        deep, post = wall.thickness + 0.03, 0.05
        for side in (-1, 1):
            at = (door.at + side * (door.width / 2 - post / 2), 0.0, door.height / 2)
            self._geom(Part("box", at, (post, deep, door.height), _FRAME), X_WS)
        self._geom(Part("box", (door.at, 0, door.height - post / 2), (door.width, deep, post), _FRAME), X_WS)
        if door.leaf_deg is None:
            return
        far = door.hinge == "far"
        hinge = (door.at + (door.width / 2 - post) * (1 if far else -1), 0.0, 0.0)
        turn = math.radians(door.leaf_deg) * (-1 if far else 1) + (math.pi if far else 0.0)
        X_WH = X_WS @ Pose3.from_translation_rpy(hinge, (0.0, 0.0, turn))
        leaf = door.width - 2 * post
        size = (leaf, door.height - post - 0.01, 0.04)
        material: str | Vector = _LEAF if _LEAF in self._config.materials else _FRAME
        self._geom(Part("box", (leaf / 2, 0, door.height / 2 - 0.02), size, material, _UPRIGHT), X_WH)
        for side in (-1, 1):
            self._geom(Part("box", (leaf - 0.09, side * 0.05, 1.03), (0.12, 0.02, 0.02), (0.6, 0.6, 0.62)), X_WH)

    def _object(self, number: int, item: ObjectConfig) -> None:
        X_WP = Pose3.from_translation_rpy((*item.at, item.z), (0.0, 0.0, math.radians(item.yaw_deg)))
        rng = np.random.default_rng([self._config.seed, number])
        materials = frozenset(self._config.materials)
        parts = furnish(item.kind, item.size, item.material, rng, materials)
        body, share_kg = None, 0.0
        if item.mass_kg is not None:
            body = self._spec.worldbody.add_body(
                name=f"{item.kind}{number}", pos=X_WP.translation, quat=X_WP.quaternion_wxyz()
            )
            body.add_freejoint()
            share_kg = item.mass_kg / len(parts)
        for index, part in enumerate(parts):
            if isinstance(part.material, str) and part.material not in materials:
                part = Part(
                    part.shape, part.at, size=part.size, material=(0.5, 0.5, 0.5), rpy=part.rpy, solid=part.solid
                )
            self._geom(part, X_WP, name=f"{item.kind}{number}.{index}", body=body, mass_kg=share_kg)

    def _cylinders(self, number: int, cylinders: CylindersConfig) -> None:
        size, middle = (2 * cylinders.radius, 2 * cylinders.radius, cylinders.height), cylinders.height / 2
        for index, (x, y) in enumerate(cylinders.at):
            part = Part("cylinder", (x, y, middle), size, cylinders.material)
            self._geom(part, Pose3.identity(), name=f"cylinder{number}.{index}")

    def _poster(self, number: int, poster: PosterConfig) -> None:
        name = f"poster{number}"
        if self._textured:
            self._add_texture(name, poster_page(poster.text, poster.title))
        self._add_material(name, [1.0, 1.0], uniform=False)
        page = Part("box", (0, 0, 0), (LETTER_WIDTH_M, LETTER_HEIGHT_M, 0.001), name, solid=False)
        self._geom(page, X_WP_of_page(poster), name=name)


_UPRIGHT: Vector = (math.pi / 2, 0.0, 0.0)
"""Turns a box so that its y points up and its z along -y of its parent frame."""


def X_WP_of_page(poster: PosterConfig) -> Pose3:
    """Pose of a poster's page in the world: x to the reader's right, y up, z out of the wall."""
    yaw = math.radians(poster.facing_deg)
    right: NDArray[np.float64] = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    out = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    rotation = np.column_stack([right, up, out])
    middle = np.array([*poster.at, poster.height - CODE_RISE_M]) + 0.001 * out
    return Pose3(rotation, middle)
