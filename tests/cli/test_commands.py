"""What the commands do when all is well."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse
from known import Call, Runner

import radiosity
from radiosity.cli.failure import Stop
from radiosity.cli.options import read_size, read_triple
from radiosity.cli.source import Meshing, cut, make_builtin


def test_help_and_version(run: Runner, call: Call) -> None:
    shown = run("--help")
    assert shown.returncode == 0
    for command in ("solve", "design", "render", "factors", "check", "compare", "demo", "scenes"):
        assert f" {command} " in shown.stdout
        assert f" {command} " in call(command, "--help").split("\n\n")[0]
    assert call("--version") == f"radiosity {radiosity.__version__}\n"


def test_scenes_lists_what_a_file_may_be(run: Runner) -> None:
    lines = run("scenes").stdout.splitlines()
    assert [line.split()[0] for line in lines] == [
        f"builtin:{name}" for name in json.loads(run("scenes", "--json").stdout)
    ]
    assert run("check", lines[0].split()[0]).returncode == 0


def test_json_is_all_there_is_on_stdout(run: Runner) -> None:
    done = run("solve", "builtin:furnace", "--patches", 200, "--accuracy", 0.05, "--json")
    content = json.loads(done.stdout)
    assert content["scene"] == "builtin:furnace"
    assert content["outputs"] == content["findings"] == []
    report = content["report"]
    assert report["reached"] is True
    assert report["estimated_error"] <= report["accuracy"] == 0.05
    assert report["patches"] == pytest.approx(200, rel=0.3)


def test_quiet(run: Runner) -> None:
    done = run("solve", "builtin:furnace", "--patches", 100, "--accuracy", 0.1, "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_options_reach_the_engine(call: Call) -> None:
    def report(*more: object) -> dict[str, Any]:
        told = call("solve", "builtin:cornell-box", "--patches", 200, "--accuracy", 0.2, "--json", *more)
        return {k: v for k, v in json.loads(told)["report"].items() if "seconds" not in k}

    assert report("--threads", 1) == report("--threads", 2)
    assert report("--seed", 1)["estimated_error"] != report("--seed", 2)["estimated_error"]
    assert report("--two-sided")["sides"] == 2 * report("--one-sided")["sides"]


def test_check_lists_everything(run: Runner, tmp_path: Path) -> None:
    (tmp_path / "room.obj").write_text("o floor\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 1 1 2\n")
    shown, listed = run("check", "room.obj"), json.loads(run("check", "room.obj", "--json").stdout)
    assert shown.returncode == 3
    assert shown.stdout.splitlines()[0].startswith("room.obj: 1 surfaces")
    severities = [f["severity"] for f in listed["findings"]]
    assert [line.split()[0] for line in shown.stdout.splitlines()[1:]] == severities
    assert severities[0] == "error"
    assert "no-light" in [f["code"] for f in listed["findings"]]
    assert listed["sound"] is False


def test_factors_are_saved_as_scipy_reads_them(run: Runner, tmp_path: Path) -> None:
    options = ["builtin:two-plates", "--max-edge", 0.5, "--rays", 4096, "-o", "F.npz"]
    done = run("factors", *options, "--json")
    assert done.returncode == 0
    f = scipy.sparse.load_npz(tmp_path / "F.npz").toarray()
    with np.load(tmp_path / "F.npz") as table:
        area, surface = table["area"], table["surface"]
        np.testing.assert_allclose(table["closure"], f.sum(axis=1))
    assert f.shape == (8, 8)
    exchange = area[:, None] * f
    np.testing.assert_allclose(exchange, exchange.T)
    assert json.loads(done.stdout)["entries"] == np.count_nonzero(f)
    # The plates are unit squares at distance 1 (Howell, C-11).
    assert exchange[surface == 0][:, surface == 1].sum() == pytest.approx(0.1998249, abs=0.005)
    first = (tmp_path / "F.npz").read_bytes()
    run("factors", *options)
    assert (tmp_path / "F.npz").read_bytes() == first


def test_the_most_patches_allowed_are_never_exceeded() -> None:
    scene = make_builtin("cornell-box")
    for limit in (100, 777, 5000):
        patches = len(cut("it", scene, Meshing(max_patches=limit)))
        assert limit / 2 < patches <= limit
    with pytest.raises(Stop, match="more than --max-patches 10"):
        cut("it", scene, Meshing(max_patches=10))


@pytest.mark.parametrize(
    ("text", "size"),
    [("4GB", 4_000_000_000), ("500MiB", 500 << 20), ("1.5k", 1500), ("12", 12), (" 2 tb ", 2 * 10**12)],
)
def test_sizes(text: str, size: int) -> None:
    assert read_size(text) == size


@pytest.mark.parametrize("text", ["", "GB", "-1GB", "4XB", "4 GB of it"])
def test_what_is_no_size(text: str) -> None:
    with pytest.raises(Stop, match="is no size of memory"):
        read_size(text)


def test_points() -> None:
    assert read_triple("0,1.5,-2e1", "--look-at") == (0, 1.5, -20)
    for text in ("1,2", "1,2,3,4", "a,b,c", "1,2,nan", "inf,0,0"):
        with pytest.raises(Stop, match=r"--look-at .* is not a point"):
            read_triple(text, "--look-at")
