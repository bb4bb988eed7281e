"""Watching light arrive: energy placed against work by four solvers, and pictures after a few shots.

Progressive refinement (Cohen, Chen, Wallace and Greenberg 1988) shoots from the patch with most unshot light. A shot is
one row of the form factors, so as many shots as there are patches are as much work as one product, which is what Jacobi
needs for one bounce and Gauss-Seidel for one sweep.
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import radiosity
from radiosity.files import LitModel
from radiosity.picture import render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

patches = radiosity.scenes.cornell_box().patches(count=1000)
n = len(patches)
F = radiosity.form_factors(patches, hemicubes=16, resolution=256, method="hemicube")
area, rho, emission = patches.area, patches.reflectance, patches.emission
emitted = area @ emission.sum(axis=1)
whole = radiosity.solve(patches, transport=F)
total = area @ whole.radiosity.sum(axis=1)

# Work in rows read: n a product, one a shot.
ROWS = {"southwell": 1, "overshooting": 1, "gauss_seidel": n, "jacobi": n}
NAMES = {"southwell": "Southwell", "overshooting": "Southwell, overshooting", "gauss_seidel": "Gauss-Seidel"}
SHOTS = (0, 9, 30, 120, 1000)
placed: dict[str, list[tuple[int, float]]] = {name: [] for name in ROWS}
guessed: list[tuple[int, float]] = []
shown: dict[int, radiosity.Snapshot] = {}


def look(snapshot: radiosity.Snapshot, name: str) -> bool:
    """Keep what is there; nobody waits for more than six products' worth."""
    before = n if name in ("gauss_seidel", "jacobi") else 0  # the first bounce
    rows = before + snapshot.iteration * ROWS[name]
    placed[name].append((rows, area @ snapshot.radiosity.sum(axis=1) / total))
    if name == "southwell":
        guessed.append((rows, area @ snapshot.with_ambient().sum(axis=1) / total))
        if snapshot.iteration in SHOTS:
            shown[snapshot.iteration] = snapshot
    return rows < 6 * n


for name in ROWS:
    report = radiosity.solve(patches, transport=F, solver=name, on_iterate=lambda s, name=name: look(s, name)).report
    share = np.interp([n // 10, n, 2 * n], *np.transpose(placed[name]), left=np.nan)
    print(f"{name:13} after {n // 10:4} rows {share[0]:6.1%}, {n} rows {share[1]:6.1%}, {2 * n} rows {share[2]:6.1%}")
    assert report.stop == "observer"

# What the first shots place follows from the form factors alone. The lamp is the only light: as many shots as it has
# patches send all it emits, and what arrives is reflected.
lamp = np.flatnonzero(emission.any(axis=1))
once = F @ emission  # exact for each patch by reciprocity
direct = area @ (emission + rho * once).sum(axis=1) / total
after_the_lamp = dict(placed["southwell"])[len(lamp)]
print(f"{len(lamp)} shots of the lamp: {after_the_lamp:.4%} of all light; emission and one bounce are {direct:.4%}")
assert np.isclose(after_the_lamp, direct, rtol=1e-12)

# A tenth of a product's work, and Southwell has placed more than Jacobi has with a whole one, which is that bounce.
assert np.interp(n // 10, *np.transpose(placed["southwell"])) > direct
# Power never shrinks as long as nothing is overshot.
assert all(b[1] >= a[1] for a, b in zip(placed["southwell"], placed["southwell"][1:], strict=False))

figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
for name, points in placed.items():
    style = {"marker": "o", "ls": "--"} if ROWS[name] == n else {}
    axes.plot(*np.transpose(points), label=NAMES.get(name, "Jacobi"), **style)
axes.plot(*np.transpose(guessed), ":", color="C0", label="Southwell with the ambient term")
axes.set(xscale="symlog", xlim=(0, 6 * n), xlabel=f"rows of form factors read, one a shot ({n} are a product)")
axes.set(ylim=(0.5, 1.15), ylabel="energy placed, as a share of all", title="Cornell box: light on its way")
axes.axhline(1, color="0.8", lw=0.8, zorder=0)
axes.legend(loc="lower right", frameon=False)
figure.savefig(OUT / "progressive_energy.png", dpi=120)

# Light arriving: above as it is, below with the ambient term. The last column is the solution.
model = LitModel.of(whole)


def picture(radiosity_now: np.ndarray) -> np.ndarray:
    """The view of the camera, patch by patch, all of them at one exposure."""
    linear = render(replace(model, radiosity=radiosity_now), width=200, height=200, samples=4, mode="patches")
    return np.clip(linear / exposure, 0, 1) ** (1 / 2.2)


exposure = np.quantile(render(model, width=200, height=200, samples=4, mode="patches"), 0.97)
figure, grid = plt.subplots(2, len(SHOTS) + 1, figsize=(12, 4.4), layout="constrained")
for column, k in enumerate(SHOTS):
    grid[0, column].imshow(picture(shown[k].radiosity))
    grid[1, column].imshow(picture(shown[k].with_ambient()))
    grid[0, column].set_title(f"{k} shots")
for row in range(2):
    grid[row, -1].imshow(picture(whole.radiosity))
grid[0, -1].set_title("solution")
grid[0, 0].set_ylabel("as it is")
grid[1, 0].set_ylabel("with ambient")
for axes in grid.flat:
    axes.set(xticks=[], yticks=[])
figure.savefig(OUT / "progressive_light.png", dpi=120)

# No matrix is needed: patches are drawn on hemicubes when they shoot, and only those that do.
quick = radiosity.solve(patches, solver="southwell", accuracy=0.1)
print(quick.report)
off = np.average((quick.irradiance - whole.irradiance) ** 2, weights=area, axis=0).mean() ** 0.5
assert off < 0.1 * np.average(whole.irradiance, weights=area, axis=0).mean()
save_image(OUT / "progressive_on_demand.png", render(quick, width=500, height=500))
