"""Where an array's microphones can be, by the arrival times of distant sounds from unknown directions.

Of sounds from afar the arrival times are linear in the positions: c t = -P d with P (M, 3) the positions, d a unit
vector, and t about its mean. Times of several sounds side by side are a matrix of rank 3, and its factors are positions
and directions up to one 3 by 3 matrix; that the directions have length 1 determines this matrix, up to a rotation and
a mirror image (S. Thrun, "Affine structure from sound", NIPS 18, 2005). It fails, and here gives None, where the
microphones lie in a plane or all directions on one cone (Y. Kuang and others, "Understanding TOA and TDOA network
calibration using far field approximation as initial estimate", ICPRAM 2012).

The same linear relation distinguishes orders of channels: with the microphones' true places, some direction of length 1
explains each sound; with places that are interchanged, none does.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

#: Greatest number of microphones of which every order is tried.
_ALL_ORDERS_OF = 8
#: The array's extents below this share of the largest are no structure.
FLAT = 0.05
#: Least number of sounds for a structure, and least ratio of the singular values of its last step.
_SOUNDS_LEAST, _CONDITION = 8, 0.02
#: Orders are likely whose misfit is at most so much more than the least (factor, m).
_LIKELY, _LIKELY_M = 2.0, 0.005
#: Turns tried to lay a structure over the configured positions, and how many of the best are followed.
_TURNS, _FOLLOWED, _REPEATS = 4000, 12, 10


def affine_structure(heard: NDArray[np.float64], dimensions: int = 3) -> NDArray[np.float64] | None:
    """Positions (M, 3) m about their middle, up to rotation and mirror image, by ``heard`` (K, M) m: arrival times of K
    distant sounds times the speed of sound. None where these do not determine them.

    With 2 ``dimensions`` the microphones are in a plane (z = 0), the sounds at one height, and the size is a guess.
    """
    centred = heard - heard.mean(axis=1, keepdims=True)
    if min(centred.shape) <= dimensions or len(heard) < _SOUNDS_LEAST:
        return None
    left, sizes, right = np.linalg.svd(centred, full_matrices=False)
    if sizes[dimensions - 1] < FLAT * sizes[0]:
        return None
    scaled = left[:, :dimensions] * np.sqrt(len(heard))
    first, second = np.triu_indices(dimensions)
    design = scaled[:, first] * scaled[:, second] * np.where(first == second, 1, 2)
    weights = np.linalg.svd(design, compute_uv=False)
    if weights[-1] < _CONDITION * weights[0]:
        return None
    square = np.zeros((dimensions, dimensions))
    square[first, second] = square[second, first] = np.linalg.lstsq(design, np.ones(len(heard)), rcond=None)[0]
    values, axes = np.linalg.eigh(square)
    if values[0] < 0.01 * values[-1]:
        return None
    # The directions are `scaled` times a root of `square`, and the positions what then gives the arrivals.
    inverse = (axes / np.sqrt(values)).T
    found = -(inverse @ (sizes[:dimensions, None] * right[:dimensions]) / np.sqrt(len(heard))).T
    positions = np.zeros((heard.shape[1], 3))
    positions[:, :dimensions] = found - found.mean(axis=0)
    return positions


def turn_between(
    positions: NDArray[np.float64], to: NDArray[np.float64], *, mirror: bool = False
) -> NDArray[np.float64]:
    """The rotation (3, 3), from the right, that lays ``positions`` (M, 3) about their middle nearest to ``to`` (M, 3)
    about its own (W. Kabsch, 1976); with ``mirror`` a mirror image, if that lies nearer."""
    about, goal = positions - positions.mean(axis=0), to - to.mean(axis=0)
    left, _, right = np.linalg.svd(about.T @ goal)
    signs = np.ones(3)
    if not mirror and np.linalg.det(left @ right) < 0:
        signs[2] = -1
    return np.asarray((left * signs) @ right)


def aligned(positions: NDArray[np.float64], to: NDArray[np.float64], *, mirror: bool = False) -> NDArray[np.float64]:
    """``positions`` (M, 3) moved and turned to lie nearest to ``to`` (M, 3); as :func:`turn_between`."""
    turn = turn_between(positions, to, mirror=mirror)
    return np.asarray((positions - positions.mean(axis=0)) @ turn + to.mean(axis=0))


def directions(heard: NDArray[np.float64], positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (K, 3) that explain ``heard`` (K, M) m best, along the axes in which the ``positions`` (M, 3) extend; of
    length 1 in an array that resolves all directions, else of at most 1."""
    about = positions - positions.mean(axis=0)
    return np.asarray(-heard @ np.linalg.pinv(about, rcond=FLAT).T)


def order_misfit(
    heard: NDArray[np.float64], configured: NDArray[np.float64], orders: NDArray[np.int64]
) -> NDArray[np.float64]:
    """How badly each of ``orders`` (N, M) explains ``heard`` (K, M) m: (N,) m, the median sound's RMS error.

    Order o says that channel i is the microphone configured as number o[i]. The error is what no direction explains,
    and, for the length of the best direction, what a direction of length 1 would differ (in a plane: of the length
    that most have, at most 1).
    """
    about = configured - configured.mean(axis=0)
    sizes = np.linalg.svd(about, compute_uv=False)
    solid = int((sizes > FLAT * sizes[0]).sum()) == 3
    inverse = np.linalg.pinv(about, rcond=FLAT)
    heard = heard - heard.mean(axis=1, keepdims=True)
    found = -np.einsum("km,nmx->nkx", heard, inverse.T[orders], optimize=True)
    explained = -np.einsum("nkx,nmx->nkm", found, about[orders], optimize=True)
    rest = ((heard - explained) ** 2).mean(axis=2)
    lengths = np.linalg.norm(found, axis=2)
    usual = np.ones((len(orders), 1)) if solid else np.minimum(np.median(lengths, axis=1, keepdims=True), 1)
    off = (lengths - usual) * np.sqrt((about**2).mean())
    return np.asarray(np.sqrt(np.median(rest + off**2, axis=1)))


def likely_orders(heard: NDArray[np.float64], configured: NDArray[np.float64], most: int) -> list[tuple[int, ...]]:
    """The orders of channels, at most ``most``, by which ``configured`` (M, 3) m explains ``heard`` (K, M) m best, the
    best first.

    Several explain equally well where a turn or a mirror image lays the array onto itself. All orders of up to 8
    microphones are tried; of more, those to which the affine structure leads, and exchanges of two.
    """
    count = len(configured)
    if count <= _ALL_ORDERS_OF:
        orders = np.array(list(itertools.permutations(range(count))), np.int64)
    else:
        starts = [np.arange(count), *_matches(heard, configured)]
        orders = np.unique([_improved(heard, configured, start) for start in starts], axis=0)
    misfits = order_misfit(heard, configured, orders)
    best = np.argsort(misfits, kind="stable")[:most]
    likely = best[misfits[best] <= _LIKELY * misfits[best[0]] + _LIKELY_M]
    return [tuple(orders[row].tolist()) for row in likely]


def _matches(heard: NDArray[np.float64], configured: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """Orders by which the affine structure, turned and mirrored in many ways, lies over the configured positions."""
    from scipy.optimize import linear_sum_assignment

    goal = configured - configured.mean(axis=0)
    _, sizes, axes = np.linalg.svd(goal)
    dimensions = int((sizes > FLAT * sizes[0]).sum())
    if dimensions < 2 or (found := affine_structure(heard, dimensions)) is None:
        return []
    goal = goal @ axes.T
    if dimensions == 2:
        found *= np.linalg.norm(goal) / np.linalg.norm(found)

    def match(placed: NDArray[np.float64]) -> NDArray[np.int64]:
        return np.asarray(linear_sum_assignment(((placed[:, None] - goal) ** 2).sum(axis=2))[1], np.int64)

    placed = np.einsum("mx,nxy->nmy", found, _turns(dimensions))
    # Distances to the nearest place are quickly computed, and what lies well has small ones.
    inner = np.einsum("nmy,py->nmp", placed, goal)
    apart = (found**2).sum(axis=1)[:, None] + (goal**2).sum(axis=1) - 2 * inner
    orders = []
    for number in np.argsort(apart.min(axis=2).sum(axis=1))[:_FOLLOWED].tolist():
        order = match(placed[number])
        for _ in range(_REPEATS):
            order = match(aligned(found, goal[order], mirror=True))
        orders.append(order)
    return orders


def _turns(dimensions: int) -> NDArray[np.float64]:
    """Orthogonal matrices (N, 3, 3), rotations and mirror images, spread over all there are in so many dimensions."""
    if dimensions == 2:
        angles = np.linspace(0, 4 * np.pi, _TURNS, endpoint=False)
        turns = np.tile(np.eye(3), (_TURNS, 1, 1))
        turns[:, 0, 0], turns[:, 0, 1], turns[:, 1, 0], turns[:, 1, 1] = (
            np.cos(angles), np.sin(angles), -np.sin(angles), np.cos(angles),
        )  # fmt: skip
        turns[_TURNS // 2 :, 1] *= -1
        return turns
    turns, corners = np.linalg.qr(np.random.default_rng(0).standard_normal((_TURNS, 3, 3)))
    # Only with these signs are they spread evenly (F. Mezzadri, Notices of the AMS 54, 2007).
    return np.asarray(turns * np.sign(np.diagonal(corners, axis1=1, axis2=2))[:, None])


def _improved(heard: NDArray[np.float64], configured: NDArray[np.float64], start: NDArray[np.int64]) -> list[int]:
    """The order that exchanging two, always the best two, reaches from ``start``."""
    order = start
    misfit = float(order_misfit(heard, configured, order[None])[0])
    pairs = np.array(list(itertools.combinations(range(len(order)), 2)))
    while True:
        tried = np.repeat(order[None], len(pairs), axis=0)
        rows = np.arange(len(pairs))
        tried[rows, pairs[:, 0]], tried[rows, pairs[:, 1]] = order[pairs[:, 1]], order[pairs[:, 0]]
        misfits = order_misfit(heard, configured, tried)
        best = int(misfits.argmin())
        if misfits[best] >= misfit:
            return [int(one) for one in order]
        order, misfit = tried[best], float(misfits[best])
