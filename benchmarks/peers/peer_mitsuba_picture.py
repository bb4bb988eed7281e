"""Mitsuba 3: a picture of the Cornell box by path tracing.

    python -m peers.peer_mitsuba_picture [--samples 16 64 ...]
    python -m peers.peer_mitsuba_picture --reference 32768

Importing, loading and the compilation of kernels are not timed.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import mitsuba as mi
import numpy as np

from peers.peer_mitsuba import scene_of, start_backend
from peers.reference import faces, load
from peers.view import CORNELL, REFERENCE, SIZE, Picture, View, arguments, climb

LADDER = [16, 64, 256, 1024, 4096, 16384]
MILLI = 1000.0  # the file of the scene counts in thousandths of a metre
AT_ONCE = 1024  # samples a pixel that one call takes


def main() -> None:
    """Climb the ladder, or make the reference."""
    parser = arguments("Mitsuba 3: a picture of the Cornell box")
    parser.add_argument("--samples", type=int, nargs="+", default=LADDER, metavar="N")
    parser.add_argument("--reference", type=int, metavar="N", help="write the reference with so many samples a pixel")
    args = parser.parse_args()
    start_backend(args.threads)
    scene, sensor = scene_of(faces(load())), camera(CORNELL)
    if args.reference:
        write_reference(scene, sensor, args.reference)
        return
    for samples in sorted({min(samples, AT_ONCE) for samples in args.samples}):
        draw(scene, sensor, samples, 0)  # compiles the kernels of this size
    climb({f"spp {samples}": partial(draw, scene, sensor, samples) for samples in args.samples}, args)


def camera(view: View) -> Any:
    """A perspective camera with a box filter."""
    film = {
        "type": "hdrfilm",
        "width": SIZE,
        "height": SIZE,
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }
    return mi.load_dict(
        {
            "type": "perspective",
            "fov": view.angle,
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(
                origin=[MILLI * x for x in view.position],
                target=[MILLI * x for x in view.target],
                up=list(view.up),
            ),
            "sampler": {"type": "independent"},
            "film": film,
        }
    )


def draw(scene: Any, sensor: Any, samples: int, seed: int) -> Picture:
    """A picture of so many samples a pixel, as many at once as memory takes."""
    calls = max(samples // AT_ONCE, 1)
    each = samples // calls
    parts = (np.array(mi.render(scene, sensor=sensor, spp=each, seed=100_000 * seed + k)) for k in range(calls))
    return np.asarray(sum(part.astype(np.float64) for part in parts) / calls)


def write_reference(scene: Any, sensor: Any, samples: int) -> None:
    """Write two halves as mean and difference."""
    one, other = (draw(scene, sensor, samples // 2, seed) for seed in (7001, 7002))
    REFERENCE.parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(REFERENCE, picture=0.5 * (one + other), noise=0.5 * (one - other))


if __name__ == "__main__":
    main()
