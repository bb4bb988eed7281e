"""What solutions say of their error against what it is, on scenes with known answers.

The reported error should be at least the true one in nine scenes of ten, never less than half of it, and not much more:
at most four times, by the median. `coverage.py` makes tables of the same.
"""

from __future__ import annotations

import numpy as np
import pytest
from known_answers import KNOWN, Known, normals_of, true_error_of_field, true_error_of_patch_means

import radiosity

EXACT = 1e-4
"""Errors below this, which a furnace has, are as good as none."""

FIELDS = [name for name, known in KNOWN.items() if name not in ("cornell", "corridor")]
"""Of Cornell only means are known, and of the corridor nothing to 2 %."""


def check(reported: dict[str, float], true: dict[str, float]) -> None:
    """Over all scenes together."""
    ratio = {name: reported[name] / max(true[name], EXACT) for name in true}
    told = {name: f"{reported[name]:.3%} reported, {true[name]:.3%} true" for name in ratio}
    kind = [name for name, r in ratio.items() if r < 1 and true[name] > EXACT]
    assert len(kind) <= 0.1 * len(ratio), {name: told[name] for name in kind}
    assert min(r for name, r in ratio.items() if true[name] > EXACT) > 0.5, told
    assert np.median(list(ratio.values())) < 4, told


def means(known: Known, seed: int) -> tuple[float, float]:
    """Of the means of given patches."""
    solution = radiosity.solve(known.mesh(600), accuracy=0.03, seed=seed)
    return solution.report.estimated_error, true_error_of_patch_means(known, solution)


def field(known: Known, seed: int) -> tuple[float, float]:
    """Of the field on a mesh of the engine's own."""
    solution = radiosity.solve(known.scene(), accuracy=0.04, max_patches=20_000, time_limit=60, seed=seed)

    def at(points: np.ndarray, surface: np.ndarray) -> np.ndarray:
        values = solution.irradiance_at(points, normals_of(solution.patches.scene, points, surface))
        assert np.isfinite(values).all()
        return values

    return solution.report.estimated_error, true_error_of_field(known, at, 600)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_means_of_given_patches(seed: int) -> None:
    reported, true = {}, {}
    for name, known in KNOWN.items():
        reported[name], true[name] = means(known, seed)
    check(reported, true)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_fields_on_meshes_of_the_engines_own(seed: int) -> None:
    reported, true = {}, {}
    for name in FIELDS:
        reported[name], true[name] = field(KNOWN[name], seed)
    check(reported, true)
