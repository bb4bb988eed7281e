"""What the page and the session say to each other: the one schema, from which ``viewer/src/messages.ts`` is written.

Messages are JSON objects with their name under "type"; blocks of numbers go as packets
(:mod:`radiosity.viewer.packet`), whose header is one of the two heads below.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

Spectrum = list[float]
"""A value per band."""

Triple = tuple[float, float, float]

VERSION = 1
"""Of the packets and messages; a page of another version says so."""

MOST_REFLECTANCE = 0.99
"""The most that paint may reflect: the closer to 1, the longer light takes to find its equilibrium."""


@dataclass(frozen=True)
class SurfaceHead:
    """A surface, by its index.

    Attributes:
        name, material: as in the file.
        reflectance: mean over its patches.
        emission: W/m2, mean over its patches, as solved.
        area: m2.
    """

    name: str
    material: str
    reflectance: Spectrum
    emission: Spectrum
    area: float


@dataclass(frozen=True)
class LampHead:
    """What is switched and dimmed together.

    Attributes:
        name: for the panel.
        surfaces, lights: indices of the emitting surfaces and of the lights without area.
    """

    name: str
    surfaces: list[int]
    lights: list[int]


@dataclass(frozen=True)
class CameraHead:
    """A viewpoint; position in metres, relative to the origin of the packet; angle in radians."""

    name: str
    position: Triple
    forward: Triple
    up: Triple
    vertical_fov: float


@dataclass(frozen=True)
class SceneHead:
    """The head of a packet with patches and the light on them.

    Arrays: polygons (n, 4, 3) f4, surface (n) u4, and those of :class:`LightHead`. A back is a patch of its own.

    Attributes:
        version: of packets and messages.
        title: what the page is called.
        bands: names.
        unit: "W/m2" or "lux": what irradiance is in.
        origin: metres, what positions are relative to.
        up: the axis that is up.
        surfaces, lamps, cameras: by index.
        is_layered: whether there is a layer of light for each lamp; else there is one for all of them.
        is_lit: whether there is light to show yet.
        is_field: whether light is linear over patches to the accuracy; else it is the means that are accurate.
        report: of the solve, as a dictionary; empty if there is none.
    """

    version: int
    title: str
    bands: list[str]
    unit: str
    origin: Triple
    up: Triple
    surfaces: list[SurfaceHead]
    lamps: list[LampHead]
    cameras: list[CameraHead]
    is_layered: bool
    is_lit: bool
    is_field: bool
    report: dict[str, Any]
    type: str = field(default="scene", init=False)


@dataclass(frozen=True)
class LightHead:
    """The head of a packet with other light on the same patches.

    Arrays, for l layers: emission, irradiance (l, n, bands) f4 W/m2; corner_irradiance (l, n, 4, bands) f4; error (n,
    bands) f4, of the light of all layers.

    Attributes:
        reflectance: of each surface.
        seconds: what finding it took.
        is_final: whether no better one follows by itself.
        report: as in the head of a scene.
    """

    reflectance: list[Spectrum]
    seconds: float
    is_final: bool
    report: dict[str, Any]
    type: str = field(default="light", init=False)


# From the page.


@dataclass(frozen=True)
class Relight:
    """Asks for the light with other paint and lamps; the latest one counts.

    Attributes:
        reflectance: of surfaces, by index as a string, 0 to 0.99; those left out are as in the scene. Both sides of a
            two-sided surface have the same paint: name either.
        lamps: what multiplies each lamp, per band, by index as a string; those left out shine as in the scene.
    """

    reflectance: dict[str, Spectrum]
    lamps: dict[str, Spectrum]
    type: str = field(default="relight", init=False)


@dataclass(frozen=True)
class Stop:
    """Ends the solve at hand; what was found so far stays."""

    type: str = field(default="stop", init=False)


# To the page.


@dataclass(frozen=True)
class Status:
    """What the session does.

    Attributes:
        stage: "shooting", "solving", "relighting", or "ready".
        done: the share of the stage that is done, 0 to 1; negative if unknown.
        can_relight: whether :class:`Relight` is understood now.
        text: the same for people.
    """

    stage: str
    done: float
    can_relight: bool
    text: str
    type: str = field(default="status", init=False)


@dataclass(frozen=True)
class Convergence:
    """One point of the plot of the error.

    Attributes:
        stage: "shooting": the error is the share of power that was not shot yet; "solving": it is the estimated error
            of irradiance, relative to its mean.
        seconds: since the session began.
        error: see stage.
        patches, iteration: of the mesh and of the solver.
        wanted: the accuracy asked for.
    """

    stage: str
    seconds: float
    error: float
    patches: int
    iteration: int
    wanted: float
    type: str = field(default="convergence", init=False)


@dataclass(frozen=True)
class Failed:
    """What could not be done, for people."""

    message: str
    type: str = field(default="failed", init=False)


def percent(share: float) -> str:
    """A share for people, in two digits: 3.9 %."""
    return f"{100 * share:.2g} %"


HEADS = (SceneHead, LightHead)
FROM_PAGE = (Relight, Stop)
TO_PAGE = (Status, Convergence, Failed)
