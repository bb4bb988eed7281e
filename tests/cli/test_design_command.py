"""``radiosity design``."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from known import Call

from radiosity.cli.design import read_targets, read_variables
from radiosity.cli.failure import ExitCode, Stop

QUICK = ("builtin:cornell-box", "--patches", 200, "--accuracy", 0.1)


def test_a_lamp_is_found_and_the_scene_saved(call: Call, tmp_path: Path) -> None:
    told = call("design", *QUICK, "--target", "floor=2", "--vary", "light=0:1000", "-o", "lit.npz", "--json")
    content = json.loads(told)
    assert content["met"] is True
    assert content["outputs"] == ["lit.npz"]
    (target,) = content["targets"]
    assert target["surface"] == "floor"
    assert target["achieved"] == pytest.approx(2.0, rel=1e-3)
    with np.load(tmp_path / "lit.npz") as arrays:
        emission = arrays["emission"]
    # The value is the mean over bands of the only surface that shines.
    assert emission.mean(axis=1).max() == pytest.approx(content["values"]["light"])
    assert "floor" in call("design", *QUICK, "--target", "floor=2", "--vary", "light=0:")


def test_paint_and_bands(call: Call) -> None:
    told = call(
        "design", *QUICK, "--target", "back=1,0.7,0.3", "--vary", "light=0:1000", "--paint", "floor=0.2:0.9",
        "--tolerance", 0.5, "--json",
    )  # fmt: skip
    content = json.loads(told)
    assert set(content["values"]) == {"light", "floor"}
    assert 0.2 <= content["values"]["floor"] <= 0.9
    assert len(content["targets"][0]["achieved"]) == 3


def test_what_is_missed_has_its_exit_code(call: Call, tmp_path: Path) -> None:
    with pytest.raises(Stop, match=r"missed 'floor' by .*: widen the bounds of 'light' at its highest") as stopped:
        call("design", *QUICK, "--target", "floor=1000", "--vary", "light=0:1", "-o", "lit.glb", "--quiet")
    assert stopped.value.code == ExitCode.ACCURACY
    assert (tmp_path / "lit.glb").exists()


def test_names_are_checked(call: Call) -> None:
    with pytest.raises(ValueError, match="no surface or light 'lihgt'; there is 'light'"):
        call("design", *QUICK, "--target", "floor=1", "--vary", "lihgt=0:1")
    with pytest.raises(ValueError, match="no surface 'flor'; there is 'floor'"):
        call("design", *QUICK, "--target", "flor=1", "--vary", "light=0:1")


@pytest.mark.parametrize(
    ("targets", "variables", "message"),
    [
        ([], ["a=0:1"], "nothing is wanted"),
        (["a=1"], [], "nothing may change"),
        (["500"], ["a=0:1"], "--target '500' names nothing"),
        (["a=b"], ["a=0:1"], "'b' is no number"),
        (["a=1"], ["a=5"], "--vary 'a=5' has no bounds: write a=0:2000"),
        (["a=1"], ["a=0:x"], "'x' is no number"),
    ],
)
def test_what_cannot_be_read(targets: list[str], variables: list[str], message: str) -> None:
    with pytest.raises(Stop, match=message) as stopped:
        read_targets(targets, [])
        read_variables(variables, [])
    assert stopped.value.code == ExitCode.ARGUMENTS


def test_what_can_be_read() -> None:
    mean, even = read_targets(["a = b=1,2"], ["desk=500"])
    assert (mean.surface, mean.value, mean.even) == ("a = b", [1.0, 2.0], False)
    assert (even.surface, even.value, even.even) == ("desk", 500.0, True)
    assert read_variables(["lamp=1:"], ["wall=0.1:0.5"]) == [
        ("lamp", (1.0, float("inf")), False),
        ("wall", (0.1, 0.5), True),
    ]
