"""Surfaces that let light through diffusely: what they are made of, where they are followed, and where not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import radiosity
from radiosity import Scene, SceneError, Surface
from radiosity.choice import choose
from radiosity.files import LitModel, load_lit, passed_through
from radiosity.picture import render
from radiosity.viewer import rough
from radiosity.viewer.lit import Lit

QUAD = np.array([[0, 1, 2, 3]])


def quad(corner: Any, u: Any, v: Any, **optics: Any) -> Surface:
    c, u, v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    return Surface(np.array([c, c + u, c + u + v, c + v]), QUAD, **optics)


def screened(**paper: Any) -> Scene:
    """A lamp above a floor, and a sheet of paper between them."""
    return Scene([
        quad((-1, -1, 0), (2, 0, 0), (0, 2, 0), reflectance=0.5, name="floor"),
        quad((-0.5, -0.5, 1), (0, 1, 0), (1, 0, 0), emission=2.0, name="lamp"),
        quad((-1, -1, 0.5), (2, 0, 0), (0, 2, 0), name="paper", **{"reflectance": 0.2, **paper}),
    ], bands=["R", "G", "B"])  # fmt: skip


PAPER = [0.6, 0.4, 0.1]


def solved(**paper: Any) -> radiosity.Solution:
    return radiosity.solve(screened(**paper).patches(max_edge=0.5), accuracy=0.05, seed=1)


def test_what_passes_is_a_part_per_band_on_two_sides() -> None:
    scene = screened(diffuse_transmittance=PAPER)
    assert scene.surfaces[2].two_sided
    patches = scene.patches(as_is=True)
    assert patches.is_translucent
    np.testing.assert_array_equal(patches.diffuse_transmittance, [[0, 0, 0], [0, 0, 0], PAPER])
    again = Scene._from_native(scene._native())
    np.testing.assert_array_equal(again.surfaces[2].diffuse_transmittance, PAPER)
    assert again.surfaces[0].diffuse_transmittance == 0.0
    assert not screened().patches(as_is=True).is_translucent
    # The number of bands is that of the longest spectrum.
    sheet = quad((0, 0, 0), (1, 0, 0), (0, 1, 0), diffuse_transmittance=PAPER)
    assert Scene([sheet]).bands == ["R", "G", "B"]


@pytest.mark.parametrize(
    ("optics", "message"),
    [
        ({"diffuse_transmittance": [0.1, 0.8, 0.1]}, r"'paper': its reflectance 0\.2 and .* 0\.8 in band G make 1"),
        ({"diffuse_transmittance": -0.1}, r"its diffuse transmittance in band R is -0\.1"),
        ({"diffuse_transmittance": 0.3, "specular": 0.3, "transmittance": 0.3}, "must stay below 1"),
        ({"diffuse_transmittance": [0.1, 0.2]}, r"diffuse_transmittance of surface 'paper' has shape \(2,\)"),
    ],
)
def test_parts_of_more_than_a_whole_are_refused(optics: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        radiosity.solve(screened(**optics))


def test_a_sheet_without_a_back_is_refused() -> None:
    scene = screened(diffuse_transmittance=0.3)
    scene.surfaces[2].two_sided = False
    assert [f.code for f in scene.findings() if f.severity == "error"] == ["translucent-one-sided"]
    with pytest.raises(SceneError, match="make it two-sided"):
        radiosity.solve(scene.patches(as_is=True))


def test_light_gets_through_and_none_is_made() -> None:
    lit, dark = solved(diffuse_transmittance=PAPER), solved(two_sided=True)
    floor, paper = (lit.patches.surface == k for k in (0, 2))
    # The lamp is seen past the paper from nowhere near the middle.
    middle = floor & (np.linalg.norm(lit.patches.centre[:, :2], axis=1) < 0.5)
    assert (lit.irradiance[middle].mean(axis=0) > dark.irradiance[middle].mean(axis=0) + 0.02).all()
    share = lit.irradiance[middle].mean(axis=0)
    assert share[0] > share[1] > share[2]
    wanted = 0.2 * lit.irradiance + lit.patches.diffuse_transmittance * lit.back_irradiance
    np.testing.assert_allclose(lit.radiosity[paper], wanted[paper], rtol=1e-12)
    behind = 0.2 * lit.back_irradiance + lit.patches.diffuse_transmittance * lit.irradiance
    np.testing.assert_allclose(lit.back_radiosity[paper], behind[paper], rtol=1e-12)
    assert abs(lit.report.imbalance) < 0.05


def test_nothing_is_as_nothing() -> None:
    one, other = solved(two_sided=True), solved(two_sided=True, diffuse_transmittance=[0.0, 0.0, 0.0])
    for name in ("irradiance", "radiosity", "error", "back_irradiance", "back_error"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_the_same_seed_gives_the_same_bytes_on_any_number_of_threads() -> None:
    patches = screened(diffuse_transmittance=PAPER).patches(max_edge=0.5)
    one, two = (radiosity.solve(patches, accuracy=0.05, threads=n, seed=3) for n in (1, 3))
    np.testing.assert_array_equal(one.radiosity, two.radiosity)
    np.testing.assert_array_equal(one.error, two.error)
    size = {"width": 16, "height": 12, "samples": 8}
    pictures = [radiosity.path_trace(patches, threads=n, **size).image for n in (1, 3)]
    np.testing.assert_array_equal(*pictures)


@pytest.mark.parametrize("solver", ["jacobi", "gauss_seidel", "over_relaxation"])
def test_every_solver_of_samples_finds_the_same(solver: Any) -> None:
    patches = screened(diffuse_transmittance=PAPER).patches(max_edge=0.5)
    one, other = (radiosity.solve(patches, accuracy=0.05, seed=1, closure="exact", solver=s)
                  for s in ("conjugate_gradient", solver))  # fmt: skip
    assert one.report.converged and other.report.converged
    np.testing.assert_allclose(one.radiosity, other.radiosity, rtol=1e-6)
    few = radiosity.solve(patches, accuracy=0.05, seed=1, solver=solver, max_iterations=2)
    assert not few.report.converged
    assert few.report.limited_by == "solver"


def test_relights_keep_what_passes() -> None:
    lit = solved(diffuse_transmittance=PAPER)
    same = lit.relight()
    np.testing.assert_allclose(same.radiosity, lit.radiosity, rtol=1e-12)
    double = lit.relight(emission=2 * lit.emission)
    np.testing.assert_allclose(double.radiosity, 2 * lit.radiosity, rtol=1e-6)
    with pytest.raises(ValueError, match=r"reflectance 0\.7 and diffuse transmittance 0\.6 must together stay below 1"):
        lit.relight(reflectance=0.7)


def test_what_cannot_follow_it_says_so() -> None:
    scene = screened(diffuse_transmittance=PAPER)
    patches = scene.patches(max_edge=1.0)
    refusal = r"surface 'paper' lets light through diffusely, which .* cannot follow: solve with transport='sampled'"
    for method in ("auto", "monte_carlo", "hierarchical"):
        with pytest.raises(ValueError, match=refusal):
            radiosity.form_factors(patches, method=method)
    for options in ({"transport": "hierarchical"}, {"solver": "southwell"}, {"solver": "shooting"}):
        with pytest.raises(ValueError, match=refusal):
            radiosity.solve(patches, **options)  # type: ignore[arg-type]
    refusal = "surface 'paper' lets light through diffusely, which .* cannot follow: set its diffuse_transmittance to 0"
    with pytest.raises(ValueError, match=refusal):
        solved(diffuse_transmittance=PAPER).sensitivity("floor")
    with pytest.raises(ValueError, match="leave out focus"):
        radiosity.solve(scene, focus="floor")
    assert choose(patches, 0.01, 0) == ("sampled", "nothing else follows light through paper and leaves")


def test_files_and_pictures_have_it(tmp_path: Path) -> None:
    solution = solved(diffuse_transmittance=PAPER)
    solution.save(tmp_path / "paper.glb")
    lit = load_lit(tmp_path / "paper.glb")
    assert lit is not None
    assert {name: tau for name, *_, tau in lit.surfaces if tau} == {"paper": PAPER, "paper (back)": PAPER}
    eye = radiosity.Camera.look_at((0.4, -1.9, 0.2), (0, 0, 0.4), (0, 0, 1))
    for mode in ("smooth", "patches", "gather", "path"):
        one, two = (render(x, eye, mode=mode, width=24, height=18, samples=16) for x in (solution, lit))  # type: ignore[arg-type]
        assert np.mean(np.abs(one - two) > 5e-3 * one.mean()) < 0.05
        # What passes is red.
        assert one[..., 0].mean() > 1.2 * one[..., 2].mean()
    solution.save(tmp_path / "paper.npz")
    with np.load(tmp_path / "paper.npz") as arrays:
        np.testing.assert_array_equal(arrays["diffuse_transmittance"], solution.patches.diffuse_transmittance)


def test_smooth_pictures_vary_with_the_light_behind() -> None:
    # From below, the paper shows what the lamp above makes of it: bright in the middle, though little varies below.
    solution = solved(diffuse_transmittance=PAPER)
    eye = radiosity.Camera.look_at((0, 0.001, 0.05), (0, 0, 0.5), (0, 1, 0), vertical_fov=2.2)
    smooth, flat = (render(solution, eye, mode=mode, width=31, height=31) for mode in ("smooth", "patches"))  # type: ignore[arg-type]
    assert smooth[15, 15, 0] > 1.05 * flat[15, 15, 0] > 1.5 * smooth[2, 2, 0]


def test_the_viewer_shows_what_passes() -> None:
    solution = solved(diffuse_transmittance=PAPER)
    model = LitModel.of(solution)
    passed = passed_through(solution.patches, model.irradiance)
    np.testing.assert_allclose(model._passed, passed, atol=1e-9)
    again = model.with_light(model.emission, model.irradiance, model._reflectance, passed)
    np.testing.assert_allclose(again.radiosity, model.radiosity, rtol=1e-9)
    assert [s[3:] for s in again.surfaces] == [s[3:] for s in model.surfaces]
    shone = Lit(model)._light()["emission"][0]
    np.testing.assert_allclose(shone + model._reflectance * model.irradiance, model.radiosity, rtol=1e-9)
    # Rough light takes paper for opaque.
    assert not rough.one_sided(solution.patches).is_translucent


def test_the_lamp_with_a_shade_is_a_scene_without_faults() -> None:
    scene = radiosity.scenes.lampshade()
    assert [f.code for f in scene.findings() if f.severity != "note"] == []
    patches = scene.patches(as_is=True)
    names = {s.name for s in scene.surfaces if np.any(s.diffuse_transmittance)}
    assert names == {"shade", "leaves"}
    lit, opaque = (
        radiosity.solve(s.patches(as_is=True), accuracy=0.2, seed=1)
        for s in (scene, radiosity.scenes.lampshade(transmittance=0.0))
    )
    shade = patches.surface == [s.name for s in scene.surfaces].index("shade")
    assert lit.radiosity[shade].mean() > 10 * opaque.radiosity[shade].mean()
