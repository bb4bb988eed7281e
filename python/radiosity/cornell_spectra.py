"""The measured spectra of the Cornell box.

Cornell University Program of Computer Graphics, *Cornell Box Data*,
https://www.graphics.cornell.edu/online/box/data.html: reflectances measured every 4 nm from 400 to 700 nm, and the
light's emission at four wavelengths.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from radiosity import _native
from radiosity.scene import Scene

Floats = npt.NDArray[np.float64]

WAVELENGTHS: Floats = np.arange(400.0, 701.0, 4.0)
"""(76,) nm."""

# Thousandths, ten wavelengths a line.
_WHITE = """
343 445 551 624 665 687 708 723 715 710
745 758 739 767 777 765 751 745 748 729
745 757 753 750 746 747 735 732 739 734
725 721 733 725 732 743 744 748 728 716
733 726 713 740 754 764 752 736 734 741
740 732 745 755 751 744 731 733 744 731
712 708 729 730 727 707 703 729 750 760
751 739 724 730 740 737
"""
_GREEN = """
 92  96  98  97  98  95  95  97  95  94
 97  98  96 101 103 104 107 109 112 115
125 140 160 187 229 285 343 390 435 464
472 476 481 462 447 441 426 406 373 347
337 314 285 277 266 250 230 207 186 171
160 148 141 136 130 126 123 121 122 119
114 115 117 117 118 120 122 128 132 139
144 146 150 152 157 159
"""
_RED = """
 40  46  48  53  49  50  53  55  57  56
 59  57  61  61  60  62  62  62  61  62
 60  59  57  58  58  58  56  55  56  59
 57  55  59  59  58  59  61  61  63  63
 67  68  72  80  90  99 124 154 192 255
287 349 402 443 487 513 558 584 620 606
609 651 612 610 650 638 627 620 630 628
642 639 657 639 635 642
"""

LAMP = 0.78
"""Reflectance of the lamp at all wavelengths."""


def _measured(thousandths: str) -> Floats:
    return np.array(thousandths.split(), dtype=np.float64) / 1000


REFLECTANCE: dict[str, Floats] = {"white": _measured(_WHITE), "green": _measured(_GREEN), "red": _measured(_RED)}
"""(76,) measured reflectance of each paint, by the name of the material."""

RADIANCE: Floats = np.interp(WAVELENGTHS, [400.0, 500.0, 600.0, 700.0], [0.0, 8.0, 15.6, 18.4])
"""(76,) of the lamp, interpolated; relative, and taken here for W/(m2 sr nm)."""


def cornell_box_spectral(bands: int = 76) -> Scene:
    """The Cornell box with its measured coordinates and measured spectra, 400 to 700 nm, in equal bands.

    Values of a band are means over the measured wavelengths in it, emission is W/m2/nm, and the band has the name of
    its middle, such as "406 nm", so that pictures are developed through the eye of the standard observer.

    Args:
        bands: a divisor of the 76 measured wavelengths: 76 bands of 4 nm, 38 of 8, 19 of 16, or 4, 2 or 1.

    Raises:
        ValueError: another number.
    """
    if bands < 1 or len(WAVELENGTHS) % bands:
        raise ValueError(f"bands must divide the {len(WAVELENGTHS)} measured wavelengths, and {bands} does not")
    scene = Scene._from_native(_native.builtin("cornell_box_original", [], []))
    for surface in scene.surfaces:
        is_lamp = surface.material == "light"
        surface.reflectance = np.full(bands, LAMP) if is_lamp else binned(REFLECTANCE[surface.material], bands)
        surface.emission = np.pi * binned(RADIANCE, bands) if is_lamp else np.zeros(bands)
    middles = binned(WAVELENGTHS, bands)
    names = [f"{middle:g} nm" for middle in middles]
    return Scene(scene.surfaces, cameras=scene.cameras, name="Cornell box, spectral", bands=names)


def binned(values: Floats, bands: int) -> Floats:
    """(bands,) means over as many equal parts of the (76,) measured wavelengths."""
    return np.asarray(values.reshape(bands, -1).mean(axis=1))
