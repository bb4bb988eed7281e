"""Two black plates face to face: their form factor and the heat between them, against the closed forms."""

import math
import sys
from pathlib import Path

import radiosity
from radiosity.picture import render, save_image

OUT = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
OUT.mkdir(parents=True, exist_ok=True)

SIGMA = 5.670374419e-8  # W/(m2 K4), Stefan and Boltzmann
HOT, WARM = SIGMA * 1000**4, SIGMA * 600**4  # exitance of black plates of 1000 K and 600 K, W/m2


def opposite_rectangles(x: float, y: float) -> float:
    """Form factor of directly opposed rectangles with sides x and y in units of their gap (Howell, C-11)."""
    a, b = math.sqrt(1 + x * x), math.sqrt(1 + y * y)
    logarithm = math.log(a * b / math.sqrt(1 + x * x + y * y))
    arcs = x * b * math.atan(x / b) + y * a * math.atan(y / a) - x * math.atan(x) - y * math.atan(y)
    return 2 / (math.pi * x * y) * (logarithm + arcs)


exact = opposite_rectangles(1.0, 1.0)  # 0.19982490

# One patch per plate: one form factor and two equations, B1 = E1 + rho1 f B2 and B2 = E2 + rho2 f B1.
grey = radiosity.scenes.two_plates(1, 1, 1, reflectance=(0.3, 0.6), emission=(HOT, WARM)).patches(as_is=True)
F = radiosity.form_factors(grey, rays=1 << 16)
f = F.row(0)[1]
print(f"form factor {f:.6f}, exact {exact:.6f}")
assert abs(f - exact) < 4 * math.sqrt(exact * (1 - exact) / (2 << 16))  # plain Monte Carlo does no worse
B = radiosity.solve(grey, transport=F).radiosity[:, 0]
assert math.isclose(B[0], (HOT + 0.3 * f * WARM) / (1 - 0.3 * 0.6 * f * f), rel_tol=1e-6)

# Many patches, black: the lower plate sends F E1 to the upper one, which sends E2 away.
patches = radiosity.scenes.two_plates(1, 1, 1, reflectance=(0, 0), emission=(HOT, WARM)).patches(max_edge=0.1)
solution = radiosity.solve(patches, accuracy=0.005)
warm = patches.surface == 1
net = patches.area[warm] @ (solution.irradiance - solution.emission)[warm, 0]
expected = exact * HOT - WARM
print(f"net heat of the warm plate {net:.0f} W, exact {expected:.0f} W")
assert abs(net - expected) < 4 * 0.005 * exact * HOT

view = radiosity.Camera.look_at([0.5, -1.2, 0.5], [0.5, 0.5, 0.5], up=(0, 0, 1))
image = render(solution, view, width=600, height=450, show="irradiance")
save_image(OUT / "two_plates.png", image, false_colours=True)
