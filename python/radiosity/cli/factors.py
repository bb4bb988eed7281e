"""``radiosity factors``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from radiosity.cli import interrupt, options, output, source
from radiosity.cli.progress import Bar

if TYPE_CHECKING:
    from radiosity import FormFactors


def factors(
    file: options.SceneFile,
    target: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="Where to save: .npz.")],
    method: Annotated[str, typer.Option(help="How they are found: auto or monte_carlo.")] = "auto",
    rays: Annotated[int | None, typer.Option(min=1, max=2**32 - 1, metavar="N", help="Rays per patch.")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Wanted standard error of one factor; sets --rays.")] = None,
    max_edge: options.MaxEdge = None,
    patches: options.PatchCount = None,
    as_is: options.AsIs = False,
    max_patches: options.MaxPatches = None,
    unit: options.Unit = None,
    threads: options.Threads = None,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure the form factors between all patches of a scene.

    The file opens with scipy.sparse.load_npz; numpy.load shows area, centre, normal, surface, face and closure too.
    """
    import radiosity

    output.check_outputs([target], [".npz"], file)
    meshing = source.Meshing(max_edge, patches, as_is, max_patches)
    source.use_threads(threads)
    elements = source.cut(file, source.open_scene(file, unit=unit, two_sided=False), meshing)
    with source.naming(file, elements.scene.name), Bar("measuring", quiet=quiet) as bar:
        f = radiosity.form_factors(
            elements,
            method=method,  # type: ignore[arg-type]  # the engine says which there are
            tolerance=tolerance,
            rays=rays,
            seed=seed,
            threads=threads,
            progress=bar,
        )
    entries = _save(f, target)
    if as_json:
        output.print_json({"scene": file, "outputs": [target], **_summary(f, entries)})
    elif not quiet:
        closure = f.closure()
        print(f"{len(elements):,} patches, {entries:,} form factors above zero")
        print(f"row sums {closure.min():.4f} to {closure.max():.4f}")
        print(f"wrote {target}")


def _save(f: FormFactors, target: Path) -> int:
    """Write F as compressed rows beside what the rows are; returns how many factors are not zero."""
    import numpy as np

    from radiosity.files import write_whole

    matrix, p = f.to_scipy_sparse(), f.patches
    arrays = {
        "format": b"csr", "shape": np.array(matrix.shape),
        "data": matrix.data, "indices": matrix.indices, "indptr": matrix.indptr,
        "area": p.area, "centre": p.centre, "normal": p.normal, "surface": p.surface, "face": p.face,
        "closure": f.closure(),
    }  # fmt: skip
    with interrupt.writing(), output.naming_file(target):
        write_whole(target, lambda file: np.savez_compressed(file, **arrays))
    return int(matrix.nnz)


def _summary(f: FormFactors, entries: int) -> dict[str, float]:
    closure = f.closure()
    return {
        "patches": len(f.patches),
        "entries": entries,
        "closure_min": float(closure.min()),
        "closure_max": float(closure.max()),
    }
