"""Detection and position of QR codes in an image: pure functions.

Decoding is zxing-cpp's (ISO/IEC 18004), with a second try on the image enlarged two times where nothing was found. A
fisheye's images are read in undistorted patches of them (``fisheye_patches``). Codes are placed here by the depth of
their own pixels; ``laser_ray`` places those that have none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
import zxingcpp
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, FloatArray
from app.messages import Image, QRCode, read_only
from app.modules.perception.fisheye_patches import FisheyePatches

#: Least number of pixels with depth, and their least share, to place a code.
FEWEST_DEPTHS = 12
SMALLEST_SHARE = 0.1

#: Least standard deviation (rad) of a normal: depth has errors that more pixels do not reduce.
LEAST_NORMAL_SIGMA = 0.02

#: Neighbouring depths err alike: so many pixels count as one.
_CORRELATED = 25.0
_UPSCALE = 2
#: Codes of the same text within this (cosine of the angle) are one, seen in two patches.
_SAME_PLACE = float(np.cos(np.radians(5.0)))


def detect(image: Image, upscale: bool = True) -> tuple[QRCode, ...]:
    """All codes of ``image``, each placed in ``base_link`` at the image's stamp where its depth could be measured.

    ``upscale``: a second try on the image enlarged two times if no code was found.
    """
    grey = np.asarray(cv2.cvtColor(image.color, cv2.COLOR_RGB2GRAY), np.uint8)
    codes = []
    for text, corners in decode(grey, upscale):
        plane = None
        if image.depth is not None and isinstance(image.camera, CameraModel):
            plane = locate(corners, image.depth, image.camera)
        code = QRCode(text, read_only(corners), None)
        if plane is not None:
            code = replace(code, p_BQ=_tuple(image.X_BC.transform(plane.p_CQ)))
            if plane.n_CQ is not None:
                normal = _tuple(image.X_BC.rotation @ plane.n_CQ)
                code = replace(code, n_BQ=normal, normal_sigma=plane.normal_sigma)
        codes.append(code)
    return tuple(codes)


def detect_panorama(image: Image, patches: FisheyePatches, most_patches: int) -> tuple[QRCode, ...]:
    """All codes of the fisheye ``image``, without positions; reads at most ``most_patches`` of ``patches``."""
    grey = np.asarray(cv2.cvtColor(image.color, cv2.COLOR_RGB2GRAY), np.uint8)
    codes: list[QRCode] = []
    known: list[tuple[str, NDArray[np.float64]]] = []
    for cell in patches.promising(grey, most_patches):
        for text, corners in decode(patches.cut(grey, cell), upscale=False):
            rays = patches.rays(cell, corners)
            middle = rays.mean(axis=0) / np.linalg.norm(rays.mean(axis=0))
            seen = patches.camera.project(rays).astype(np.float32)
            if np.isnan(seen).any() or any(text == other and middle @ ray > _SAME_PLACE for other, ray in known):
                continue
            known.append((text, middle))
            codes.append(QRCode(text, read_only(seen), None))
    return tuple(codes)


def corner_rays(code: QRCode, camera: CameraModel | FisheyeModel) -> NDArray[np.float64]:
    """Unit vectors (4, 3) in the camera's optical frame towards the corners of ``code``."""
    return camera.rays(code.corners.astype(np.float64)).astype(np.float64)


def central_ray(rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vector (3,) towards the centre of a plane quadrilateral seen along ``rays`` (4, 3).

    The diagonals lie in the planes of opposite rays; the centre is where these planes cross, with any kind of camera.
    """
    a, b, c, d = rays
    mean = rays.mean(axis=0)
    along = np.cross(np.cross(a, c), np.cross(b, d))
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return np.asarray(mean / np.linalg.norm(mean))
    return np.asarray(along / length if along @ mean > 0 else -along / length)


def edge_angle(rays: NDArray[np.float64]) -> float:
    """Angle (rad) subtended by the longest edge of a code, by the ``rays`` (4, 3) of its corners."""
    cosines = np.einsum("ij,ij->i", rays, np.roll(rays, 1, axis=0))
    return float(np.arccos(np.clip(cosines.min(), -1.0, 1.0)))


def decode(grey: NDArray[np.uint8], upscale: bool = True) -> list[tuple[str, NDArray[np.float32]]]:
    """Text and corners (4, 2) float32 px of each code in ``grey`` (H, W) uint8; see :class:`app.messages.QRCode`."""
    found = _read(grey)
    if found or not upscale:
        return found
    enlarged = cv2.resize(grey, None, fx=_UPSCALE, fy=_UPSCALE, interpolation=cv2.INTER_CUBIC)
    # Pixel centres: u of the small image is 2 u + 1/2 of the enlarged one.
    shift = np.float32(0.5 * (_UPSCALE - 1))
    return [(text, (corners - shift) / np.float32(_UPSCALE)) for text, corners in _read(np.asarray(enlarged, np.uint8))]


def _read(grey: NDArray[np.uint8]) -> list[tuple[str, NDArray[np.float32]]]:
    found = []
    # Micro and rectangular codes have one corner mark or little redundancy: they are "read" in the grain of walls.
    formats = zxingcpp.BarcodeFormats(zxingcpp.BarcodeFormat.QRCodeModel2)
    for barcode in zxingcpp.read_barcodes(grey, formats=formats, text_mode=zxingcpp.TextMode.Plain):
        at = barcode.position
        corners = [(p.x, p.y) for p in (at.top_left, at.top_right, at.bottom_right, at.bottom_left)]
        found.append((barcode.text, np.array(corners, dtype=np.float32)))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class CodePlane:
    """Where a code is in the camera's optical frame: its centre ``p_CQ`` (3,) m, and the unit vector ``n_CQ`` (3,) of
    its outward normal, towards the camera, with ``normal_sigma`` (rad); None where no plane fits its depths."""

    p_CQ: NDArray[np.float64]
    n_CQ: NDArray[np.float64] | None
    normal_sigma: float | None


def locate(corners: NDArray[np.float32], depth: NDArray[np.uint16], camera: CameraModel) -> CodePlane | None:
    """Centre and normal of a code, or None where too few of its pixels have depth.

    ``corners`` (4, 2) px, clockwise; ``depth`` (H, W) uint16 mm, 0 = none. The inverse depth of a plane is linear in
    the pixels, so 1/z = a u + b v + c is fitted to the depths inside the corners, twice: the second time without those
    beyond three times the median residual of the first. The centre is where the diagonals cross, which perspective
    leaves in place, at the plane's depth there; the median depth replaces the plane where they differ by more than the
    code's size allows.

    With n . p = d on the plane, (a fx, b fy, c') = n / d, where c' is 1/z at the principal point: the covariance of the
    fit is that of the normal's direction, too.
    """
    centre = diagonal_crossing(corners.astype(np.float64))
    v, u = _inside(corners, depth.shape)
    z = depth[v, u].astype(np.float64) * 1e-3
    valid = z > 0
    if np.count_nonzero(valid) < max(FEWEST_DEPTHS, SMALLEST_SHARE * len(z)):
        return None
    u, v, z = u[valid], v[valid], z[valid]
    median = float(np.median(z))
    fit = _plane(u - centre[0], v - centre[1], z)
    across = float(np.linalg.norm(corners[0] - corners[2])) / camera.fx * median
    if fit is None or abs(1.0 / fit[0][2] - median) > 0.5 * across:
        return CodePlane(_back_projected(camera, centre, median), None, None)
    (a, b, c), covariance = fit
    # From 1/z at the code's centre to 1/z at the principal point, and from pixels to rays.
    shift = np.array([camera.cx - centre[0], camera.cy - centre[1], 1.0])
    to_normal = np.array([[camera.fx, 0.0, 0.0], [0.0, camera.fy, 0.0], shift])
    towards = to_normal @ np.array([a, b, c])
    length = float(np.linalg.norm(towards))
    unit = towards / length
    across_unit = np.eye(3) - np.outer(unit, unit)
    spread = across_unit @ to_normal @ covariance @ to_normal.T @ across_unit / length**2
    sigma = math.hypot(LEAST_NORMAL_SIGMA, math.sqrt(max(0.0, float(np.linalg.eigvalsh(spread)[-1]))))
    return CodePlane(_back_projected(camera, centre, 1.0 / c), -unit, sigma)


def _back_projected(camera: CameraModel, pixel: NDArray[np.float64], z: float) -> NDArray[np.float64]:
    return camera.back_project(pixel, np.array(z)).astype(np.float64)


def _tuple(v: FloatArray) -> tuple[float, float, float]:
    x, y, z = v.tolist()
    return x, y, z


def diagonal_crossing(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Intersection of the diagonals of the quadrilateral ``corners`` (4, 2); its mean corner if they are parallel."""
    a, b, c, d = corners
    system = np.stack((c - a, b - d), axis=1)
    if abs(np.linalg.det(system)) < 1e-9:
        mean: NDArray[np.float64] = corners.mean(axis=0)
        return mean
    along = np.linalg.solve(system, b - a)[0]
    crossing: NDArray[np.float64] = a + along * (c - a)
    return crossing


def _inside(corners: NDArray[np.float32], shape: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the image's pixels inside the quadrilateral."""
    height, width = shape
    whole = np.round(corners).astype(np.int32)
    u0, v0 = np.clip(whole.min(axis=0), 0, (width, height))
    u1, v1 = np.clip(whole.max(axis=0) + 1, 0, (width, height))
    # A mask of the code's own box: a mask of the whole image would dominate the cost.
    mask = np.zeros((v1 - v0, u1 - u0), np.uint8)
    if mask.size:
        cv2.fillConvexPoly(mask, whole - (u0, v0), 1)
    v, u = np.nonzero(mask)
    return v + v0, u + u0


def _plane(
    u: NDArray[np.float64], v: NDArray[np.float64], z: NDArray[np.float64]
) -> tuple[tuple[float, float, float], NDArray[np.float64]] | None:
    """a, b, c > 0 of the plane 1/z = a u + b v + c through the depths ``z`` at (``u``, ``v``), and their covariance
    (3, 3); None if they lie on a line."""
    terms = np.stack((u, v, np.ones_like(z)), axis=-1)
    inverse = 1.0 / z
    keep = np.ones(len(z), dtype=bool)
    for _ in range(2):
        kept = terms[keep]
        normal = kept.T @ kept
        if np.linalg.cond(normal) > 1e12:
            return None
        solution = np.linalg.solve(normal, kept.T @ inverse[keep])
        if solution[2] <= 0:
            return None
        residual = np.abs(terms @ solution - inverse)
        spread = float(residual[keep] @ residual[keep]) / max(1, int(np.count_nonzero(keep)) - 3)
        covariance = _CORRELATED * spread * np.linalg.inv(normal)
        keep = residual <= 3.0 * max(float(np.median(residual)), 1e-6)
    a, b, c = (float(value) for value in solution)
    return (a, b, c), np.asarray(covariance, np.float64)
