"""Pictures of scenes in which doubtful places are marked."""

from __future__ import annotations

import io
from pathlib import Path

import broken
import numpy as np
import pytest
from PIL import Image

from radiosity import Finding, Scene, Surface, diagnosis, marking
from radiosity.marking import sheet, views
from radiosity.marking.kinds import COLOURS
from radiosity.marking.stage import Stage


def staged(scene: Scene, **options: object) -> tuple[Stage, list[views.Panel]]:
    stage = Stage.of(scene, diagnosis.examine(scene, **options))
    return stage, views.choose(stage)


def hue_distance(pixel: np.ndarray, colour: str) -> float:
    """How far the direction of a colour, after grey is taken out, is from another: 0 to 2."""
    a, b = np.asarray(pixel, float) / 255, np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    a, b = a - a.mean(), b - b.mean()
    return float(np.linalg.norm(a / max(np.linalg.norm(a), 0.02) - b / np.linalg.norm(b)))


@pytest.mark.parametrize("name", ["flipped wall", "rug in the floor", "doubled wall", "white wall", "flipped side"])
def test_faces_are_tinted_where_they_are(name: str) -> None:
    make, code, _, _ = broken.MODELS[name]
    stage, panels = staged(make())
    (mark,) = [mark for mark in stage.marks if mark.finding.code == code]
    view, seen, _ = panels[0]
    assert mark in seen
    place = views.visible_anchors(view, mark)[:1]
    x, y, _ = view.project(place, 400, 300)[0]
    image = sheet.shade(view, 400, 300)
    assert hue_distance(image[int(y), int(x)], COLOURS[code]) < 0.3
    # The rest is grey.
    assert np.mean(np.ptp(image.astype(int), axis=2) > 40) < 0.6


@pytest.mark.parametrize(
    ("make", "code", "options"),
    [
        (broken.missing_face, "light-escapes", {}),
        (broken.floating_wall, "narrow-gap", {}),
        (broken.non_manifold, "non-manifold-edges", {"enclosure": True}),
    ],
)
def test_edges_are_drawn_where_they_are(make: object, code: str, options: dict[str, bool]) -> None:
    stage, panels = staged(make(), **options)
    picture = np.asarray(Image.open(io.BytesIO(sheet.png(stage, panels, "room"))).convert("RGB"))
    box, view = sheet.boxes(len(panels))[0], panels[0][0]
    (mark,) = [mark for mark in stage.marks if mark.finding.code == code]
    along = np.concatenate([mark.edges[:, 0] * (1 - t) + mark.edges[:, 1] * t for t in (0.3, 0.7)])
    pixels = view.project(along, box.width, box.height)[view.sees(along)]
    assert len(pixels)
    hit = [
        min(
            hue_distance(picture[box.top + int(y) + i, box.left + int(x) + j], COLOURS[code])
            for i in range(-2, 3)
            for j in range(-2, 3)
        )
        for x, y, _ in pixels
    ]
    # A number or another mark may lie over one of them.
    assert np.median(hit) < 0.3


def test_what_is_tiny_is_shown_close_up() -> None:
    stage, panels = staged(broken.floating_wall())
    assert [name for _, _, name in panels] == ["", "1 close up"]
    near = panels[1][0]
    gap = near.project(stage.marks[0].finding.points, 1000, 750)
    assert 10 < np.linalg.norm(gap[1, :2] - gap[0, :2]) < 200


def test_what_stands_before_the_scene_is_left_out() -> None:
    stage, panels = staged(broken.room())
    shown, _ = panels[0][0].first_hits(200, 150)
    names = {stage.scene.surfaces[k].name for k in np.unique(stage.surface[shown[shown >= 0]])}
    assert {"floor", "cupboard"} <= names
    # Nor is the outside of two-sided walls shown.
    scene = broken.room()
    for surface in scene.surfaces:
        surface.two_sided = True
    stage, panels = staged(scene)
    shown, _ = panels[0][0].first_hits(200, 150)
    assert "floor" in {stage.scene.surfaces[k].name for k in np.unique(stage.surface[shown[shown >= 0]])}


def test_a_camera_of_the_scene_is_used_where_it_sees_all() -> None:
    from radiosity import Camera

    scene = broken.rug_in_the_floor()
    scene.cameras = [Camera.look_at((3.6, 0.3, 2.0), (1.5, 1.5, 0.0), (0, 0, 1), np.radians(70))]
    assert staged(scene)[1][0][0].camera == scene.cameras[0]
    scene.cameras = [Camera.look_at((3.6, 0.3, 1.0), (3.6, 0.3, 2.0), (0, 1, 0), np.radians(20))]
    assert staged(scene)[1][0][0].camera != scene.cameras[0]


def test_the_file_is_whole_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "marked.png"
    scene = broken.rug_in_the_floor()
    marking.draw(scene, diagnosis.examine(scene), target, title="a $ room")
    with Image.open(target) as image:
        image.load()
        assert image.width == sheet.WIDTH
    before = target.read_bytes()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="No space"):
        marking.draw(scene, [], target)
    assert [p.name for p in tmp_path.iterdir()] == ["marked.png"]
    assert target.read_bytes() == before


def test_unsound_scenes_are_drawn_as_far_as_they_go(tmp_path: Path) -> None:
    scene = broken.nan_vertex()
    marking.draw(scene, diagnosis.examine(scene), tmp_path / "marked.png")
    far = Finding("note", "code", "it", "its place is nowhere", 99, np.array([7]), np.full((1, 2, 3), np.nan))
    marking.draw(broken.room(), [far], tmp_path / "far.png")
    for empty in (Scene([]), Scene([Surface([[np.inf] * 3] * 3, [[0, 1, 2]])])):
        with pytest.raises(ValueError, match="there is no face to draw"):
            marking.draw(empty, [], tmp_path / "empty.png")
    assert not (tmp_path / "empty.png").exists()
