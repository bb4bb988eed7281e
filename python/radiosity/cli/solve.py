"""``radiosity solve``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from radiosity.cli import options, output, source
from radiosity.cli.failure import ExitCode, Stop
from radiosity.cli.progress import Bar

if TYPE_CHECKING:
    from radiosity import FormFactors, Patches, Scene, Solution

SUFFIXES = (".glb", ".npz", ".vtp")

Outputs = Annotated[
    list[Path] | None,
    typer.Option("--output", "-o", metavar="FILE", help="Where to save: .glb, .npz or .vtp; may be repeated."),
]

Exchange = Annotated[
    Path | None,
    typer.Option(
        "--exchange",
        metavar="FILE",
        help="Solve on form factors that radiosity factors saved as .exchange or .npz, on the patches of then.",
    ),
]


@dataclass(frozen=True)
class Effort:
    """How accurate, and with what means."""

    accuracy: float = 0.01
    max_rays: int | None = None
    memory: str | None = None
    solver: str | None = None
    max_iterations: int | None = None
    threads: int | None = None
    seed: int = 0
    time_limit: float | None = None
    transport: str | None = None
    max_patches: int | None = None
    focus: str | None = None


def solve(
    file: options.SceneFile,
    outputs: Outputs = None,
    exchange: Exchange = None,
    accuracy: options.Accuracy = 0.01,
    max_edge: options.MaxEdge = None,
    patches: options.PatchCount = None,
    as_is: options.AsIs = False,
    max_patches: options.MaxPatches = None,
    focus: options.Focus = None,
    max_rays: options.MaxRays = None,
    memory: options.Memory = None,
    time_limit: options.TimeLimit = None,
    unit: options.Unit = None,
    two_sided: options.TwoSided = None,
    solver: options.Solver = None,
    transport: options.Transport = None,
    max_iterations: options.MaxIterations = None,
    threads: options.Threads = None,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Find the equilibrium of light in a scene and save it."""
    targets = outputs or []
    output.check_outputs(targets, SUFFIXES, file)
    meshing = source.Meshing(max_edge, patches, as_is, max_patches)
    effort = Effort(
        accuracy, max_rays, memory, solver, max_iterations, threads, seed, time_limit, transport, max_patches, focus
    )  # fmt: skip
    source.use_threads(threads)
    if exchange is not None:
        two_sided = source.sides_of_factors(file, two_sided)
    scene = source.open_unlit(file, unit=unit, two_sided=two_sided)
    if exchange is None:
        target, factors = source.cut_or_leave(file, scene, meshing), None
    else:
        target, factors = _saved(file, scene, meshing, exchange, memory)
    solution = solve_target(file, target, effort, factors=factors, quiet=quiet)
    output.save(solution, targets)
    findings = scene.findings()
    if as_json:
        found = output.findings_out(findings)
        output.print_json({"scene": file, "outputs": targets, "report": solution.report.to_dict(), "findings": found})
    elif not quiet:
        print(solution.report)
        for path in targets:
            print(f"wrote {path}")
    if not quiet:
        output.warn_of_findings(file, findings)
    output.demand_accuracy(file, solution.report)


def _saved(
    file: str, scene: Scene, meshing: source.Meshing, exchange: Path, memory: str | None
) -> tuple[Patches, FormFactors]:
    """The scene's patches, cut as those of a file of form factors were, and the form factors between them.

    Raises:
        Stop: the file cannot be used for this scene.
    """
    from radiosity import FormFactors
    from radiosity.exchange_files import ExchangeFile, is_exchange

    try:
        if not is_exchange(exchange):
            patches = source.cut(file, scene, meshing)
            return patches, FormFactors.load(exchange, patches)
        saved = ExchangeFile(exchange)
        if saved.cut is not None and meshing.is_left_open:
            meshing = replace(meshing, **saved.cut)
        patches = source.cut(file, scene, meshing)
        return patches, saved.factors(patches, None if memory is None else options.read_size(memory))
    except ValueError as error:
        raise Stop(ExitCode.INPUT, f"{error} (solving {file})") from error


def solve_target(
    file: str, target: Scene | Patches, effort: Effort, *, factors: FormFactors | None = None, quiet: bool
) -> Solution:
    """Solve patches, or a scene on a mesh of the engine's own, with a progress bar, on form factors if they are given.

    Raises:
        SceneError: the scene cannot be lit. ResourceError: it does not fit the memory.
    """
    import radiosity

    memory = None if effort.memory is None else options.read_size(effort.memory)
    limits: dict[str, Any] = {} if effort.max_rays is None else {"max_rays": effort.max_rays}
    if isinstance(target, radiosity.Patches):
        scene = target.scene
    else:
        scene, limits = target, limits | {"max_patches": effort.max_patches}
    with source.naming(file, scene.name), Bar("solving", quiet=quiet) as bar:
        return radiosity.solve(
            target,
            transport=factors or effort.transport,  # type: ignore[arg-type]  # likewise
            accuracy=effort.accuracy,
            solver=effort.solver,  # type: ignore[arg-type]  # the engine says which there are
            max_iterations=effort.max_iterations,
            memory_limit=memory,
            time_limit=effort.time_limit,
            focus=effort.focus,
            threads=effort.threads,
            seed=effort.seed,
            progress=bar,
            **limits,
        )
