"""Scenes from arrays and from files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from known import CUBE, INWARD, cube, square

from radiosity import (
    Camera,
    DirectionalLight,
    PointLight,
    Scene,
    SceneError,
    SpotLight,
    Surface,
    load,
    scenes,
    solve,
)

QUAD = [[0, 1, 2, 3]]


def irradiance_below(light: object, reflectance: float = 0.0) -> float:
    """Irradiance of a centimetre of black floor at the origin."""
    scene = Scene([Surface(square(0.01), QUAD, reflectance)], lights=[light])
    return float(solve(scene.patches(as_is=True)).irradiance[0, 0])


def test_a_point_light_obeys_the_inverse_square() -> None:
    assert irradiance_below(PointLight((0, 0, 2.0), 8.0)) == pytest.approx(8 / 2**2, rel=1e-3)


def test_a_spot_light_shines_within_its_cone_only() -> None:
    down = {"inner_angle": 0.1, "outer_angle": 0.2}
    assert irradiance_below(SpotLight((0, 0, 2.0), (0, 0, -1), 8.0, **down)) == pytest.approx(2.0, rel=1e-3)
    assert irradiance_below(SpotLight((0, 0, 2.0), (1, 0, -1), 8.0, **down)) == 0


def test_a_light_that_points_nowhere_is_refused() -> None:
    for light in (SpotLight((0, 0, 2), (0, 0, 0), 8.0, name="dud"), DirectionalLight((0, 0, math.nan), 5.0, "dud")):
        with pytest.raises(SceneError, match=r"light 'dud': its direction .* points nowhere"):
            irradiance_below(light)


def test_a_directional_light_obeys_the_cosine() -> None:
    slanted = (math.sin(1.0), 0, -math.cos(1.0))
    assert irradiance_below(DirectionalLight(slanted, 5.0)) == pytest.approx(5 * math.cos(1.0), rel=1e-6)
    assert irradiance_below(DirectionalLight((0, 0, 1), 5.0)) == 0


@pytest.mark.parametrize("reflectance", [0.25, [0.25], np.float64(0.25), np.full(3, 0.25), (0.25, 0.25, 0.25)])
def test_spectra_broadcast(reflectance: object) -> None:
    patches = Scene([Surface(square(), QUAD, reflectance, [1, 2, 3])]).patches(as_is=True)
    assert patches.reflectance.tolist() == [[0.25] * 3]
    assert patches.emission.tolist() == [[1, 2, 3]]
    assert patches.scene.bands == ["R", "G", "B"]


def test_bands_follow_the_longest_spectrum() -> None:
    assert Scene([Surface(square(), QUAD)]).bands == ["grey"]
    assert Scene([Surface(square(), QUAD, [0.1] * 5)]).bands == [f"band {k}" for k in range(1, 6)]
    assert Scene([Surface(square(), QUAD)], [PointLight((0, 0, 1), (1, 1, 1))]).bands == ["R", "G", "B"]


def test_a_spectrum_of_another_length_is_refused() -> None:
    scene = Scene([Surface(square(), QUAD, [0.5] * 3, [1.0, 1.0], "lamp")])
    with pytest.raises(SceneError, match=r"emission of surface 'lamp' has shape \(2,\).*one per band \(3\)"):
        scene.patches(as_is=True)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (square(), [[0.0, 1.0, 2.0]], "surface 'it': faces must be integers, not float64"),
        (square(), [0, 1, 2], r"surface 'it': faces must have shape \(m, 3\) or \(m, 4\), not \(3,\)"),
        (square(), [[0, 1]], r"faces must have shape .* not \(1, 2\)"),
        (np.zeros((4, 2)), QUAD, r"surface 'it': vertices must have shape \(n, 3\), not \(4, 2\)"),
    ],
)
def test_arrays_of_another_shape_are_refused_at_once(vertices: object, faces: object, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Surface(vertices, faces, name="it")


@pytest.mark.parametrize(
    ("surface", "code"),
    [
        (Surface(square(), [[0, 1, 2, 9]], 0.5, 1.0), "index-out-of-range"),
        (Surface([*square()[:3], [-0.5, 0.5, 0.3]], QUAD, 0.5, 1.0), "non-planar-face"),
        (Surface(square(), [[0, 2, 1, 3]], 0.5, 1.0), "non-convex-face"),
        (Surface([*square()[:3], [math.nan, 0.5, 0]], QUAD, 0.5, 1.0), "non-finite-vertex"),
        (Surface(square(), QUAD, 1.0, 1.0), "reflectance"),
        (Surface(square(), QUAD, -0.1, 1.0), "reflectance"),
        (Surface(square(), QUAD, 0.5, -1.0), "emission"),
        (Surface(square(), QUAD, 0.5, 0.0), "no-light"),
        (Surface([], [], 0.5, 1.0), "no-faces"),
    ],
)
def test_what_cannot_be_lit_is_an_error_and_refused(surface: Surface, code: str) -> None:
    scene = Scene([surface], name="wrong")
    errors = [f for f in scene.findings() if f.severity == "error"]
    assert any(code in f.code for f in errors), errors
    with pytest.raises(SceneError, match=r"^wrong: "):
        solve(scene)


def test_negative_indices_are_refused() -> None:
    with pytest.raises(SceneError, match="face 0: vertex index -1 is out of range"):
        Scene([Surface(square(), [[0, 1, 2, -1]], 0.5, 1.0)]).findings()


def test_findings_come_worst_first_and_name_their_element() -> None:
    loose = [*square(), [9.0, 9.0, 9.0]]
    scene = Scene([Surface(loose, QUAD, 0.99, 1.0, "mirror"), Surface(square(z=1), QUAD, 2.0, 0.0, "wall")])
    findings = scene.findings()
    ranks = [["error", "warning", "note"].index(f.severity) for f in findings]
    assert ranks == sorted(ranks)
    assert {0, 2} <= set(ranks)
    assert "wall" in findings[0].element
    assert str(findings[0]).startswith("error [")


def test_a_sound_scene_has_no_findings() -> None:
    assert cube().findings() == []


def test_nameless_surfaces_are_numbered() -> None:
    scene = Scene([Surface(square(), QUAD, name="floor"), Surface(square(z=1), QUAD)])
    assert [s.name for s in scene.surfaces] == ["floor", "surface 1"]


def test_a_camera_looks_where_it_is_told() -> None:
    camera = Camera.look_at((1, 2, 3), (1, 2, -7))
    assert camera.forward == (0, 0, -1)
    with pytest.raises(SceneError, match="coincide"):
        Camera.look_at((1, 2, 3), (1, 2, 3))


def test_cameras_are_kept() -> None:
    (camera,) = scenes.cornell_box().cameras
    # As published: position, direction, and the field of view of a 35 mm focal length on a 25 mm film.
    assert camera.position == pytest.approx((0.278, 0.273, -0.8))
    assert camera.forward == (0, 0, 1)
    assert camera.vertical_fov == pytest.approx(2 * math.atan(25 / 2 / 35))
    assert {type(v) for v in (camera.position, camera.forward, camera.up)} == {tuple}


@pytest.mark.parametrize(
    "make", [scenes.cornell_box, scenes.furnace, scenes.two_plates, *scenes.BUILTIN_SCENES.values()]
)
def test_built_in_scenes_can_be_lit(make: object) -> None:
    make().validate()


def test_two_plates_are_as_described() -> None:
    lower, upper = scenes.two_plates(2.0, 3.0, 0.5, reflectance=(0.1, 0.2), emission=(4.0, 5.0)).surfaces
    size = np.ptp(np.asarray(lower.vertices), axis=0)
    assert sorted(size) == [0, 2, 3]
    assert [lower.reflectance, upper.reflectance, lower.emission, upper.emission] == [[0.1], [0.2], [4.0], [5.0]]
    gap = np.asarray(upper.vertices).mean(axis=0) - np.asarray(lower.vertices).mean(axis=0)
    assert np.linalg.norm(gap) == pytest.approx(0.5)


def test_an_unknown_variant_is_refused() -> None:
    with pytest.raises(ValueError, match="choose rgb or original"):
        scenes.cornell_box("green")


OBJ = """mtllib room.mtl
o floor
usemtl white
""" + "".join(f"v {x} {y} {z}\n" for x, y, z in 1000 * CUBE) + "".join(
    "f " + " ".join(str(i + 1) for i in face) + "\n" for face in INWARD.values()
)  # fmt: skip


def write_obj(folder: Path) -> Path:
    (folder / "room.mtl").write_text("newmtl white\nKd 0.5 0.5 0.5\nKe 1 1 1\n")
    path = folder / "room.obj"
    path.write_text(OBJ)
    return path


def test_a_file_is_read_in_its_unit(tmp_path: Path) -> None:
    scene = load(write_obj(tmp_path), unit="mm", two_sided=False)
    patches = scene.patches(as_is=True)
    assert patches.area == pytest.approx(np.ones(6))
    assert not patches.two_sided.any()
    assert load(write_obj(tmp_path), unit="0.001").patches(as_is=True).area == pytest.approx(np.ones(6))
    assert load(write_obj(tmp_path), two_sided=True).patches(as_is=True).two_sided.all()


def test_a_missing_file_and_an_unknown_unit_say_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"none\.glb: the file does not exist; check the path"):
        load(tmp_path / "none.glb")
    with pytest.raises(ValueError, match="'furlong' is no unit of length"):
        load(write_obj(tmp_path), unit="furlong")


def mirror(**optics: object) -> Scene:
    """A lamp above a square of such optics."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    floor = Surface(square, [[0, 1, 2, 3]], name="floor", **optics)  # type: ignore[arg-type]
    lamp = Surface(square[::-1] + np.array([0.0, 0, 1]), [[0, 1, 2, 3]], 0.5, [1.0, 2.0, 3.0], "lamp")
    return Scene([floor, lamp])


def test_mirrors_and_glass_cross_the_border_and_back() -> None:
    scene = Scene._from_native(mirror(reflectance=0.2, specular=[0.3, 0.3, 0.3], transmittance=0.25)._native())
    assert (scene.surfaces[0].specular, scene.surfaces[0].transmittance) == (0.3, 0.25)
    patches = scene.patches(max_edge=0.5)
    np.testing.assert_array_equal(patches.specular, np.where(patches.surface == 0, 0.3, 0.0))
    np.testing.assert_array_equal(patches.transmittance, np.where(patches.surface == 0, 0.25, 0.0))
    assert patches.is_specular
    assert not mirror().patches(as_is=True).is_specular


@pytest.mark.parametrize(
    ("optics", "message"),
    [
        ({"specular": 0.5}, r"'floor': its reflectance 0\.5, specular 0\.5 .* must stay below 1"),
        ({"reflectance": 0.0, "specular": 0.8, "transmittance": 0.3}, "must stay below 1"),
        ({"reflectance": 0.0, "specular": 1.5}, r"its specular is 1\.5; it must be at least 0 and at most 1"),
        ({"reflectance": 0.0, "emission": 1.0, "specular": 1.0}, "nothing of it is left to emit"),
        ({"specular": [0.1, 0.2, 0.3]}, "specular of surface 'floor' differs between bands"),
        ({"transmittance": [0.1, 0.2]}, r"transmittance of surface 'floor' has shape \(2,\)"),
    ],
)
def test_impossible_mirrors_are_refused(optics: dict[str, object], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        mirror(**optics).validate()
