"""Solutions as files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from known import cube, square

from radiosity import Solution, Surface, solve
from radiosity.files import LitModel, load_lit, write_whole


def test_a_lit_model_comes_back_in_single_precision(cornell: Solution, tmp_path: Path) -> None:
    cornell.save(tmp_path / "lit.glb")
    lit = load_lit(tmp_path / "lit.glb")
    assert lit is not None
    for name in ("emission", "irradiance", "radiosity", "error"):
        np.testing.assert_allclose(getattr(lit, name), getattr(cornell, name), rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(lit.patches.polygons, cornell.patches.polygons, atol=1e-6)
    assert lit.patches.surface.tolist() == cornell.patches.surface.tolist()
    assert [name for name, *_ in lit.surfaces] == [s.name for s in cornell.patches.scene.surfaces]
    assert lit.bands == ["R", "G", "B"]
    assert lit.report["estimated_error"] == cornell.report.estimated_error
    assert lit.cameras[0].forward == cornell.patches.scene.cameras[0].forward


def test_arrays_come_back_as_they_were(cornell: Solution, tmp_path: Path) -> None:
    cornell.save(tmp_path / "lit.npz")
    with np.load(tmp_path / "lit.npz") as table:
        for name in ("irradiance", "radiosity", "emission", "error", "reflectance"):
            assert np.array_equal(table[name], getattr(cornell, name)), name
        for name in ("area", "normal", "centre", "polygons", "surface"):
            assert np.array_equal(table[name], getattr(cornell.patches, name)), name
        report = json.loads(str(table["report"]))
    assert report["patches"] == len(cornell.patches)
    assert not any("seconds" in name for name in report)


def test_backs_become_patches_of_their_own() -> None:
    scene = cube(0.5, {"ceiling": 1.0})
    scene.surfaces.append(Surface(np.add(square(0.5, z=0.5), [0.5, 0.5, 0]), [[0, 1, 2, 3]], 0.5, name="sheet",
                                  two_sided=True))  # fmt: skip
    solution = solve(scene.patches(max_edge=0.3), accuracy=0.1)
    lit, n, back = LitModel.of(solution), len(solution.patches), solution.patches.two_sided
    assert len(lit.patches) == n + back.sum()
    assert np.array_equal(lit.irradiance, np.concatenate([solution.irradiance, solution.back_irradiance[back]]))
    np.testing.assert_allclose(lit.patches.normal[n:], -solution.patches.normal[back], atol=1e-12)
    np.testing.assert_allclose(lit.patches.area[n:], solution.patches.area[back])
    assert {lit.surfaces[k][0] for k in lit.patches.surface[n:]} == {"sheet (back)"}
    # The front faces the lamp.
    assert solution.irradiance[back].mean() > solution.back_irradiance[back].mean()


def test_a_lit_model_takes_other_light_of_the_same_patches(cornell: Solution) -> None:
    model, other = LitModel.of(cornell), cornell.relight(emission=2 * cornell.emission, reflectance=0.1)
    relit = model.relit(other)
    assert relit.patches is model.patches
    np.testing.assert_allclose([rho for _, _, rho, *_ in relit.surfaces], 0.1, rtol=1e-12)
    for name in ("emission", "irradiance", "radiosity", "error"):
        assert np.array_equal(getattr(relit, name), getattr(LitModel.of(other), name))
    with pytest.raises(ValueError, match="on other patches than the model"):
        model.relit(solve(cube(), accuracy=0.5, transport="hierarchical"))


def test_what_cannot_be_written_is_refused(cornell: Solution, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"cannot write '\.pdf' files; use one of \.glb, \.npz, \.vtp"):
        cornell.save(tmp_path / "lit.pdf")
    for name in ("lit.glb", "lit.npz", "lit.vtp"):
        with pytest.raises(OSError, match="No such file or directory"):
            cornell.save(tmp_path / "none" / name)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_fails_leaves_the_one_before(tmp_path: Path) -> None:
    def fail(file: object) -> None:
        file.write(b"half")
        raise RuntimeError("no more")

    path = tmp_path / "a.bin"
    path.write_bytes(b"before")
    with pytest.raises(RuntimeError, match="no more"):
        write_whole(path, fail)
    assert path.read_bytes() == b"before"
    assert [p.name for p in tmp_path.iterdir()] == ["a.bin"]


def test_a_scene_is_no_lit_model() -> None:
    study = Path(__file__).parent.parent / "scenes" / "study.glb"
    assert load_lit(study) is None
