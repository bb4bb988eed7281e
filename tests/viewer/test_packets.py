"""Packets there and back, and the schema that page and session share."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import hypothesis.extra.numpy as arrays
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import radiosity
from radiosity.files import LitModel
from radiosity.viewer.lit import Lit, up_axis
from radiosity.viewer.packet import pack, unpack
from radiosity.viewer.typescript import written

VIEWER = Path(__file__).parents[2] / "viewer"


@dataclass
class Head:
    said: Any


NUMBERS = arrays.arrays(np.float32, arrays.array_shapes(min_side=0), elements=st.floats(width=32, allow_nan=False))
INDICES = arrays.arrays(np.uint32, arrays.array_shapes(min_side=0))


@given(st.text(), st.dictionaries(st.text(), NUMBERS | INDICES, max_size=5))
def test_what_is_packed_comes_out(said: str, blocks: dict[str, np.ndarray]) -> None:
    packet = pack(Head(said), blocks)
    head, found = unpack(packet)
    assert head == {"said": said}
    assert list(found) == list(blocks)
    for name, block in blocks.items():
        assert found[name].dtype == block.dtype
        np.testing.assert_array_equal(found[name], block)
    assert len(packet) % 8 == 0


@given(st.binary(max_size=100), st.sampled_from([b"", b"RADPKT01"]))
def test_what_is_no_packet_is_refused(data: bytes, magic: bytes) -> None:
    with pytest.raises(ValueError, match=r"this is no packet|this packet is damaged"):
        unpack(magic + data)


@given(st.integers(0))
def test_what_is_cut_off_is_refused(end: int) -> None:
    packet = pack(Head("all"), {"numbers": np.ones((3, 4), np.float32)})
    with pytest.raises(ValueError, match="packet"):
        unpack(packet[: end % len(packet)])


def test_numbers_that_json_does_not_have_become_null() -> None:
    head, _ = unpack(pack(Head([float("inf"), float("nan"), np.float64(2), {1: None}]), {}))
    assert head == {"said": [None, None, 2.0, {"1": None}]}


def test_the_page_has_the_same_schema() -> None:
    messages = VIEWER / "src" / "messages.ts"
    if not messages.is_file():
        pytest.skip("no checkout")
    assert messages.read_text() == written(), "run python -m radiosity.viewer.typescript viewer/src/messages.ts"


def test_a_scene_packet_has_the_arrays_of_the_model(lit_room: radiosity.Solution) -> None:
    model = LitModel.of(lit_room)
    head, found = unpack(Lit(model, title="room", unit="lux").scene_packet())
    json.dumps(head, allow_nan=False)
    assert (head["title"], head["unit"], head["is_layered"], head["is_lit"]) == ("room", "lux", False, True)
    assert len(head["surfaces"]) == len(model.surfaces)
    np.testing.assert_allclose(found["polygons"] + head["origin"], model.patches.polygons, atol=1e-6)
    np.testing.assert_array_equal(found["surface"], model.patches.surface)
    for name in ("emission", "irradiance"):
        np.testing.assert_array_equal(found[name][0], getattr(model, name).astype(np.float32))
    assert found["corner_irradiance"].shape == (1, len(model.patches), 4, 3)
    assert found["corner_irradiance"].min() >= 0


def camera(*up: float) -> radiosity.Camera:
    return radiosity.Camera((0, 0, 0), (0.6, 0.0, 0.8), up)


@pytest.mark.parametrize(
    ("ups", "axis"),
    [
        ([], (0, 1, 0)),
        ([(0, 0, 1)], (0, 0, 1)),
        ([(0.1, -0.2, 0.97), (0, 0, 1)], (0, 0, 1)),
        ([(0, 0, 1), (0, 1, 0)], (0, 1, 0)),
        ([(0, -1, 0)], (0, -1, 0)),
    ],
)
def test_up_is_what_cameras_agree_on(ups: list[tuple[float, ...]], axis: tuple[float, ...]) -> None:
    assert up_axis(camera(*up) for up in ups) == axis
