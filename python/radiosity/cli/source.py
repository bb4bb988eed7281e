"""From what the user named to a scene and its patches."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from radiosity.cli.failure import ExitCode, Stop, bad_argument

if TYPE_CHECKING:
    from radiosity import Patches, Scene
    from radiosity.files import LitModel

BUILTIN = "builtin:"

_ATTEMPTS = 8


@dataclass(frozen=True)
class Meshing:
    """How to cut a scene into patches: one of the first three at most, and the most patches allowed.

    Only files of form factors from before there were lines of contact ask for patches without them.
    """

    max_edge: float | None = None
    count: int | None = None
    as_is: bool = False
    max_patches: int | None = None
    contacts: bool = True

    def __post_init__(self) -> None:
        if (self.max_edge is not None) + (self.count is not None) + self.as_is > 1:
            raise bad_argument("give only one of --max-edge, --patches and --as-is")
        if self.max_edge is not None and not 0 < self.max_edge < float("inf"):
            raise bad_argument(f"--max-edge must be a positive number of metres, not {self.max_edge:g}")

    @property
    def is_left_open(self) -> bool:
        """Whether nothing is said of how."""
        return self.max_edge is None and self.count is None and not self.as_is


def use_threads(threads: int | None) -> None:
    """Limit the stages that take no argument for it, such as building the ray hierarchy."""
    if threads is not None:
        os.environ["RAYON_NUM_THREADS"] = str(threads)


def builtin_name(file: str) -> str | None:
    """The name after ``builtin:``, if FILE says so."""
    return file.removeprefix(BUILTIN) if file.startswith(BUILTIN) else None


def open_scene(file: str, *, unit: str | None = None, two_sided: bool | None = None) -> Scene:
    """Read a scene file or make a built-in scene.

    Raises:
        SceneError: the file cannot be read.
        Stop: there is no such built-in scene, or it is given a unit.
    """
    from radiosity import load

    name = builtin_name(file)
    if name is None:
        with naming(file):
            return load(file, unit=unit or "m", two_sided=two_sided)
    if unit is not None:
        raise bad_argument("built-in scenes are in metres: leave out --unit")
    scene = make_builtin(name)
    for surface in scene.surfaces if two_sided is not None else []:
        surface.two_sided = bool(two_sided)
    return scene


def open_unlit(file: str, *, unit: str | None = None, two_sided: bool | None = None) -> Scene:
    """Open a scene to solve it.

    Raises:
        SceneError: the file cannot be read, or it is a solution itself.
        Stop: as :func:`open_scene`.
    """
    from radiosity import SceneError

    scene = open_scene(file, unit=unit, two_sided=two_sided)
    lit = [finding.message for finding in scene.loading_findings if finding.code == "lit-model"]
    if lit:
        raise SceneError(f"{file}: {lit[0]}")
    return scene


def open_lit(file: str, unit: str | None) -> LitModel | None:
    """The lit model in FILE; None if it is a scene that is not lit yet.

    Raises:
        Stop: the file is damaged, or a lit model is given a unit.
    """
    from radiosity.files import load_lit

    path = Path(file)
    if builtin_name(file) is not None or path.suffix.lower() != ".glb" or not path.is_file():
        return None
    try:
        lit = load_lit(path)
    except OSError as error:
        why = (error.strerror or str(error)).removeprefix(f"{file}: ")
        raise Stop(ExitCode.INPUT, f"{file}: {why}") from error
    if lit is not None and unit is not None:
        raise bad_argument("lit models are in metres: leave out --unit")
    return lit


def sides_of_factors(file: str, two_sided: bool | None) -> bool | None:
    """Which sides take part in form factors; OBJ does not say, and backs would double the rows."""
    return False if two_sided is None and Path(file).suffix.lower() == ".obj" else two_sided


def make_builtin(name: str) -> Scene:
    """A built-in scene by its name on the command line, such as ``cornell-box``."""
    from radiosity.scenes import BUILTIN_SCENES

    if name not in BUILTIN_SCENES:
        raise bad_argument(f"there is no built-in scene '{name}': choose one of {', '.join(BUILTIN_SCENES)}")
    return BUILTIN_SCENES[name]()


def cut_or_leave(file: str, scene: Scene, meshing: Meshing) -> Scene | Patches:
    """The patches if it is said how to cut, else the scene, for the engine to choose."""
    return scene if meshing.is_left_open else cut(file, scene, meshing)


def cut(file: str, scene: Scene, meshing: Meshing) -> Patches:
    """The patches to solve on.

    Raises:
        SceneError: a face cannot be cut.
        Stop: more patches than allowed.
    """
    with naming(file, scene.name):
        if meshing.as_is or meshing.max_edge is not None:
            patches = scene.patches(max_edge=meshing.max_edge, as_is=meshing.as_is, contacts=meshing.contacts)
        else:
            patches = _cut_to_count(scene, meshing)
    limit = meshing.max_patches
    if limit is not None and len(patches) > limit:
        raise Stop(
            ExitCode.RESOURCES,
            f"{file}: {len(patches):,} patches are more than --max-patches {limit:,}: raise it or cut less finely",
        )
    return patches


def _cut_to_count(scene: Scene, meshing: Meshing) -> Patches:
    """About as many patches as wanted; they come out a few percent more or less, so aim lower at a hard limit."""
    from radiosity.solution import DEFAULT_PATCHES

    count = meshing.count or DEFAULT_PATCHES
    limit = meshing.max_patches or sys.maxsize
    goal = min(count, limit)
    patches = scene.patches(count=goal, contacts=meshing.contacts)
    for _ in range(_ATTEMPTS):
        if len(patches) <= limit or goal == 1:
            break
        goal = max(1, int(0.98 * goal * limit / len(patches)))
        patches = scene.patches(count=goal, contacts=meshing.contacts)
    return patches


@contextmanager
def naming(file: str, scene_name: str = "") -> Iterator[None]:
    """Have every error about the scene begin with FILE as the user wrote it."""
    from radiosity import ResourceError, SceneError

    try:
        yield
    except ResourceError as error:
        raise ResourceError(f"{file}: {error}") from error
    except SceneError as error:
        rest = str(error)
        for name in (file, scene_name, Path(file).name):
            if name and rest.startswith(f"{name}: "):
                rest = rest.removeprefix(f"{name}: ")
                break
        raise SceneError(f"{file}: {rest}") from error
