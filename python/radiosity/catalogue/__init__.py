"""Configuration factors in closed form: a catalogue with sources, in numpy alone.

    >>> from radiosity import catalogue
    >>> catalogue.coaxial_disks(radius_1=1.0, radius_2=[1.0, 2.0], gap=1.0)
    array([0.38196601, 0.76393202])
    >>> for entry in catalogue.find("sphere to disk"):
    ...     print(entry)

Each function is one configuration. It says from what to what its factor F_12 goes, takes keyword arguments in metres
and radians that broadcast against each other, and names its entry in Howell's catalogue (J. R. Howell, A Catalog of
Radiation Heat Transfer Configuration Factors, thermalradiation.net) and who derived it. Surfaces are diffuse, nothing
stands between them unless said, and A_1 F_12 = A_2 F_21 gives the way back.
"""

from __future__ import annotations

from radiosity.catalogue.coaxial_cylinders import (
    annular_end_to_other_end,
    inner_cylinder_to_annular_end,
    outer_cylinder_to_annular_end,
    outer_cylinder_to_inner,
    outer_cylinder_to_itself,
)
from radiosity.catalogue.cones import (
    frustum_base_to_side,
    frustum_side_to_base,
    frustum_side_to_itself,
    frustum_to_attached_frustum,
)
from radiosity.catalogue.cylinder_interior import (
    cylinder_base_to_side,
    cylinder_disk_to_side,
    cylinder_point_to_side,
    cylinder_ring_to_disk,
    cylinder_ring_to_side,
    cylinder_section_to_disk,
    cylinder_section_to_section,
    cylinder_side_to_base,
    cylinder_side_to_itself,
)
from radiosity.catalogue.disks import coaxial_disks, coaxial_rings, disks_in_a_sphere, half_disks_with_common_diameter
from radiosity.catalogue.long_cylinders import (
    long_outer_cylinder_to_inner,
    long_outer_cylinder_to_itself,
    parallel_cylinders,
    plane_to_tube_row,
    strip_to_cylinder,
)
from radiosity.catalogue.points import (
    point_to_cylinder,
    point_to_infinite_strip,
    point_to_parallel_disk,
    point_to_parallel_rectangle,
    point_to_perpendicular_disk,
    point_to_perpendicular_rectangle,
    point_to_polygon,
    point_to_sphere,
    point_to_tilted_rectangle,
    tilted_point_to_disk,
)
from radiosity.catalogue.rectangles import (
    coaxial_squares,
    equal_parallel_rectangles,
    hinged_rectangles,
    parallel_rectangles,
    perpendicular_rectangles,
    perpendicular_rectangles_with_common_edge,
    tilted_plane_to_ground,
)
from radiosity.catalogue.registry import REGISTERED, Configuration
from radiosity.catalogue.spheres import (
    cap_to_base,
    outer_sphere_to_inner,
    outer_sphere_to_itself,
    sphere_patches,
    sphere_to_cylinder,
    sphere_to_disk,
    sphere_to_polygon,
    sphere_to_rectangle,
)
from radiosity.catalogue.strips import (
    coaxial_strips,
    crossed_strings,
    equal_parallel_strips,
    parallel_strips,
    segments,
    strips_at_angle,
    strips_with_common_edge,
    triangular_duct,
)

__all__ = [
    "CONFIGURATIONS",
    "Configuration",
    "annular_end_to_other_end",
    "cap_to_base",
    "coaxial_disks",
    "coaxial_rings",
    "coaxial_squares",
    "coaxial_strips",
    "crossed_strings",
    "cylinder_base_to_side",
    "cylinder_disk_to_side",
    "cylinder_point_to_side",
    "cylinder_ring_to_disk",
    "cylinder_ring_to_side",
    "cylinder_section_to_disk",
    "cylinder_section_to_section",
    "cylinder_side_to_base",
    "cylinder_side_to_itself",
    "disks_in_a_sphere",
    "equal_parallel_rectangles",
    "equal_parallel_strips",
    "find",
    "frustum_base_to_side",
    "frustum_side_to_base",
    "frustum_side_to_itself",
    "frustum_to_attached_frustum",
    "half_disks_with_common_diameter",
    "hinged_rectangles",
    "inner_cylinder_to_annular_end",
    "long_outer_cylinder_to_inner",
    "long_outer_cylinder_to_itself",
    "outer_cylinder_to_annular_end",
    "outer_cylinder_to_inner",
    "outer_cylinder_to_itself",
    "outer_sphere_to_inner",
    "outer_sphere_to_itself",
    "parallel_cylinders",
    "parallel_rectangles",
    "parallel_strips",
    "perpendicular_rectangles",
    "perpendicular_rectangles_with_common_edge",
    "plane_to_tube_row",
    "point_to_cylinder",
    "point_to_infinite_strip",
    "point_to_parallel_disk",
    "point_to_parallel_rectangle",
    "point_to_perpendicular_disk",
    "point_to_perpendicular_rectangle",
    "point_to_polygon",
    "point_to_sphere",
    "point_to_tilted_rectangle",
    "segments",
    "sphere_patches",
    "sphere_to_cylinder",
    "sphere_to_disk",
    "sphere_to_polygon",
    "sphere_to_rectangle",
    "strip_to_cylinder",
    "strips_at_angle",
    "strips_with_common_edge",
    "tilted_plane_to_ground",
    "tilted_point_to_disk",
    "triangular_duct",
]

CONFIGURATIONS: tuple[Configuration, ...] = tuple(sorted(REGISTERED, key=lambda entry: entry.name))
"""All entries, by the names of their functions."""


def find(text: str) -> tuple[Configuration, ...]:
    """The entries whose number, name or title has all the words of a text, in any case.

    Args:
        text: such as "disk", "parallel strip" or "C-14".
    """
    words = text.lower().split()
    return tuple(entry for entry in CONFIGURATIONS if all(word in str(entry).lower() for word in words))
