"""The equilibrium of diffuse light and heat, to the accuracy you ask for.

    >>> import radiosity
    >>> scene = radiosity.scenes.cornell_box()
    >>> solution = radiosity.solve(scene, accuracy=0.02)
    >>> print(solution.report)

Lengths are metres, emission is radiant exitance in W/m2 per band, ``F[i, j]`` is the form factor from i to j.
"""

from radiosity import scenes
from radiosity._native import ResourceError, SceneError, __version__
from radiosity.factors import FormFactors, form_factors
from radiosity.patches import Patches
from radiosity.report import Report
from radiosity.scene import Camera, DirectionalLight, Finding, PointLight, Scene, SpotLight, Surface, load
from radiosity.solution import Solution, solve

__all__ = [
    "Camera",
    "DirectionalLight",
    "Finding",
    "FormFactors",
    "Patches",
    "PointLight",
    "Report",
    "ResourceError",
    "Scene",
    "SceneError",
    "Solution",
    "SpotLight",
    "Surface",
    "__version__",
    "form_factors",
    "load",
    "scenes",
    "solve",
]
