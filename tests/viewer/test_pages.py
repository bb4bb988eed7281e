"""The page as a file."""

from __future__ import annotations

import base64
import gzip
import re
from pathlib import Path

import numpy as np
import pytest

import radiosity
from radiosity.files import LitModel
from radiosity.viewer import MissingPageError, export, page
from radiosity.viewer.packet import unpack
from radiosity.viewer.settings import Settings
from radiosity.viewer.showing import lit_of


def embedded(text: str) -> tuple[dict, dict[str, np.ndarray]]:
    """The scene in a page, as its script finds it."""
    (found,) = re.findall(r'<script type="application/gzip" id="radiosity-scene">([^<]*)</script>', text)
    return unpack(gzip.decompress(base64.b64decode(found, validate=True)))


def test_an_exported_page_has_the_scene_in_it(lit_room: radiosity.Solution, built: Path, tmp_path: Path) -> None:
    export(tmp_path / "room.html", lit_room)
    text = (tmp_path / "room.html").read_text()
    head, arrays = embedded(text)
    _, expected = unpack(lit_of(lit_room, Settings()).scene_packet())
    assert {name: array.tobytes() for name, array in arrays.items()} == {
        name: array.tobytes() for name, array in expected.items()
    }
    assert head["title"] == "lamp room"
    assert [lamp["name"] for lamp in head["lamps"]] == ["warm", "cold", "screen", "bulb", "sun"]
    # The rest is the page.
    rest = re.sub(r"<script type=.application/gzip.*</script>\n?", "", text)
    assert rest.replace("lamp room", "radiosity", 1) == built.read_text()


def test_layers_go_into_the_file(lit_room: radiosity.Solution, built: Path, tmp_path: Path) -> None:
    export(tmp_path / "room.html", lit_room, layers=True)
    head, arrays = embedded((tmp_path / "room.html").read_text())
    assert head["is_layered"]
    model = LitModel.of(lit_room)
    assert arrays["irradiance"].shape == (5, *model.irradiance.shape)
    np.testing.assert_allclose(arrays["irradiance"].sum(axis=0), model.irradiance, rtol=1e-5, atol=1e-6)


def test_a_scene_is_solved_first(built: Path, tmp_path: Path) -> None:
    export(tmp_path / "box.html", radiosity.scenes.cornell_box().patches(count=100), accuracy=0.2, title="box")
    head, _ = embedded((tmp_path / "box.html").read_text())
    assert head["report"]["accuracy"] == 0.2
    assert head["title"] == "box"


def test_files_are_opened(lit_room: radiosity.Solution, built: Path, tmp_path: Path) -> None:
    lit_room.save(tmp_path / "lit.glb")
    export(tmp_path / "lit.html", tmp_path / "lit.glb")
    head, _ = embedded((tmp_path / "lit.html").read_text())
    assert (head["title"], head["unit"], head["lamps"]) == ("lit", "W/m2", [])
    scenes = Path(__file__).parents[2] / "scenes"
    export(tmp_path / "study.html", scenes / "study.glb", accuracy=0.5)
    head, _ = embedded((tmp_path / "study.html").read_text())
    assert (head["title"], head["unit"]) == ("study", "lux")


def test_layers_of_a_lit_model_are_refused(lit_room: radiosity.Solution, built: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="a lit model has the light of all lamps together"):
        export(tmp_path / "lit.html", LitModel.of(lit_room), layers=True)
    assert not (tmp_path / "lit.html").exists()


def test_a_title_is_text(lit_room: radiosity.Solution, built: Path, tmp_path: Path) -> None:
    nasty = "</title></script><script>alert(1)</script>&amp;"
    export(tmp_path / "room.html", lit_room, title=nasty)
    text = (tmp_path / "room.html").read_text()
    assert "alert(1)" in text
    assert "<script>" not in text
    assert text.count("</script>") == 1
    assert embedded(text)[0]["title"] == nasty


def test_a_page_that_cannot_be_written_leaves_nothing(
    lit_room: radiosity.Solution, built: Path, tmp_path: Path
) -> None:
    with pytest.raises(OSError, match="No such file"):
        export(tmp_path / "missing" / "room.html", lit_room)
    before = sorted(tmp_path.iterdir())
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match=r"folder"):
        export(tmp_path / "folder", lit_room)
    assert sorted(tmp_path.iterdir()) == sorted([*before, tmp_path / "folder"])


def test_a_missing_page_is_said_before_any_work(
    lit_room: radiosity.Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "BUNDLE", tmp_path / "none.html")
    with pytest.raises(MissingPageError, match=r"installed without its viewer.*make viewer"):
        export(tmp_path / "room.html", "no such scene")


def test_a_stale_page_is_noticed(built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sources = tmp_path / "viewer"
    (sources / "src").mkdir(parents=True)
    for name in ("package.json", "index.html", "package-lock.json", "tsconfig.json", "vite.config.ts", "src/main.ts"):
        (sources / name).write_text(name)
    monkeypatch.setattr(page, "SOURCES", sources)
    with pytest.raises(MissingPageError, match=r"older than its sources.*make viewer"):
        page.page()
    built.write_text(f'<meta name="radiosity-sources" content="{page.fingerprint(sources)}">')
    assert page.page() == built.read_text()
    (sources / "src" / "main.ts").write_text("changed")
    with pytest.raises(MissingPageError, match="older"):
        page.page()
