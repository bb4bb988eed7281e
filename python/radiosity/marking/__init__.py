"""A picture of a scene in which doubtful places are marked, with a legend.

    >>> findings = radiosity.diagnosis.examine(scene)
    >>> radiosity.marking.draw(scene, findings, "marked.png")

Needs matplotlib.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from radiosity.scene import Finding, Scene

__all__ = ["draw"]


def draw(scene: Scene, findings: list[Finding], path: str | os.PathLike[str], *, title: str | None = None) -> None:
    """Draw a scene in grey with its findings in colour, numbered as in the legend below, into a ``.png`` file.

    Faces that turn their backs and outer walls are left out, so that one sees into rooms. What is hidden all the same
    is drawn dimmed; what is too small is shown close up beside the whole.

    Args:
        scene: what was examined.
        findings: those of :func:`radiosity.diagnosis.examine` or :meth:`radiosity.Scene.findings`.
        path: the file; it is whole or not there.
        title: what to call the scene; its name by default.

    Raises:
        ValueError: the scene has nothing to draw. OSError: the file cannot be written.
        ImportError: matplotlib is not installed.
    """
    from radiosity.marking import sheet, views  # noqa: PLC0415
    from radiosity.marking.stage import Stage  # noqa: PLC0415
    from radiosity.teaching.figures import style  # noqa: PLC0415

    with style():
        stage = Stage.of(scene, findings)
        content = sheet.png(stage, views.choose(stage), title or scene.name)
    _write(Path(path), content)


def _write(path: Path, content: bytes) -> None:
    """Write a whole file or none."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    beside = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        umask = os.umask(0)
        os.umask(umask)
        beside.chmod(0o666 & ~umask)
        beside.replace(path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
