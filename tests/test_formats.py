"""Files of shapes without light, and what only blocks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from known import ADJACENT, CUBE, HATCH, INWARD, OPPOSITE, VIEW3D_CUBE, Runner, cube, square

from radiosity import Scene, SceneError, Surface, _native, form_factors, load, solve

SCENES = Path(__file__).parents[1] / "scenes"
QUAD = [[0, 1, 2, 3]]

RAYS = 1 << 16
FOUR_SIGMA = 4 * 0.5 / RAYS**0.5
"""Four standard errors of a factor by independent rays, at worst; quasi-random ones do better."""


def plates(screen: list[Surface]) -> Scene:
    """Two unit squares that face each other at unit distance, and what is between them."""
    lower, upper = Surface(square(), QUAD, name="lower"), Surface(square(z=1.0)[::-1], QUAD, name="upper")
    return Scene([lower, upper], obstructions=screen)


def test_obstructions_block_and_have_no_patches() -> None:
    screen = Surface(square(2.0, z=0.5), QUAD, name="screen")
    open_plates, closed = plates([]).patches(as_is=True), plates([screen]).patches(as_is=True)
    assert form_factors(open_plates, rays=RAYS).toarray()[0, 1] == pytest.approx(OPPOSITE, abs=FOUR_SIGMA)
    assert len(closed) == 2
    assert form_factors(closed, rays=RAYS).toarray() == pytest.approx(np.zeros((2, 2)))


def test_half_a_screen_hides_what_symmetry_says() -> None:
    # A wide screen between the plates up to their middle hides half of them by symmetry: a ray and its mirror image
    # cross the middle plane on either side.
    half = Surface([[-5, -5, 0.5], [0, -5, 0.5], [0, 5, 0.5], [-5, 5, 0.5]], QUAD)
    factors = form_factors(plates([half]).patches(as_is=True), rays=RAYS).toarray()
    assert factors[0, 1] == pytest.approx(OPPOSITE / 2, abs=FOUR_SIGMA)


@pytest.mark.parametrize("cut", [{"as_is": True}, {"count": 100}, {"max_edge": 0.2}])
def test_obstructions_cross_every_meshing(cut: dict[str, float]) -> None:
    triangle = Surface([[0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5]], [[0, 1, 2]])
    scene = plates([triangle])
    assert scene.obstructions[0].name == "obstruction 0"
    patches = scene.patches(**cut)
    corners = np.array(triangle.vertices)
    assert np.array_equal(patches.obstructions, [corners[[0, 1, 2, 2]]])
    assert patches.surface.max() == 1
    again = _native.Patches(patches.polygons, patches.surface, patches.face, patches.two_sided, patches.obstructions)
    assert np.array_equal(again.obstructions, patches.obstructions)
    assert plates([]).patches(**cut).obstructions.shape == (0, 4, 3)


def test_obstructions_cross_the_border_both_ways() -> None:
    scene = plates([Surface(square(z=0.5), QUAD, name="screen")])
    scene.combined = {1: 0}
    again = Scene._from_native(scene._native())
    assert [s.name for s in again.obstructions] == ["screen"]
    assert np.array_equal(again.obstructions[0].vertices, scene.obstructions[0].vertices)
    assert again.combined == {1: 0}
    assert "1 obstructions" in repr(scene)


def test_unsound_obstructions_are_refused() -> None:
    bent = Surface([[0, 0, 0], [1, 0, 0], [1, 1, 0.3], [0, 1, 0]], QUAD, name="sail")
    with pytest.raises(SceneError, match=r"obstruction 'sail', face 0: the corners of the quad lie .* off their plane"):
        plates([bent]).patches(as_is=True)
    with pytest.raises(ValueError, match="obstructions: polygon 0 has a corner that is not finite"):
        patches = plates([]).patches(as_is=True)._native
        broken = np.full((1, 4, 3), np.nan)
        _native.Patches(patches.polygons, patches.surface, patches.face, patches.two_sided, broken)


def test_light_stops_at_obstructions() -> None:
    lamp, floor = Surface(square(z=1.0)[::-1], QUAD, 0.0, 1.0), Surface(square(), QUAD, 0.0)
    screen = Surface(square(2.0, z=0.5), QUAD)
    dark = solve(Scene([lamp, floor], obstructions=[screen]).patches(as_is=True), accuracy=0.05)
    assert dark.irradiance[1, 0] == 0


def test_closed_samples_close() -> None:
    for name in ("corner.stl", "corner.ply"):
        scene = load(SCENES / name)
        patches = scene.patches(max_edge=0.5)
        assert not patches.two_sided.any()
        closure = form_factors(patches, rays=1 << 14).closure()
        assert closure == pytest.approx(np.ones(len(patches)), abs=2 * FOUR_SIGMA)
        assert patches.area.sum() == pytest.approx(14.0)
        assert load(SCENES / name, unit="cm").patches(as_is=True).area.sum() == pytest.approx(14e-4)


def test_the_cube_of_view3d_has_its_factors(tmp_path: Path) -> None:
    (tmp_path / "cube.vs3").write_text(VIEW3D_CUBE)
    scene = load(tmp_path / "cube.vs3")
    assert [s.name for s in scene.surfaces] == ["zeq0", "xeq0", "yeq0", "zeq1", "xeq1", "yeq1"]
    assert scene.surfaces[0].reflectance == [0.5]
    assert scene.hints == {"tolerance": pytest.approx(1e-3), "enclosure": True, "row": 3}
    factors = form_factors(scene.patches(as_is=True), rays=RAYS)
    exact = np.full((6, 6), ADJACENT)
    exact[np.arange(6), np.arange(6)], exact[np.arange(6), (np.arange(6) + 3) % 6] = 0, OPPOSITE
    assert factors.toarray() == pytest.approx(exact, abs=FOUR_SIGMA)
    assert factors.closure() == pytest.approx(np.ones(6), abs=FOUR_SIGMA)


def test_what_view3d_separates_means_the_same(tmp_path: Path) -> None:
    """A subsurface takes area and factors from its base: F of the base is that of its remainder, and all add up."""
    (tmp_path / "hatch.vs3").write_text(HATCH)
    patches = load(tmp_path / "hatch.vs3").patches(as_is=True)
    area = np.bincount(patches.surface, patches.area)
    assert area == pytest.approx([0.75, 1, 1, 1, 1, 1, 0.25])
    exchange = form_factors(patches, rays=RAYS).toarray() * patches.area[:, None]
    member = np.eye(7)[patches.surface]
    between = member.T @ exchange @ member
    assert between[[0, 6]][:, [0, 6]] == pytest.approx(np.zeros((2, 2)))
    assert between[0, 3] + between[6, 3] == pytest.approx(OPPOSITE, abs=FOUR_SIGMA)
    assert between[0].sum() == pytest.approx(0.75, abs=FOUR_SIGMA)


def test_the_sample_of_view3d_is_read() -> None:
    scene = load(SCENES / "room.vs3")
    assert scene.combined == {2: 1}
    assert [s.name for s in scene.obstructions] == ["table"]
    patches = scene.patches(as_is=True)
    factors = form_factors(patches).toarray()
    # The table hides part of the floor, and nobody else sees less than everything.
    assert np.all(factors.sum(axis=1) < 1 + 1e-9)
    plate, floor = patches.surface == 8, patches.surface == 0
    assert factors[plate][:, floor] == pytest.approx(0)
    assert factors[floor].sum() < 1 - 0.01


def test_enclosures_are_checked_where_asked(run: Runner) -> None:
    open_cube = cube()
    open_cube.surfaces.pop()
    assert "open-edges" not in [f.code for f in open_cube.findings()]
    assert "open-edges" in [f.code for f in open_cube.findings(enclosure=True)]
    open_cube.hints["enclosure"] = True
    assert "open-edges" in [f.code for f in open_cube.findings()]
    assert "open-edges" not in [f.code for f in open_cube.findings(enclosure=False)]

    study = SCENES / "study.obj"
    asked, plain = (json.loads(run("check", study, "--json", *more).stdout) for more in (["--enclosure"], []))
    # The study is closed: what has one face only are rims of things in it.
    assert "open-rims" in [f["code"] for f in asked["findings"]]
    assert plain["findings"] == []


def test_a_surface_turned_inside_out_is_noticed() -> None:
    faces = [list(face) for face in INWARD.values()]
    faces[2].reverse()
    found = Scene([Surface(CUBE, faces, name="cube")]).findings()
    assert "mixed-winding" in [f.code for f in found]


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("cut.stl", b"x" * 80 + b"\xff\xff\xff\xff" + b"\0" * 50, "ends after 1 of 4294967295 triangles"),
        ("nan.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
         b"end_header\n1 nan 2\n", "vertex 0: its coordinates are not three finite numbers"),
        ("flat.vs3", b"F 2\nV 1 0 0\n", "line 1: the file describes a 2-D geometry"),
        ("mask.vs3", b"V 1 0 0 0\nV 2 1 0 0\nV 3 0 1 0\nS 1 1 2 3 0 0 0 .5 a\nM 2 3 2 1 0 1 0 .5 b\n",
         "line 5: masking surfaces are not modelled"),
    ],
)  # fmt: skip
def test_damaged_files_exit_with_3(run: Runner, tmp_path: Path, name: str, content: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(content)
    done = run("factors", name, "-o", "F.npz")
    assert done.returncode == 3
    assert done.stderr.startswith(f"radiosity: {name}: ")
    assert words in done.stderr
    assert len(done.stderr.splitlines()) == 1
