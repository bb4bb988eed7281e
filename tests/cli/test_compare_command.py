"""``radiosity compare``, and the modes of ``radiosity render`` that it shows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from known import Call, Runner
from PIL import Image

from radiosity.cli.failure import Stop

SMALL = ["--width", 60, "--height", 40, "--samples", 4]
QUICK = ["cornell-box", *SMALL, "--patches", 300, "--accuracy", 0.1]


def pixels(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB"), dtype=float)


def test_one_command_makes_the_comparison(run: Runner, tmp_path: Path) -> None:
    done = run("compare", "ferren", *SMALL, "--patches", 1500, "--accuracy", 0.1)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0].split() == ["mean", "subject", "from", "path", "by", "noise"]
    assert [line.split()[0] for line in lines[1:5]] == ["whitted", "direct", "gather", "path"]
    assert lines[2].split()[2] == "0"
    assert lines[-1] == "wrote out/ferren-comparison.png"
    sheet = pixels(tmp_path / "out/ferren-comparison.png")
    assert sheet.shape[1] > 4 * 60
    assert sheet.shape[0] > 40
    # Paper between panels.
    assert (sheet[:, 0] == 255).all()


def test_panels_are_saved_and_told_of(call: Call, tmp_path: Path) -> None:
    panels = ["--panels", "direct, patches,smooth", "--columns", 2, "--each", ".exr", "--each", ".png"]
    told = json.loads(call("compare", *QUICK, *panels, "-o", "a.png", "--of", "tall*", "--exposure", 1.5, "--json"))
    assert told["scene"] == "builtin:cornell-box"
    assert told["exposure"] == 1.5
    assert told["report"]["reached"] is True
    assert [panel["mode"] for panel in told["panels"]] == ["direct", "patches", "smooth"]
    assert all(set(panel) == {"mode", "luminance", "subject"} for panel in told["panels"])
    assert told["panels"][0]["luminance"] < told["panels"][1]["luminance"]
    names = ["a.png", *(f"a-{mode}{suffix}" for mode in ("direct", "patches", "smooth") for suffix in (".exr", ".png"))]
    assert told["outputs"] == names
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    sheet, single = pixels(tmp_path / "a.png"), pixels(tmp_path / "a-smooth.png")
    assert single.shape == (40, 60, 3)
    # Each panel is on the sheet, pixel by pixel.
    windows = np.lib.stride_tricks.sliding_window_view(sheet, single.shape)[:, :, 0]
    assert (windows == single).all(axis=(2, 3, 4)).sum() == 1


def test_the_same_seed_gives_the_same_sheet(call: Call, tmp_path: Path) -> None:
    for name, threads in (("a", 1), ("b", 2)):
        call("compare", *QUICK, "-o", f"{name}.png", "--threads", threads, "--quiet")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_what_needs_no_solution_is_not_solved(call: Call) -> None:
    told = json.loads(call("compare", "ferren", *SMALL, "--panels", "whitted,direct", "--ambient", 1, "--json"))
    assert told["report"] is None
    assert told["panels"][1]["subject"] == 0
    # The ambient light alone: of luminance rho / pi on white fronts.
    assert told["panels"][0]["subject"] == pytest.approx(0.8 / np.pi, rel=1e-4)


def test_a_lit_model_is_compared_as_it_is(call: Call) -> None:
    call("solve", "builtin:cornell-box", "--patches", 300, "--accuracy", 0.1, "-o", "lit.glb")
    told = json.loads(call("compare", "lit.glb", *SMALL, "--panels", "smooth,path", "-o", "a.png", "--json"))
    assert told["report"] is None
    assert 0 < told["panels"][0]["difference"] < 2


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--panels", "gather,rough"], "there is no mode 'rough'"),
        (["--panels", "gather,gather"], "name every mode once"),
        (["--panels", "gather", "--ambient", 1], "--ambient is for --mode whitted"),
        (["--ambient", -1], "--ambient must be a number of W/m2 from 0 on, not -1"),
        (["--each", ".jpg"], "--each .jpg: choose .png or .exr"),
        (["-o", "a.exr"], "a.exr: name a file that ends in .png"),
        (["--of", "sofa", "-o", "a.png"], "--of 'sofa': no surface of that name is seen"),
    ],
)
def test_what_cannot_be_compared(call: Call, tmp_path: Path, options: list[object], sentence: str) -> None:
    with pytest.raises(Stop, match=sentence):
        call("compare", *QUICK, *options)
    assert not list(tmp_path.glob("*.png"))


def test_without_matplotlib_there_is_no_sheet(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radiosity.cli.comparison.find_spec", lambda name: None)
    with pytest.raises(Stop, match=r"needs matplotlib: pip install 'radiosity\[plots\]'"):
        call("compare", *QUICK)


def test_pictures_by_direct_and_by_ambient_light(call: Call, tmp_path: Path) -> None:
    for mode, more in (("direct", []), ("whitted", ["--ambient", 2])):
        said = call("render", "builtin:ferren", "-o", f"{mode}.png", *SMALL, "--mode", mode, *more)
        assert said == f"wrote {mode}.png\n"
    quick = ["builtin:cornell-box", *SMALL, "--patches", 300, "--accuracy", 0.1, "--exposure", 0]
    call("render", *quick, "-o", "a.png", "--mode", "whitted")
    call("render", *quick, "-o", "b.png", "--mode", "direct")
    assert pixels(tmp_path / "a.png").mean() > pixels(tmp_path / "b.png").mean()
    with pytest.raises(Stop, match="--ambient is for --mode whitted"):
        call("render", *quick, "-o", "c.png", "--ambient", 1)
