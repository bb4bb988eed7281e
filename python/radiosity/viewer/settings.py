"""How a scene is to be solved and shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Unit = Literal["W/m2", "lux"]

ACCURACY = 0.02
"""The accuracy asked for where nobody says: what an eye can tell, in a fifth of the time that 1 % takes."""

PHOTOMETRIC = (".glb", ".gltf")
"""Scene files whose numbers are lux, and not W/m2."""


@dataclass(frozen=True)
class Settings:
    """What the user may say.

    Attributes:
        title: of the page.
        unit: what irradiance is in.
        is_layered: whether the light of each lamp is sent.
        accuracy, max_patches, threads, seed: as in :func:`radiosity.solve`.
    """

    title: str = "radiosity"
    unit: Unit = "W/m2"
    is_layered: bool = False
    accuracy: float = ACCURACY
    max_patches: int | None = None
    threads: int | None = None
    seed: int = 0
