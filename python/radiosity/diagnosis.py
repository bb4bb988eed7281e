"""What is doubtful about a scene: what its shapes and a few rays tell, or the form factors measured on it.

    >>> for finding in radiosity.diagnosis.examine(scene):
    ...     print(finding)
    >>> for finding in radiosity.diagnosis.of(F):
    ...     print(finding)

Nothing here changes a number.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from radiosity.scene import Finding

if TYPE_CHECKING:
    from collections.abc import Callable

    from radiosity.factors import FormFactors
    from radiosity.scene import Scene

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

CLOSED = 0.98
"""Mean row sum by area above which patches are taken to enclose a space."""

ENCLOSED = 0.8
"""Mean row sum of its neighbours above which a patch should see much too."""

LEAST_DEVIATION = 1e-3
"""Deviations of a row sum up to this are not worth a word."""

MOST_NAMED = 10
"""So many patches are named one by one."""

OPTICS = frozenset({
    "camera", "camera-left-out", "camera-unusable", "dark-light", "emission-range", "emissivity-limited",
    "high-reflectance", "ignored-extensions", "lamp-without-area",
    "light-intensity", "light-placement", "light-range", "lit-model",
    "metallic-material", "missing-library", "no-bands", "no-diffuse-colour", "no-light", "no-material",
    "no-texture-coordinates", "reflectance-limited", "reflectance-range", "spectrum-length", "texture",
    "texture-averaged", "texture-limited", "translucent-one-sided", "translucent-range", "translucent-sum",
    "transparent-material", "unknown-material", "unreadable-texture",
})  # fmt: skip
"""Codes of findings about paint, lamps and cameras, on which form factors do not depend."""

_RANK = {"error": 0, "warning": 1, "note": 2}


@dataclass(frozen=True)
class Place:
    """Where a row of form factors belongs."""

    row: int
    patch: int
    surface: str
    face: int
    is_back: bool
    centre: tuple[float, float, float]
    row_sum: float

    def __str__(self) -> str:
        x, y, z = (round(c, 4) + 0.0 for c in self.centre)
        return f"{self.element} at ({x:g}, {y:g}, {z:g})"

    @property
    def element(self) -> str:
        """The patch by its number, surface and face."""
        back = "the back of " if self.is_back else ""
        return f"{back}patch {self.patch} of '{self.surface}', face {self.face}"


def examine(
    scene: Scene,
    *,
    enclosure: bool | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> list[Finding]:
    """Everything doubtful about a scene, worst first: what :meth:`radiosity.Scene.findings` tells, and a few rays.

    Rays find faces that look the wrong way, that lie within solids or right before others, and where light leaves a
    space that is nearly closed. They are left out where shapes are unsound, and above 200,000 faces.

    Args:
        scene: what is examined.
        enclosure: whether the surfaces should enclose a space; as the hints say by default.
        seed, threads, progress: of the rays, as in :func:`radiosity.solve`.
    """
    from radiosity import ray_tests  # noqa: PLC0415

    known = scene.findings(enclosure=enclosure)
    found = ray_tests.complete(scene, known, enclosure, seed=seed, threads=threads, progress=progress)
    return sorted(found, key=lambda finding: _RANK[finding.severity])


def of(factors: FormFactors, *, enclosure: bool | None = None) -> list[Finding]:
    """Everything doubtful about the geometry, worst first: what the shapes and what the factors tell.

    Args:
        factors: what was measured.
        enclosure: whether the patches should enclose a space, so that every row sums to 1; see :func:`is_enclosure`.
    """
    closed = is_enclosure(factors) if enclosure is None else enclosure
    blind = _blind(factors)
    shapes = factors.patches.scene.findings(enclosure=closed)
    if not closed and blind.all():
        # Perhaps a closed space that is looked at from outside.
        turned = factors.patches.scene.findings(enclosure=True)
        shapes += [finding for finding in turned if finding.code == "looking-outward"]
    found = [finding for finding in shapes if finding.code not in OPTICS]
    found += _seeing_nothing(factors, blind, closed)
    found += _turned(factors, blind)
    if closed:
        found += _deviations(factors, blind)
    return sorted(found, key=lambda finding: _RANK[finding.severity])


def is_enclosure(factors: FormFactors) -> bool:
    """Whether the patches are meant to enclose a space, as their file says, or do so by their row sums."""
    hint = factors.patches.scene.hints.get("enclosure")
    return bool(hint) if hint is not None else mean_closure(factors) > CLOSED


def mean_closure(factors: FormFactors) -> float:
    """Mean row sum by area; sides of two-sided patches that see nothing do not count."""
    closure = factors.closure()
    area = np.where((closure > 0) | ~_is_two_sided(factors), factors.area, 0.0)
    return float(np.average(closure, weights=area)) if np.any(area > 0) else 0.0


def farthest(factors: FormFactors) -> Place:
    """The row whose sum is farthest from 1; sides of two-sided patches that see nothing come last."""
    closure = factors.closure()
    deviation = np.where((closure == 0) & _is_two_sided(factors), -1.0, abs(closure - 1))
    return place(factors, int(np.argmax(deviation)))


def place(factors: FormFactors, row: int) -> Place:
    """Which patch and surface a row belongs to, where that is, and what the row sums to."""
    patches, patch = factors.patches, int(factors.patch[row])
    x, y, z = map(float, patches.centre[patch])
    name = patches.scene.surfaces[int(patches.surface[patch])].name
    is_back = row >= len(patches)
    row_sum = float(factors.row(row).sum())
    return Place(row, patch, name, int(patches.face[patch]), is_back, (x, y, z), row_sum)


def allowed_deviation(factors: FormFactors) -> float:
    """What a row sum may be off before the geometry is blamed and not the method."""
    report = factors.report
    if report.method == "monte_carlo" and report.samples:
        # A row of F takes n hits of n rays, so that the variance of its sum is 1/n at most; five standard deviations.
        return max(LEAST_DEVIATION, 5 / float(np.sqrt(report.samples)))
    return max(LEAST_DEVIATION, 10 * (report.tolerance or 0.0), 3 * report.estimated_error)


def _is_two_sided(factors: FormFactors) -> npt.NDArray[np.bool_]:
    """(n,) whether the patch of each row has another row for its other side."""
    return np.asarray(factors.patches.two_sided[factors.patch])


def _blind(factors: FormFactors) -> npt.NDArray[np.bool_]:
    """(n_patches,) which patches see nothing from any side."""
    return np.asarray(np.bincount(factors.patch, factors.closure(), len(factors.patches)) == 0)


def _seeing_nothing(factors: FormFactors, blind: npt.NDArray[np.bool_], closed: bool) -> list[Finding]:
    """One finding for each surface that is blind as a whole, and one for each other that is in part."""
    patches = factors.patches
    if len(patches) == 1 or not blind.any():
        return []
    # In an open scene a surface may well look away from all others.
    severity: Literal["note", "warning"] = "warning" if closed or blind.all() else "note"
    if blind.all():
        message = (
            "no patch sees another; if they should, reverse the order of their corners so that normals face inward"
        )
        return [Finding(severity, "sees-nothing", "", message)]
    names = [surface.name for surface in patches.scene.surfaces]
    found = []
    for k in np.unique(patches.surface[blind]):
        own = np.flatnonzero(patches.surface == k)
        lost = own[blind[own]]
        if len(lost) == len(own):
            element = f"surface '{names[k]}'"
            message = "it sees nothing: its normals may be inverted; reverse the order of its corners if they are"
        else:
            first = place(factors, int(lost[0]))
            element = f"surface '{names[k]}', face {first.face}"
            message = (
                f"{len(lost):,} of its {len(own):,} patches see nothing, first {first}: their normals may be "
                "inverted, or they lie behind another face"
            )
        found.append(Finding(severity, "sees-nothing", element, message))
    return found


def _turned(factors: FormFactors, blind: npt.NDArray[np.bool_]) -> list[Finding]:
    """Patches that see little where their neighbours are enclosed."""
    patches = factors.patches
    best = np.zeros(len(patches))
    np.maximum.at(best, factors.patch, factors.closure())
    around = _of_neighbours(patches.polygons, best)
    suspects = np.flatnonzero((best + allowed_deviation(factors) < 0.5) & ~blind & (around > ENCLOSED))
    meaning = "its normal may be inverted, or a face lies right before it"
    found = []
    for i in suspects[:MOST_NAMED]:
        spot = place(factors, int(i))
        message = f"row sum {spot.row_sum:.4g} where those of its neighbours average {around[i]:.2g}: {meaning}"
        found.append(Finding("warning", "sees-little", str(spot), message))
    return found


def _of_neighbours(polygons: Floats, values: Floats) -> Floats:
    """(n,) mean of the values of what meets each patch at its corners, counted at each of them; 0 if nothing does."""
    n, corners = len(polygons), polygons.reshape(-1, 3)
    grain = 1e-6 * (float(np.ptp(corners, axis=0).max()) or 1.0)
    _, place_of = np.unique(np.round(corners / grain), axis=0, return_inverse=True)
    corner = place_of.reshape(n, 4)
    weight = np.ones((n, 4))
    weight[corner[:, 2] == corner[:, 3], 3] = 0.0
    own = weight * values[:, None]
    total, count = np.bincount(corner.ravel(), own.ravel()), np.bincount(corner.ravel(), weight.ravel())
    others = (weight * (total[corner] - own)).sum(axis=1)
    return np.asarray(others / np.maximum((weight * (count[corner] - weight)).sum(axis=1), 1))


def _deviations(factors: FormFactors, blind: npt.NDArray[np.bool_]) -> list[Finding]:
    """The patches of an enclosure whose rows do not sum to 1: what that means, and which they are, worst first."""
    off = factors.closure() - 1
    off[blind[factors.patch] | ((off == -1) & _is_two_sided(factors))] = 0.0
    limit = allowed_deviation(factors)
    black = "an obstruction or the back of a face" if factors.patches.scene.obstructions else "the back of a face"
    lost = f"there is a hole nearby, something stands on them, or they see {black}"
    return [
        *_named(factors, -off, "leak", f"sum to less than 1 by more than {limit:.1g}: {lost}"),
        *_named(factors, off, "excess", f"sum to more than 1 by more than {limit:.1g}: faces overlap or coincide"),
    ]


def _named(factors: FormFactors, deviation: Floats, code: str, meaning: str) -> list[Finding]:
    """How many rows deviate too much, and the worst of them by name."""
    order = np.argsort(-deviation, kind="stable")
    order = order[deviation[order] > allowed_deviation(factors)]
    if len(order) == 0:
        return []
    worst = [place(factors, int(row)) for row in order[:MOST_NAMED]]
    few = "these" if len(worst) == len(order) else f"the worst {MOST_NAMED}"
    summary = Finding("warning", code, "", f"{len(order):,} of {len(deviation):,} rows {meaning}; {few}:")
    return [summary, *(Finding("warning", code, str(spot), f"row sum {spot.row_sum:.4g}") for spot in worst)]
