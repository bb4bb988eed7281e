"""What shapes and rays tell of models that are broken in one way each."""

from __future__ import annotations

import broken
import numpy as np
import pytest
from known import cube

from radiosity import Finding, Scene, Surface, diagnosis, scenes
from radiosity.sight import BACK, FRONT, look_around


def told(scene: Scene, **options: object) -> list[tuple[str, str]]:
    return [(f.code, f.element) for f in diagnosis.examine(scene, **options)]


@pytest.mark.parametrize("name", broken.MODELS)
def test_each_fault_is_named_by_surface_and_face(name: str) -> None:
    make, code, surface, faces = broken.MODELS[name]
    scene = make()
    found = {f.code: f for f in diagnosis.examine(scene)}
    assert code in found
    finding = found[code]
    assert surface in finding.element
    assert finding.message
    index = [k for k, s in enumerate(scene.surfaces) if s.name == surface]
    assert [finding.surface] == (index or [None])
    if faces:
        assert sorted(set(finding.faces.tolist())) == faces
    # Whatever else is said comes from the same fault.
    usual = {"zero-area-faces", "lamp-without-area"}
    assert set(found) <= {code} | usual


@pytest.mark.parametrize("make", [broken.room, scenes.furnished_room, scenes.furnace, cube])
def test_sound_models_have_nothing_to_remark(make: object) -> None:
    assert told(make()) == []


def test_places_cross_the_border_as_arrays() -> None:
    (gap,) = diagnosis.examine(broken.floating_wall())
    assert (gap.faces.dtype, gap.edges.shape, gap.points.shape) == (np.uint32, (2, 2, 3), (2, 3))
    # One edge is the wall's, 2 mm above the floor's; the points are one on each.
    assert sorted(set(gap.edges[..., 2].ravel())) == [0, 0.002]
    assert np.linalg.norm(gap.points[1] - gap.points[0]) == pytest.approx(0.002)
    (rug,) = diagnosis.examine(broken.rug_in_the_floor())
    np.testing.assert_allclose(np.ptp(rug.edges.reshape(-1, 3), axis=0), [1.5, 1.5, 0], atol=1e-12)


def test_findings_are_made_and_compared_without_places() -> None:
    plain = Finding("note", "code", "element", "message")
    assert (plain.surface, len(plain.faces), plain.edges.shape, plain.points.shape) == (None, 0, (0, 2, 3), (0, 3))
    assert plain == Finding("note", "code", "element", "message", None, np.arange(3))
    assert len({plain, Finding("note", "code", "element", "message")}) == 1


def test_light_escapes_through_the_hole_that_is_there() -> None:
    (finding,) = diagnosis.examine(broken.small_hole())
    assert (finding.severity, finding.code) == ("note", "light-escapes")
    # The third strip of the ceiling ends 0.2 m before the wall x = 4.
    assert {tuple(p) for p in finding.edges.reshape(-1, 3)[:, :2]} >= {(3.8, 1.5), (3.8, 2.25)}
    assert "100 % of that passes the hole around (" in finding.message
    assert [
        f.severity for f in diagnosis.examine(broken.small_hole(), enclosure=True) if f.code == "light-escapes"
    ] == ["warning"]
    assert told(broken.small_hole(), enclosure=False) == []


def test_rims_that_no_light_passes_are_told_together() -> None:
    codes = [code for code, _ in told(broken.missing_face(), enclosure=True)]
    assert codes == ["light-escapes", "open-edges", "open-rims"]
    (rims,) = diagnosis.examine(broken.room(), enclosure=True)
    assert (rims.code, rims.element, len(rims.edges)) == ("open-rims", "surfaces 'lamp', 'cupboard'", 8)


def test_joints_of_more_than_two_faces() -> None:
    found = [f for f in diagnosis.examine(broken.non_manifold(), enclosure=True) if f.code == "non-manifold-edges"]
    assert [f.element for f in found] == ["surface 'floor', face 0"]
    assert "between 'floor', 'left' and 'fin'" in found[0].message
    assert found[0].edges.shape == (2, 2, 3)


def test_what_both_sides_of_a_face_see() -> None:
    sight = look_around(cube().patches(as_is=True))
    np.testing.assert_array_equal(sight.lit, np.tile([1.0, 0.0], (6, 1)))
    np.testing.assert_array_equal(sight.escaped, np.tile([0.0, 1.0], (6, 1)))
    assert len(sight.exits) == 0
    turned = look_around(broken.flipped_wall().patches(as_is=True))
    assert (turned.lit[3, FRONT], turned.lit[3, BACK]) == (0, 1)


def test_the_same_seed_finds_the_same_on_any_number_of_threads() -> None:
    one, two = (diagnosis.examine(broken.missing_face(), threads=n) for n in (1, 2))
    assert list(map(str, one)) == list(map(str, two))


def test_progress_is_told_and_can_stop_the_rays() -> None:
    seen = []
    diagnosis.examine(broken.room(), progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (12, 12)

    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        diagnosis.examine(broken.room(), progress=stop)


@pytest.mark.parametrize(
    ("scene", "code"),
    [
        (Scene([]), "no-faces"),
        (Scene([Surface([], [], name="empty")]), "no-faces"),
        (broken.nan_vertex(), "non-finite-vertex"),
        (Scene([Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 7]], name="bad")]), "index-out-of-range"),
    ],
)
def test_hostile_scenes_are_told_and_not_looked_around_in(scene: Scene, code: str) -> None:
    found = diagnosis.examine(scene)
    assert (found[0].severity, code in {f.code for f in found}) == ("error", True)


def test_scenes_too_large_for_rays_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radiosity.ray_tests.MOST_FACES", 5)
    assert told(broken.flipped_wall()) == [("no-rays", "")]
