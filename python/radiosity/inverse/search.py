"""The search for what misses least."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.optimize import Bounds, lsq_linear, minimize

from radiosity.inverse.goals import Goals
from radiosity.inverse.levers import Levers
from radiosity.sensitivity import demand_exchange, gradients
from radiosity.solution import Solution

Floats = npt.NDArray[np.float64]

TOGETHER = 32
"""Sums whose derivatives are held at a time."""

MOST_SUMS = 64
"""With more, a search with paint takes one adjoint solve for all of them at each step, and no Jacobian."""

FIRST_DAMPING = 1e-4
"""Of steps in lamps and paint together, relative to the steepest."""

MOST_CORRECTIONS = 3
"""Linear problems are solved again where lamps that were tested anew make it worth it."""


class Problem:
    """Goals and levers on one exchange."""

    def __init__(self, measured: Solution | None, goals: Goals, levers: Levers, economy: float) -> None:
        if not (np.isfinite(economy) and economy >= 0):
            raise ValueError(f"economy must be 0 or more, not {economy}")
        self.goals, self.levers, self.economy = goals, levers, economy
        self.history: list[float] = []
        self._measured = measured
        self._last: tuple[bytes, Solution] | None = None

    @property
    def measured(self) -> Solution:
        """What is relit."""
        if self._measured is None:
            raise RuntimeError("nothing was measured yet")
        return self._measured

    @measured.setter
    def measured(self, solution: Solution) -> None:
        demand_exchange(solution)
        self._measured, self._last = solution, None

    def _relit(self, blocks: dict[str, Floats]) -> Solution:
        return self.measured.relight(
            emission=blocks.get("emission"), reflectance=blocks.get("reflectance"), lights=blocks.get("lights")
        )

    def relit(self, x: Floats) -> Solution:
        """The equilibrium at x; the last one is kept."""
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = key, self._relit(self.levers.applied(self.measured, x))
            self.history.append(self.goals.residual(self.values(x)))
        return self._last[1]

    def values(self, x: Floats) -> Floats:
        """(n_rows,) W/m2."""
        return self.goals.values(self.relit(x))

    def jacobian(self, x: Floats) -> Floats:
        """(n_rows, n) derivatives of the values, by adjoint solves."""
        goals, bands = self.goals, self.goals.bands.shape[1]
        by_lever = np.empty((goals.weights.shape[0], len(self.levers.all), bands))
        for first in range(0, len(by_lever), TOGETHER):
            weights = goals.weights[first : first + TOGETHER].toarray()
            by_lever[first : first + TOGETHER] = self._by_lever(x, np.repeat(weights[:, :, None], bands, axis=2))
        return self._columns(by_lever)

    def by_relighting(self) -> Floats:
        """The same where nothing but lamps varies: each alone, at a strength of one."""
        dark = {"emission": np.zeros_like(self.measured.emission), "lights": np.zeros_like(self.measured.lights)}
        by_lever = []
        for lever in self.levers.all:
            lit = {name: block.copy() for name, block in dark.items()}
            lit["lights" if lever.kind == "strength" else lever.kind][lever.on] = 1.0
            by_lever.append(self.goals.weights @ self._relit(lit).irradiance)
        return self._columns(np.stack(by_lever, axis=1))

    def squares(self, x: Floats) -> tuple[float, Floats]:
        """The sum of squared misses and its gradient, from one adjoint solve."""
        goals = self.goals
        misses = self.values(x) - goals.wanted
        by_sum = np.zeros((goals.weights.shape[0], goals.bands.shape[1]))
        np.add.at(by_sum, goals.sums, (2 * goals.factor**2 * misses)[:, None] * goals.bands)
        found = self._by_lever(x, (goals.weights.T @ by_sum)[None])[0]
        gradient = np.concatenate([lever.spectra @ f for lever, f in zip(self.levers.all, found, strict=True)])
        return float(np.sum((goals.factor * misses) ** 2)), gradient

    def _by_lever(self, x: Floats, weights: Floats) -> Floats:
        """(n_sums, n_levers, n_bands) derivatives of sums by all of what a lever acts on."""
        emission, reflectance, lights = gradients(self.relit(x), weights)
        blocks = {"emission": emission, "reflectance": reflectance, "strength": lights}
        return np.stack([blocks[lever.kind][:, lever.on].sum(axis=1) for lever in self.levers.all], axis=1)

    def _columns(self, by_lever: Floats) -> Floats:
        """From levers to their numbers, and from sums to rows."""
        rows = by_lever[self.goals.sums] * self.goals.bands[:, None, :]
        return np.concatenate([rows[:, k] @ lever.spectra.T for k, lever in enumerate(self.levers.all)], axis=1)


def optimum(problem: Problem, start: Floats, max_evaluations: int) -> Floats:
    """The x within bounds that misses least; with less power where that is worth something."""
    is_paint = problem.levers.is_paint
    if not np.any(is_paint):
        return _linear(problem, start, ~is_paint)
    # Lamps first: then paint begins where it matters.
    x = _linear(problem, start, ~is_paint) if np.any(~is_paint) else start
    x = _search(problem, x, max_evaluations, None)
    reference = float(problem.levers.power @ x)
    return _search(problem, x, max_evaluations, reference) if problem.economy and reference else x


def _linear(problem: Problem, x: Floats, free: npt.NDArray[np.bool_]) -> Floats:
    """Lamps alone: bounded linear least squares, on derivatives that hold everywhere."""
    goals, levers = problem.goals, problem.levers
    fewer_lamps = len(levers.all) < goals.weights.shape[0] and bool(np.all(free))
    jacobian = (problem.by_relighting() if fewer_lamps else problem.jacobian(x))[:, free]
    low, high, power = levers.low[free], levers.high[free], levers.power[free]
    for _ in range(MOST_CORRECTIONS):
        base = problem.values(x) - jacobian @ x[free]
        matrix, misses = goals.factor[:, None] * jacobian, goals.factor * (goals.wanted - base)
        found = _bounded(matrix, misses, low, high)
        reference = float(power @ found)
        if problem.economy and reference:
            row = problem.economy * np.sqrt(np.sum(goals.weight**2 * goals.share)) * power / reference
            found = _bounded(np.vstack([matrix, row]), np.append(misses, 0.0), low, high)
        x = x.copy()
        x[free] = found
        # What is tested anew for other lamps is not quite what it was.
        off = goals.factor * (problem.values(x) - base - jacobian @ found)
        if np.sqrt(np.sum(off**2)) <= 1e-4:
            break
    return x


def _bounded(matrix: Floats, wanted: Floats, low: Floats, high: Floats) -> Floats:
    """Bounded least squares with columns of equal length."""
    length = np.linalg.norm(matrix, axis=0)
    length[length == 0] = 1.0
    bounds = (low * length, high * length)
    found = lsq_linear(matrix / length, wanted, bounds, method="bvls", tol=1e-12, max_iter=100 + 10 * len(low))
    return np.asarray(np.clip(found.x / length, low, high))


def _search(problem: Problem, start: Floats, max_evaluations: int, reference: float | None) -> Floats:
    """A search from `start`, with a row for power if it is worth something."""
    goals, levers = problem.goals, problem.levers
    row = np.zeros_like(start)
    if reference:
        row = problem.economy * np.sqrt(np.sum(goals.weight**2 * goals.share)) * levers.power / reference
    span = np.where(np.isfinite(levers.high), levers.high - levers.low, np.maximum(start, 1.0))
    way = _quasi_newton if goals.weights.shape[0] > MOST_SUMS else _gauss_newton
    return way(problem, start, row, span, max_evaluations)


def _gauss_newton(problem: Problem, x: Floats, row: Floats, span: Floats, max_evaluations: int) -> Floats:
    """Bounded linear least squares over and over, steps damped where the last one did not keep what it promised
    (Levenberg 1944; Marquardt 1963). Many lamps are out or at their brightest, and bounds are met exactly.
    """  # noqa: D205
    goals, levers = problem.goals, problem.levers

    def misses(x: Floats) -> Floats:
        return np.append(goals.factor * (problem.values(x) - goals.wanted), row @ x)

    now, matrix, damping = misses(x), None, FIRST_DAMPING
    for _ in range(max_evaluations):
        if matrix is None:
            matrix = np.vstack([goals.factor[:, None] * problem.jacobian(x), row]) * span
        size = np.sqrt(damping) * max(float(np.linalg.norm(matrix, axis=0).max()), 1e-300)
        damped = np.vstack([matrix, size * np.eye(len(x))])
        low, high = (levers.low - x) / span, (levers.high - x) / span
        step = _bounded(damped, np.append(-now, np.zeros(len(x))), low, high)
        promised = float(now @ now - np.sum((now + matrix @ step) ** 2))
        if promised <= 1e-8 * float(now @ now) or now @ now <= 1e-14 * np.sum(goals.weight**2):
            break
        then = np.clip(x + span * step, levers.low, levers.high)
        new = misses(then)
        kept = float(now @ now - new @ new) / promised
        if kept > 0:
            x, now, matrix = then, new, None
        damping *= 0.1 if kept > 0.75 else 1.0 if kept > 0.25 else 8.0
    return x


def _quasi_newton(problem: Problem, start: Floats, row: Floats, span: Floats, max_evaluations: int) -> Floats:
    """On the sum of squares alone (L-BFGS-B), whose gradient takes one adjoint solve for any number of targets."""
    low, high = problem.levers.low, problem.levers.high

    def squares(y: Floats) -> tuple[float, Floats]:
        x = np.clip(y * span, low, high)
        value, gradient = problem.squares(x)
        return value + float(row @ x) ** 2, span * (gradient + 2 * float(row @ x) * row)

    bounds, options = Bounds(low / span, high / span), {"maxfun": max_evaluations, "ftol": 1e-12, "gtol": 1e-9}
    found = minimize(squares, start / span, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(np.clip(found.x * span, low, high))
