"""Positions of microphones by nonlinear least squares over all claps, robust against wrong arrival times.

Unknown are the positions p (M, 3), and of each clap its direction d (3,), the inverse u of its distance and the instant
of its arrival at the middle. What is fitted, in metres (times the speed of sound)::

    c t = |d / u - p| - 1 / u + c t0                            for each clap and microphone

with the way round the body where there is one. Prior knowledge are rows like measurements, each with its standard
deviation: the configured positions, the length 1 of d, and distances of 0.8 to 3 m. Microphones in a plane hear
nothing of the part of d across it, so that sound gives their places up to a stretch of the plane. There the claps are
taken to be at about one height, near that of the array, and the array to have about the configured size, as a line
is. Too small a configured size shows all the same, since no direction makes the differences so large.

Levenberg-Marquardt steps on a Cauchy cost, whose scale is lowered in stages (scipy's least_squares, which has no such
cost with these steps, ended in a minimum 14 mm away in one of 16 simulated rooms, where these stay within 4 mm).
Standard deviations are those of the linearized problem at the solution. Where the whole array is (six numbers) sound
cannot show: the result is turned and moved to lie nearest to the configured positions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.structure import directions, turn_between
from app.modules.perception.voices.steering_vectors import paths

#: Error of an arrival time (m), and what is added to it for sound along the body (m per m).
_ARRIVAL_M, _CREEPING = 0.001, 0.03
#: Prior deviation of a position from the configured one (m), and across the plane or line of the array (m).
PRIOR_M, _ACROSS_M = 0.03, 0.0005
#: Prior inverse distance of a clap (1/m) and its standard deviation.
_INVERSE_RANGE, _INVERSE_RANGE_SD = 0.7, 0.25
#: Deviation of a direction's length from 1, and in a plane that of its visible part from that of most claps.
_LENGTH_SD, _HEIGHT_SD = 1e-3, 0.03
_USUAL, _USUAL_SD = 0.98, 0.05
#: Relative deviation of the size of a plane or line from the configured one.
_SIZE_SD = 0.02
#: Waves along a rigid surface are slower than in the air by about this share at a clap's frequencies, which is fitted.
_SLOWER, _SLOWER_SD = 0.05, 0.05
#: Scales (m) of the Cauchy cost; the last is by the residuals, and not below the least.
_SCALES_M, _LEAST_SCALE_M = (0.03, 0.01), 0.002
#: Least variance of an arrival time, of _ARRIVAL_M squared, and how many must be left over for it to be estimated.
_LEAST_VARIANCE, _MANY = 0.1, 12
_STEPS = 12
#: Damping is in proportion to the matrix's diagonal, but at least to this.
_LEAST_SIZE = 100.0
_EPSILON = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """What is known before: ``positions`` (M, 3) m about their middle; ``axes`` (3, 3), one principal axis a row, of
    which the array extends along the first ``dimensions``; ``body_m``: radius of the body, 0 for none."""

    positions: NDArray[np.float64]
    axes: NDArray[np.float64]
    dimensions: int
    body_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """The solution for K claps and M microphones.

    ``positions`` (M, 3) m, about the middle of the configured ones; ``directions`` (K, 3) and ``ranges`` (K,) m of the
    claps; ``residuals`` (K, M) m; ``weights`` (K, M): how much of each was believed, from 0 to 1; ``deviations`` (M,)
    m: standard deviation of each position's part that does not move or turn the whole; ``undetermined``: how many of
    the numbers that give the array's shape come from the configuration rather than from the sound; ``unevenness``: of
    a plane array, how much the claps' visible parts differ, RMS of at most 1, and ``visible`` what they usually are (1:
    in the plane; 1 for arrays in space); ``cost`` by which fits compare.
    """

    positions: NDArray[np.float64]
    directions: NDArray[np.float64]
    ranges: NDArray[np.float64]
    residuals: NDArray[np.float64]
    weights: NDArray[np.float64]
    deviations: NDArray[np.float64]
    undetermined: int
    unevenness: float
    visible: float
    cost: float


def refine(
    heard: NDArray[np.float64],
    prior: Geometry,
    start: NDArray[np.float64] | None = None,
    prior_m: float = PRIOR_M,
) -> Fit:
    """Fit all claps ``heard`` (K, M) m: arrival times times the speed of sound.

    ``start`` (M, 3): positions to begin with (default: the prior ones). ``prior_m``: standard deviation (m) of the
    prior positions; 0 keeps them, and only the claps are fitted.
    """
    problem = _Problem(heard - heard.mean(axis=1, keepdims=True), prior, prior_m)
    state = problem.initial(prior.positions if start is None else start)
    for scale in _SCALES_M:
        state = _descend(problem, state, scale)
    for _ in range(2):
        state = _descend(problem, state, problem.scale(state))
    return problem.result(state, problem.scale(state))


class _Problem:
    """Residuals and their derivatives; the state is one vector: p (3 M), d (3 K), u (K), c t0 (K), usual visible part,
    slower share."""

    def __init__(self, heard: NDArray[np.float64], prior: Geometry, prior_m: float) -> None:
        self._heard = heard
        self._prior = prior
        self._claps, self._count = heard.shape
        self._flat = prior.dimensions == 2
        self._size = float((prior.positions**2).sum())
        along = np.arange(3) < prior.dimensions
        self._position_sd = np.where(along, prior_m, min(prior_m, _ACROSS_M)) if prior_m else np.full(3, 1e-7)
        self._sd = np.full(heard.shape, _ARRIVAL_M)

    def initial(self, start: NDArray[np.float64]) -> NDArray[np.float64]:
        seen = directions(self._heard, start)
        lengths = np.linalg.norm(seen, axis=1, keepdims=True)
        if self._prior.dimensions == 3:
            seen /= np.maximum(lengths, 1e-6)
        else:
            seen *= np.minimum(1, 0.98 / np.maximum(lengths, 1e-6))
            aside = self._aside()
            seen += np.sqrt(1 - (seen**2).sum(axis=1))[:, None] * aside
        usual = float(np.clip(np.median(lengths), 0.5, 1)) if self._flat else 1.0
        claps = self._claps
        return np.concatenate(
            [start.ravel(), seen.ravel(), np.full(claps, _INVERSE_RANGE), np.zeros(claps), [usual, _SLOWER]]
        )

    def _aside(self) -> NDArray[np.float64]:
        """The direction on one side of the array's plane or line, upward where it can."""
        across = self._prior.axes[self._prior.dimensions :]
        chosen = across[int(np.abs(across[:, 2]).argmax())]
        return np.asarray(chosen if chosen[2] >= 0 else -chosen)

    def parts(self, state: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Positions, directions, inverse distances, instants."""
        count, claps = self._count, self._claps
        ends = np.cumsum([3 * count, 3 * claps, claps, claps])
        p, d, u, t, _ = np.split(state, ends)
        return p.reshape(count, 3), d.reshape(claps, 3), u, t

    def _model(
        self, p: NDArray[np.float64], d: NDArray[np.float64], u: NDArray[np.float64], slower: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        ways, creeping = paths(p, d / u[:, None], self._prior.body_m)
        return ways + slower * creeping - 1 / u[:, None], creeping

    def rows(self, state: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Residuals (K, M) of the arrivals and those of the prior knowledge, both in standard deviations."""
        p, d, u, t = self.parts(state)
        usual, slower = state[-2:]
        ways, creeping = self._model(p, d, u, slower)
        self._sd = _ARRIVAL_M + _CREEPING * creeping
        return (self._heard - ways - t[:, None]) / self._sd, self._prior_rows(p, d, u, usual=usual, slower=slower)

    def _prior_rows(
        self, p: NDArray[np.float64], d: NDArray[np.float64], u: NDArray[np.float64], *, usual: float, slower: float
    ) -> NDArray[np.float64]:
        axes = self._prior.axes
        rows = [
            ((p - self._prior.positions) @ axes.T / self._position_sd).ravel(),
            (np.linalg.norm(d, axis=1) - 1) / _LENGTH_SD,
            (u - _INVERSE_RANGE) / _INVERSE_RANGE_SD,
            np.array([(usual - _USUAL) / _USUAL_SD, (slower - _SLOWER) / _SLOWER_SD]),
        ]
        if self._prior.dimensions < 3:
            rows.append(np.array([(p * self._prior.positions).sum() / self._size - 1]) / _SIZE_SD)
        if self._flat:
            rows.append((np.linalg.norm(d @ axes[:2].T, axis=1) - usual) / _HEIGHT_SD)
        return -np.concatenate(rows)

    def jacobians(self, state: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Derivatives of both kinds of rows: (K M, N) and (R, N). A microphone's position moves its own arrivals alone,
        and so does a clap's direction."""
        count, claps = self._count, self._claps
        p, d, u, _ = self.parts(state)
        slower = state[-1]
        now, creeping = self._model(p, d, u, slower)
        arrivals = np.zeros((claps, count, len(state)))
        every, clap = np.arange(count), np.arange(claps)
        for axis in range(3):
            step = _EPSILON * np.eye(3)[axis]
            moved = (self._model(p + step, d, u, slower)[0] - now) / _EPSILON
            arrivals[:, every, 3 * every + axis] = moved
            turned = (self._model(p, d + step, u, slower)[0] - now) / _EPSILON
            arrivals[clap, :, 3 * count + 3 * clap + axis] = turned
        first = 3 * count + 3 * claps
        arrivals[clap, :, first + clap] = (self._model(p, d, u + _EPSILON, slower)[0] - now) / _EPSILON
        arrivals[clap, :, first + claps + clap] = 1
        arrivals[:, :, -1] = creeping
        arrivals /= self._sd[:, :, None]
        return arrivals.reshape(claps * count, -1), self._prior_jacobian(state)

    def _prior_jacobian(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        count, claps = self._count, self._claps
        _, d, _, _ = self.parts(state)
        axes = self._prior.axes
        size = len(state)
        clap = np.arange(claps)
        positions = np.zeros((3 * count, size))
        for microphone in range(count):
            span = slice(3 * microphone, 3 * microphone + 3)
            positions[span, span] = axes / self._position_sd[:, None]
        lengths = np.zeros((claps, size))
        unit = d / np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-9)
        ranges = np.zeros((claps, size))
        ranges[clap, 3 * (count + claps) + clap] = 1 / _INVERSE_RANGE_SD
        shared = np.zeros((2, size))
        shared[0, -2], shared[1, -1] = 1 / _USUAL_SD, 1 / _SLOWER_SD
        heights = np.zeros((claps, size))
        seen = d @ axes[:2].T
        in_plane = (seen / np.maximum(np.linalg.norm(seen, axis=1, keepdims=True), 1e-9)) @ axes[:2]
        for axis in range(3):
            column = 3 * count + 3 * clap + axis
            lengths[clap, column] = unit[:, axis] / _LENGTH_SD
            heights[clap, column] = in_plane[:, axis] / _HEIGHT_SD
        heights[:, -2] = -1 / _HEIGHT_SD
        sizes = np.zeros((1, size))
        sizes[0, : 3 * count] = self._prior.positions.ravel() / self._size / _SIZE_SD
        more = [*([sizes] if self._prior.dimensions < 3 else []), *([heights] if self._flat else [])]
        return np.concatenate([positions, lengths, ranges, shared, *more])

    # --- robustness ---

    def scale(self, state: NDArray[np.float64]) -> float:
        """The Cauchy scale (m) that fits the residuals."""
        arrivals, _ = self.rows(state)
        return max(_LEAST_SCALE_M, 3 * 1.48 * float(np.median(np.abs(arrivals))) * _ARRIVAL_M)

    def weights(self, arrivals: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
        """The weight of each arrival, from 0 to 1."""
        return np.asarray(1 / (1 + (arrivals * _ARRIVAL_M / scale) ** 2))

    def cost(self, state: NDArray[np.float64], scale: float) -> float:
        """The robust cost."""
        arrivals, prior = self.rows(state)
        wide = (scale / _ARRIVAL_M) ** 2
        return float(wide * np.log1p(arrivals**2 / wide).sum() + (prior**2).sum())

    def normal(self, state: NDArray[np.float64], scale: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The weighted normal equations: matrix (N, N) and right side (N,)."""
        arrivals, prior = self.rows(state)
        weights = self.weights(arrivals, scale).ravel()
        of_arrivals, of_prior = self.jacobians(state)
        matrix = of_arrivals.T @ (weights[:, None] * of_arrivals) + of_prior.T @ of_prior
        return matrix, of_arrivals.T @ (weights * arrivals.ravel()) + of_prior.T @ prior

    # --- result ---

    def result(self, state: NDArray[np.float64], scale: float) -> Fit:
        """The solution, turned to lie nearest to the prior positions."""
        p, d, u, _ = self.parts(state)
        arrivals, _ = self.rows(state)
        weights = self.weights(arrivals, scale)
        turn = turn_between(p, self._prior.positions)
        deviations, undetermined = self._deviations(p, self._spread(state, weights))
        lengths = np.linalg.norm(d @ self._prior.axes[:2].T, axis=1)
        return Fit(
            (p - p.mean(axis=0)) @ turn + self._prior.positions.mean(axis=0),
            d @ turn,
            1 / u,
            residuals=arrivals * self._sd,
            weights=weights,
            deviations=deviations,
            undetermined=undetermined,
            unevenness=float(np.sqrt(np.mean((lengths - state[-2]) ** 2))) if self._flat else 0.0,
            visible=float(state[-2]) if self._flat else 1.0,
            cost=self.cost(state, _SCALES_M[-1]),
        )

    def _spread(self, state: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Covariance (3 M, 3 M) m2 of the positions, arrival times being as exact as their residuals are small."""
        arrivals, _ = self.rows(state)
        of_arrivals, of_prior = self.jacobians(state)
        free = self._claps * (self._count - 3) - 3 * self._count + 6
        variance = float((weights * arrivals**2).sum()) / max(1, free)
        variance = max(variance, _LEAST_VARIANCE if free >= _MANY else 1.0)
        matrix = of_arrivals.T @ (weights.reshape(-1, 1) / variance * of_arrivals) + of_prior.T @ of_prior
        # A line hears nothing of how a clap lies around it.
        matrix += np.eye(len(matrix))
        return np.asarray(np.linalg.inv(matrix)[: 3 * self._count, : 3 * self._count])

    def _deviations(self, p: NDArray[np.float64], spread: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
        """Standard deviations (M,) m of the shape, and how many of its numbers are those of the prior still."""
        count = self._count
        about = p - p.mean(axis=0)
        whole = np.zeros((3 * count, 6))
        for axis in range(3):
            unit = np.eye(3)[axis]
            whole[:, axis] = np.tile(unit, count)
            whole[:, 3 + axis] = np.cross(unit, about).ravel()
        basis, sizes, _ = np.linalg.svd(whole, full_matrices=False)
        basis = basis[:, sizes > 1e-6 * sizes[0]]
        shape = np.eye(3 * count) - basis @ basis.T
        within = shape @ spread @ shape
        deviations = np.sqrt(np.maximum(np.diag(within).reshape(count, 3).sum(axis=1), 0))
        along = np.where(np.arange(3) < self._prior.dimensions, 1.0, 0.0)
        turned = np.kron(np.eye(count), along[:, None] * self._prior.axes)
        seen = np.linalg.eigvalsh(turned @ within @ turned.T)
        prior_m = float(self._position_sd[0])
        return deviations, int((seen > (0.4 * prior_m) ** 2).sum())


def _descend(problem: _Problem, state: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    """Levenberg-Marquardt steps at one scale of the cost."""
    damping = 1e-3
    cost = problem.cost(state, scale)
    for _ in range(_STEPS):
        matrix, right = problem.normal(state, scale)
        sizes = np.diag(np.maximum(np.diag(matrix), _LEAST_SIZE))
        # Residuals are measured minus modelled; rows of prior knowledge have the same sign.
        for _ in range(6):
            step = np.linalg.solve(matrix + damping * sizes, right)
            tried = problem.cost(state + step, scale)
            if tried < cost:
                break
            damping *= 10
        else:
            return state
        gain = cost - tried
        state, cost, damping = state + step, tried, max(1e-9, damping / 10)
        if gain < 1e-6 * cost:
            break
    return state
