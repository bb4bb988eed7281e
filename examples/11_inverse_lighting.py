"""Inverse lighting: how bright 15 lamps must be, and how light a wall, so that every place has the light it needs.

The irradiance that is wanted goes in, lamps and paint come out. The search runs on derivatives of irradiance by all
that shines and reflects, which take one more solve a target; drawn on the room they show what light is worth where.
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import radiosity
from radiosity import Emission, Reflectance, Surface, Target
from radiosity.files import LitModel
from radiosity.picture import render

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

# A meeting room of 8 x 6 x 2.8 m, y up, in lumen and lux, with walls seen from inside.
X, Y, Z = 8.0, 2.8, 6.0
WARM, OAK, WHITE, BLUE = [1.15, 1.0, 0.85], [0.42, 0.3, 0.2], [0.8, 0.78, 0.74], [0.3, 0.42, 0.55]
corners = np.array([[x, y, z] for z in (0, Z) for y in (0, Y) for x in (0, X)])
shell = {
    "floor": ([0, 4, 5, 1], [0.3, 0.27, 0.24]), "ceiling": ([2, 3, 7, 6], WHITE), "end wall": ([0, 2, 6, 4], BLUE),
    "near wall": ([1, 5, 7, 3], WHITE), "left wall": ([4, 6, 7, 5], WHITE), "right wall": ([0, 1, 3, 2], WHITE),
}  # fmt: skip
surfaces = [Surface(corners, [face], rho, name=name) for name, (face, rho) in shell.items()]


def level(name: str, x: tuple, z: tuple, y: float, rho: list, **more: object) -> Surface:
    """A horizontal rectangle; it faces down if z falls."""
    flat = [[x[0], y, z[0]], [x[0], y, z[1]], [x[1], y, z[1]], [x[1], y, z[0]]]
    return Surface(flat, [[0, 1, 2, 3]], rho, name=name, **more)


def block(name: str, x: tuple, y: tuple, z: tuple, rho: list) -> Surface:
    """A box without a bottom."""
    points = [[i, j, k] for k in z for j in y for i in x]
    return Surface(points, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [2, 6, 7, 3]], rho, name=name)


hung = [[0.02, 1.0, 3.8], [0.02, 1.0, 2.2], [0.02, 2.0, 2.2], [0.02, 2.0, 3.8]]
surfaces += [
    level("table", (2.4, 5.6), (2.2, 3.8), 0.74, OAK, two_sided=True),
    level("desk", (0.3, 1.1), (4.0, 5.7), 0.74, WHITE, two_sided=True),
    Surface(hung, [[0, 1, 2, 3]], [0.75, 0.55, 0.3], name="painting"),
    block("foot 1", (2.8, 2.92), (0, 0.74), (2.6, 3.4), OAK),
    block("foot 2", (5.1, 5.22), (0, 0.74), (2.6, 3.4), OAK),
    block("cupboard", (0.6, 2.4), (0, 0.9), (0.02, 0.45), OAK),
    block("stool", (1.3, 1.7), (0, 0.45), (4.6, 5.0), BLUE),
]
SIDE = 0.3
places = {f"lamp {k}": (0.8 + 1.6 * (k // 3), 1.0 + 2.0 * (k % 3)) for k in range(15)}
for lamp, (x, z) in places.items():
    across, along = (x - SIDE / 2, x + SIDE / 2), (z + SIDE / 2, z - SIDE / 2)
    surfaces.append(level(lamp, across, along, Y - 0.02, [0.6] * 3))
eye = radiosity.Camera.look_at([7.7, 2.2, 5.5], [2.6, 0.95, 2.5], vertical_fov=np.radians(58))
room = radiosity.Scene(surfaces, cameras=[eye], name="meeting room")

# Lux that are wanted; lumen that a square metre of lamp may send; how light one wall may be painted. Saving power is
# worth a hundredth of the targets.
wanted = [Target("table", 300), Target("desk", 500), Target("painting", 150)]
variables = [Emission(lamp, (0, 50_000), tint=WARM) for lamp in places]
variables.append(Reflectance("right wall", (0.2, 0.85)))
found = radiosity.design(room.patches(max_edge=0.5), wanted, variables, economy=0.01, tolerance=0.02, accuracy=0.03)
print(found)
assert found.met

# The same lamps, all equal, and as bright as it takes to have nowhere less.
solution, patches = found.solution, found.solution.patches
is_lamp = np.isin(patches.surface, [k for k, s in enumerate(found.scene.surfaces) if s.name in places])
even = solution.relight(emission=np.where(is_lamp[:, None], WARM, 0.0))
least = max(target.value / even.sensitivity(target.surface).value.mean() for target in wanted)
even = even.relight(emission=least * even.emission)
powers = [patches.area[is_lamp] @ s.emission[is_lamp].mean(axis=1) for s in (even, solution)]
print(f"{powers[0]:.0f} lm if all lamps are alike, {powers[1]:.0f} lm as designed")
assert powers[1] < 0.75 * powers[0]

# Derivatives are what differences are: one lamp a tenth brighter.
owed = solution.sensitivity("desk")
brightest = max(places, key=lambda lamp: found.values[lamp])
on = patches.surface == [s.name for s in found.scene.surfaces].index(brightest)
more = solution.relight(emission=np.where(on[:, None], 1.1, 1.0) * solution.emission)
gained = (owed.weights * (more.irradiance - solution.irradiance)).sum(axis=0)
expected = 0.1 * (owed.emission * solution.emission)[on].sum(axis=0)
print(f"{brightest} a tenth brighter: the desk gains {gained.mean():.3f} lx, the derivative says {expected.mean():.3f}")
# The solver stops at a residual of 0.02 x 0.03 of the light.
assert np.allclose(gained, expected, atol=0.02 * 0.03 * owed.value.mean())

model = LitModel.of(solution)
lit = {"all lamps alike": LitModel.of(even), "as designed": model}
seen = {title: render(m, eye, width=720, height=450) for title, m in lit.items()}
white = 2 * np.quantile(seen["as designed"], 0.7)  # both developed alike, as film that saturates slowly
figure, axes = plt.subplots(2, 2, figsize=(12.5, 8), layout="constrained")
for axis, (title, image), power in zip(axes[0], seen.items(), powers, strict=True):
    axis.imshow((1 - np.exp(-image / white)) ** (1 / 2.2))
    axis.set(title=f"{title}: {power / 1000:.1f} klm", xticks=[], yticks=[])

# Seen from above: discs as large as the lamps are bright.
plan = axes[1, 0]
for name, colour in (("table", "#c9a27a"), ("desk", "#d9d5cc"), ("painting", "#d8a13c")):
    box = np.asarray(next(s.vertices for s in surfaces if s.name == name))[:, [0, 2]]
    low, size = box.min(axis=0), np.maximum(np.ptp(box, axis=0), 0.12)
    plan.add_patch(plt.Rectangle(low, *size, color=colour, zorder=0))
    outcome = next(o for o in found.outcomes if o.surface == name)
    label = f"{name}: {outcome.achieved:.0f} lx"
    # Beside the lamps: at the lower edge of the table, below the desk and the painting.
    x, z, align = (low[0] + 0.1, low[1] + 0.08, "bottom") if name == "table" else (0.15, low[1] - 0.06, "top")
    plan.text(x, z, label, va=align, weight="bold", fontsize=9)
xs, zs = np.transpose(list(places.values()))
lumens = np.array([found.values[lamp] for lamp in places]) * SIDE**2
plan.scatter(xs, zs, s=30, facecolors="none", edgecolors="0.6", lw=0.8)
plan.scatter(xs, zs, s=lumens / 8, color="#f5b301", alpha=0.75, edgecolors="#a87900")
for x, z, lumen in zip(xs, zs, lumens, strict=True):
    if lumen >= 1:
        plan.annotate(f"{lumen:.0f} lm", (x, z), (0, 17), textcoords="offset points", ha="center", fontsize=8)
plan.plot([0, X], [0, 0], color=plt.cm.gray(found.values["right wall"]), lw=6, solid_capstyle="butt")
plan.text(
    X / 2, 0.12, f"right wall: reflectance {found.values['right wall']:.2f}", ha="center", va="bottom", fontsize=8
)
plan.set(xlim=(0, X), ylim=(0, Z), aspect="equal", xticks=[], yticks=[], title="the lamps, from above")

worth = axes[1, 1]
both_sides = np.concatenate([owed.importance, owed.importance[patches.two_sided]])  # as a lit model has them
importance = render(replace(model, irradiance=both_sides), eye, width=720, height=450, show="irradiance")
shown = worth.imshow(np.log10(np.maximum(importance.mean(axis=2), 1e-4)), cmap="magma", vmin=-2.5, vmax=-0.5)
worth.set(title="what light is worth that leaves here, to the desk", xticks=[], yticks=[])
bar = figure.colorbar(shown, ax=worth, shrink=0.9, ticks=[-2.5, -2, -1.5, -1, -0.5])
bar.ax.set_yticklabels([f"{10.0**v:.3f}" for v in (-2.5, -2, -1.5, -1, -0.5)])
bar.set_label("lux on the desk for a lumen")
figure.savefig(OUT / "inverse_lighting.png", dpi=110)
