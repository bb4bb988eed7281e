"""Golden pictures: what each is of, and whether another is of the same light.

Pictures of the same scene by another seed differ by noise, so what is kept is the mean and the variance over
independent pictures, solve included. A new picture is held to both by statistics, not pixel by pixel (as Mitsuba's and
pbrt's are).

    python tests/golden/goldens.py [NAME ...]    make them again, after looking at them
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import radiosity
from radiosity.picture import Mode, render, save_image
from radiosity.scene import Scene

Picture = npt.NDArray[np.float64]

HERE = Path(__file__).resolve().parent
FOLDER = HERE.parents[1] / "out" / "golden"
"""Where pictures that failed leave what they look like."""

COPIES = 16
"""Independent pictures that a golden one is made of."""

SIZE = (40, 30)
"""Width and height, pixels."""


class Subject(NamedTuple):
    """What a golden picture is of."""

    make: Callable[[], Scene]
    mode: Mode
    max_edge: float
    samples: int


def tiled_box() -> Scene:
    """The Cornell box with a floor of tiles."""
    scene = radiosity.scenes.cornell_box()
    floor = next(surface for surface in scene.surfaces if surface.name == "floor")
    tiles = np.kron([[0.1, 1.0], [1.0, 0.1]], np.ones((8, 8)))
    places = np.asarray(floor.vertices)[:, [0, 2]]
    floor.texture = radiosity.Texture(tiles, 3.0 * places / places.max(axis=0))
    return scene


SUBJECTS: dict[str, Subject] = {
    "cornell-smooth": Subject(radiosity.scenes.cornell_box, "smooth", 0.06, 16),
    "cornell-patches": Subject(radiosity.scenes.cornell_box, "patches", 0.1, 16),
    "cornell-gather": Subject(radiosity.scenes.cornell_box, "gather", 0.06, 16),
    "cornell-path": Subject(radiosity.scenes.cornell_box, "path", 1.0, 256),
    "ferren-gather": Subject(radiosity.scenes.ferren, "gather", 0.2, 16),
    "mirror-room-gather": Subject(radiosity.scenes.mirror_room, "gather", 0.5, 32),
    "lampshade-gather": Subject(radiosity.scenes.lampshade, "gather", 0.2, 64),
    "tiled-box-gather": Subject(tiled_box, "gather", 0.06, 16),
}


def draw(subject: Subject, seed: int) -> Picture:
    """One picture, solved and drawn afresh."""
    scene = subject.make()
    eye, (width, height) = scene.cameras[0], SIZE
    size = {"width": width, "height": height, "samples": subject.samples, "seed": seed}
    patches = scene.patches(max_edge=subject.max_edge)
    lit = patches if subject.mode == "path" else radiosity.solve(patches, accuracy=0.03, seed=seed)
    return render(lit, eye, mode=subject.mode, **size).astype(np.float64)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Golden:
    """Mean and variance of single pictures, (height, width, bands), over some copies."""

    mean: Picture
    variance: Picture
    copies: int

    @classmethod
    def load(cls, name: str) -> Golden:
        """Read one that was made."""
        with np.load(HERE / f"{name}.npz") as arrays:
            mean, variance = (arrays[key].astype(np.float64) for key in ("mean", "variance"))
            return cls(mean, variance, int(arrays["copies"]))

    @classmethod
    def of(cls, pictures: list[Picture]) -> Golden:
        """The statistics of some pictures."""
        return cls(np.mean(pictures, axis=0), np.var(pictures, axis=0, ddof=1), len(pictures))

    def save(self, name: str) -> None:
        """Keep it, in single precision."""
        mean, variance = self.mean.astype(np.float32), self.variance.astype(np.float32)
        np.savez_compressed(HERE / f"{name}.npz", mean=mean, variance=variance, copies=self.copies)

    def scores(self, picture: Picture) -> Picture:
        """How many standard deviations each pixel is off, by their mean over bands.

        Neighbours share what noise they have, and a few copies do not tell the variance of a single pixel well: so it
        is averaged over the pixels around. What never varies may differ by rounding.
        """
        level = float(self.mean.mean())
        off = (picture - self.mean).mean(axis=2)
        # Bands share their paths.
        deviation = np.sqrt(self.variance).mean(axis=2) ** 2
        own = _around(deviation) * (1 + 1 / self.copies) + (1e-4 * level) ** 2
        return off / np.sqrt(own)

    def verdict(self, picture: Picture) -> str | None:
        """What is wrong with a picture; None if it is of the same light."""
        if picture.shape != self.mean.shape:
            return f"it has the shape {picture.shape}, not {self.mean.shape}"
        scores = self.scores(picture)
        far = float(np.mean(np.abs(scores) > FAR))
        if far > MOST_FAR:
            return f"{far:.1%} of its pixels are more than {FAR:g} standard deviations off"
        spread = float(np.mean(np.minimum(scores**2, FAR**2)))
        if not LEAST_SPREAD < spread < MOST_SPREAD:
            return f"the mean square of its deviations is {spread:.2f} variances"
        bright = float(picture.mean() / self.mean.mean() - 1)
        # As if only every twelfth pixel had noise of its own, at three standard deviations and more.
        noise = math.sqrt(float(self.variance.mean())) / float(self.mean.mean())
        allowed = 0.004 + 12 * noise / math.sqrt(scores.size)
        if abs(bright) > allowed:
            return f"it is {bright:+.2%} brighter on average"
        return None


FAR = 5.0
MOST_FAR = 0.01
LEAST_SPREAD, MOST_SPREAD = 0.2, 2.5


def _around(values: Picture) -> Picture:
    """Means over three by three pixels."""
    padded = np.pad(values, 1, mode="edge")
    height, width = values.shape
    return np.mean([padded[y : y + height, x : x + width] for y in range(3) for x in range(3)], axis=0)


def leave(name: str, golden: Golden, picture: Picture) -> Path:
    """Write the golden picture, the other and their difference side by side, and tell where."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    level = float(golden.mean.mean())
    difference = np.clip(0.5 * level + 2 * (picture - golden.mean), 0, None)
    path = FOLDER / f"{name}-difference.png"
    save_image(path, np.concatenate([golden.mean, picture, difference], axis=1).astype(np.float32))
    return path


def main() -> None:
    """Make golden pictures anew."""
    for name in sys.argv[1:] or SUBJECTS:
        golden = Golden.of([draw(SUBJECTS[name], seed) for seed in range(1000, 1000 + COPIES)])
        golden.save(name)
        noise = np.sqrt(golden.variance.mean()) / golden.mean.mean()
        print(f"{name}: noise {noise:.2%} of the mean; look at {leave(name, golden, golden.mean)}")


if __name__ == "__main__":
    main()
