"""Saving solutions, and making pictures of them."""

from __future__ import annotations

import json
import re
import resource
from pathlib import Path

import numpy as np
import pytest
from known import Call, Runner
from PIL import Image

QUICK = ["builtin:cornell-box", "--patches", 300, "--accuracy", 0.1]
SMALL = ["--width", 40, "--height", 30, "--samples", 4]


def test_solve_saves_every_form_asked_for(run: Runner, tmp_path: Path) -> None:
    names = ["lit.glb", "lit.npz", "lit.vtp"]
    done = run("solve", *QUICK, *(part for name in names for part in ("-o", name)), "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["outputs"] == names
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    assert (tmp_path / "lit.glb").read_bytes()[:4] == b"glTF"
    with np.load(tmp_path / "lit.npz") as table:
        assert table["irradiance"].shape == (json.loads(done.stdout)["report"]["patches"], 3)


def test_the_same_seed_gives_the_same_files(run: Runner, tmp_path: Path) -> None:
    for name in ("one", "two"):
        outputs = [part for suffix in (".glb", ".npz", ".vtp") for part in ("-o", name + suffix)]
        run("solve", *QUICK, *outputs, "--threads", 1 if name == "one" else 2)
    for suffix in (".glb", ".npz", ".vtp"):
        assert (tmp_path / f"one{suffix}").read_bytes() == (tmp_path / f"two{suffix}").read_bytes()


def test_the_result_is_saved_though_the_accuracy_is_not_reached(run: Runner, tmp_path: Path) -> None:
    assert run("solve", *QUICK[:3], "--max-rays", 16, "-o", "lit.npz").returncode == 4
    assert (tmp_path / "lit.npz").exists()


@pytest.mark.parametrize("name", ["lit.glb", "lit.npz", "lit.vtp", "lit.png", "lit.exr"])
def test_a_full_disk_leaves_no_file(run: Runner, tmp_path: Path, name: str) -> None:
    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    command = ["solve"] if name in ("lit.glb", "lit.npz", "lit.vtp") else ["render", *SMALL]
    done = run(*command, *QUICK, "-o", name, preexec_fn=full)
    assert done.returncode == 5
    assert done.stderr == f"radiosity: {name}: File too large: free some space or write elsewhere\n"
    assert list(tmp_path.iterdir()) == []


def test_a_lit_model_is_not_lit_again(run: Runner, tmp_path: Path) -> None:
    run("solve", *QUICK, "-o", "lit.glb")
    solved = run("solve", "lit.glb", "-o", "again.glb")
    assert (solved.returncode, solved.stdout) == (3, "")
    assert solved.stderr.startswith("radiosity: lit.glb: the file is a lit model: a solution already")
    assert "draw it with radiosity render" in solved.stderr
    checked = run("check", "lit.glb", "--json")
    assert checked.returncode == 3
    findings = json.loads(checked.stdout)["findings"]
    assert findings[0]["code"] == "lit-model"
    assert "metallic-material" not in {finding["code"] for finding in findings}


def test_a_lit_model_takes_no_unit(run: Runner) -> None:
    run("solve", *QUICK, "-o", "lit.glb")
    done = run("render", "lit.glb", "-o", "lit.png", *SMALL, "--unit", "mm")
    assert (done.returncode, done.stderr) == (2, "radiosity: lit models are in metres: leave out --unit\n")


def test_the_angle_of_view_holds_without_a_camera(run: Runner, tmp_path: Path) -> None:
    (tmp_path / "lamp.mtl").write_text("newmtl lamp\nKd 0.5 0.5 0.5\nKe 1 1 1\n")
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    (tmp_path / "lamp.obj").write_text(f"mtllib lamp.mtl\n{square}usemtl lamp\nf 1 2 3 4\n")
    for name, angle in [("far", 90), ("near", 10)]:
        assert run("render", "lamp.obj", "-o", f"{name}.png", *SMALL, "--fov", angle).returncode == 0
    assert np.mean(picture(tmp_path / "near.png") > 0) > 2 * np.mean(picture(tmp_path / "far.png") > 0)


def test_the_source_is_not_overwritten(run: Runner, tmp_path: Path) -> None:
    run("solve", *QUICK, "-o", "lit.glb")
    before = (tmp_path / "lit.glb").read_bytes()
    done = run("solve", "lit.glb", "-o", "lit.glb")
    assert done.returncode == 2
    assert "this would overwrite the file it is made from" in done.stderr
    assert (tmp_path / "lit.glb").read_bytes() == before


def picture(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB"), dtype=float)


def test_a_lit_model_is_drawn_like_the_scene_it_came_from(run: Runner, tmp_path: Path) -> None:
    run("solve", *QUICK, "-o", "lit.glb")
    assert run("render", "lit.glb", "-o", "lit.png", *SMALL, "--camera", 0).returncode == 0
    assert run("render", *QUICK, "-o", "scene.png", *SMALL).returncode == 0
    lit, scene = picture(tmp_path / "lit.png"), picture(tmp_path / "scene.png")
    assert lit.shape == scene.shape == (30, 40, 3)
    assert scene.std() > 10
    # A lit model holds single precision, so that hardly a pixel may differ by more than a step or two.
    assert np.mean(np.abs(lit - scene) > 2) < 0.01


def test_views_and_quantities_differ(call: Call, tmp_path: Path) -> None:
    call("solve", *QUICK, "-o", "lit.glb")
    variants: list[list[object]] = [
        [],
        ["--show", "irradiance"],
        ["--mode", "patches"],
        ["--exposure", -8],
        ["--look-from", "0.1,0.3,0.1", "--look-at", "0.3,0.2,0.5"],
        ["--fov", 20],
    ]
    pictures = []
    for k, options in enumerate(variants):
        assert call("render", "lit.glb", "-o", f"{k}.png", *SMALL, *options) == f"wrote {k}.png\n"
        pictures.append((tmp_path / f"{k}.png").read_bytes())
    assert len(set(pictures)) == len(variants)


def test_path_tracing_solves_nothing_and_tells_its_errors(run: Runner, tmp_path: Path) -> None:
    done = run("render", "builtin:cornell-box", "-o", "a.png", *SMALL, "--mode", "path", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    told = json.loads(done.stdout)
    assert told["report"] is None
    assert told["paths"]["samples"] == 4
    assert 0 < told["paths"]["relative_error"] < 2
    said = run("render", "builtin:cornell-box", "-o", "a.png", *SMALL[:4], "--mode", "path", "--accuracy", 0.2)
    assert said.returncode == 0
    assert "mean relative standard error" in said.stdout
    missed = run("render", "builtin:cornell-box", "-o", "b.png", *SMALL, "--mode", "path", "--accuracy", 1e-4)
    assert missed.returncode == 4
    assert "after 4 paths a pixel; raise --samples" in missed.stderr
    assert picture(tmp_path / "b.png").std() > 10


def test_a_gathered_lit_model(run: Runner, tmp_path: Path) -> None:
    run("solve", *QUICK, "-o", "lit.glb")
    done = run("render", "lit.glb", "-o", "gather.png", *SMALL, "--mode", "gather")
    assert done.returncode == 0
    assert re.search(r"[0-9,]+ rays, noise [0-9.]+% of the mean", done.stdout)
    assert run("render", "lit.glb", "-o", "path.png", *SMALL, "--mode", "path", "--samples", 256).returncode == 0
    gathered, traced = picture(tmp_path / "gather.png"), picture(tmp_path / "path.png")
    assert np.mean(np.abs(gathered - traced)) < 12


def test_false_colours_have_a_legend(call: Call, tmp_path: Path) -> None:
    call("solve", *QUICK, "-o", "lit.glb")
    said = call("render", "lit.glb", "-o", "a.png", *SMALL, "--show", "error", "--false-colours")
    assert "colours from 0 to" in said
    assert picture(tmp_path / "a.png").shape[1] > 40 + 80


def test_a_mode_that_cannot_show_it(run: Runner, tmp_path: Path) -> None:
    done = run("render", *QUICK, "-o", "a.png", "--mode", "gather", "--show", "error")
    assert done.returncode == 2
    assert "--mode gather cannot show error: choose --show radiosity or irradiance" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_camera(run: Runner, tmp_path: Path) -> None:
    done = run("render", *QUICK, "-o", "a.png", "--camera", "attic")
    assert done.returncode == 2
    assert "there is no camera 'attic'; there are: 0 'camera'" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_radiance_for_other_programs(run: Runner, tmp_path: Path) -> None:
    assert run("render", *QUICK, "-o", "a.exr", "-o", "a.png", *SMALL).returncode == 0
    assert (tmp_path / "a.exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"


def test_demo(run: Runner, tmp_path: Path) -> None:
    done = run("demo", "two-plates", "--json")
    assert done.returncode == 0
    outputs = json.loads(done.stdout)["outputs"]
    assert outputs == [f"out/two-plates{suffix}" for suffix in (".glb", ".png", ".npz")]
    assert all((tmp_path / path).stat().st_size > 0 for path in outputs)
