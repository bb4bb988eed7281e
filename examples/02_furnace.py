"""The furnace: in a closed room where everything glows alike, B = E / (1 - rho), and nothing can be seen.

All of a uniform B arrives again, whatever the shapes: H = B, so B = E + rho B.
"""

import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity.picture import render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

rho = np.array([0.5, 0.9, 0.99])  # a furnace for each band
E = np.array([1.0, 0.5, 0.1])
B = E / (1 - rho)

scene = radiosity.scenes.furnace(rho, E)
patches = scene.patches(count=1500)

# In a closed room the rows of F sum to 1. Rows that are sampled do so nearly; "exact" scales them until they do.
solution = radiosity.solve(patches, accuracy=0.05, closure="exact")
worst = np.abs(solution.radiosity / B - 1).max()
print(f"B = {solution.radiosity.mean(axis=0)}, exact {B}; worst patch off by {worst:.1e}")
assert worst < 1e-6

inside = radiosity.Camera.look_at([3.8, 2.8, 0.2], [1.5, 1.2, 2.5])
image = render(solution, inside, width=400, height=300, mode="patches", show="irradiance")
save_image(OUT / "furnace.png", image / B.astype(np.float32), exposure=-1.0, curve="linear")
