"""Pictures of form factors, and the numbers behind them."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from known import CUBE, INWARD, cube, square

from radiosity import Patches, Scene, Surface, catalogue, form_factors, scenes, teaching
from radiosity.teaching.hemicube import _unfold

POINT, UP = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
ABOVE = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]


def area(outline: np.ndarray) -> float:
    """On the base, by the shoelace formula."""
    x, y, _ = outline.T
    return float(abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2)


def test_the_outline_is_on_the_hemisphere_and_covers_the_form_factor() -> None:
    outline = teaching.nusselt_outline(POINT, UP, ABOVE, steps=1000)
    assert outline.shape == (4000, 3)
    np.testing.assert_allclose(np.linalg.norm(outline, axis=1), 1, rtol=1e-14)
    exact = catalogue.point_to_parallel_rectangle(width=1, length=1, distance=1)
    assert area(outline) / np.pi == pytest.approx(exact, rel=1e-5)
    assert teaching.nusselt_form_factor(POINT, UP, ABOVE) == pytest.approx(exact, rel=1e-14)


def test_turning_everything_changes_nothing() -> None:
    rng = np.random.default_rng(1)
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    q *= np.linalg.det(q)
    polygon = np.array(ABOVE) @ q.T + [1, 2, 3]
    outline = teaching.nusselt_outline([1, 2, 3], 5 * q[:, 2], polygon, steps=50)
    assert area(outline) == pytest.approx(area(teaching.nusselt_outline(POINT, UP, ABOVE, steps=50)), rel=1e-12)
    frame = teaching.frame(q[:, 2])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1)
    # The first corner is a unit vector along its direction.
    direction = frame @ (polygon[0] - [1, 2, 3])
    np.testing.assert_allclose(outline[0], direction / np.linalg.norm(direction), atol=1e-14)


def test_what_is_below_the_horizon_is_cut_off() -> None:
    tall = [[1, 0, -4], [1, 1, -4], [1, 1, 1], [1, 0, 1]]
    exact = catalogue.point_to_perpendicular_rectangle(height=1, length=1, distance=1)
    assert teaching.nusselt_form_factor(POINT, UP, tall) == pytest.approx(exact, rel=1e-13)
    assert np.all(teaching.nusselt_outline(POINT, UP, tall)[:, 2] >= 0)
    below = np.array(ABOVE) * [1, 1, -1]
    assert teaching.nusselt_outline(POINT, UP, below).shape == (0, 3)
    assert teaching.nusselt_form_factor(POINT, UP, below) == 0
    with pytest.raises(ValueError, match="wholly below the horizon"):
        teaching.draw_nusselt(POINT, UP, below)


def test_what_is_no_point_normal_or_polygon() -> None:
    for normal in ((0, 0, 0), (0, 0, np.nan), (1, 0)):
        with pytest.raises(ValueError, match="normal must be three finite numbers"):
            teaching.nusselt_outline(POINT, normal, ABOVE)
    with pytest.raises(ValueError, match=r"polygon must have shape \(n, 3\)"):
        teaching.nusselt_outline(POINT, UP, ABOVE[:2])
    with pytest.raises(ValueError, match="three finite numbers"):
        teaching.nusselt_outline((0, 0, np.inf), UP, ABOVE)
    with pytest.raises(ValueError, match="steps must be from 1"):
        teaching.nusselt_outline(POINT, UP, ABOVE, steps=0)


def test_pixels_add_up_to_the_hemisphere() -> None:
    top, side = teaching.delta_form_factors(64)
    assert top.shape == (64, 64) and side.shape == (32, 64)
    assert top.sum() + 4 * side.sum() == pytest.approx(1, rel=1e-13)
    for resolution in (6, 9, 4098):
        with pytest.raises(ValueError, match="resolution"):
            teaching.delta_form_factors(resolution)


def test_rows_of_item_buffers_are_those_of_the_method() -> None:
    patches = cube().patches(as_is=True)
    rows = np.array([teaching.item_buffer(patches, i, resolution=64, seed=3).row() for i in range(6)])
    np.testing.assert_allclose(rows.sum(axis=1), 1, rtol=1e-13)
    # Faces are equally large, so that either end counts half.
    found = form_factors(patches, method="hemicube", resolution=64, hemicubes=1, seed=3).toarray()
    np.testing.assert_allclose(0.5 * (rows + rows.T), found, rtol=1e-12)


def test_what_the_pixels_see() -> None:
    patches = cube().patches(as_is=True)
    names = list(INWARD)
    buffer = teaching.item_buffer(patches, names.index("floor"), resolution=32)
    np.testing.assert_allclose(buffer.position, [0.5, 0.5, 0], atol=1e-15)
    np.testing.assert_allclose(buffer.axes[2], [0, 0, 1], atol=1e-15)
    for owners, depths, directions in zip(buffer.owners, buffer.depths, buffer.directions, strict=True):
        assert owners.shape == depths.shape == directions.shape[:2]
        # Directions have length 1 along the axis of their face, along which depths are measured.
        hits = buffer.position + depths[..., None] * directions
        assert np.all(np.abs(hits - 0.5) < 0.5 + 1e-5)
        off = {"ceiling": (2, 1), "front": (1, 0), "back": (1, 1), "left": (0, 0), "right": (0, 1)}
        for name, (axis, at) in off.items():
            np.testing.assert_allclose(hits[owners == names.index(name)][:, axis], at, atol=1e-5)
    np.testing.assert_array_equal(buffer.unfolded, _unfold(buffer.owners, teaching.NOTHING))


def test_nothing_and_backs_have_codes() -> None:
    # Below an upward square of half the hemisphere's cube top: a back; around it, nothing.
    floor, ceiling = (Surface(square(1.0, z), [[0, 1, 2, 3]]) for z in (0.0, 0.5))
    patches = Scene([floor, ceiling]).patches(as_is=True)
    buffer = teaching.item_buffer(patches, 0, resolution=64)
    seen = np.unique(np.concatenate([face.ravel() for face in buffer.owners]))
    assert seen.tolist() == [teaching.BACK, teaching.NOTHING]
    quarter = catalogue.point_to_parallel_rectangle(width=0.5, length=0.5, distance=0.5)
    assert buffer.to_backs() == pytest.approx(4 * quarter, abs=0.01)
    assert buffer.to_backs() + buffer.to_nothing() == pytest.approx(1, rel=1e-13)
    assert buffer.row().tolist() == [0, 0]


def two_sided_plate() -> Patches:
    surfaces = [Surface(CUBE[corners], [[0, 1, 2, 3]], name=name) for name, corners in INWARD.items()]
    surfaces.append(Surface(np.add(square(0.4, 0.5), [0.5, 0.5, 0]), [[0, 1, 2, 3]], name="plate", two_sided=True))
    return Scene(surfaces).patches(as_is=True)


def test_backs_that_see() -> None:
    patches = two_sided_plate()
    back = teaching.item_buffer(patches, 6, resolution=64, back=True)
    assert back.side == 7 and back.patch.tolist() == [*range(7), 6]
    row = back.row()
    assert row[0] > row[2] > 0 and row[1] == 0  # it looks down
    with pytest.raises(ValueError, match="patch 0 is one-sided"):
        teaching.item_buffer(patches, 0, back=True)
    with pytest.raises(ValueError, match="patch must be from 0 to 6"):
        teaching.item_buffer(patches, 7)


def test_pictures_show_the_number() -> None:
    figure = teaching.draw_nusselt(POINT, UP, ABOVE)
    assert "F = 0.1385" in figure.get_suptitle()
    patches = scenes.cornell_box().patches(max_edge=0.2, contacts=False)  # else the first is under a block
    figure = teaching.draw_item_buffer(patches, 0, resolution=32)
    assert "on patch 0 (floor), 32 pixels" in figure.get_suptitle()
    legend = figure.axes[0].get_legend()
    labels = [text.get_text() for text in legend.get_texts()]
    assert any("right_green" in label for label in labels), labels
    assert any("nothing" in label for label in labels), labels
    with pytest.raises(ValueError, match="names must be from 1 to 14"):
        teaching.draw_item_buffer(patches, 0, names=15)


def test_numbers_need_no_matplotlib() -> None:
    script = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from radiosity import teaching\n"
        f"print(teaching.nusselt_form_factor({POINT}, {UP}, {ABOVE}))\n"
        "try:\n"
        f"    teaching.draw_nusselt({POINT}, {UP}, {ABOVE})\n"
        "except ImportError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    number, message = done.stdout.splitlines()
    assert float(number) == pytest.approx(0.1385316060, abs=1e-10)  # Howell B-3
    assert message == "pictures need matplotlib: pip install 'radiosity[plots]'"
