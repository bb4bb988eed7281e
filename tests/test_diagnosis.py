"""What form factors tell of the geometry."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from known import ADJACENT, CUBE, INWARD, OPPOSITE, cube, one_surface, square, tiles

from radiosity import FormFactors, Scene, Surface, diagnosis, form_factors, scenes

SHELF = CUBE[INWARD["floor"]] + np.array([0, 0, 0.5])
"""(4, 3) corners of a square that parts the cube in two and faces up."""

MIDDLE = 12
"""Of the 25 tiles of the floor, the one in the middle; its centre is (0.5, 0.5, 0)."""


def measured(*surfaces: Surface, **options: object) -> FormFactors:
    return form_factors(Scene(list(surfaces)).patches(as_is=True), **options)


def codes(factors: FormFactors, **options: object) -> Counter[str]:
    return Counter(finding.code for finding in diagnosis.of(factors, **options))


def without(name: str) -> Scene:
    scene = cube()
    scene.surfaces = [surface for surface in scene.surfaces if surface.name != name]
    return scene


def test_a_closed_cube_has_nothing_to_remark() -> None:
    scene = cube(emission=0.0)
    assert "no-light" in [finding.code for finding in scene.findings()]
    factors = form_factors(scene.patches(as_is=True))
    assert diagnosis.of(factors) == []
    assert diagnosis.is_enclosure(factors)
    assert diagnosis.mean_closure(factors) == pytest.approx(1)


def test_inside_out() -> None:
    factors = measured(one_surface(tile[::-1] for tile in tiles(1)))
    found = diagnosis.of(factors)
    assert [(f.severity, f.code) for f in found] == [("warning", "looking-outward"), ("warning", "sees-nothing")]
    assert "reverse the order of their corners" in found[1].message
    assert not diagnosis.is_enclosure(factors)


def test_a_missing_face_is_a_leak() -> None:
    factors = form_factors(without("ceiling").patches(as_is=True))
    assert codes(factors) == {}
    found = [f for f in diagnosis.of(factors, enclosure=True) if f.code == "leak"]
    assert "5 of 5 rows sum to less than 1 by more than 0.001: there is a hole nearby" in found[0].message
    # The walls lose what the ceiling would get from them, the floor a little less.
    told = {f.element: f.message for f in found[1:]}
    assert told["patch 0 of 'floor', face 0 at (0.5, 0.5, 0)"] == f"row sum {1 - OPPOSITE:.4g}"
    assert told["patch 4 of 'right', face 0 at (1, 0.5, 0.5)"] == f"row sum {1 - ADJACENT:.4g}"
    assert codes(factors, enclosure=True) == {"leak": 6, "open-edges": 1}
    assert diagnosis.farthest(factors).surface != "floor"


def test_a_file_may_say_that_it_is_closed() -> None:
    scene = without("ceiling")
    scene.hints = {"enclosure": True}
    scene.obstructions = [Surface(square(0.1, z=-1.0), [[0, 1, 2, 3]])]
    factors = form_factors(scene.patches(as_is=True))
    assert diagnosis.is_enclosure(factors)
    assert any("or they see an obstruction" in finding.message for finding in diagnosis.of(factors))


def test_no_more_than_ten_are_named() -> None:
    # A hole of 1/150 of the area, which all tiles of five faces see.
    shell = tiles(5)
    factors = measured(one_surface(shell[:MIDDLE] + shell[MIDDLE + 1 :]))
    assert diagnosis.mean_closure(factors) == pytest.approx(1 - 1 / 149, abs=1e-4)
    found = [f for f in diagnosis.of(factors) if f.code == "leak"]
    assert found[0].message.endswith("the worst 10:")
    assert len(found) == 1 + diagnosis.MOST_NAMED


def test_a_turned_face_sees_nothing() -> None:
    shell = tiles(5)
    shell[MIDDLE] = shell[MIDDLE][::-1]
    found = {f.code: f for f in diagnosis.of(measured(one_surface(shell)))}
    assert found["sees-nothing"].severity == "warning"
    assert "1 of its 150 patches see nothing, first patch 12" in found["sees-nothing"].message
    assert "at (0.5, 0.5, 0): their normals may be inverted" in found["sees-nothing"].message
    assert {"mixed-winding", "leak"} <= set(found)


def test_a_turned_surface_sees_nothing() -> None:
    scene = cube()
    scene.surfaces[0].faces = np.asarray(scene.surfaces[0].faces)[:, ::-1]
    factors = form_factors(scene.patches(as_is=True))
    # Without its floor the rest is far from closed: whether that is meant nobody knows.
    for enclosure, severity in ((None, "note"), (True, "warning")):
        found = [f for f in diagnosis.of(factors, enclosure=enclosure) if f.code == "sees-nothing"]
        assert [(f.severity, f.element) for f in found] == [(severity, "surface 'floor'")]


def test_a_face_right_before_another() -> None:
    shell = tiles(5)
    lid = shell[MIDDLE] + [0, 0, 0.002]
    factors = measured(one_surface(shell), one_surface([lid], "lid"), rays=4096)
    # What leaves through the gap of 1/100 of the edge is some 4 / 200 by the area of the gap's sides.
    assert factors.closure()[MIDDLE] < 0.05
    found = [f for f in diagnosis.of(factors) if f.code == "sees-little"]
    assert [f.element for f in found] == ["patch 12 of 'shell', face 12 at (0.5, 0.5, 0)"]


def test_two_floors_in_one_place_are_seen_twice() -> None:
    scene = cube()
    scene.surfaces.append(Surface(scene.surfaces[0].vertices, scene.surfaces[0].faces, name="carpet"))
    factors = form_factors(scene.patches(as_is=True))
    found = codes(factors)
    assert found["duplicate-faces"] == 1
    # All but the floors themselves.
    assert found["excess"] == 1 + 5
    told = [f.message for f in diagnosis.of(factors) if f.code == "excess"]
    assert told[0] == "5 of 7 rows sum to more than 1 by more than 0.001: faces overlap or coincide; these:"
    assert set(told[1:]) == {f"row sum {1 + ADJACENT:.4g}"} == {f"row sum {1 + OPPOSITE:.4g}"}


@pytest.mark.parametrize("options", [{"rays": 64}, {"hemicubes": 1, "resolution": 32}, {"points": 1}])
def test_the_error_of_a_method_is_not_blamed_on_the_geometry(options: dict[str, int]) -> None:
    factors = form_factors(scenes.furnace().patches(count=200), **options)
    assert abs(factors.closure() - 1).max() > diagnosis.LEAST_DEVIATION
    assert codes(factors) == {}


def test_the_outside_of_two_sided_walls_is_not_missed() -> None:
    scene = cube()
    for surface in scene.surfaces:
        surface.two_sided = True
    factors = form_factors(scene.patches(as_is=True))
    assert factors.shape == (12, 12)
    assert diagnosis.mean_closure(factors) == pytest.approx(1)
    assert diagnosis.of(factors) == []
    assert diagnosis.farthest(factors).row_sum == pytest.approx(1)


def test_backs_are_named() -> None:
    scene = without("ceiling")
    scene.surfaces.append(Surface(SHELF, [[0, 1, 2, 3]], name="shelf", two_sided=True))
    factors = form_factors(scene.patches(as_is=True))
    back = diagnosis.place(factors, 6)
    assert str(back) == "the back of patch 5 of 'shelf', face 0 at (0.5, 0.5, 0.5)"
    assert back.row_sum == pytest.approx(1, abs=1e-5)
    assert diagnosis.place(factors, 5).row_sum < 1 - OPPOSITE


def test_a_patch_alone_sees_nothing_and_that_is_right() -> None:
    assert codes(measured(Surface(square(), [[0, 1, 2, 3]]))) == {}


def test_plates_that_look_away_are_worth_a_note() -> None:
    lower, upper = Surface(square(), [[0, 1, 2, 3]], name="lower"), Surface(square(z=1)[::-1], [[0, 1, 2, 3]])
    away = Surface(square(z=2), [[0, 1, 2, 3]], name="roof")
    found = diagnosis.of(measured(lower, upper, away))
    assert [(f.severity, f.code, f.element) for f in found] == [("note", "sees-nothing", "surface 'roof'")]


def test_names_of_the_cube_are_those_of_its_surfaces() -> None:
    factors = form_factors(cube().patches(as_is=True))
    assert [diagnosis.place(factors, row).surface for row in range(6)] == list(INWARD)
