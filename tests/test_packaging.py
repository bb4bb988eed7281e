"""What users install has the viewer's page in it."""

import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from radiosity.viewer import page

ROOT = Path(__file__).parents[1]
PAGE = "radiosity/viewer/bundle/index.html"

pytestmark = pytest.mark.skipif(not (ROOT / "viewer").is_dir(), reason="needs a checkout")


def maturin(*arguments: str) -> None:
    subprocess.run([Path(sys.executable).with_name("maturin"), *arguments], cwd=ROOT, check=True, capture_output=True)


def test_the_source_distribution_has_the_page_and_what_it_is_built_from(tmp_path: Path) -> None:
    maturin("sdist", "--out", str(tmp_path))
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as tar:
        tar.extractall(tmp_path, filter="data")
    (unpacked,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert (unpacked / "python" / PAGE).read_bytes() == page.BUNDLE.read_bytes()
    assert page.fingerprint(unpacked / "viewer") == page.fingerprint(ROOT / "viewer")
    assert not (unpacked / "viewer" / "node_modules").exists()


@pytest.mark.slow
def test_a_wheel_that_is_installed_alone_shows_a_scene(tmp_path: Path) -> None:
    maturin("build", "--release", "--locked", "--out", str(tmp_path))
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
    code = (
        "import radiosity, radiosity.viewer as v; assert 'installed' in radiosity.__file__;"
        "s = radiosity.solve(radiosity.scenes.furnace().patches(count=24), accuracy=0.1); v.export('page.html', s)"
    )
    subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, check=True, env={"PYTHONPATH": str(tmp_path / "installed")}
    )
    assert "radiosity-scene" in (tmp_path / "page.html").read_text()
