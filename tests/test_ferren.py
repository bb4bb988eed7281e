"""The boards: no front sees the window, and what colours a front is the paint of the back it faces."""

import numpy as np
import pytest

import radiosity
from radiosity import ferren as module
from radiosity.scenes import ferren


def mean_of(solution: radiosity.Solution, name: str) -> np.ndarray:
    index = [s.name for s in solution.patches.scene.surfaces].index(name)
    chosen = solution.patches.surface == index
    return np.average(solution.irradiance[chosen], axis=0, weights=solution.patches.area[chosen])


@pytest.mark.parametrize(("boards", "yaw"), [(6, 30), (7, 40), (9, 45), (9, 60)])
def test_no_front_sees_the_window(boards: int, yaw: float) -> None:
    patches = ferren(boards, yaw=yaw).patches(max_edge=0.15)
    names = np.array([s.name for s in patches.scene.surfaces])[patches.surface]
    fronts = np.array([name.endswith("front") and name != "end front" for name in names])
    window = names == "window"
    assert fronts.sum() >= 12 * boards
    to = patches.polygons[window].mean(axis=1)[None] - patches.polygons[fronts].mean(axis=1)[:, None]
    # Not one point of the window is on the side that any front looks to.
    assert (np.einsum("fwx,fx->fw", to, patches.normal[fronts]) < 0).all()


def test_fronts_have_the_colour_of_the_backs_they_face() -> None:
    solution = radiosity.solve(ferren().patches(count=3000), accuracy=0.05)
    for k in range(1, 8):
        light = mean_of(solution, f"board {k} front")
        paint = np.array(module.PAINTS[k % len(module.PAINTS)])
        # Light that left the paint once has its colour; the rest, which is seen at the side, is less.
        assert np.corrcoef(light, paint)[0, 1] > 0.7
        assert light.argmax() == paint.argmax() or np.ptp(np.sort(paint)[-2:]) < 0.2


def test_without_paint_the_fronts_are_neutral() -> None:
    daylight = (300.0, 300.0, 300.0)
    solution = radiosity.solve(ferren(paints=[module.WHITE], daylight=daylight).patches(count=1500), accuracy=0.1)
    for k in range(1, 8):
        light = mean_of(solution, f"board {k} front")
        # One band is like another to rounding: rays are the same for all.
        assert np.ptp(light) < 1e-6 * light.mean()
        assert light.mean() > 1


def test_boards_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 2"):
        ferren(1)
    with pytest.raises(ValueError, match="30 to 60"):
        ferren(yaw=10)
    with pytest.raises(ValueError, match="touch"):
        ferren(spacing=0.05)
