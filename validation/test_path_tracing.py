"""Path tracing against closed forms and another program, and solutions and gathered pictures against path tracing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from pieces import rectangle
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.stats import t as student

import radiosity
from radiosity.files import load_lit
from radiosity.picture import render


def room_with_lights() -> radiosity.Scene:
    """An open room of 2 x 2 x 2 m with a screen from both sides, a lamp, a point light, a spot and some sun."""
    white, red = [0.7, 0.7], [0.6, 0.1]
    surfaces = [
        rectangle([0, 0, 0], [2, 0, 0], [0, 2, 0], white, name="floor"),
        rectangle([0, 0, 2], [0, 2, 0], [2, 0, 0], white, name="ceiling"),
        rectangle([0, 0, 0], [0, 2, 0], [0, 0, 2], red, name="left"),
        rectangle([0, 2, 0], [2, 0, 0], [0, 0, 2], white, name="back"),
        rectangle([0.8, 0.8, 1.98], [0, 0.4, 0], [0.4, 0, 0], 0.2, [9.0, 6.0], name="lamp"),
    ]
    screen = rectangle([1.2, 0.9, 0.0], [0.0, 0.8, 0.0], [0.1, 0.0, 0.9], [0.5, 0.8], name="screen")
    screen.two_sided = True
    lights = [
        radiosity.PointLight((0.5, 1.0, 1.2), [0.4, 0.3]),
        radiosity.SpotLight((1.5, 0.3, 1.7), (0.0, 0.3, -1.0), [1.0, 1.5], 0.2, 0.5),
        radiosity.DirectionalLight((-0.5, 0.3, -0.8), [0.8, 0.5]),
    ]
    eye = radiosity.Camera.look_at((2.6, -1.5, 1.4), (0.8, 1.2, 0.8), (0, 0, 1))
    return radiosity.Scene([*surfaces, screen], lights, [eye], "room with lights")


@pytest.mark.parametrize("rho", [0.3, 0.9])
def test_a_furnace_is_uniform(rho: float) -> None:
    scene = radiosity.scenes.furnace([rho, 0.5], 1.0)
    found = radiosity.path_irradiance(scene, samples=4096, seed=1)
    truth = np.array([1 / (1 - rho), 2.0])
    exposed = ~np.isclose(found.irradiance[:, 1], 0, atol=0.5)
    # 64 rounds; the largest of some fifty scores is below 4.5 but for one time in two thousand.
    score = (found.irradiance - truth)[exposed] / found.error[exposed]
    assert exposed.sum() > 6
    assert np.abs(score).max() < 4.5
    assert found.effort.relative_error < 0.02


def test_the_cornell_box_is_that_of_another_program(
    cornell: dict[str, np.ndarray], cornell_patches: radiosity.Patches
) -> None:
    found = radiosity.path_irradiance(cornell_patches, samples=512, seed=2)
    lit = (cornell["emission"].sum(axis=1) == 0) & (cornell["covered"] < 0.999)
    deviation, sigma = (found.irradiance - cornell["E"])[lit], np.hypot(found.error, cornell["sem"])[lit]
    # Bands of a patch share their paths, so one tells all. Eight rounds of 64: t with seven degrees of freedom.
    # Where only few paths find light, as on patches almost under a block, eight rounds are no normal numbers: so the
    # tail is given three times its share.
    score = np.abs(deviation / sigma)[:, 1]
    assert np.median(score) == pytest.approx(student.ppf(0.75, 7), rel=0.15)
    assert np.mean(score > student.ppf(0.995, 7)) < 0.03
    # Errors of patches are independent, those of their bands are taken to be the same.
    weight = cornell["area"][lit][:, None]
    whole = np.sqrt(np.sum((weight * sigma).sum(axis=1) ** 2))
    assert abs((weight * deviation).sum()) < 4 * whole
    assert whole < 0.001 * (weight * cornell["E"][lit]).sum()


def test_errors_fall_with_the_root_of_the_samples() -> None:
    scene = radiosity.scenes.cornell_box()
    camera = scene.cameras[0]
    counts, errors = [64, 256, 1024], []
    for samples in counts:
        # Rounds of eight, sixteen and so on would gain from being even; of 64 all are.
        traced = radiosity.path_trace(scene, camera, width=32, height=32, samples=8 * samples, seed=4)
        errors.append(traced.effort.relative_error)
        assert traced.effort.samples == 8 * samples
    rate = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert rate == pytest.approx(-0.5, abs=0.05)


def test_an_accuracy_is_reached_and_no_more() -> None:
    traced = radiosity.path_trace(radiosity.scenes.cornell_box(), width=40, height=40, accuracy=0.1, seed=4)
    assert traced.effort.reached
    assert 0.08 < traced.effort.relative_error <= 0.1


def test_solutions_agree_with_path_tracing() -> None:
    # Lamps, lights without area, screens with two sides: what the references have no case of.
    patches = room_with_lights().patches(max_edge=0.25)
    solution = radiosity.solve(patches, accuracy=0.01, seed=5)
    found = radiosity.path_irradiance(patches, samples=1024, seed=6)
    assert found.back_irradiance is not None
    assert found.back_error is not None
    mean = np.average(found.irradiance, axis=0, weights=patches.area)
    difference = (solution.irradiance - found.irradiance) / mean
    rms = np.sqrt(np.average(difference**2, axis=0, weights=patches.area).mean())
    noise = np.sqrt(np.average((found.error / mean) ** 2, axis=0, weights=patches.area).mean())
    assert noise < 0.02
    assert np.sqrt(max(rms**2 - noise**2, 0)) < 0.012
    backs = patches.two_sided
    assert backs.sum() > 10
    sigma = np.hypot(found.back_error[backs], solution.back_error[backs])
    assert np.mean(np.abs(solution.back_irradiance[backs] - found.back_irradiance[backs]) > 3 * sigma) < 0.1


def test_points_have_what_closed_forms_say() -> None:
    # A lamp of 1 x 1 m, 1 m above the middle of a black floor, and a bulb beside it.
    lamp = rectangle([-0.5, -0.5, 1], [0, 1, 0], [1, 0, 0], 0, 5.0, name="lamp")
    floor = rectangle([-9, -9, 0], [18, 0, 0], [0, 18, 0], 0, name="floor")
    scene = radiosity.Scene([lamp, floor], [radiosity.PointLight((3, 0, 1), 2.0)])
    found = radiosity.path_irradiance(scene, [[0, 0, 0], [3, 0, 0]], [0, 0, 1], samples=4096)
    # Four quarters of Hottel's parallel rectangle seen from below its corner, a = b = 0.5, c = 1.
    k = 0.5 / np.sqrt(1.25)
    middle = 4 * (2 * k * np.arctan(k)) / (2 * np.pi)
    bulb = 2.0 / 10**1.5
    assert found.irradiance[0, 0] == pytest.approx(5 * middle + bulb, abs=4 * found.error[0, 0] + 1e-6)
    assert found.error[0, 0] < 0.003
    assert found.irradiance[1, 0] > 2.0
    assert found.back_irradiance is None


@pytest.mark.parametrize("make", [radiosity.scenes.cornell_box, room_with_lights])
def test_gathered_and_path_traced_pictures_agree(make: Callable[[], radiosity.Scene]) -> None:
    scene = make()
    size = {"width": 48, "height": 48, "seed": 8}
    solution = radiosity.solve(scene.patches(count=2000), accuracy=0.01, seed=7)
    truth = radiosity.path_trace(scene, samples=1024, **size)
    picture = render(solution, mode="gather", samples=256, **size)
    # Across edges sixteen points of a pixel tell its mean to some per cent of what is on either side: leave them out.
    brightness = truth.image.mean(axis=2)
    high, low = maximum_filter(brightness, 3), minimum_filter(brightness, 3)
    inner = (low > 0) & (high < 1.5 * low)
    inner[[0, -1]] = inner[:, [0, -1]] = False
    assert inner.mean() > 0.3
    value, difference = truth.image[inner], (picture - truth.image)[inner]
    noise = truth.standard_error[inner]
    # The picture's own noise at 256 samples and the 1 % of the solution are all that is left.
    rms = np.sqrt(max(np.mean(difference**2) - np.mean(noise**2), 0)) / value.mean()
    assert rms < 0.03
    # No light is lost or counted twice, in the light or in shadows.
    dark = value.mean(axis=1) < np.median(value.mean(axis=1))
    for part in (dark, ~dark):
        assert abs(difference[part].mean()) < 0.01 * value[part].mean()


def test_a_lit_model_gathers_as_its_solution_does(tmp_path: object) -> None:
    scene = room_with_lights()
    solution = radiosity.solve(scene.patches(max_edge=0.3), accuracy=0.03)
    path = f"{tmp_path}/lit.glb"
    solution.save(path)
    lit = load_lit(path)
    assert lit is not None
    with pytest.raises(ValueError, match="two-sided surfaces"):
        radiosity.path_irradiance(lit)
    size = {"width": 40, "height": 40, "samples": 32}
    for mode in ("gather", "path"):
        one, two = render(solution, mode=mode, **size), render(lit, mode=mode, **size)
        # Corners of lit models are in single precision: few paths go another way.
        assert np.mean(np.abs(one - two) > 5e-3 * one.mean()) < 0.05
        assert one.mean() == pytest.approx(two.mean(), rel=1e-3)


@pytest.mark.parametrize("transmittance", [0.7, 0.0])
def test_solutions_agree_with_path_tracing_by_mirrors_and_glass(transmittance: float) -> None:
    # Behind its lamp, the room is lit by the mirror alone, beside what walls reflect.
    patches = radiosity.scenes.mirror_room(transmittance=transmittance).patches(max_edge=0.5)
    solution = radiosity.solve(patches, accuracy=0.01, seed=5, transport="sampled")
    found = radiosity.path_irradiance(patches, samples=4096, seed=6)
    assert found.back_error is not None
    weight = patches.area[:, None]
    mean = np.average(found.irradiance, axis=0, weights=patches.area)
    difference = (solution.irradiance - found.irradiance) / mean
    noise = found.error / mean
    rms, sigma = (float(np.sqrt(np.average(v**2, axis=0, weights=patches.area).mean())) for v in (difference, noise))
    assert np.sqrt(max(rms**2 - sigma**2, 0)) < 0.02
    # No light is lost or counted twice on any surface. Bands share their paths.
    for k, surface in enumerate(patches.scene.surfaces):
        own = patches.surface == k
        total = (weight * found.irradiance)[own].sum()
        error = np.sqrt(((weight * found.error)[own].sum(axis=1) ** 2).sum())
        off = (weight * (solution.irradiance - found.irradiance))[own].sum()
        assert abs(off) < 4 * error + 0.01 * total, surface.name


def test_lights_without_area_agree_by_mirrors_and_glass() -> None:
    room = radiosity.scenes.mirror_room()
    lights = [
        radiosity.PointLight((1.0, 0.6, 2.0), [5.0, 4.0, 3.0]),
        radiosity.SpotLight((2.0, 1.5, 1.5), (-1.0, 0.2, -0.1), [9.0, 9.0, 9.0], 0.3, 0.6),
    ]
    patches = radiosity.Scene(room.surfaces, lights, bands=room.bands).patches(max_edge=0.5)
    solution = radiosity.solve(patches, accuracy=0.01, seed=5)
    found = radiosity.path_irradiance(patches, samples=2048, seed=6)
    for k, surface in enumerate(patches.scene.surfaces):
        own, area = patches.surface == k, patches.area[:, None]
        error = np.sqrt(((area * found.error)[own].sum(axis=1) ** 2).sum())
        off = (area * (solution.irradiance - found.irradiance))[own].sum()
        assert abs(off) < 4 * error + 0.01 * (area * found.irradiance)[own].sum(), surface.name


@pytest.mark.parametrize("camera", [0, 1])
def test_pictures_show_the_room_in_the_mirror(camera: int) -> None:
    scene = radiosity.scenes.mirror_room()
    eye, size = scene.cameras[camera], {"width": 40, "height": 30, "seed": 8}
    solution = radiosity.solve(scene.patches(max_edge=0.2), accuracy=0.01, seed=7)
    truth = radiosity.path_trace(scene, eye, samples=2048, **size)
    brightness = truth.image.mean(axis=2)
    high, low = maximum_filter(brightness, 3), minimum_filter(brightness, 3)
    inner = (low > 0) & (high < 1.5 * low)
    assert inner.mean() > 0.4
    for mode, samples, bound in (("gather", 512, 0.05), ("smooth", 64, 0.06), ("patches", 64, 0.1)):
        picture = render(solution, eye, mode=mode, samples=samples, **size)  # type: ignore[arg-type]
        difference = (picture - truth.image)[inner]
        # A gather finds the lamp in the mirror by rays, as paths do, and so with their noise.
        noise = np.mean(truth.standard_error[inner] ** 2) * (1 + (2048 / samples if mode == "gather" else 0))
        assert np.sqrt(max(np.mean(difference**2) - noise, 0)) < bound * truth.image[inner].mean(), mode
        # Of patches that are seen in part, single values tell the mean of the whole.
        assert abs(difference.mean()) < (0.03 if mode == "patches" else 0.015) * truth.image[inner].mean(), mode


def test_a_mirror_shows_the_room_as_if_it_went_on_behind_it() -> None:
    # A mirror for a wall against the same room continued behind it, where the mirror leaves 0.8 of what is seen.
    floor = rectangle([0, 0, 0], [2, 0, 0], [0, 2, 0], 0.0, 3.0, name="floor")
    lamp = rectangle([0.5, 0.5, 1.5], [0.3, 0, 0], [0, 0.3, 0], 0.0, 7.0, name="lamp")
    mirror = rectangle([0, 0, 0], [0, 2, 0], [0, 0, 2], 0.0, name="mirror")
    mirror.specular = 0.8
    beyond = [
        rectangle([0, 0, 0], [0, 2, 0], [-2, 0, 0], 0.0, 0.8 * 3.0, name="floor beyond"),
        rectangle([-0.5, 0.5, 1.5], [0, 0.3, 0], [-0.3, 0, 0], 0.0, 0.8 * 7.0, name="lamp beyond"),
    ]
    eye = radiosity.Camera.look_at((1.8, 1.1, 1.7), (0.0, 1.0, 0.9), (0, 0, 1))
    size = {"width": 40, "height": 40, "samples": 1}
    seen = [
        render(radiosity.solve(radiosity.Scene(surfaces).patches(as_is=True)), eye, mode="patches", **size)  # type: ignore[arg-type]
        for surfaces in ([floor, lamp, mirror], [floor, lamp, *beyond])
    ]
    inside = np.abs(seen[0] - seen[1])[..., 0]
    # Where the mirror ends the continued room goes on; everything else is the same but for edges.
    shown = seen[0][..., 0] > 0
    assert (shown & (seen[1][..., 0] < 3.0 / np.pi * 0.9)).sum() > 50
    assert np.mean(inside[shown] > 1e-5) < 0.01


def test_lit_models_keep_their_mirrors(tmp_path: object) -> None:
    scene = radiosity.scenes.mirror_room()
    solution = radiosity.solve(scene.patches(max_edge=0.5), accuracy=0.03)
    path = f"{tmp_path}/mirrors.glb"
    solution.save(path)
    lit = load_lit(path)
    assert lit is not None
    kept = {name: parts for name, *_, specular, clear, _ in lit.surfaces if any(parts := (specular, clear))}
    # Surfaces without backs are written with one too.
    assert kept.pop("mirror (back)") == kept["mirror"]
    assert kept == {"mirror": (0.9, 0.0), "pane": (0.5 * (1 - 0.8), 0.8), "pane (back)": (0.5 * (1 - 0.8), 0.8)}
    size = {"width": 40, "height": 30, "samples": 16}
    for mode in ("smooth", "patches", "gather", "path"):
        one, two = render(solution, mode=mode, **size), render(lit, mode=mode, **size)  # type: ignore[arg-type]
        assert np.mean(np.abs(one - two) > 5e-3 * one.mean()) < 0.05
        assert one.mean() == pytest.approx(two.mean(), rel=2e-3)


def test_paint_and_mirror_are_parts_of_one_whole() -> None:
    room = radiosity.scenes.mirror_room()
    room.surfaces[6].reflectance = 0.3
    with pytest.raises(ValueError, match="more than"):
        radiosity.path_irradiance(room.patches(max_edge=1.0))
