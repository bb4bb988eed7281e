"""The command ``radiosity factors``."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse
from known import ADJACENT, CUBE, INWARD, OPPOSITE, VIEW3D_CUBE, Call, Runner, cube_factors, tiles, write_stl

import radiosity
from radiosity.cli.failure import ExitCode, diagnose
from radiosity.factors import SINGLE_METHODS

SCENES = Path(__file__).parents[2] / "scenes"
ROOM, DUCT, PIPE = SCENES / "room.vs3", SCENES / "corner.stl", SCENES / "corner.ply"
TOLERANCE = 1e-6


@pytest.fixture
def cube(tmp_path: Path) -> str:
    """A PLY of the unit cube seen from inside, a square a face."""
    header = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    corners = "".join(f"{x} {y} {z}\n" for x, y, z in CUBE)
    faces = "".join(f"4 {a} {b} {c} {d}\n" for a, b, c, d in INWARD.values())
    table = f"{header}element face 6\nproperty list uchar int vertex_indices\nend_header\n{corners}{faces}"
    (tmp_path / "cube.ply").write_text(table)
    return "cube.ply"


def told(call: Call, *arguments: object) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(call("factors", *arguments, "--json"))
    return content


def table(path: Path) -> tuple[list[str], list[list[str]]]:
    with path.open(newline="") as file:
        head, *rows = list(csv.reader(file))
    return head, rows


def codes(content: dict[str, Any]) -> set[str]:
    return {finding["code"] for finding in content["findings"]}


def refused(call: Call, *arguments: object) -> tuple[ExitCode, str]:
    with pytest.raises(Exception) as caught:
        call("factors", *arguments)
    return diagnose(caught.value)


def test_a_room_of_view3d_has_factors_between_its_surfaces(call: Call, tmp_path: Path) -> None:
    content = told(call, ROOM, "-o", "F.csv")
    head, rows = table(tmp_path / "F.csv")
    names = ["floor", "ceiling", "back", "window", "front", "left", "right", "plate"]
    assert head == ["", *names]
    assert [row[0] for row in rows] == names == content["surfaces"]["names"]
    factors = np.array([[float(cell) for cell in row[1:]] for row in rows])
    assert np.array_equal(factors, content["surfaces"]["F"])
    area = np.array(content["surfaces"]["area"])
    # 4 m x 2.5 m x 3 m; a window of 1.4 m x 1.1 m in the back, both parts of the ceiling together.
    assert area == pytest.approx([12, 12, 10 - 1.54, 1.54, 10, 7.5, 7.5, 0.16])
    assert area[:, None] * factors == pytest.approx((area[:, None] * factors).T, abs=1e-12)
    # The plate faces up and nothing is above it but the room.
    assert factors[7].sum() == pytest.approx(1, abs=8 * TOLERANCE)
    # What lies in one plane does not see each other, and the plate lies on a table above the floor.
    assert factors[2, 3] == pytest.approx(0, abs=1e-12)
    assert factors[0, 7] == 0


def test_a_room_of_view3d_by_patch(call: Call, tmp_path: Path) -> None:
    content = told(call, ROOM, "--by", "patch", "-o", "F.csv", "-o", "F.npz")
    assert content["patches"] == 12
    assert content["outputs"] == ["F.csv", "F.npz"]
    head, rows = table(tmp_path / "F.csv")
    assert head == ["from", "to", "factor", "from_surface", "to_surface"]
    assert {row[3] for row in rows} >= {"ceiling", "ceiling_right"}
    matrix = scipy.sparse.load_npz(tmp_path / "F.npz").toarray()
    assert [float(row[2]) for row in rows] == [matrix[int(row[0]), int(row[1])] for row in rows]
    # The same by hand: all that leaves the frame around the window and arrives at the floor.
    patches = radiosity.load(ROOM).patches(as_is=True)
    frame, floor = patches.surface == 3, patches.surface == 0
    share = (patches.area[:, None] * matrix)[frame][:, floor].sum() / patches.area[frame].sum()
    by_surface = told(call, ROOM)["surfaces"]
    assert by_surface["F"][2][0] == pytest.approx(share, abs=1e-12)


def test_hints_that_are_left_to_options_are_worth_a_note(call: Call, tmp_path: Path) -> None:
    (tmp_path / "cube.vs3").write_text(VIEW3D_CUBE.replace("row=4", "row=4 emit=1"))
    content = told(call, "cube.vs3")
    assert content["enclosure"] is True
    assert content["report"]["tolerance"] == TOLERANCE
    notes = " ".join(finding["message"] for finding in content["findings"] if finding["code"] == "unused-hint")
    assert all(word in notes for word in ("eps=0.001", "emit=1", "row="))
    exact = np.array([1, ADJACENT, ADJACENT, OPPOSITE, ADJACENT, ADJACENT])
    assert content["surfaces"]["F"][0][1:] == pytest.approx(exact[1:], abs=TOLERANCE)


@pytest.mark.parametrize(("file", "patches"), [(DUCT, 20), (PIPE, 14)])
def test_faces_of_shapes_are_patches(call: Call, tmp_path: Path, file: Path, patches: int) -> None:
    content = told(call, file, "-o", "F.npz")
    assert (content["patches"], content["enclosure"], content["findings"]) == (patches, True, [])
    assert [content[f"closure_{which}"] for which in ("min", "mean", "max")] == pytest.approx([1, 1, 1], abs=1e-5)
    assert content["report"]["estimated_error"] <= TOLERANCE
    assert radiosity.FormFactors.load(tmp_path / "F.npz").shape == (patches, patches)
    assert told(call, file, "--max-edge", 0.5, "--rays", 64)["patches"] > 2 * patches


def test_what_is_said_to_people(call: Call, cube: str) -> None:
    shown = call("factors", cube, "-o", "F.npz")
    lines = shown.splitlines()
    assert lines[0] == "cube.ply: 6 patches, 30 form factors above zero"
    assert "method            auto" in lines
    assert "row sums          1.000000 to 1.000000, mean by area 1.000000" in lines
    assert any(line.startswith("farthest from 1   patch ") for line in lines)
    assert lines[-1] == "wrote F.npz"
    by_surface = call("factors", cube, "--by", "surface")
    assert "from | to   cube    sum\ncube      1.0000 1.0000\n" in by_surface
    assert call("factors", cube, "--quiet") == ""


def test_shapes_are_diagnosed(call: Call, tmp_path: Path) -> None:
    walls = tiles(1)
    shapes = {"outward": [wall[::-1] for wall in walls], "open": [walls[0], *walls[2:]], "twice": [*walls, walls[0]]}
    for name, polygons in shapes.items():
        write_stl(tmp_path / f"{name}.stl", polygons)
    assert codes(told(call, "outward.stl")) == {"looking-outward", "sees-nothing"}
    assert "warning [sees-nothing] no patch sees another" in call("factors", "outward.stl")
    content = told(call, "open.stl")
    assert (content["enclosure"], codes(content)) == (False, set())
    # By area all but the share of the ceiling, which is a sixth for the average of the others: 1 / 5.
    assert content["closure_mean"] == pytest.approx(1 - (OPPOSITE + 4 * ADJACENT) / 5, abs=1e-5)
    assert "enclosure         no" in call("factors", "open.stl")
    assert codes(told(call, "open.stl", "--enclosure")) == {"leak", "open-edges"}
    assert codes(told(call, "twice.stl")) == {"duplicate-faces", "excess", "non-manifold-edges"}
    assert codes(told(call, "twice.stl", "--no-enclosure")) == {"duplicate-faces"}
    # Nothing of it is about light, which check goes on to ask for.
    assert "no-light" in codes({"findings": [vars(f) for f in radiosity.load("open.stl").findings()]})


def test_the_farthest_row_has_a_place(call: Call, tmp_path: Path) -> None:
    turned = tiles(2)
    turned[5] = turned[5][::-1]
    write_stl(tmp_path / "turned.stl", turned)
    content = told(call, "turned.stl", "--enclosure")
    place = content["farthest_from_closure"]
    # Tiles are cut in two, and the fifth is the first to come of the two that see nothing.
    assert (place["patch"], place["face"], place["surface"], place["row_sum"]) == (10, 10, "shell", 0)
    assert place["centre"] == pytest.approx(np.mean(np.array(turned[5])[:3], axis=0))
    assert {"mixed-winding", "sees-nothing", "leak"} <= codes(content)


@pytest.mark.parametrize(
    ("method", "options"),
    [
        ("analytic", []),
        ("contour", ["--tolerance", 1e-8]),
        ("nusselt", ["--points", 8]),
        ("hemicube", ["--resolution", 256, "--hemicubes", 64]),
        ("monte_carlo", ["--rays", 1 << 16]),
    ],
)
def test_every_method(call: Call, tmp_path: Path, cube: str, method: str, options: list[object]) -> None:
    content = told(call, cube, "--method", method, *options, "-o", "F.npz")
    assert content["report"]["method"] == method
    factors = scipy.sparse.load_npz(tmp_path / "F.npz").toarray()
    allowed = 4 * max(content["report"]["estimated_error"], 1e-8)
    assert abs(factors - cube_factors()).max() < allowed < 0.1


def test_a_count_chooses_its_method(call: Call, cube: str) -> None:
    assert told(call, cube, "--points", 2)["report"]["method"] == "nusselt"
    assert told(call, cube, "--hemicubes", 2)["report"]["method"] == "hemicube"


def test_sides(call: Call, tmp_path: Path) -> None:
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE)
    faces = "".join(f"f {a + 1} {b + 1} {c + 1} {d + 1}\n" for a, b, c, d in INWARD.values())
    (tmp_path / "cube.obj").write_text(f"o box\n{corners}{faces}")
    fronts, both = told(call, "cube.obj", "--as-is"), told(call, "cube.obj", "--as-is", "--two-sided")
    assert (fronts["rows"], both["rows"], both["patches"]) == (6, 12, 6)
    assert both["closure_mean"] == pytest.approx(1, abs=1e-5)
    assert "6 patches with 12 sides" in call("factors", "cube.obj", "--as-is", "--two-sided")


def test_what_does_not_go_together(call: Call, cube: str, tmp_path: Path) -> None:
    before = sorted(tmp_path.iterdir())
    for options, sentence in [
        (["--method", "contour", "--rays", 10], "the method contour takes no rays"),
        (["--method", "nusselt", "--resolution", 64], "the method nusselt takes no resolution"),
        (["--points", 2, "--rays", 10], "the method monte_carlo takes no points"),
        (["--resolution", 9], "resolution must be even"),
        (["--tolerance", 0], "tolerance must be a positive number"),
        (["--method", "monte_carlo", "--tolerance", 1e-7], "out of reach of rays"),
        (["-o", "F.txt"], "F.txt: name a file that ends in .npz or .csv"),
        (["--compare", "-o", "F.npz"], "--compare runs all methods and saves nothing"),
        (["--compare", "--by", "surface"], "--compare runs all methods and saves nothing"),
        (["--compare", "--method", "contour"], "--compare runs all methods and saves nothing"),
        (["--as-is", "--max-edge", 1], "give only one of --max-edge, --patches and --as-is"),
    ]:
        code, said = refused(call, cube, *options)
        assert (code, sentence in said) == (ExitCode.ARGUMENTS, True), said
    assert sorted(tmp_path.iterdir()) == before


def test_unsound_faces_are_named(run: Runner, tmp_path: Path) -> None:
    (tmp_path / "tie.vs3").write_text(VIEW3D_CUBE.replace("1   2   3   4   0", "1   3   2   4   0"))
    (tmp_path / "bent.vs3").write_text(VIEW3D_CUBE.replace("V  7   1.   1.   1.", "V  7   1.   1.   1.2"))
    for name, sentence in [
        ("tie.vs3", "surface 'zeq0', face 0: the quad has an inward corner or crosses itself"),
        ("bent.vs3", "surface 'zeq1', face 0: the corners of the quad lie"),
    ]:
        done = run("factors", name, "-o", "F.npz")
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (3, "", 1)
        assert done.stderr.startswith(f"radiosity: {name}: {sentence}")
        assert not (tmp_path / "F.npz").exists()


def test_limits(call: Call, cube: str) -> None:
    code, said = refused(call, cube, "--memory", "100B")
    assert (code, said.startswith("cube.ply: ")) == (ExitCode.RESOURCES, True)
    code, said = refused(call, cube, "--max-edge", 0.04, "--compare")
    assert (code, "to compare all methods on 3,750 patches takes long" in said) == (ExitCode.RESOURCES, True)
    code, said = refused(call, cube, "--max-patches", 5)
    assert (code, "6 patches are more than --max-patches 5" in said) == (ExitCode.RESOURCES, True)


def test_a_tolerance_that_is_not_reached(call: Call, cube: str, tmp_path: Path) -> None:
    code, said = refused(call, cube, "--method", "hemicube", "--resolution", 16, "--tolerance", 1e-6, "-o", "F.npz")
    assert code == ExitCode.ACCURACY
    assert "the estimated error is " in said
    assert "not 1.0e-06" in said
    assert (tmp_path / "F.npz").exists()


def test_methods_side_by_side(call: Call, cube: str) -> None:
    content = told(call, cube, "--compare", "--rays", 1 << 14, "--hemicubes", 16)
    rows = {row["method"]: row for row in content["methods"]}
    assert tuple(rows) == SINGLE_METHODS
    assert content["enclosure"] is True
    # All is in full view, so that contour integrals are the reference.
    assert content["reference"]["method"] == "contour"
    assert content["reference"]["tolerance"] == pytest.approx(TOLERANCE / 100)
    assert max(rows[method]["worst"] for method in ("auto", "analytic", "contour")) < TOLERANCE
    for row in rows.values():
        assert row["rms"] <= row["worst"] <= 2 * max(row["estimated_error"], TOLERANCE)
        assert row["off_closure"] <= 5 * row["worst"] + 1e-9
        assert row["seconds"] >= 0
        assert row["memory_bytes"] > 0
    assert rows["monte_carlo"]["settings"] == "16,384 rays"
    assert rows["hemicube"]["settings"] == "16 x 512 px"
    assert rows["hemicube"]["disagreement"] > 0
    shown = call("factors", cube, "--compare")
    assert [line.split()[0] for line in shown.splitlines()[3:9]] == list(SINGLE_METHODS)
    assert "reference   contour to 1e-08" in shown


def test_what_is_hidden_is_compared_with_a_tighter_tolerance(call: Call) -> None:
    content = told(call, DUCT, "--compare", "--tolerance", 1e-4)
    assert content["reference"]["tolerance"] == pytest.approx(1e-6)
    assert {row["method"]: row["worst"] for row in content["methods"]}["auto"] < 1e-4
