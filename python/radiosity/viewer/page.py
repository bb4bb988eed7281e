"""The page: the bundle that ``make viewer`` builds, and the same with a scene in it."""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import os
from pathlib import Path

from radiosity.files import write_whole
from radiosity.viewer.lit import Lit

BUNDLE = Path(__file__).parent / "bundle" / "index.html"

SOURCES = Path(__file__).parents[3] / "viewer"
"""Where the page is made from, in a checkout."""

_MARK = '<meta name="radiosity-sources" content="{}"'
_BODY = "<body>"


class MissingPageError(RuntimeError):
    """The page was not built, or its sources have changed since."""


def page() -> str:
    """The HTML of the page without a scene.

    Raises:
        MissingPageError: there is none, or it is out of date.
    """
    try:
        text = BUNDLE.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise MissingPageError(
            f"{BUNDLE} is missing: this copy of radiosity was installed without its viewer. "
            "Build it with `make viewer` in a checkout, which needs Node.js"
        ) from None
    if SOURCES.joinpath("package.json").is_file() and _MARK.format(fingerprint(SOURCES)) not in text:
        raise MissingPageError(f"{BUNDLE} is older than its sources in {SOURCES}: run `make viewer`")
    return text


def fingerprint(sources: Path) -> str:
    """A hash of all that the page is built from; ``viewer/vite.config.ts`` computes the same."""
    files = [path for path in (sources / "src").rglob("*") if path.is_file()]
    files += [sources / name for name in ("index.html", "package-lock.json", "tsconfig.json", "vite.config.ts")]
    digest = hashlib.sha256()
    for name, path in sorted((path.relative_to(sources).as_posix(), path) for path in files):
        data = path.read_bytes()
        digest.update(f"{name}\n{len(data)}\n".encode() + data)
    return digest.hexdigest()


def with_scene(lit: Lit) -> str:
    """The HTML of the page with a scene in it, which needs nothing else."""
    scene = base64.b64encode(gzip.compress(lit.scene_packet(), compresslevel=6, mtime=0)).decode()
    element = f'<script type="application/gzip" id="radiosity-scene">{scene}</script>'
    text = page().replace("<title>radiosity</title>", f"<title>{html.escape(lit.title)}</title>", 1)
    before, body, after = text.partition(_BODY)
    return f"{before}{body}\n{element}{after}"


def export(path: str | os.PathLike[str], lit: Lit) -> None:
    """Write the page with a scene in it as one file; it appears whole or not at all.

    Raises:
        MissingPageError: the page was not built.
        OSError: the file cannot be written.
    """
    text = with_scene(lit).encode()
    write_whole(Path(path), lambda file: file.write(text))
