"""Lamps of a scene, and the light of each."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from known import square

import radiosity
from radiosity.files import LitModel
from radiosity.viewer.layers import MOST_LAMPS, factors, lamps, layers


def many_lamps(materials: list[str], names: list[str], powers: list[float]) -> radiosity.Patches:
    """Squares in a row that shine, and a spot in the same place for each name."""
    surfaces = [
        radiosity.Surface(np.add(square(), [2 * k, 0, 0]), [[0, 1, 2, 3]], 0.5, power, f"panel {k}", material=material)
        for k, (material, power) in enumerate(zip(materials, powers, strict=True))
    ]
    lights = [radiosity.SpotLight([0, 0, 3], [0, 0, -1], 5.0, name=name) for name in names]
    return radiosity.Scene([*surfaces, radiosity.Surface(square(), [[0, 1, 2, 3]])], lights).patches(as_is=True)


def test_few_lamps_are_one_each() -> None:
    patches = many_lamps(["white", "white"], ["spot 1", "spot 2"], [1.0, 2.0])
    found = lamps(patches)
    assert [lamp.name for lamp in found] == ["panel 0", "panel 1", "spot 1", "spot 2"]
    assert [lamp.surfaces for lamp in found] == [[0], [1], [], []]
    assert [lamp.lights for lamp in found] == [[], [], [0], [1]]


def test_many_lamps_go_by_material_and_by_name() -> None:
    patches = many_lamps(["white"] * 10 + ["red"], [f"desk ({k})" for k in range(9)], [1.0] * 11)
    found = lamps(patches)
    assert [lamp.name for lamp in found] == ["white", "panel 10", "desk"]
    assert found[0].surfaces == list(range(10))
    assert found[2].lights == list(range(9))


def test_the_weakest_are_one_where_there_are_too_many() -> None:
    powers = [float(k + 1) for k in range(40)]
    found = lamps(many_lamps([f"paint {k}" for k in range(40)], [], powers))
    assert len(found) == MOST_LAMPS
    assert sorted(k for lamp in found for k in lamp.surfaces) == list(range(40))
    rest = next(lamp for lamp in found if lamp.name == "other lamps")
    assert rest.surfaces == list(range(40 - MOST_LAMPS + 1))


def test_names_are_told_apart() -> None:
    patches = many_lamps([], ["lamp", "lamp", "lamp 2", ""], [])
    assert [lamp.name for lamp in lamps(patches)] == ["lamp", "lamp 2", "lamp 2 2", "lamp 3"]


def test_what_is_dark_is_no_lamp() -> None:
    patches = many_lamps(["white", "white"], ["spot"], [0.0, 1.0])
    assert [lamp.name for lamp in lamps(patches)] == ["panel 1", "spot"]
    dark = lamps(patches, 0 * patches.emission, np.zeros((1, 1)))
    assert dark == []


@given(st.integers(0, 60), st.integers(0, 60), st.integers(1, 5), st.randoms(use_true_random=False))
def test_every_source_is_in_one_lamp(surfaces: int, lights: int, kinds: int, random: object) -> None:
    powers = [random.random() + 0.1 for _ in range(surfaces)]  # type: ignore[attr-defined]
    materials = [f"m{random.randrange(kinds)}" for _ in range(surfaces)]  # type: ignore[attr-defined]
    found = lamps(many_lamps(materials, [f"light {k}" for k in range(lights)], powers))
    assert len(found) <= MOST_LAMPS
    assert sorted(k for lamp in found for k in lamp.surfaces) == list(range(surfaces))
    assert sorted(k for lamp in found for k in lamp.lights) == list(range(lights))
    assert len({lamp.name for lamp in found}) == len(found)


def test_factors_reach_what_a_lamp_is_made_of() -> None:
    patches = many_lamps(["white", "white"], ["spot"], [1.0, 2.0])
    emitted, shone = factors(lamps(patches), patches, np.array([[0.5], [2.0], [3.0]]))
    assert emitted.tolist() == [[0.5], [2.0], [1.0]]
    assert shone.tolist() == [[3.0]]


@pytest.mark.parametrize("transport", ["sampled", "hierarchical"])
def test_layers_add_up(transport: str) -> None:
    from rooms import lamp_room

    patches = lamp_room().patches(count=200)
    solution = radiosity.solve(patches, transport=transport, accuracy=0.05)  # type: ignore[arg-type]
    model, found = LitModel.of(solution), lamps(patches)
    assert [lamp.name for lamp in found] == ["warm", "cold", "screen", "bulb", "sun"]
    each = layers(solution, found, model)
    for name in ("emission", "irradiance", "radiosity"):
        whole = getattr(model, name)
        total = sum(getattr(layer, name) for layer in each)
        np.testing.assert_allclose(total, whole, rtol=1e-12, atol=1e-12 * whole.max())
    # Backs of the sheet, which the screen below it lights, are among them.
    backs = np.arange(len(patches), len(model.patches))
    assert each[2].irradiance[backs].max() > 0


def test_layers_are_what_the_engine_finds(lit_room: radiosity.Solution) -> None:
    """Scaling them to add up changes them by no more than the solver leaves."""
    model, found = LitModel.of(lit_room), lamps(lit_room.patches)
    for which, layer in enumerate(layers(lit_room, found, model)):
        weights = np.zeros((len(found), 3))
        weights[which] = 1
        emitted, shone = factors(found, lit_room.patches, weights)
        alone = lit_room.relight(emission=lit_room.emission * emitted, lights=lit_room.lights * shone)
        scale = alone.irradiance.max()
        np.testing.assert_allclose(layer.irradiance[: len(alone.irradiance)], alone.irradiance, atol=1e-2 * scale)


def test_one_lamp_is_all_light(cornell: radiosity.Solution) -> None:
    model = LitModel.of(cornell)
    (only,) = layers(cornell, lamps(cornell.patches), model)
    assert np.array_equal(only.irradiance, model.irradiance)
