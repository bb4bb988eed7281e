"""Walls and floors stop whoever walks."""

import numpy as np
from browsing import Open
from scenes import lit, two_lamps


def test_walls_stop_and_let_slide(open_lit: Open) -> None:
    page = open_lit(lit(two_lamps()), width=1100, height=600)
    page.evaluate("radiosity.look([2, 1, 1.5], [2, 1, 0]); radiosity.mode = 'walk'")
    start = np.array(page.evaluate("radiosity.step(1)"))
    # Standing on the floor, below the ceiling at 2 m.
    assert 0.3 < start[1] < 1.95
    end = np.array(page.evaluate("radiosity.step(10, ['KeyW'])"))
    assert 0.02 < end[2] < 0.6 and abs(end[0] - 2) < 0.2 and np.isclose(end[1], start[1], atol=0.02)
    # Along the wall, at an angle: it slides, and comes to a stop in the corner.
    page.evaluate("radiosity.look([2, 1, 1.5], [1, 1, 0])")
    corner = np.array(page.evaluate("radiosity.step(20, ['KeyW'], true)"))
    assert 0.02 < corner[0] < 0.6 and 0.02 < corner[2] < 0.6
    # However one runs, one stays inside.
    for target in ([4, 1, 3], [4, 1, 0], [0, 0, 3], [3, 2, 1], [2, 0, 1.4]):
        page.evaluate("target => radiosity.look([2, 1, 1.5], target)", target)
        for keys in (["KeyW"], ["KeyW", "KeyD"], ["KeyS", "KeyA"]):
            x, y, z = page.evaluate("keys => radiosity.step(5, keys, true)", keys)
            assert 0 < x < 4 and 0 < y < 2 and 0 < z < 3


def test_orbiting_and_flying_go_where_they_are_told(open_lit: Open) -> None:
    page = open_lit(lit(two_lamps()), width=1100, height=600)
    page.evaluate("radiosity.mode = 'fly'; radiosity.look([2, 1, 1.5], [2, 1, 0])")
    x, y, z = page.evaluate("radiosity.step(0.2, ['KeyD'])")
    assert x > 2 and np.isclose(y, 1, atol=0.01) and np.isclose(z, 1.5, atol=0.01)
