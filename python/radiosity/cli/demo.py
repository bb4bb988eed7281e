"""``radiosity demo``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from radiosity.cli import options, output, picture, source
from radiosity.cli.solve import Effort, solve_target

PATCHES = 8000

ACCURACY = {"furnished-room": 0.03, "cornell-box": 0.02, "cornell-box-spectral": 0.02, "lampshade": 0.1}
"""Of scenes that would take long to the usual 1 %."""

EVENLY = ("furnished-room",)
"""Scenes that are cut into ``PATCHES`` patches: a mesh for 3 % of the light between its small lamps takes minutes."""


def demo(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="A built-in scene (see radiosity scenes).")
    ] = "cornell-box",
    folder: Annotated[Path, typer.Option("--folder", help="Where the files go; created if need be.")] = Path("out"),
    threads: options.Threads = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Light a built-in scene (to 1 %, furnished-room to 3 %) and save a model, a picture and a table."""
    source.use_threads(threads)
    scene = source.make_builtin(name)
    with output.naming_file(folder):
        folder.mkdir(parents=True, exist_ok=True)
    model, image, table = (folder / f"{name}{suffix}" for suffix in (".glb", ".png", ".npz"))
    output.check_outputs([model, image, table], (".glb", ".png", ".npz"))
    effort = Effort(accuracy=ACCURACY.get(name, 0.01), threads=threads)
    target = source.cut(name, scene, source.Meshing(count=PATCHES)) if name in EVENLY else scene
    solution = solve_target(name, target, effort, quiet=quiet)
    output.save(solution, [model, table])
    view = picture.View(600, 600, camera=scene.cameras[0] if scene.cameras else None, threads=threads)
    picture.save(picture.render(solution, view, quiet=quiet), scene.bands, [image], picture.Tone())
    if as_json:
        output.print_json(
            {"scene": f"{source.BUILTIN}{name}", "outputs": [model, image, table], "report": solution.report.to_dict()}
        )
    elif not quiet:
        print(f"{scene.name}\n{solution.report}\nwrote {model}, {image} and {table}")
        print(f"\nNow try:  radiosity render {model} -o {folder / 'irradiance.png'} --show irradiance --false-colours")
        print(f"          radiosity compare {name}")
    output.demand_accuracy(name, solution.report)
