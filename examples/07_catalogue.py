"""How black is a hole? Form factors in closed form, from the catalogue, and no mesh.

A cavity of one temperature looks blacker than its walls: what they reflect meets them again. What leaves its mouth, in
units of what a black body would send, is its apparent emissivity.
"""

import numpy as np

from radiosity import catalogue

emissivity = 0.5

# A hemisphere. All that the mouth sends meets the wall, so from the wall the share 1/2 goes out and 1/2 to itself.
wall_to_mouth = catalogue.cap_to_base(radius=1.0, height=1.0)
B = emissivity / (1 - (1 - emissivity) * (1 - wall_to_mouth))  # the same everywhere: B = eps + (1 - eps) F B
print(f"hemisphere: {B:.6f}")
assert np.isclose(B, 2 / 3, rtol=1e-14)  # 1 / (1 + (A_mouth / A_wall)(1 / eps - 1)), and the areas are as 1 to 2


def drilled_hole(depth: float, rings: int) -> float:
    """Apparent emissivity of a cylindrical hole of radius 1, its side cut into rings."""
    ends = np.linspace(0, depth, rings + 1)
    low, high = ends[:-1], ends[1:]  # from the bottom
    side = 2 * (high - low)  # areas over pi; the bottom and the mouth have 1
    F = np.zeros((rings + 1, rings + 1))
    F[:-1, :-1] = catalogue.cylinder_section_to_section(
        radius=1.0, section_1=(low[:, None], high[:, None]), section_2=(low, high)
    )
    F[:-1, -1] = catalogue.cylinder_section_to_disk(radius=1.0, section=(low, high))
    F[-1, :-1] = F[:-1, -1] * side
    to_mouth = np.append(
        catalogue.cylinder_section_to_disk(radius=1.0, section=(depth - high, depth - low)),
        catalogue.coaxial_disks(radius_1=1.0, radius_2=1.0, gap=depth),
    )
    assert np.allclose(F.sum(axis=1) + to_mouth, 1, atol=1e-12)  # the hole and its mouth are closed

    B = np.linalg.solve(np.eye(rings + 1) - (1 - emissivity) * F, np.full(rings + 1, emissivity))
    return float(np.append(side, 1.0) * to_mouth @ B)


for depth in (0.5, 1.0, 2.0, 4.0):
    coarse, fine, finest = (drilled_hole(depth, rings) for rings in (50, 100, 200))
    print(f"hole {depth} radii deep: {finest:.6f}, with half the rings {fine:.6f}")
    assert 3 < (fine - coarse) / (finest - fine) < 5  # second order in the width of the rings
    # Were B the same on the whole wall. By Cauchy-Schwarz in A (1 - rho F), uneven walls stay below.
    uniform = 1 / (1 + (1 / emissivity - 1) / (1 + 2 * depth))
    assert emissivity < finest < uniform

# The shallow limit is the flat bottom, and every entry says where it comes from.
assert np.isclose(drilled_hole(1e-6, 4), emissivity, atol=1e-5)
print(f"\n{len(catalogue.CONFIGURATIONS)} configurations; of coaxial ones:")
for entry in catalogue.find("coaxial"):
    print(f"  {entry}")
