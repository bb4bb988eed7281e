"""Images on surfaces: their means in the solve, themselves in pictures."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

import radiosity
from radiosity import Camera, PointLight, Scene, SceneError, Solution, Surface, Texture, path_irradiance, path_trace
from radiosity.files import load_lit
from radiosity.picture import render

DARK, LIGHT = 0.2, 0.8
UV = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
"""Of the corners of a quad, from its lower left on, so that the image stands upright."""


def chequers(squares: int, texels: int = 16) -> npt.NDArray[np.float64]:
    """(n, n) of two values, the upper left square dark."""
    y, x = np.indices((squares * texels, squares * texels)) // texels
    return np.where((x + y) % 2 == 0, DARK, LIGHT)


def quad(corner: npt.ArrayLike, u: npt.ArrayLike, v: npt.ArrayLike) -> npt.NDArray[np.float64]:
    c, u, v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    return np.array([c, c + u, c + u + v, c + v])


def room(floor: Surface) -> Scene:
    """A unit cube of grey walls with a lamp for a ceiling; the floor, which looks up along y, is the caller's."""
    o, x, y, z = np.zeros(3), np.eye(3)[0], np.eye(3)[1], np.eye(3)[2]
    walls = [quad(o, x, y), quad(z, y, x), quad(o, y, z), quad(x, z, y)]
    surfaces = [Surface(w, [[0, 1, 2, 3]], 0.5, name=f"wall {k}") for k, w in enumerate(walls)]
    lamp = Surface(quad(y, x, z), [[0, 1, 2, 3]], 0.5, 1.0, name="lamp")
    return Scene([floor, *surfaces, lamp], name="room")


FLOOR = quad([0, 0, 1], [1, 0, 0], [0, 0, -1])
ABOVE = Camera.look_at((0.5, 0.9, 0.5), (0.5, 0.0, 0.5), up=(0, 0, -1), vertical_fov=math.radians(45))


def textured_floor(image: npt.NDArray[np.float64], reflectance: npt.ArrayLike = 1 - 1e-9) -> Surface:
    return Surface(FLOOR, [[0, 1, 2, 3]], reflectance, name="floor", texture=Texture(image, UV))


@pytest.fixture(scope="module")
def lit() -> Solution:
    """A floor of 4 by 4 squares on patches of which none is a square."""
    return radiosity.solve(room(textured_floor(chequers(4))).patches(max_edge=0.15), accuracy=0.02)


def seen_on_the_floor(width: int) -> npt.NDArray[np.float64]:
    """(width, width, 2) x and z of what the centres of pixels show from above."""
    at = 0.9 * math.tan(math.radians(22.5)) * (2 * (np.arange(width) + 0.5) / width - 1)
    x, z = np.meshgrid(0.5 + at, 0.5 + at)
    return np.stack([x, z], axis=-1)


def squares_seen(width: int, squares: int = 4) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Which pixels are well within a dark square, and which within a light one."""
    place = squares * seen_on_the_floor(width)
    inner = np.all(np.abs(place - np.floor(place) - 0.5) < 0.4, axis=-1)
    is_dark = np.floor(place).sum(axis=-1) % 2 == 0
    return inner & is_dark, inner & ~is_dark


def test_the_means_over_the_patches_of_a_face_have_the_mean_of_its_image(lit: Solution) -> None:
    on = lit.patches.surface == 0
    rho, area = lit.patches.reflectance[on, 0], lit.patches.area[on]
    assert len(rho) > 30
    assert rho.min() < DARK + 0.1
    assert rho.max() > LIGHT - 0.1
    # Exact but for the rounding of texels and of their factor to single precision.
    assert area @ rho / area.sum() == pytest.approx((DARK + LIGHT) / 2, rel=1e-6)


def test_a_fine_texture_lights_as_its_mean_does() -> None:
    # Every patch covers whole squares, so that its mean is that of the paint.
    both = [textured_floor(chequers(16)), Surface(FLOOR, [[0, 1, 2, 3]], (DARK + LIGHT) / 2, name="floor")]
    fine, plain = (radiosity.solve(room(floor).patches(max_edge=0.25), accuracy=0.05) for floor in both)
    np.testing.assert_allclose(fine.patches.reflectance, plain.patches.reflectance, rtol=1e-6)
    np.testing.assert_allclose(fine.irradiance, plain.irradiance, rtol=1e-6)
    assert fine.report.estimated_error == pytest.approx(plain.report.estimated_error, rel=1e-4)


def test_smooth_pictures_show_the_texture_at_every_point(lit: Solution) -> None:
    size = {"width": 64, "height": 64, "samples": 1}
    radiance, irradiance = render(lit, ABOVE, **size), render(lit, ABOVE, show="irradiance", **size)
    rho = math.pi * radiance[..., 0] / irradiance[..., 0]
    dark, light = squares_seen(64)
    assert dark.sum() > 300
    # The rays are the same, so that what is left is rounding to single precision.
    np.testing.assert_allclose(rho[dark], DARK, rtol=1e-5)
    np.testing.assert_allclose(rho[light], LIGHT, rtol=1e-5)


def test_patches_show_one_colour_each(lit: Solution) -> None:
    image = render(lit, ABOVE, mode="patches", width=64, height=64, samples=1)
    floor = lit.radiosity[lit.patches.surface == 0, 0] / math.pi
    assert len(np.unique(image)) <= len(floor)


@pytest.mark.parametrize("mode", ["gather", "path"])
def test_traced_pictures_show_light_and_dark_squares(lit: Solution, mode: str) -> None:
    image = render(lit, ABOVE, mode=mode, width=48, height=48, samples=64)[..., 0]
    dark, light = squares_seen(48)
    # Light on both is the same by symmetry; the noise of some 500 pixels of 64 paths is well below 2 %.
    assert image[light].mean() / image[dark].mean() == pytest.approx(LIGHT / DARK, rel=0.02)
    # What arrives is what the solution says, to its 2 %.
    on = lit.patches.surface == 0
    inner = on & np.all(np.abs(lit.patches.centre[:, [0, 2]] - 0.5) < 0.37, axis=1)
    arrives = np.average(lit.irradiance[inner, 0], weights=lit.patches.area[inner])
    assert math.pi * image[light].mean() / LIGHT == pytest.approx(arrives, rel=0.03)


def test_paths_are_reflected_by_texels_as_by_tiles() -> None:
    """The same floor as an image and as tiles of their own paint lights the room the same."""
    corners = [(i, j) for i in range(2) for j in range(2)]
    squares = [quad([i / 2, 0, (j + 1) / 2], [0.5, 0, 0], [0, 0, -0.5]) for i, j in corners]
    paints = [LIGHT if (i + j) % 2 else DARK for i, j in corners]
    tiles = [Surface(square, [[0, 1, 2, 3]], paint) for square, paint in zip(squares, paints, strict=True)]
    image = room(textured_floor(chequers(2, 256)))
    plain = room(tiles[0])
    plain.surfaces[1:1] = tiles[1:]
    # On the walls just above tiles of both kinds.
    points = [[0.25, 0.05, 0.001], [0.75, 0.05, 0.001], [0.999, 0.05, 0.25], [0.999, 0.05, 0.75]]
    normals = [[0, 0, 1], [0, 0, 1], [-1, 0, 0], [-1, 0, 0]]
    one, other = (path_irradiance(s, points, normals, samples=1 << 14, seed=k) for k, s in enumerate((image, plain)))
    deviation = (one.irradiance - other.irradiance) / np.hypot(one.error, other.error)
    assert np.abs(deviation).max() < 4
    assert one.irradiance[1, 0] > one.irradiance[0, 0] + 10 * one.error[0, 0]  # the upper right tile is light


def test_a_texture_is_seen_in_a_mirror() -> None:
    scene = room(textured_floor(chequers(4)))
    ceiling = scene.surfaces[-1]
    ceiling.specular, ceiling.reflectance, ceiling.emission = 1.0, 0.0, 0.0
    scene.lights = [PointLight((0.5, 0.5, 0.5), 1.0)]
    solution = radiosity.solve(scene.patches(max_edge=0.2), accuracy=0.05)
    up = Camera.look_at((0.5, 0.1, 0.5), (0.5, 1.0, 0.5), up=(0, 0, -1), vertical_fov=math.radians(10))
    # The floor is 1.9 m away by the mirror, and the picture covers the middle 0.33 m of it: parts of four squares.
    size = {"width": 33, "height": 33}
    for mode, samples, rel in (("smooth", 1, 0.02), ("gather", 256, 0.05), ("path", 256, 0.05)):
        image = render(solution, up, mode=mode, samples=samples, **size)[..., 0]
        one, other = image[4:12, 4:12].mean(), image[4:12, -12:-4].mean()
        assert max(one, other) / min(one, other) == pytest.approx(LIGHT / DARK, rel=rel), mode


def test_other_paint_covers_a_texture_and_other_lamps_do_not(lit: Solution) -> None:
    size = {"width": 32, "height": 32, "samples": 1}
    painted = lit.relight(reflectance=0.5)
    image = math.pi * render(painted, ABOVE, **size) / render(painted, ABOVE, show="irradiance", **size)
    np.testing.assert_allclose(image, 0.5, rtol=1e-5)
    dimmed = lit.relight(emission=0.5 * lit.emission)
    np.testing.assert_allclose(render(dimmed, ABOVE, **size), 0.5 * render(lit, ABOVE, **size), rtol=1e-4)


def test_both_sides_of_a_sheet_show_the_texture() -> None:
    scene = room(Surface(FLOOR, [[0, 1, 2, 3]], 0.5, 1.0))
    sheet = replace(textured_floor(chequers(4)), vertices=FLOOR + np.array([0, 0.5, 0]), two_sided=True, name="sheet")
    scene.surfaces.append(sheet)
    solution = radiosity.solve(scene.patches(max_edge=0.3), accuracy=0.1)
    below = Camera.look_at((0.5, 0.01, 0.5), (0.5, 0.5, 0.5), up=(0, 0, -1), vertical_fov=math.radians(40))
    size = {"width": 40, "height": 40, "samples": 1}
    rho = math.pi * render(solution, below, **size) / render(solution, below, show="irradiance", **size)
    assert all(np.isclose(rho, value, rtol=1e-4).sum() > 500 for value in (DARK, LIGHT))
    # Square by square, from below: the picture covers 0.36 m, its middle is a corner of four squares.
    assert rho[10, 10, 0] == pytest.approx(rho[30, 30, 0])
    assert rho[10, 10, 0] * rho[10, 30, 0] == pytest.approx(DARK * LIGHT, rel=1e-4)


def test_a_mesh_of_the_engines_own_has_the_means() -> None:
    solution = radiosity.solve(room(textured_floor(chequers(2))), accuracy=0.1)
    on = solution.patches.surface == 0
    area, rho = solution.patches.area[on], solution.reflectance[on, 0]
    assert np.ptp(rho) > 0.5
    assert area @ rho / area.sum() == pytest.approx((DARK + LIGHT) / 2, rel=1e-6)
    np.testing.assert_allclose(
        solution.radiosity, solution.emission + solution.reflectance * solution.irradiance, rtol=1e-9
    )


def test_colours_need_three_bands_and_make_them() -> None:
    colours = np.zeros((2, 2, 3), np.uint8)
    colours[..., 0] = 128
    scene = room(textured_floor(colours))
    assert scene.bands == ["R", "G", "B"]
    # IEC 61966-2-1: 128 is 21.6 % of white.
    np.testing.assert_allclose(scene.patches(as_is=True).reflectance[0], [0.2158605, 0, 0], rtol=1e-6)
    spectral = replace(scene, bands=["a", "b"])
    with pytest.raises(SceneError, match="surface 'floor': its texture has 3 channels for 2 bands"):
        spectral.validate()
    with pytest.raises(SceneError, match="3 channels for 2 bands"):
        spectral.patches(as_is=True)._textures_in(np.zeros((6, 2)))


@pytest.mark.parametrize(
    ("image", "uv", "wrap", "message"),
    [
        (np.zeros((2, 2)), UV[:, :1], "repeat", r"uv must have shape \(n_vertices, 2\)"),
        (np.zeros((2, 2)), [[0, 0], [0, np.nan]], "repeat", "coordinate 1 is not finite"),
        (np.zeros((2, 2, 4)), UV, "repeat", r"shape \(height, width, 1 or 3\), not \[2, 2, 4\]"),
        (np.zeros((0, 2)), UV, "repeat", "shape"),
        (np.zeros(2), UV, "repeat", "shape"),
        (np.full((2, 2), 1.5), UV, "repeat", r"lie in \[0, 1\]"),
        (np.full((2, 2), np.nan), UV, "repeat", r"lie in \[0, 1\]"),
        (np.zeros((2, 2), np.int64), UV, "repeat", "uint8 or floats"),
        (np.zeros((2, 2)), UV, "wrap", "there is no wrap mode 'wrap'"),
        (np.zeros((2, 2)), UV, ("clamp",), "one mode or two"),
    ],
)
def test_unsound_textures_are_refused(image: object, uv: object, wrap: object, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Texture(image, uv, wrap)  # type: ignore[arg-type]


def test_every_vertex_needs_a_place() -> None:
    with pytest.raises(SceneError, match="surface 'floor': its texture has 3 coordinates for 4 vertices"):
        Surface(FLOOR, [[0, 1, 2, 3]], name="floor", texture=Texture(np.zeros((2, 2)), UV[:3]))


def test_wrap_modes_and_values_are_kept() -> None:
    texture = Texture(chequers(2, 1), UV, ("clamp", "mirror"))
    again = replace(texture, wrap="repeat")
    assert texture._raster.wrap == ("clamp", "mirror")
    assert again._raster.wrap == ("repeat", "repeat")
    np.testing.assert_allclose(again.values()[..., 0], [[DARK, LIGHT], [LIGHT, DARK]], rtol=1e-7)


def png(pixels: npt.NDArray[np.uint8]) -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG")
    return file.getvalue()


def write_gltf(path: Path, pixels: npt.NDArray[np.uint8]) -> None:
    """A square of a paint with an image on it, clamped and mirrored at its edges, that glows faintly."""
    arrays = [
        np.array(FLOOR, "<f4").tobytes(), (2 * UV - 0.5).astype("<f4").tobytes(),
        np.array([0, 1, 2, 0, 2, 3], "<u4").tobytes(),
    ]  # fmt: skip
    starts = np.cumsum([0, *map(len, arrays)])
    kinds = [(5126, "VEC3", 4), (5126, "VEC2", 4), (5125, "SCALAR", 6)]
    path.with_name("squares.png").write_bytes(png(pixels))
    path.with_name("floor.bin").write_bytes(b"".join(arrays))
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "floor"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"name": "tiles", "emissiveFactor": [0.1, 0.1, 0.1], "pbrMetallicRoughness": {
            "baseColorFactor": [0.9, 0.8, 0.7, 1], "metallicFactor": 0, "baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0, "sampler": 0}], "images": [{"uri": "squares.png"}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "buffers": [{"uri": "floor.bin", "byteLength": int(starts[-1])}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(s), "byteLength": len(a)} for s, a in zip(starts[:-1], arrays, strict=True)
        ],
        "accessors": [
            {"bufferView": k, "componentType": c, "type": t, "count": n} for k, (c, t, n) in enumerate(kinds)
        ],
    }  # fmt: skip
    path.write_text(json.dumps(gltf))


def test_a_texture_from_a_file_is_the_one_from_arrays(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 240, (6, 9, 3), dtype=np.uint8)
    write_gltf(tmp_path / "floor.gltf", pixels)
    loaded = radiosity.load(tmp_path / "floor.gltf")
    assert loaded.findings() == []
    texture = Texture(pixels, 2 * UV - 0.5, ("clamp", "mirror"))
    faces = [[0, 1, 2], [0, 2, 3]]
    paint = np.float32([0.9, 0.8, 0.7]).astype(float)
    built = Scene([Surface(FLOOR, faces, paint, math.pi * float(np.float32(0.1)), "floor", texture=texture)])
    one, other = (s.patches(max_edge=0.2) for s in (loaded, built))
    np.testing.assert_array_equal(one.reflectance, other.reflectance)
    pictures = [render(radiosity.solve(p, accuracy=0.1), ABOVE, width=32, height=32) for p in (one, other)]
    assert pictures[0].tobytes() == pictures[1].tobytes()
    assert pictures[0].std() > 0


def test_a_saved_solution_keeps_the_reflectance_of_patches(lit: Solution, tmp_path: Path) -> None:
    lit.save(tmp_path / "lit.npz")
    with np.load(tmp_path / "lit.npz") as arrays:
        np.testing.assert_array_equal(arrays["reflectance"], lit.patches.reflectance)
    lit.save(tmp_path / "lit.glb")
    model = load_lit(tmp_path / "lit.glb")
    assert model is not None
    # Pictures of it show the means.
    rho = model._reflectance[lit.patches.surface == 0, 0]
    np.testing.assert_allclose(rho, lit.reflectance[lit.patches.surface == 0, 0], rtol=1e-4)


def test_path_tracing_takes_scenes_patches_and_solutions(lit: Solution) -> None:
    size = {"width": 8, "height": 8, "samples": 8}
    from_patches, from_solution = (path_trace(s, ABOVE, **size).image for s in (lit.patches, lit))
    np.testing.assert_array_equal(from_patches, from_solution)
    scene = path_trace(lit.patches.scene, ABOVE, **size).image
    assert abs(scene.mean() / from_patches.mean() - 1) < 0.2  # other random numbers
