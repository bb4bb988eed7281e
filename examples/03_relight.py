"""Day and evening from one exchange: rays are shot once, lamps are switched in the equations."""

import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity.picture import render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

scene = radiosity.scenes.furnished_room(1)
patches = scene.patches(count=4000)
solution = radiosity.solve(patches, accuracy=0.05)  # with everything on, so that every lamp is sampled well

everything = np.array([surface.emission for surface in scene.surfaces])  # (n_surfaces, n_bands)
window = np.array([surface.name == "window" for surface in scene.surfaces])[:, None]
day = solution.relight(emission=np.where(window, everything, 0.0))
evening = solution.relight(emission=np.where(window, 0.0, everything))
for name, answer in {"all": solution, "day": day, "evening": evening}.items():
    # Samples were shared out for everything on, so that a part of the light is known less well.
    print(f"{name:7} {answer.report.seconds:6.2f} s, estimated error {answer.report.estimated_error:.2%}")

# The equations are linear, and F is the same: light adds up. The solver stops at a residual, hence the tolerance.
difference = day.irradiance + evening.irradiance - solution.irradiance
assert np.abs(difference).max() < 1e-3 * solution.irradiance.mean()

for name, answer in {"day": day, "evening": evening}.items():
    image = render(answer, scene.cameras[0], width=600, height=400)
    save_image(OUT / f"room_{name}.png", image)
