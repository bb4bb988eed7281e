"""View3D (Walton, NIST): adaptive line and area integrals, shadows by polygon clipping; one thread.

    VIEW3D=/path/to/view3d python -m peers.peer_view3d SCENE OUT.npy [--eps 1e-4]

The executable is looked for in the environment variable VIEW3D, then as View3D and view3d in PATH. Its input is a text
file of vertices and surfaces; of its output formats the binary one is used, because text has six digits only.
"""

from __future__ import annotations

import os
import re
import resource
import shutil
import subprocess
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from factor_scenes import Scene
from peers.view_factors import Answer, parser, peak_of, report

HEADER = 32  # bytes: program, version, format, enclosure, emittances, number of surfaces
SECONDS = re.compile(r"([\d.]+) seconds to compute view factors")


def main() -> None:
    """Run View3D on a scene."""
    options = parser("View3D on a scene of the comparison")
    options.add_argument("--eps", type=float, default=1e-4, help="convergence; 1e-4 is View3D's own")
    args = options.parse_args()
    program = executable()
    report(args, lambda of: factors(of, program, args.eps), f"eps {args.eps:g}, 1 thread")


def executable() -> Path:
    """The program, or an exit that says how to name it."""
    named = os.environ.get("VIEW3D")
    found = named or shutil.which("View3D") or shutil.which("view3d")
    if found is None or not Path(found).is_file():
        raise SystemExit(f"no file {named}" if named else "set VIEW3D to the path of a View3D executable")
    return Path(found).resolve()


def factors(of: Scene, program: Path, eps: float) -> Answer:
    """All factors; not normalised, so that row sums are what was computed."""
    with tempfile.TemporaryDirectory() as folder:
        source, result = Path(folder, "scene.vs3"), Path(folder, "factors.bin")
        source.write_text(vs3(of, eps))
        start = perf_counter()
        done = subprocess.run([program, source, result], cwd=folder, capture_output=True, text=True, check=False)
        seconds = perf_counter() - start
        if done.returncode != 0 or not result.exists():
            raise SystemExit(f"View3D failed: {done.stderr.strip()[-200:]}")
        log = "".join(p.read_text(errors="replace") for p in Path(folder).glob("*.LOG"))
        said = SECONDS.findall(done.stderr + log)
        peak = peak_of(resource.RUSAGE_CHILDREN)
        return Answer(read(result, len(of.faces)), float(said[-1]) if said else seconds, peak)


def vs3(of: Scene, eps: float) -> str:
    """The scene as View3D reads it; a fourth vertex of 0 says triangle."""
    vertices = [f"V {k} {x:.9g} {y:.9g} {z:.9g}" for k, (x, y, z) in enumerate(of.vertices, 1)]
    corners = np.zeros((len(of.faces), 4), int)
    corners[:, : of.faces.shape[1]] = of.faces + 1
    surfaces = [f"S {k} {a} {b} {c} {d} 0 0 0.9 s{k}" for k, (a, b, c, d) in enumerate(corners, 1)]
    return "\n".join([f"T {of.name}", "F 3", f"C eps={eps:g} out=1 list=0", *vertices, *surfaces, "E", ""])


def read(path: Path, n: int) -> NDArray[np.float32]:
    """F from the binary output: a header, areas, rows of F, emittances, all in single precision."""
    numbers = np.fromfile(path, "<f4", offset=HEADER)
    if len(numbers) != n * (n + 2):
        raise SystemExit(f"View3D wrote {len(numbers)} numbers where {n * (n + 2)} were expected")
    return numbers[n:-n].reshape(n, n)


if __name__ == "__main__":
    main()
