"""Arguments and options that several commands share, and how their text is read."""

from __future__ import annotations

import math
import re
import sys
from typing import Annotated

import typer

from radiosity.cli.failure import bad_argument

MOST_PATCHES = 50_000_000
"""The engine's own limit."""

Triple = tuple[float, float, float]

SceneFile = Annotated[
    str,
    typer.Argument(
        metavar="FILE",
        help="A .glb, .gltf, .obj, .stl, .ply or .vs3 file, or builtin:NAME (see radiosity scenes).",
    ),
]

# How the scene is read.
Unit = Annotated[str | None, typer.Option(help="What the number 1 in the file means: m, cm, mm, in, ft, km or metres.")]
TwoSided = Annotated[
    bool | None,
    typer.Option("--two-sided/--one-sided", help="Which sides reflect, whatever the file says.", show_default=False),
]

Enclosure = Annotated[
    bool | None,
    typer.Option(
        "--enclosure/--no-enclosure",
        help="Whether the surfaces should enclose a space; as the file says by default.",
        show_default=False,
    ),
]

# How it is cut into patches.
MaxEdge = Annotated[float | None, typer.Option(metavar="METRES", help="Longest edge of a patch.")]
PatchCount = Annotated[
    int | None, typer.Option("--patches", min=1, max=MOST_PATCHES, metavar="N", help="About how many patches.")
]
AsIs = Annotated[bool, typer.Option("--as-is", help="One patch per face of the file.")]
MaxPatches = Annotated[int | None, typer.Option(min=1, metavar="N", help="The most patches allowed.")]

Focus = Annotated[
    str | None,
    typer.Option(
        "--for",
        metavar="SURFACE",
        help="A surface that matters: the accuracy is that of the light on it.",
        show_default=False,
    ),
]

# How it is solved.
Accuracy = Annotated[float, typer.Option(help="Wanted error of irradiance, RMS over area, relative to the mean.")]
MaxRays = Annotated[int | None, typer.Option(min=1, max=2**32 - 1, metavar="N", help="Most rays per patch.")]
TimeLimit = Annotated[
    float | None,
    typer.Option(
        "--time-limit",
        "--time",
        metavar="SECONDS",
        help="Seconds after which a mesh of the engine's own is not refined, and shooting adds no more rays.",
        show_default=False,
    ),
]
Memory = Annotated[str | None, typer.Option(metavar="SIZE", help="Memory to stay within, such as 4GB or 500MiB.")]
Solver = Annotated[
    str | None,
    typer.Option(
        help="How the equations are solved: conjugate_gradient, jacobi, gauss_seidel, over_relaxation; or by shooting "
        "from the brightest patch, without a matrix: southwell, overshooting; or by rays that carry power, for scenes "
        "too large for anything else: shooting. Chosen by default.",
        show_default=False,
    ),
]
Transport = Annotated[
    str | None,
    typer.Option(
        help="What they are solved on: sampled, what every patch sees; or hierarchical, an exchange in blocks, for "
        "many patches. Chosen by default.",
        show_default=False,
    ),
]
MaxIterations = Annotated[
    int | None, typer.Option(min=0, metavar="N", help="Most products, sweeps or shots; as many as it takes by default.")
]
Threads = Annotated[int | None, typer.Option(min=1, metavar="N", help="Threads to use; all cores by default.")]
Seed = Annotated[int, typer.Option(min=0, max=2**64 - 1, help="The same seed gives the same bytes.")]

# How it is drawn.
Ambient = Annotated[
    float | None,
    typer.Option(
        metavar="W/M2",
        help="Ambient irradiance of whitted pictures, in every band; what interreflection is worth by default.",
        show_default=False,
    ),
]

# What is said.
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else there.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]

_SIZE = re.compile(r"\s*([0-9]*\.?[0-9]+)\s*([kmgt]?)(i?)b?\s*", re.IGNORECASE)


def read_size(text: str) -> int:
    """Bytes from text such as ``4GB`` (powers of 1000) or ``500MiB`` (powers of 1024).

    Raises:
        Stop: it is no size.
    """
    match = _SIZE.fullmatch(text)
    if match is None:
        raise bad_argument(f"'{text}' is no size of memory: write a number and a unit, such as 4GB or 500MiB")
    number, prefix, binary = match.groups()
    size = float(number) * (1024 if binary else 1000) ** " kmgt".index(prefix.lower() or " ")
    return int(min(size, sys.maxsize // 2))


def read_triple(text: str, option: str) -> Triple:
    """Three finite numbers from ``x,y,z``.

    Raises:
        Stop: it is something else.
    """
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        x = math.nan
    if not math.isfinite(x) or not math.isfinite(y + z):
        raise bad_argument(f"{option} '{text}' is not a point: write three numbers with commas, such as 0,1.5,-2")
    return x, y, z
