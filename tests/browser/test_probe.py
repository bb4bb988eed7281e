"""A click tells what the solution's arrays hold, and where the light comes from."""

import numpy as np
from browsing import Open, pixels
from scenes import Seen, lit, two_lamps


def cosine_directions(n: int, normal: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(0)
    u, phi = rng.random(n), 2 * np.pi * rng.random(n)
    up = normal / np.linalg.norm(normal)
    across = np.cross(up, [1.0, 0, 0] if abs(up[0]) < 0.9 else [0, 1.0, 0])
    across /= np.linalg.norm(across)
    along = np.cross(up, across)
    r = np.sqrt(u)[:, None]
    return r * np.cos(phi)[:, None] * across + r * np.sin(phi)[:, None] * along + np.sqrt(1 - u)[:, None] * up


def test_the_probe_reads_the_solution(open_lit: Open) -> None:
    solution = two_lamps()
    scene = solution.patches.scene
    page = open_lit(lit(solution), width=1100, height=600)
    picture = pixels(page)
    seen = Seen(solution, picture.shape, every=41)
    places = np.flatnonzero(seen.inner(solution))[::4]
    assert len(places) >= 8
    for k in places:
        # The centre of that pixel.
        said = page.evaluate("([x, y]) => radiosity.probe(x, y)", [int(seen.x[k]) + 0.5, int(seen.y[k]) + 0.5])
        patch = seen.patch[k]
        assert said["patch"] == patch
        assert said["surface"] == scene.surfaces[solution.patches.surface[patch]].name
        assert np.allclose(said["position"], seen.point[k], atol=1e-4)
        field = solution.irradiance_at(seen.point[k], seen.normal[k])[0]
        assert np.allclose(said["irradiance"], field, rtol=2e-3)
        assert np.allclose(said["radiosity"], solution.emission[patch] + solution.reflectance[patch] * field, rtol=2e-3)
        assert np.allclose(said["mean"]["irradiance"], solution.irradiance[patch], rtol=1e-5)
        assert np.allclose(said["mean"]["error"], solution.error[patch], rtol=1e-5)


def test_the_row_of_form_factors_is_what_rays_see(open_lit: Open) -> None:
    solution = two_lamps()
    patches, names = solution.patches, [s.name for s in solution.patches.scene.surfaces]
    page = open_lit(lit(solution), width=1100, height=600)
    seen = Seen(solution, pixels(page).shape, every=41)
    (k,) = np.flatnonzero(seen.inner(solution) & (patches.surface[seen.patch] == names.index("floor")))[:1]
    said = page.evaluate("([x, y]) => radiosity.probe(x, y)", [int(seen.x[k]) + 0.5, int(seen.y[k]) + 0.5])

    n = 200_000
    directions = cosine_directions(n, seen.normal[k])
    origin = np.broadcast_to(seen.point[k] + 1e-6 * seen.normal[k], directions.shape).copy()
    hit, _, _ = patches._enclosure.looks(origin, directions)
    factor = np.bincount(patches.surface[hit], minlength=len(names)) / n
    arriving = np.array([solution.radiosity[hit[patches.surface[hit] == s]].sum(axis=0) / n for s in range(len(names))])
    for source in said["sources"]:
        # 200,000 random rays here and 4,096 even ones there: some thousandths.
        assert abs(source["factor"] - factor[source["surface"]]) < 0.01
        assert np.allclose(source["irradiance"], arriving[source["surface"]], atol=0.02 * arriving.sum(axis=0).max())
    assert abs(sum(source["factor"] for source in said["sources"]) + said["outside"] + said["backs"] - 1) < 1e-3
    # The light that these surfaces send is that of the field, to the accuracy of the solve.
    assert np.allclose(said["gathered"], said["irradiance"], rtol=0.08)
    assert page.locator(".probe").inner_text().count(said["surface"]) >= 1
