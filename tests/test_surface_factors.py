"""Form factors between whole surfaces."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from known import ADJACENT, CUBE, HATCH, INWARD, OPPOSITE, VIEW3D_CUBE, cube, cube_factors, square

from radiosity import FormFactors, Scene, Surface, SurfaceFactors, form_factors, load

TOLERANCE = 1e-6
"""Of form factors by default; constants of known.py have eight digits."""


def between(scene: Scene, **cut: object) -> SurfaceFactors:
    return form_factors(scene.patches(**(cut or {"as_is": True}))).by_surface()


def written(tmp_path: Path, text: str) -> Scene:
    (tmp_path / "cube.vs3").write_text(text)
    return load(tmp_path / "cube.vs3")


def test_surfaces_do_not_depend_on_how_they_are_cut() -> None:
    coarse, fine = between(cube()), between(cube(), max_edge=0.5)
    assert coarse.names == fine.names == tuple(INWARD)
    for found in (coarse, fine):
        assert found.area == pytest.approx(np.ones(6))
        # Four patches a face, so that four errors add up.
        np.testing.assert_allclose(found.F, cube_factors(), rtol=0, atol=4 * TOLERANCE)
        assert found.closure() == pytest.approx(np.ones(6), abs=4 * TOLERANCE)


def test_combined_surfaces_count_as_one() -> None:
    scene = cube()
    scene.combined = {1: 0}
    found = between(scene)
    assert found.names == ("floor", "front", "back", "left", "right")
    assert found.area == pytest.approx([2, 1, 1, 1, 1])
    # Both faces see each other, by OPPOSITE, and every other face by ADJACENT; together they are seen twice as well.
    assert found.F[0] == pytest.approx([OPPOSITE, ADJACENT, ADJACENT, ADJACENT, ADJACENT], abs=TOLERANCE)
    assert found.F[1] == pytest.approx([2 * ADJACENT, 0, OPPOSITE, ADJACENT, ADJACENT], abs=TOLERANCE)


def test_view3d_combines(tmp_path: Path) -> None:
    found = between(written(tmp_path, VIEW3D_CUBE.replace("6   0   0   0.50  xeq1", "6   0   2   0.50  xeq1")))
    assert found.names == ("zeq0", "xeq0", "yeq0", "zeq1", "yeq1")
    assert found.F[0] == pytest.approx([0, 2 * ADJACENT, ADJACENT, OPPOSITE, ADJACENT], abs=TOLERANCE)
    assert found.F[1, 1] == pytest.approx(OPPOSITE, abs=TOLERANCE)


def test_a_subsurface_takes_its_share_of_the_base(tmp_path: Path) -> None:
    scene = written(tmp_path, HATCH)
    found = between(scene)
    assert len(scene.patches(as_is=True)) > len(found.names) == 7
    assert found.area == pytest.approx([0.75, 1, 1, 1, 1, 1, 0.25])
    base = found.F[:, 0] + found.F[:, 6]
    # xeq0, yeq0, zeq1, xeq1 and yeq1 see both together as they saw the whole face.
    assert base[1:6] == pytest.approx([ADJACENT, ADJACENT, OPPOSITE, ADJACENT, ADJACENT], abs=9 * TOLERANCE)
    assert found.area[:, None] * found.F == pytest.approx(found.area * found.F.T, abs=1e-14)
    assert found.closure() == pytest.approx(np.ones(7), abs=9 * TOLERANCE)


def test_backs_are_surfaces_of_their_own() -> None:
    scene = cube()
    corners = CUBE[INWARD["floor"]] + np.array([0, 0, 0.5])
    scene.surfaces.insert(0, Surface(corners, [[0, 1, 2, 3]], name="shelf", two_sided=True))
    found = between(scene)
    assert found.names == ("shelf", *INWARD, "shelf (back)")
    # The shelf faces up and parts the cube.
    assert found.F[0, [0, 1, 7]] == pytest.approx([0, 0, 0])
    assert found.F[7, [0, 2, 7]] == pytest.approx([0, 0, 0])
    assert found.F[7, 1] == pytest.approx(found.F[0, 2], abs=TOLERANCE)
    assert found.closure() == pytest.approx(np.ones(8), abs=8 * TOLERANCE)


def test_what_nothing_is_left_of_is_left_out() -> None:
    scene = cube()
    scene.surfaces.insert(3, Surface(np.zeros((0, 3)), np.zeros((0, 4), int), name="nothing"))
    assert between(scene).names == tuple(INWARD)


def test_they_print_as_a_table() -> None:
    lower, upper = Surface(square(), [[0, 1, 2, 3]], name="lower plate"), Surface(square(z=1)[::-1], [[0, 1, 2, 3]])
    assert str(between(Scene([lower, upper]))).splitlines() == [
        "from | to   lower plate surface 1    sum",
        "lower plate      0.0000    0.1998 0.1998",
        "surface 1        0.1998    0.0000 0.1998",
    ]


@pytest.mark.parametrize("name", ["F.npz", "F.csv"])
def test_files(tmp_path: Path, name: str) -> None:
    found = between(cube())
    found.save(tmp_path / name)
    if name == "F.npz":
        with np.load(tmp_path / name, allow_pickle=False) as table:
            names, area, factors = table["names"], table["area"], table["F"]
        assert np.array_equal(area, found.area)
    else:
        with (tmp_path / name).open(newline="") as file:
            rows = list(csv.reader(file))
        names, factors = rows[0][1:], np.array([[float(cell) for cell in row[1:]] for row in rows[1:]])
        assert [row[0] for row in rows[1:]] == list(names)
    assert tuple(names) == found.names
    assert np.array_equal(factors, found.F)


def test_another_suffix_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"cannot write '\.txt' files of form factors"):
        between(cube()).save(tmp_path / "F.txt")
    assert list(tmp_path.iterdir()) == []


def test_saved_factors_combine_too(tmp_path: Path) -> None:
    scene = cube()
    scene.combined = {1: 0}
    factors = form_factors(scene.patches(as_is=True))
    factors.save(tmp_path / "F.npz")
    again = FormFactors.load(tmp_path / "F.npz").by_surface()
    assert again.names == factors.by_surface().names
    np.testing.assert_allclose(again.F, factors.by_surface().F)
