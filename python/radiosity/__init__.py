"""The equilibrium of diffuse light and heat, to the accuracy you ask for.

    >>> import radiosity
    >>> scene = radiosity.scenes.cornell_box()
    >>> solution = radiosity.solve(scene, accuracy=0.02)
    >>> print(solution.report)

Lengths are metres, emission is radiant exitance in W/m2 per band, ``F[i, j]`` is the form factor from i to j.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from radiosity import catalogue, diagnosis, scenes, teaching, viewer
    from radiosity._native import ResourceError, SceneError, __version__
    from radiosity.certificate import Certificate
    from radiosity.factors import FormFactors, form_factors
    from radiosity.inverse import Design, Emission, Reflectance, Strength, Target, design
    from radiosity.patches import Patches
    from radiosity.path_tracing import PathIrradiance, PathTraced, path_irradiance, path_trace
    from radiosity.report import Report
    from radiosity.scene import Camera, DirectionalLight, Finding, PointLight, Scene, SpotLight, Surface, load
    from radiosity.sensitivity import Sensitivity
    from radiosity.snapshot import Snapshot
    from radiosity.solution import Solution, solve
    from radiosity.surface_factors import SurfaceFactors
    from radiosity.texture import Texture

__all__ = [
    "Camera",
    "Certificate",
    "Design",
    "DirectionalLight",
    "Emission",
    "Finding",
    "FormFactors",
    "Patches",
    "PathIrradiance",
    "PathTraced",
    "PointLight",
    "Reflectance",
    "Report",
    "ResourceError",
    "Scene",
    "SceneError",
    "Sensitivity",
    "Snapshot",
    "Solution",
    "SpotLight",
    "Strength",
    "Surface",
    "SurfaceFactors",
    "Target",
    "Texture",
    "__version__",
    "catalogue",
    "design",
    "diagnosis",
    "form_factors",
    "load",
    "path_irradiance",
    "path_trace",
    "scenes",
    "solve",
    "teaching",
    "viewer",
]

# Names are imported when first used: scipy alone takes longer to import than `radiosity --help` may take in all.
_HOME = {
    "Certificate": "certificate",
    "ResourceError": "_native",
    "SceneError": "_native",
    "__version__": "_native",
    "FormFactors": "factors",
    "form_factors": "factors",
    "Design": "inverse",
    "Emission": "inverse",
    "Reflectance": "inverse",
    "Strength": "inverse",
    "Target": "inverse",
    "design": "inverse",
    "Patches": "patches",
    "PathIrradiance": "path_tracing",
    "PathTraced": "path_tracing",
    "path_irradiance": "path_tracing",
    "path_trace": "path_tracing",
    "Report": "report",
    "Camera": "scene",
    "DirectionalLight": "scene",
    "Finding": "scene",
    "PointLight": "scene",
    "Scene": "scene",
    "SpotLight": "scene",
    "Surface": "scene",
    "load": "scene",
    "Sensitivity": "sensitivity",
    "Snapshot": "snapshot",
    "Solution": "solution",
    "solve": "solution",
    "SurfaceFactors": "surface_factors",
    "Texture": "texture",
}
_MODULES = {
    "adaptive",
    "catalogue",
    "certificate",
    "colour",
    "comparison",
    "diagnosis",
    "direct",
    "factors",
    "files",
    "inverse",
    "patches",
    "path_tracing",
    "picture",
    "report",
    "scene",
    "scenes",
    "sensitivity",
    "snapshot",
    "shooting",
    "solution",
    "surface_factors",
    "teaching",
    "texture",
    "viewer",
}


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"radiosity.{name}")
    if name not in _HOME:
        raise AttributeError(f"module 'radiosity' has no attribute '{name}'")
    value = getattr(importlib.import_module(f"radiosity.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
