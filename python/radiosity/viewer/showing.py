"""Showing a solution: in a browser beside this process, or as a file."""

from __future__ import annotations

import os
import webbrowser
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import radiosity
from radiosity.files import LitModel, load_lit
from radiosity.patches import Patches
from radiosity.scene import Scene
from radiosity.solution import Solution
from radiosity.viewer import page
from radiosity.viewer.layers import lamps, layers
from radiosity.viewer.lit import Lit, up_axis
from radiosity.viewer.session import NO_LAYERS, Session, What
from radiosity.viewer.settings import ACCURACY, PHOTOMETRIC, Settings, Unit

NO_BROWSER = "no browser was found: open the address in one on this machine"


def view(
    what: Solution | LitModel | Scene | Patches | str | os.PathLike[str],
    *,
    layers: bool = False,
    accuracy: float = ACCURACY,
    max_patches: int | None = None,
    unit: Unit | None = None,
    title: str | None = None,
    port: int | None = None,
    open_browser: bool = True,
    threads: int | None = None,
    seed: int = 0,
) -> None:
    """Show something in the browser, and go on until Ctrl-C.

    A scene is shown while it is solved: light comes in by progressive refinement, then on mesh after mesh. When it is
    solved, lamps and paint can be changed.

    Args:
        what: a solution; a lit model, whose lamps and paint are fixed; a scene or patches, which are solved; or the
            path of a file of either.
        layers: whether to send the light of each lamp, so that the page switches and dims lamps by itself.
        accuracy, max_patches, threads, seed: of the solve, as in :func:`radiosity.solve`.
        unit: "W/m2" or "lux", what irradiance is in; by default lux for glTF scene files, which say so, else W/m2.
        title: of the page; the name of the scene by default.
        port: of 127.0.0.1 to serve at; a free one by default. Only this machine, and only who has the printed address,
            gets anything there.
        open_browser: whether to open the address.

    Raises:
        MissingPageError: this copy of radiosity has no page; it says how to get one.
        SceneError: the scene cannot be lit.
        ValueError: layers of a lit model.
        OSError: a file cannot be read, or the port is taken.
    """
    thing, settings = _opened(
        what,
        Settings(title or "", unit or "W/m2", layers, accuracy, max_patches, threads, seed),
        is_unit_given=unit is not None,
    )
    try:
        serve(thing, settings, port=port, open_browser=open_browser, say=print, warn=print)
    except KeyboardInterrupt:
        return


def export(
    path: str | os.PathLike[str],
    what: Solution | LitModel | Scene | Patches | str | os.PathLike[str],
    *,
    layers: bool = False,
    accuracy: float = ACCURACY,
    max_patches: int | None = None,
    unit: Unit | None = None,
    title: str | None = None,
    threads: int | None = None,
    seed: int = 0,
) -> None:
    """Write a page with a solution in it: one file that needs no network and no server.

    Args:
        path: the ``.html`` file; it appears whole or not at all.
        what, accuracy, max_patches, unit, title, threads, seed: as in :func:`view`; a scene is solved first.
        layers: whether the light of each lamp goes into the file, so that the page can switch and dim lamps. The file
            grows by the light of each.

    Raises:
        MissingPageError: this copy of radiosity has no page; it says how to get one.
        SceneError: the scene cannot be lit.
        ValueError: layers of a lit model.
        OSError: a file cannot be read or written.
    """
    page.page()  # before long work
    thing, settings = _opened(
        what,
        Settings(title or "", unit or "W/m2", layers, accuracy, max_patches, threads, seed),
        is_unit_given=unit is not None,
    )
    if isinstance(thing, Scene | Patches):
        most: dict[str, Any] = {"max_patches": max_patches} if isinstance(thing, Scene) else {}
        thing = radiosity.solve(thing, accuracy=accuracy, threads=threads, seed=seed, **most)
    page.export(path, lit_of(thing, settings))


def serve(
    what: What,
    settings: Settings,
    *,
    port: int | None,
    open_browser: bool,
    say: Callable[[str], object],
    warn: Callable[[str], object],
) -> None:
    """Serve the page of something until Ctrl-C, which ends it as a KeyboardInterrupt.

    Args:
        what, settings: see :class:`radiosity.viewer.session.Session`.
        port: see :class:`radiosity.viewer.server.Server`.
        open_browser: whether to open the address.
        say: is told the address.
        warn: is told that there is no browser.
    """
    from radiosity.viewer.server import Server  # noqa: PLC0415 - files are exported without it

    page.page()  # before long work
    with Server(Session(what, settings), port) as server:
        say(server.address)
        if open_browser and not _open(server.address):
            warn(NO_BROWSER)
        server.wait()


def lit_of(what: Solution | LitModel, settings: Settings) -> Lit:
    """What a page shows of it.

    Raises:
        ValueError: layers of a lit model.
    """
    if isinstance(what, LitModel):
        if settings.is_layered:
            raise ValueError(NO_LAYERS)
        return Lit(what, unit=settings.unit, title=settings.title, up=up_axis(what.cameras))
    model = LitModel.of(what)
    heads = lamps(what.patches, what.emission, what.lights)
    each = layers(what, heads, model) if settings.is_layered else []
    return Lit(model, each, heads, settings.unit, settings.title, up=up_axis(model.cameras))


def _opened(what: What | str | os.PathLike[str], settings: Settings, *, is_unit_given: bool) -> tuple[What, Settings]:
    """What to show, and the settings with a title and unit that fit it."""
    if isinstance(what, str | os.PathLike):
        path = Path(what)
        lit = load_lit(path) if path.suffix.lower() == ".glb" else None
        if lit is None and path.suffix.lower() in PHOTOMETRIC and not is_unit_given:
            settings = replace(settings, unit="lux")
        return lit or radiosity.load(path), replace(settings, title=settings.title or path.stem)
    scene = what if isinstance(what, Scene) else None if isinstance(what, LitModel) else _patches(what).scene
    return what, replace(settings, title=settings.title or (scene.name if scene else "radiosity"))


def _patches(what: Solution | Patches) -> Patches:
    return what.patches if isinstance(what, Solution) else what


def _open(address: str) -> bool:
    """Whether a browser was opened, in a window of its own."""
    try:
        browser = webbrowser.get()
    except webbrowser.Error:
        return False
    # One that runs in the terminal would take it away from us, and draws no scene.
    if type(browser) is webbrowser.GenericBrowser:
        return False
    return browser.open(address)
