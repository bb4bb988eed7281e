"""The Cornell box: scene, patches, solution, picture; and where all the power goes."""

import math
import sys
from pathlib import Path

import numpy as np

import radiosity
from radiosity.picture import render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

scene = radiosity.scenes.cornell_box()
patches = scene.patches(count=5000)
solution = radiosity.solve(patches, accuracy=0.02)
report = solution.report
print(report)

# A Lambertian lamp of radiance L and area A sends pi L A.
radiance = np.array([17.0, 12.0, 4.0])  # W/(m2 sr)
sent = math.pi * radiance * 0.130 * 0.105
np.testing.assert_allclose(report.emitted, sent, rtol=1e-6)

# What is sent is absorbed, or leaves by the open front.
np.testing.assert_allclose(np.add(report.absorbed, report.escaped), sent, rtol=0.02)
assert report.reached

solution.save(OUT / "cornell_box.glb")
save_image(OUT / "cornell_box.png", render(solution, width=600, height=600))
