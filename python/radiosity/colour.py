"""From bands to what the eye sees: linear sRGB and luminance."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Of linear sRGB, ITU-R BT.709."""

RGB_FROM_XYZ = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)
"""Linear sRGB (D65) from CIE 1931 XYZ, IEC 61966-2-1."""

# Amplitude, wavelength of the peak in nm, and 1 / standard deviation below and above it, 1/nm.
_LOBES = (
    ((1.056, 599.8, 0.0264, 0.0323), (0.362, 442.0, 0.0624, 0.0374), (-0.065, 501.1, 0.0490, 0.0382)),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)

_WAVELENGTH = re.compile(r"(\d+(?:\.\d+)?) ?nm")


def matching_functions(wavelengths: npt.ArrayLike) -> Floats:
    """(n, 3) CIE 1931 colour matching functions x, y, z at wavelengths in nm.

    By the fit of Wyman, Sloan and Shirley 2013, *Simple analytic approximations to the CIE XYZ color matching
    functions*, the sums of lobes of their section 2.2.
    """
    nm = np.asarray(wavelengths, dtype=np.float64)
    return np.stack([sum((_lobe(nm, *lobe) for lobe in lobes), np.zeros_like(nm)) for lobes in _LOBES], axis=-1)


def _lobe(nm: Floats, amplitude: float, peak: float, below: float, above: float) -> Floats:
    t = (nm - peak) * np.where(nm < peak, below, above)
    return np.asarray(amplitude * np.exp(-0.5 * t**2))


def to_rgb(image: npt.ArrayLike, wavelengths: npt.ArrayLike) -> npt.NDArray[Any]:
    """Linear sRGB of spectra.

    Args:
        image: (..., n) spectral density at the wavelengths, such as W/m2/sr/nm.
        wavelengths: (n,) nm, rising; the middles of bands that touch.

    Returns:
        (..., 3) in the type of the image, scaled so that a spectrum of 1 everywhere has luminance 1. Colours that no
        screen shows have negative parts.

    Raises:
        ValueError: the wavelengths do not rise, are not one per band, or none of them is visible.
    """
    values, nm = np.asarray(image), np.asarray(wavelengths, dtype=np.float64)
    if nm.ndim != 1 or values.shape[-1:] != nm.shape:
        raise ValueError(f"{nm.shape} wavelengths do not fit an image of shape {values.shape}")
    if (np.diff(nm) <= 0).any():
        raise ValueError("wavelengths must rise")
    weights = matching_functions(nm) * (np.gradient(nm) if len(nm) > 1 else np.ones(1))[:, None]
    if not weights[:, 1].sum() > 1e-3:
        raise ValueError("none of the wavelengths is visible")
    matrix = weights @ RGB_FROM_XYZ.T / weights[:, 1].sum()
    return np.asarray(values @ matrix.astype(values.dtype if values.dtype.kind == "f" else np.float64))


def wavelengths_of(bands: Sequence[str]) -> list[float] | None:
    """Wavelengths in nm where all bands are named by theirs, such as "400 nm"; else None."""
    found = [_WAVELENGTH.fullmatch(band) for band in bands]
    return [float(match[1]) for match in found if match] if found and all(found) else None


def developed(image: npt.NDArray[Any], bands: Sequence[str]) -> npt.NDArray[Any]:
    """(..., 3) linear sRGB of an image of any bands: wavelengths by the eye, others grey at their mean.

    Three bands that are not wavelengths are taken for red, green and blue.
    """
    wavelengths = wavelengths_of(bands)
    if wavelengths is not None:
        return to_rgb(image, wavelengths)
    return image if image.shape[-1] == 3 else np.repeat(image.mean(axis=-1, keepdims=True), 3, axis=-1)


def luminance(image: npt.NDArray[Any], bands: Sequence[str]) -> npt.NDArray[Any]:
    """(...) luminance of an image, in its unit: what a grey of the same luminance has in every band."""
    return np.asarray(developed(image, bands) @ LUMINANCE)
