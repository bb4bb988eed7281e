"""The hierarchical exchange: its products, its files, and solving on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import radiosity
from radiosity import FormFactors, Patches, choice, factors, form_factors, scenes, solve


@pytest.fixture(scope="module")
def box() -> Patches:
    return scenes.cornell_box().patches(count=1500)


@pytest.fixture(scope="module")
def blocks(box: Patches) -> FormFactors:
    return form_factors(box, method="hierarchical", tolerance=5e-3)


def rms(values: npt.NDArray[np.float64], area: npt.NDArray[np.float64]) -> float:
    return float(np.sqrt(np.average(values**2, weights=area)))


def test_products_are_within_the_tolerance(box: Patches, blocks: FormFactors) -> None:
    exact = form_factors(box, tolerance=5e-4)
    for x in (np.ones(len(box)), np.random.default_rng(1).random(len(box)), box.centre[:, 0] / box.centre[:, 0].max()):
        assert rms(blocks @ x - exact @ x, box.area) < 5e-3
    off = rms(blocks.closure() - exact.closure(), box.area)
    assert 0.5 * off < blocks.report.estimated_error < 5e-3
    assert blocks.report.memory_bytes < 0.7 * exact.report.memory_bytes


def test_rows_and_the_dense_matrix_are_products(blocks: FormFactors) -> None:
    dense = blocks.toarray()
    x = np.random.default_rng(2).random(len(dense))
    np.testing.assert_allclose(dense @ x, blocks @ x, rtol=1e-10)
    np.testing.assert_allclose(blocks.row(7), dense[7], rtol=1e-12)
    np.testing.assert_allclose(blocks.to_scipy_sparse() @ x, blocks @ x, rtol=1e-10)
    assert blocks.reciprocity_error() < 1e-12


def test_what_blocks_cannot(box: Patches, blocks: FormFactors) -> None:
    with pytest.raises(ValueError, match=r"out of reach of blocks: ask for 0\.0005 or more"):
        form_factors(box, method="hierarchical", tolerance=1e-5)
    with pytest.raises(ValueError, match="hierarchical and keeps no single form factors"):
        blocks.enforce("closure")


def test_auto_takes_blocks_for_many_patches(box: Patches, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(factors, "MANY_PATCHES", 1000)
    report = form_factors(box, tolerance=2e-2).report
    assert (report.method, report.why) == ("hierarchical", f"{len(box):,} sides and a tolerance of 2.0e-02")
    assert form_factors(box.scene.patches(count=300), tolerance=2e-2).report.method == "auto"


def test_built_onto_a_file(box: Patches, blocks: FormFactors, tmp_path: Path) -> None:
    path, x = tmp_path / "F.exchange", np.random.default_rng(3).random((len(box), 3))
    built = form_factors(box, method="hierarchical", tolerance=5e-3, checkpoint=path)
    assert (built @ x).tobytes() == (blocks @ x).tobytes()
    assert built.report.links_partly_hidden == blocks.report.links_partly_hidden > 0
    assert built.report.estimated_error == pytest.approx(blocks.report.estimated_error, rel=1e-6)
    # What a killed process leaves: some blocks, and the beginning of another.
    content = path.read_bytes()
    path.unlink()
    (tmp_path / "F.exchange.partial").write_bytes(content[: len(content) // 2])
    form_factors(box, method="hierarchical", tolerance=5e-3, checkpoint=path)
    assert path.read_bytes() == content
    loaded = FormFactors.load(path, box)
    assert (loaded @ x).tobytes() == (blocks @ x).tobytes()
    blocks.save(tmp_path / "G.exchange")
    assert (FormFactors.load(tmp_path / "G.exchange", box) @ x).tobytes() == (blocks @ x).tobytes()


def test_solving_agrees_with_samples(box: Patches) -> None:
    # Around the feet of the blocks neighbours are no squares of four, and what the size of patches leaves is
    # overestimated: the error is below 1 %.
    lit = solve(box, accuracy=0.02, transport="hierarchical")
    assert lit.report.reached
    assert abs(lit.report.imbalance) < 0.02
    assert not any(lit.report.from_lights)
    assert (lit.report.transport, lit.report.why) == ("hierarchical", "")
    reference = solve(box, accuracy=0.005, transport="sampled")
    mean = np.average(reference.irradiance.mean(axis=1), weights=box.area)
    off = np.sqrt(np.average(((lit.irradiance - reference.irradiance) ** 2).mean(axis=1), weights=box.area)) / mean
    assert off < 1.5 * np.hypot(lit.report.estimated_error, reference.report.estimated_error)


@pytest.mark.parametrize("reflectance", [0.5, 0.9])
def test_the_furnace(reflectance: float) -> None:
    # A closed box with equal emission and reflectance everywhere: B = E / (1 - rho), whatever stands in it.
    patches = scenes.furnace(reflectance).patches(count=1200)
    lit = solve(patches, accuracy=0.01, transport="hierarchical")
    emission = patches.emission[0, 0]
    mean = np.average(lit.radiosity[:, 0], weights=patches.area)
    assert mean * (1 - reflectance) / emission == pytest.approx(1, abs=0.01)


def test_relighting(box: Patches) -> None:
    lit = solve(box, accuracy=0.02, transport="hierarchical")
    # Twice the lamp is twice the light, from lamps that were tested as from the exchange.
    np.testing.assert_allclose(lit.relight(emission=2 * lit.emission).irradiance, 2 * lit.irradiance, rtol=1e-5)
    red = lit.emission * [1.0, 0.5, 0.1]
    np.testing.assert_allclose(lit.relight(emission=red).irradiance, lit.irradiance * [1.0, 0.5, 0.1], rtol=1e-4)
    dark = lit.relight(emission=0.0)
    assert np.all(dark.irradiance == 0)
    black = lit.relight(reflectance=0.0)
    assert np.all(black.radiosity == black.emission)
    assert np.all(black.irradiance <= lit.irradiance + 1e-12)


def test_lights_without_area() -> None:
    room = scenes.furnace(0.5, emission=0.0)
    room = radiosity.Scene(room.surfaces, lights=[radiosity.PointLight([0.1, 0.2, 0.3], 1.0)])
    patches = room.patches(count=900)
    lit, reference = (solve(patches, accuracy=0.02, transport=way) for way in ("hierarchical", "sampled"))
    mean = np.average(reference.irradiance[:, 0], weights=patches.area)
    off = rms(lit.irradiance[:, 0] - reference.irradiance[:, 0], patches.area) / mean
    assert off < 2 * np.hypot(lit.report.estimated_error, reference.report.estimated_error)
    assert lit.report.from_lights[0] == pytest.approx(reference.report.from_lights[0], rel=0.02)
    assert abs(lit.report.imbalance) < 0.02


def test_the_same_bytes_on_any_number_of_threads(box: Patches) -> None:
    one, three = (solve(box, accuracy=0.05, transport="hierarchical", threads=threads) for threads in (1, 3))
    assert one.irradiance.tobytes() == three.irradiance.tobytes()
    assert one.report.to_dict(timed=False) == three.report.to_dict(timed=False)


def test_the_choice(box: Patches) -> None:
    plenty = 10**12
    assert choice.choose(box, 0.01, plenty)[0] == "sampled"

    class Many:
        def __init__(self, n: int) -> None:
            self.n, self.two_sided, self.is_specular = n, np.zeros(n, bool), False
            self.is_translucent = False

        def __len__(self) -> int:
            return self.n

    def of(n: int, accuracy: float, memory: int) -> str:
        return choice.choose(Many(n), accuracy, memory)[0]  # type: ignore[arg-type]

    assert of(20_000, 0.01, plenty) == "hierarchical"
    assert of(20_000, 0.001, plenty) == "sampled"
    assert of(20_000, 0.01, 10**7) == "shooting"
    assert of(2_000_000, 0.02, plenty) == "shooting"


def test_the_choice_is_told(box: Patches, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choice, "MANY_SIDES", 1000)
    report = solve(box, accuracy=0.05).report
    assert (report.transport, report.why) == ("hierarchical", f"{len(box):,} sides are many")
    monkeypatch.setattr(choice, "TOO_MANY_SIDES", 1001)
    report = solve(box, accuracy=0.1).report
    assert report.transport == "shooting"
    assert "too many" in str(report)


def test_wrong_transports(box: Patches) -> None:
    with pytest.raises(ValueError, match="there is no transport 'dense'; choose sampled or hierarchical"):
        solve(box, transport="dense")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="shooting has no transport"):
        solve(box, transport="sampled", solver="shooting")
    with pytest.raises(ValueError, match="southwell shoots from rows, not samples"):
        solve(box, transport="sampled", solver="southwell")
