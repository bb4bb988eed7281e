"""``radiosity check``: what it says, and the picture it draws."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from known import INWARD, Call, Runner, tiles, write_stl
from PIL import Image

CLOSED = tiles(1)
CEILING = list(INWARD).index("ceiling")


@pytest.fixture
def leaky(tmp_path: Path) -> Path:
    """A cube of 1 m without its ceiling."""
    path = tmp_path / "leaky.stl"
    write_stl(path, CLOSED[:CEILING] + CLOSED[CEILING + 1 :])
    return path


def test_a_picture_is_drawn_and_named(run: Runner, leaky: Path, tmp_path: Path) -> None:
    done = run("check", leaky.name, "--picture", "marked.png")
    # An STL file has no light, which is an error to whoever wants to solve it.
    assert (done.returncode, done.stderr) == (3, "")
    assert done.stdout.splitlines()[-1] == "wrote marked.png"
    with Image.open(tmp_path / "marked.png") as image:
        image.load()
        assert image.format == "PNG"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["leaky.stl", "marked.png"]


def test_json_has_the_places(call: Call, run: Runner, leaky: Path) -> None:
    told = json.loads(run("check", leaky.name, "--enclosure", "--json", "--picture", "marked.png").stdout)
    assert told["pictures"] == ["marked.png"]
    (rim,) = [finding for finding in told["findings"] if finding["code"] == "open-edges"]
    assert rim["surface"] == 0
    assert {point[2] for edge in rim["edges"] for point in edge} == {1.0}
    assert (len(rim["edges"]), len(rim["faces"]), rim["points"]) == (4, 4, [])
    assert json.loads(call("check", "builtin:furnace", "--json")) == {
        "scene": "builtin:furnace", "sound": True, "pictures": [], "findings": [],
    }  # fmt: skip


def test_a_sound_scene_has_nothing_to_remark(call: Call, tmp_path: Path) -> None:
    shown = call("check", "builtin:furnace", "--picture", "sound.png").splitlines()
    assert shown[1:] == ["nothing to remark", "wrote sound.png"]
    assert (tmp_path / "sound.png").exists()
    assert call("check", "builtin:furnace", "--quiet") == ""


@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ("marked.pdf", "marked.pdf: name a file that ends in .png"),
        ("no/marked.png", "no/marked.png: the folder no does not exist; create it"),
    ],
)
def test_pictures_that_cannot_be_written(run: Runner, tmp_path: Path, target: str, sentence: str) -> None:
    done = run("check", "builtin:furnace", "--picture", target)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"radiosity: {sentence}")
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("none.obj", None),
        ("text.glb", "hello"),
        ("empty.stl", "solid nothing\nendsolid nothing\n"),
        ("nan.obj", "o floor\nv 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"),
    ],
)
def test_hostile_files_have_a_finding_and_no_picture(
    run: Runner, tmp_path: Path, name: str, content: str | None
) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    before = sorted(tmp_path.iterdir())
    done = run("check", name, "--picture", "marked.png")
    assert done.returncode == 3
    assert "error [" in done.stdout
    assert done.stderr == f"radiosity: {name}: there is nothing to draw, and marked.png was not written\n"
    assert sorted(tmp_path.iterdir()) == before


def test_without_matplotlib_there_is_no_picture(
    call: Call, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from radiosity.cli.failure import Stop

    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(Stop, match=r"--picture needs matplotlib: pip install 'radiosity\[plots\]'"):
        call("check", "builtin:furnace", "--picture", "marked.png")
