"""``radiosity design``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from radiosity.cli import options, output, source
from radiosity.cli.failure import ExitCode, Stop, bad_argument
from radiosity.cli.progress import Bar
from radiosity.cli.solve import SUFFIXES, Outputs

if TYPE_CHECKING:
    from radiosity import Design, Target

Wanted = Annotated[
    list[str] | None,
    typer.Option(
        "--target",
        metavar="NAME=W/M2",
        help="Mean irradiance wanted on a surface: a number for the mean over bands, or one for each with commas; may "
        "be repeated.",
    ),
]
Even = Annotated[
    list[str] | None,
    typer.Option("--even", metavar="NAME=W/M2", help="The same on every patch of the surface; may be repeated."),
]
Vary = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="NAME=LOW:HIGH",
        help="A lamp that is free within bounds: the emission of a surface, W/m2, or the strength of a light without "
        "area, W/sr; HIGH may be left out; may be repeated.",
    ),
]
Paint = Annotated[
    list[str] | None,
    typer.Option("--paint", metavar="NAME=LOW:HIGH", help="A surface whose reflectance is free; may be repeated."),
]


def design(
    file: options.SceneFile,
    wanted: Wanted = None,
    even: Even = None,
    vary: Vary = None,
    paint: Paint = None,
    outputs: Outputs = None,
    economy: Annotated[
        float, typer.Option(min=0.0, help="What saving all power is worth, as a part of the targets to miss.")
    ] = 0.0,
    tolerance: Annotated[float, typer.Option(min=0.0, help="Part of a target that it may be missed by.")] = 0.01,
    accuracy: options.Accuracy = 0.01,
    max_edge: options.MaxEdge = None,
    patches: options.PatchCount = None,
    as_is: options.AsIs = False,
    max_patches: options.MaxPatches = None,
    memory: options.Memory = None,
    unit: options.Unit = None,
    two_sided: options.TwoSided = None,
    transport: options.Transport = None,
    threads: options.Threads = None,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Find lamps and paint that make the irradiance that is wanted, and save the scene lit by them."""
    from radiosity import Reflectance
    from radiosity import design as find
    from radiosity.inverse import lamp

    saved = outputs or []
    output.check_outputs(saved, SUFFIXES, file)
    meshing = source.Meshing(max_edge, patches, as_is, max_patches)
    targets, variables = read_targets(wanted or [], even or []), read_variables(vary or [], paint or [])
    source.use_threads(threads)
    scene = source.open_unlit(file, unit=unit, two_sided=two_sided)
    cut = source.cut(file, scene, meshing)
    free = [
        Reflectance(name, bounds) if is_paint else lamp(scene, name, bounds) for name, bounds, is_paint in variables
    ]
    limits: dict[str, Any] = {} if memory is None else {"memory_limit": options.read_size(memory)}
    with source.naming(file, scene.name), Bar("designing", quiet=quiet) as bar:
        found = find(
            cut, targets, free, economy=economy, tolerance=tolerance, accuracy=accuracy, transport=transport,
            threads=threads, seed=seed, progress=bar, **limits,
        )  # fmt: skip
    output.save(found.solution, saved)
    if as_json:
        output.print_json({"scene": file, "outputs": saved, **design_out(found)})
    elif not quiet:
        print(found)
        for path in saved:
            print(f"wrote {path}")
    demand_targets(file, found)
    output.demand_accuracy(file, found.solution.report)


def read_targets(means: list[str], even: list[str]) -> list[Target]:
    """Targets from ``NAME=VALUE``.

    Raises:
        Stop: there are none, or one is something else.
    """
    from radiosity import Target

    if not means and not even:
        raise bad_argument("nothing is wanted: say what, such as --target desk=500")
    found = []
    for option, texts in (("--target", means), ("--even", even)):
        for text in texts:
            name, values = _named(text, option, "500, or a value for each band, such as 500,400,300")
            numbers = [_number(v, text, option) for v in values.split(",")]
            found.append(Target(name, numbers[0] if len(numbers) == 1 else numbers, even=option == "--even"))
    return found


def read_variables(vary: list[str], paint: list[str]) -> list[tuple[str, tuple[float, float], bool]]:
    """Names, bounds and whether of paint, from ``NAME=LOW:HIGH``.

    Raises:
        Stop: there are none, or one is something else.
    """
    if not vary and not paint:
        raise bad_argument("nothing may change: say what, such as --vary lamp=0:2000 or --paint walls=0.1:0.9")
    found = []
    for option, texts, example in (("--vary", vary, "0:2000"), ("--paint", paint, "0.1:0.9")):
        for text in texts:
            name, bounds = _named(text, option, example)
            low, colon, high = bounds.partition(":")
            if not colon:
                raise bad_argument(f"{option} '{text}' has no bounds: write {name}={example}")
            most = math.inf if option == "--vary" else 0.99
            found.append(
                (name, (_number(low, text, option), _number(high, text, option) if high else most), option == "--paint")
            )
    return found


def _named(text: str, option: str, example: str) -> tuple[str, str]:
    """Name and rest; names may have an equals sign in them."""
    name, equals, rest = text.rpartition("=")
    if not equals or not name:
        raise bad_argument(f"{option} '{text}' names nothing: write a name, = and {example}")
    return name, rest


def _number(part: str, text: str, option: str) -> float:
    try:
        return float(part)
    except ValueError:
        raise bad_argument(f"{option} '{text}': '{part}' is no number") from None


def design_out(found: Design) -> dict[str, Any]:
    """A design for JSON."""
    import numpy as np

    def plain(value: Any) -> Any:
        return np.asarray(value).tolist()

    targets = [
        {"surface": o.surface, "wanted": plain(o.wanted), "achieved": plain(o.achieved), "miss": o.miss, "met": o.met}
        for o in found.outcomes
    ]
    return {
        "met": found.met,
        "targets": targets,
        "values": {name: plain(value) for name, value in found.values.items()},
        "at_bound": found.at_bound,
        "residual": found.residual,
        "history": found.history,
        "power": found.power,
        "report": found.solution.report.to_dict(),
    }


def demand_targets(file: str, found: Design) -> None:
    """End the command with its own exit code if targets are missed.

    Raises:
        Stop: some are.
    """
    if found.met:
        return
    missed = ", ".join(f"'{o.surface}' by {o.miss:.1%}" for o in found.missed)
    stuck = [f"'{name}' at its {bound}est" for name, bound in found.at_bound.items() if bound]
    remedy = f"widen the bounds of {', '.join(stuck)}, or vary more" if stuck else "vary more, or ask for less at once"
    raise Stop(ExitCode.ACCURACY, f"{file}: missed {missed}: {remedy}")
