"""Rough metals: diffuse in the solve, with their lobes in traced pictures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

import radiosity
from radiosity import Camera, PointLight, Scene, SceneError, Surface
from radiosity.picture import render

FACE = [[0, 1, 2, 3]]
Floats = npt.NDArray[np.float64]


def quad(corner: npt.ArrayLike, u: npt.ArrayLike, v: npt.ArrayLike) -> Floats:
    c, u, v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    return np.array([c, c + u, c + u + v, c + v])


def smith(square: float, cosine: npt.ArrayLike) -> Floats:
    """Smith's auxiliary function, of the square of alpha and the cosine with the normal."""
    z = np.asarray(cosine, dtype=float) ** 2
    return np.asarray(0.5 * (np.sqrt(1 + square * (1 - z) / z) - 1))


def lobe(roughness: float, f0: float, view: Floats, light: Floats) -> Floats:
    """The BRDF of a rough metal for (..., 3) unit vectors, z along the normal (Walter et al. 2007, Heitz 2014)."""
    square = roughness**4
    half = light + view
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    density = square / (math.pi * ((half[..., 2] ** 2) * (square - 1) + 1) ** 2)

    fresnel = f0 + (1 - f0) * (1 - np.sum(view * half, axis=-1)) ** 5
    shadowing = 1 / (1 + smith(square, view[..., 2]) + smith(square, light[..., 2]))
    return density * shadowing * fresnel / (4 * view[..., 2] * light[..., 2])


def albedo(roughness: float, f0: float, view: npt.ArrayLike) -> float:
    """The part of even light that it reflects toward the view, by facets (Heitz 2018).

    What another facet is in the way of is reflected once more.
    """
    square, to_eye = roughness**4, np.asarray(view, dtype=float)
    u, angle = np.meshgrid((np.arange(1000) + 0.5) / 1000, 2 * math.pi * (np.arange(400) + 0.5) / 400)
    z = np.sqrt((1 - u) / (1 + (square - 1) * u))  # so that facets have the density D cos
    r = np.sqrt(1 - z**2)
    facet = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1)
    cosine = np.maximum(facet @ to_eye, 0)
    light = 2 * cosine[..., None] * facet - to_eye
    mine = 1 + smith(square, to_eye[2])
    with np.errstate(divide="ignore", invalid="ignore"):
        passes = np.where(light[..., 2] > 0, mine / (mine + smith(square, light[..., 2])), 0)
    fresnel = f0 + (1 - f0) * (1 - cosine) ** 5
    seen = cosine / (mine * to_eye[2] * z)
    return float(np.mean(seen * fresnel * (passes + (1 - passes) * f0)))


def lobe_albedo(roughness: float, f0: float, view: Floats) -> float:
    """What of that is the lobe's."""
    z, angle = np.meshgrid((np.arange(2000) + 0.5) / 2000, 2 * math.pi * (np.arange(400) + 0.5) / 400)
    r = np.sqrt(1 - z**2)
    light = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1)
    return float(2 * math.pi * np.mean(lobe(roughness, f0, view, light) * z))


def cube(floor: Surface, *, rho: float = 0.5, glow: float = 0.5) -> Scene:
    """A unit cube whose floor, which looks up along y, is the caller's."""
    o, x, y, z = np.zeros(3), np.eye(3)[0], np.eye(3)[1], np.eye(3)[2]
    others = [quad(o, x, y), quad(z, y, x), quad(o, y, z), quad(x, z, y), quad(y, x, z)]
    return Scene([floor, *(Surface(w, FACE, rho, glow, name=f"wall {k}") for k, w in enumerate(others))])


FLOOR = quad([0, 0, 1], [1, 0, 0], [0, 0, -1])
DOWN = Camera.look_at((0.5, 0.6, 0.5), (0.5, 0, 0.5), up=(0, 0, -1), vertical_fov=math.radians(1))
ASLANT = Camera.look_at((0.5, 0.4, 0.9), (0.5, 0, 0.5), vertical_fov=math.radians(1))


@pytest.mark.parametrize("mode", ["gather", "path"])
@pytest.mark.parametrize(("roughness", "camera", "view"), [
    (0.3, DOWN, (0, 0, 1)), (0.6, ASLANT, (math.sqrt(0.5), 0, math.sqrt(0.5))), (1.0, DOWN, (0, 0, 1)),
])  # fmt: skip
def test_a_metal_in_a_furnace_shows_the_albedo_of_its_lobe(
    mode: str, roughness: float, camera: Camera, view: tuple[float, float, float]
) -> None:
    # What emits 1 - rho has B = 1, whatever rho is.
    metal = Surface(FLOOR, FACE, 0.9, 0.1, metallic=1.0, roughness=roughness)
    solution = radiosity.solve(cube(metal).patches(max_edge=0.5), accuracy=0.01)
    np.testing.assert_allclose(solution.radiosity, 1, rtol=0.02)
    image = math.pi * render(solution, camera, mode=mode, width=8, height=8, samples=1024)
    # 64 pixels of 1024 paths, and the solve's 1 %.
    assert image.mean() == pytest.approx(0.1 + albedo(roughness, 0.9, view), rel=0.015)


def test_white_metal_loses_nothing() -> None:
    for roughness in (0.2, 0.7, 1.0):
        # The grid leaves out facets on edge.
        assert albedo(roughness, 1.0, (0.6, 0.0, 0.8)) == pytest.approx(1, abs=5e-3)


@pytest.mark.parametrize("roughness", [0.15, 0.4, 0.8])
@pytest.mark.parametrize("size", [0.02, 0.6])
def test_lamps_are_counted_once(roughness: float, size: float) -> None:
    """A lamp over a metal in a black room, found by points on it or by the lobe."""
    scene = cube(Surface(FLOOR, FACE, 0.9, metallic=1.0, roughness=roughness), rho=0.0, glow=0.0)
    corner = np.array([0.6 - size / 2, 0.9, 0.5 - size / 2])
    scene.surfaces.append(Surface(quad(corner, [size, 0, 0], [0, 0, size]), FACE, 0.0, 1.0, name="lamp"))
    eye = np.array([0.4, 0.5, 0.5])
    camera = Camera.look_at(eye, (0.5, 0, 0.5), up=(0, 1, 0.001), vertical_fov=math.radians(0.1))
    image = render(scene, camera, mode="path", width=16, height=16, samples=256)
    u, v = np.meshgrid(*2 * [(np.arange(400) + 0.5) / 400])
    to_lamp = corner + size * np.stack([u, 0 * u, v], axis=-1) - [0.5, 0, 0.5]
    distance = np.linalg.norm(to_lamp, axis=-1)
    light = (to_lamp / distance[..., None])[..., [0, 2, 1]]  # y is the normal here
    view = ((eye - [0.5, 0, 0.5]) / np.linalg.norm(eye - [0.5, 0, 0.5]))[[0, 2, 1]]
    lit = lobe(roughness, 0.9, view, light) * light[..., 2] ** 2 / distance**2 / math.pi
    expected = size**2 * float(np.mean(lit))
    # What leaves diffusely: irradiance by the albedo that the lobe lacks.
    arrives = size**2 * float(np.mean(light[..., 2] ** 2 / distance**2)) / math.pi
    expected += (albedo(roughness, 0.9, view) - lobe_albedo(roughness, 0.9, view)) * arrives / math.pi
    assert image.mean() == pytest.approx(expected, rel=0.02)


def test_a_part_that_is_no_metal_stays_paint() -> None:
    metal = Surface(FLOOR, FACE, 0.8, 0.2, metallic=0.5, roughness=0.5)
    image = math.pi * render(cube(metal), DOWN, mode="path", width=8, height=8, samples=1024)
    assert image.mean() == pytest.approx(0.2 + 0.5 * 0.8 + 0.5 * albedo(0.5, 0.8, (0, 0, 1)), rel=0.015)


def striped(floor: Surface) -> Scene:
    """A black room whose ceiling has glowing stripes."""
    scene = cube(floor, rho=0.0, glow=0.0)
    stripes = [Surface(quad([k / 8, 0.999, 0], [1 / 8, 0, 0], [0, 0, 1]), FACE, 0.0, float(k % 2)) for k in range(8)]
    return replace(scene, surfaces=[*scene.surfaces, *stripes])


WIDE = Camera.look_at((0.5, 0.3, 0.5), (0.5, 0, 0.5), up=(0, 0, -1), vertical_fov=math.radians(40))


def test_a_smooth_metal_is_a_mirror_and_a_rough_one_dull() -> None:
    size = {"width": 32, "height": 8, "mode": "path", "samples": 256}
    mirror = render(striped(Surface(FLOOR, FACE, 0.0, specular=0.9)), WIDE, **size)[..., 0]
    metals = {
        roughness: render(striped(Surface(FLOOR, FACE, 0.9, metallic=1.0, roughness=roughness)), WIDE, **size)[..., 0]
        for roughness in (0.0, 0.2, 0.5, 1.0)
    }
    # At 20 degrees and less from the normal Fresnel adds a millionth, and edges of stripes are 256 samples.
    assert np.abs(metals[0.0] - mirror).max() < 0.06 * mirror.max()
    assert metals[0.0].mean() == pytest.approx(mirror.mean(), rel=0.01)
    contrast = [float(np.ptp(image.mean(axis=0)) / image.mean()) for image in metals.values()]
    assert contrast == sorted(contrast, reverse=True)
    assert contrast[0] > 1.8
    assert contrast[-1] < 0.5


def test_highlights_of_lights_without_area_are_what_the_formula_says() -> None:
    light = np.array([0.8, 0.5, 0.5])
    scene = cube(Surface(FLOOR, FACE, 0.7, metallic=1.0, roughness=0.4), rho=0.0, glow=0.0)
    scene.lights = [PointLight(tuple(light), 3.0)]
    for eye in ((0.2, 0.5, 0.5), (0.35, 0.6, 0.8)):
        camera = Camera.look_at(eye, (0.5, 0, 0.5), up=(0, 1, 0.001), vertical_fov=math.radians(0.1))
        image = render(scene, camera, mode="path", width=4, height=4, samples=8)
        ways = [np.array(p) - [0.5, 0, 0.5] for p in (eye, light)]
        distance = float(np.linalg.norm(ways[1]))
        to_eye, to_light = ((w / np.linalg.norm(w))[[0, 2, 1]] for w in ways)  # y is the normal here
        arrives = 3.0 * to_light[2] / distance**2
        lacks = albedo(0.4, 0.7, to_eye) - lobe_albedo(0.4, 0.7, to_eye)
        expected = arrives * (float(lobe(0.4, 0.7, to_eye, to_light)) + lacks / math.pi)
        # The picture is a tenth of a degree wide.
        assert image.mean() == pytest.approx(expected, rel=0.01)


def test_gathered_and_traced_pictures_of_a_metal_agree() -> None:
    floor = Surface(FLOOR, FACE, [0.9, 0.6, 0.3], metallic=1.0, roughness=0.35)
    scene = replace(cube(floor, rho=0.5, glow=0.0), bands=["R", "G", "B"])
    scene.surfaces[5].emission = 1.0
    scene.surfaces[1].reflectance = [0.7, 0.1, 0.1]
    solution = radiosity.solve(scene.patches(max_edge=0.2), accuracy=0.02)
    size = {"width": 8, "height": 8, "samples": 512}
    gathered, traced = (render(solution, ASLANT, mode=mode, **size).mean(axis=(0, 1)) for mode in ("gather", "path"))
    # The solve's 2 %, and noise of 64 x 512 paths below 1 %.
    np.testing.assert_allclose(gathered, traced, rtol=0.03)
    plain = replace(scene, surfaces=[replace(floor, metallic=0.0), *scene.surfaces[1:]])
    paint = radiosity.solve(plain.patches(max_edge=0.2), accuracy=0.02)
    np.testing.assert_array_equal(paint.irradiance, solution.irradiance)


def test_a_metal_is_seen_in_a_mirror() -> None:
    metal = Surface(FLOOR, FACE, 0.9, 0.1, metallic=1.0, roughness=0.3)
    scene = cube(metal)
    scene.surfaces[5] = replace(scene.surfaces[5], specular=1.0, reflectance=0.0, emission=0.0)
    up = Camera.look_at((0.5, 0.4, 0.5), (0.5, 1, 0.5), up=(0, 0, -1), vertical_fov=math.radians(1))
    image = math.pi * render(scene, up, mode="path", width=8, height=8, samples=512)
    # All that glows has B = 1, and so has what is seen in the mirror.
    assert image.mean() == pytest.approx(0.1 + albedo(0.3, 0.9, (0, 0, 1)), rel=0.02)


@pytest.mark.parametrize(("field", "value"), [("metallic", 1.5), ("roughness", -0.1), ("roughness", math.nan)])
def test_parts_are_parts(field: str, value: float) -> None:
    scene = cube(replace(Surface(FLOOR, FACE, name="floor"), **{field: value}))
    with pytest.raises(SceneError, match=f"surface 'floor': its {field} is"):
        scene.validate()
