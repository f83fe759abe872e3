"""Images of faces at known places, as a Kinect and a panoramic camera would see them: for tests and measurements.

A face is a flat card with a photograph of the simulated people (public domain, sources in
``app/robots/simulated/scenery/faces``), hung where it is wanted and turned as it is wanted, before a grey gradient.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3
from app.messages import Image, read_only
from app.robots.simulated.scenery.faces import EYES_PX, FACES, MIDDLE_PX, MOUTH_PX, face_picture

#: Kinect: 57 x 43 degrees at 640 x 480 (f = 589 px).
KINECT = CameraModel(640, 480, 589.0, 589.0, 319.5, 239.5)
PANORAMA = FisheyeModel.from_fov(1024, 768, math.pi, math.pi)
_FORWARD = (-math.pi / 2, 0.0, -math.pi / 2)
X_BKINECT = Pose3.from_translation_rpy((0.1, 0.0, 1.3), _FORWARD)
X_BPANORAMA = Pose3.from_translation_rpy((0.1, 0.0, 0.89), _FORWARD)
NAMES = tuple(FACES)
#: From the eyes to the mouth (m) of a person of mean height.
EYES_TO_MOUTH_M = 0.040 * 1.71
_FINE = 3


@dataclass(frozen=True, slots=True)
class FaceCard:
    """A face whose middle is at ``place`` (m, odom), looking along ``heading`` (rad, in the horizontal plane)."""

    name: str
    place: tuple[float, float, float]
    heading: float


def facing(name: str, place: tuple[float, float, float], towards: tuple[float, float] = (0.0, 0.0)) -> FaceCard:
    """A face at ``place`` that looks towards a point of the floor."""
    return FaceCard(name, place, math.atan2(towards[1] - place[1], towards[0] - place[0]))


def kinect_image(stamp: float, X_OB: Pose2, cards: Sequence[FaceCard], seed: int = 0) -> Image:
    """Colour and depth, a wall 4.5 m ahead; what is under 0.4 m or over 5 m away has no depth."""
    color = _background(KINECT.width, KINECT.height)
    depth = np.full((KINECT.height, KINECT.width), 4.5)
    _draw(color, depth, KINECT, X_OB.to_pose3() @ X_BKINECT, cards)
    rng = np.random.default_rng(seed)
    noisy = depth + rng.normal(0, 1, depth.shape) * (0.0012 + 0.0019 * (depth - 0.4) ** 2)
    millimetres = np.where((depth < 0.4) | (depth > 5.0), 0, np.round(1000 * noisy)).astype(np.uint16)
    return Image(stamp, "kinect", _noisy(color, rng), read_only(millimetres), KINECT, X_BKINECT)


def panorama_image(stamp: float, X_OB: Pose2, cards: Sequence[FaceCard], seed: int = 0) -> Image:
    """The hemisphere ahead, without depth."""
    color = _background(PANORAMA.width, PANORAMA.height)
    _draw(color, None, PANORAMA, X_OB.to_pose3() @ X_BPANORAMA, cards)
    return Image(stamp, "panorama", _noisy(color, np.random.default_rng(seed)), None, PANORAMA, X_BPANORAMA)


def _background(width: int, height: int) -> NDArray[np.float32]:
    rows = np.linspace(150, 90, height, dtype=np.float32)[:, None, None]
    return np.broadcast_to(rows + np.array((4, 0, -6), np.float32), (height, width, 3)).copy()


def _noisy(color: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.uint8]:
    noise = rng.standard_normal(color.shape, dtype=np.float32)
    return read_only(np.clip(color + 2 * noise, 0, 255).astype(np.uint8))


@functools.cache
def _picture(name: str, blur: float) -> NDArray[np.uint8]:
    picture = face_picture(name)
    return picture if blur == 0 else np.asarray(cv2.GaussianBlur(picture, (0, 0), blur), np.uint8)


def _draw(
    color: NDArray[np.float32],
    depth: NDArray[np.float64] | None,
    camera: CameraModel | FisheyeModel,
    X_OC: Pose3,
    cards: Sequence[FaceCard],
) -> None:
    """Draw ``cards``, the farthest first, each with ``_FINE`` x ``_FINE`` rays per pixel."""
    metres_per_px = EYES_TO_MOUTH_M / (MOUTH_PX - EYES_PX)
    for card in sorted(cards, key=lambda c: -math.dist(c.place, X_OC.translation)):
        # The card's frame: x to the picture's right, y down, z into it, origin in the middle of the face.
        X_OF = Pose3.from_translation_rpy(card.place, (0, 0, card.heading + math.pi)) @ Pose3.from_translation_rpy(
            (0, 0, 0), _FORWARD
        )
        X_CF = X_OC.inverse() @ X_OF
        height, width = _picture(card.name, 0).shape[:2]
        middle = np.array((MIDDLE_PX, (EYES_PX + MOUTH_PX) / 2))
        u, v = np.meshgrid(np.linspace(0, width, 9), np.linspace(0, height, 9))
        rim = (np.stack((u, v), axis=-1) - middle) * metres_per_px
        seen = camera.project(X_CF.transform(np.concatenate((rim, np.zeros((9, 9, 1))), axis=-1)))
        if np.isnan(seen).all():
            continue
        low = np.floor(np.nanmin(seen, axis=(0, 1))).astype(int) - 1
        high = np.ceil(np.nanmax(seen, axis=(0, 1))).astype(int) + 2
        u0, v0 = np.clip(low, 0, (camera.width, camera.height))
        u1, v1 = np.clip(high, 0, (camera.width, camera.height))
        if u1 <= u0 or v1 <= v0:
            continue
        offsets = (np.arange(_FINE) + 0.5) / _FINE - 0.5
        columns = (np.arange(u0, u1)[:, None] + offsets).ravel()
        rows = (np.arange(v0, v1)[:, None] + offsets).ravel()
        rays = camera.rays(np.stack(np.meshgrid(columns, rows), axis=-1))
        normal = X_CF.rotation[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            along = float(normal @ X_CF.translation) / (rays @ normal)
            points = rays * along[..., None]
            at = (points - X_CF.translation) @ X_CF.rotation[:, :2] / metres_per_px + middle
        hit = (rays @ normal > 0) & (along > 0) & (at >= 0).all(axis=-1) & (at <= (width, height)).all(axis=-1)
        at = np.where(hit[..., None], at, -9).astype(np.float32)
        # Blurred to the pixels that see it, so that reducing it makes no pattern.
        share = width / max(1.0, float(np.nanmax(seen[..., 0]) - np.nanmin(seen[..., 0]))) / _FINE
        picture = _picture(card.name, round(0.4 * share, 1) if share > 1 else 0)
        drawn = cv2.remap(
            picture, at[..., 0] - 0.5, at[..., 1] - 0.5, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        size = (int(u1 - u0), int(v1 - v0))
        cover = cv2.resize(hit.astype(np.float32), size, interpolation=cv2.INTER_AREA)
        paint = cv2.resize(drawn * hit[..., None].astype(np.float32), size, interpolation=cv2.INTER_AREA)
        box = (slice(v0, v1), slice(u0, u1))
        color[box] = color[box] * (1 - cover[..., None]) + paint
        if depth is not None:
            z = cv2.resize(np.where(hit, points[..., 2], 0), size, interpolation=cv2.INTER_AREA)
            depth[box] = np.where(cover > 0.5, z / np.maximum(cover, 0.5), depth[box])
