"""Remakes the pictures of the gallery and its README.

python docs/gallery/make.py [NAME ...] [--draft]

Without names all pictures are made, each by one command in the folder of this file, and README.md is written. Drafts
take few samples and go to out/gallery.
"""

from __future__ import annotations

import argparse
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
DRAFTS = HERE.parents[1] / "out" / "gallery"

LARGEST = 1_500_000
"""Bytes that a picture may have."""


class Picture(NamedTuple):
    """One picture: its name without suffix, the command that makes it but for the output, and what it shows."""

    name: str
    command: str
    caption: str

    @property
    def file(self) -> str:
        """The name of the file."""
        return f"{self.name}.png"

    @property
    def line(self) -> str:
        """The whole command."""
        return f"{self.command} -o {self.file}"


PICTURES = [
    Picture(
        "ferren-comparison",
        "radiosity compare ferren --columns 2 --width 450 --height 450 --samples 128",
        "The classical comparison, after Goral et al. 1984: white boards whose backs, which one does not see, are "
        "painted and face the window. By direct light their fronts are black, with ambient light they are white, and "
        "only interreflection gives them the colours that they have; path tracing, which solves no equations, agrees.",
    ),
    Picture(
        "ferren",
        "radiosity render builtin:ferren --mode gather --samples 64 --width 860 --height 1024",
        "The boards by themselves: after John Ferren, *Construction in Wood, a Daylight Experiment* (1968).",
    ),
    Picture(
        "goral-box",
        "radiosity compare goral-box --as-is --panels patches,smooth,gather --samples 64 --width 334 --height 334",
        "The empty cube that radiosity began with: 49 patches a side, each of one value; the same interpolated, as "
        "they were shown in 1984; and gathered, where every pixel looks at them once more.",
    ),
    Picture(
        "cornell-box",
        "radiosity compare cornell-box --patches 3000 --panels patches,smooth,gather --samples 64 "
        "--width 334 --height 334",
        "The Cornell box with its two blocks on 3,000 patches.",
    ),
    Picture(
        "cornell-box-spectral",
        "radiosity render builtin:cornell-box-spectral --patches 4000 --accuracy 0.02 --mode gather --samples 64 "
        "--width 768 --height 768",
        "The same in its measured shape and spectra, 76 bands of 4 nm, developed by the colour matching functions of "
        "the CIE. Its lamp is as yellow as that.",
    ),
    Picture(
        "furnished-room-panels",
        "radiosity compare furnished-room --panels patches,smooth,gather --samples 64 --width 334 --height 223",
        "A furnished room on 8,000 patches.",
    ),
    Picture(
        "furnished-room",
        "radiosity render builtin:furnished-room --patches 8000 --accuracy 0.03 --mode gather --width 1024 "
        "--height 683",
        "The room by itself, gathered.",
    ),
    Picture(
        "mirror-room",
        "radiosity render builtin:mirror-room --accuracy 0.02 --mode gather --samples 128 --width 1024 --height 683",
        "A room whose only lamp looks into a mirror: what is behind it is lit by the mirror alone.",
    ),
    Picture(
        "lampshade",
        "radiosity render builtin:lampshade --accuracy 0.1 --mode gather --samples 64 --width 1024 --height 768",
        "Paper and leaves let light through: diffuse transmission, a second reflectance towards the other side.",
    ),
    Picture(
        "irradiance",
        "radiosity render builtin:furnished-room --patches 8000 --accuracy 0.03 --show irradiance --false-colours "
        "--width 880 --height 587",
        "Irradiance of the furnished room.",
    ),
    Picture(
        "error",
        "radiosity render builtin:cornell-box --patches 3000 --accuracy 0.02 --show error --mode patches "
        "--false-colours --width 700 --height 700",
        "How wrong the solution of the Cornell box says that it is, patch by patch: the standard error of irradiance.",
    ),
]
"""All pictures, in the order of the README."""


def readme() -> str:
    """The text of README.md: every picture with its caption and its command."""
    parts = [
        "# Gallery",
        "",
        "`make gallery` remakes this page and its pictures, each by the command below it.",
    ]
    for picture in PICTURES:
        parts += ["", f"![{picture.name}]({picture.file})", "", picture.caption, "", f"    {picture.line}"]
    return "\n".join([*parts, ""])


def make(picture: Picture, folder: Path, more: list[str]) -> None:
    """Run the command of a picture, with further options, in a folder.

    Raises:
        SystemExit: it failed.
    """
    start = time.monotonic()
    command = [sys.executable, "-m", *shlex.split(picture.line), *more, "--quiet"]
    if subprocess.run(command, cwd=folder, check=False).returncode:
        raise SystemExit(f"{picture.name}: its command failed: {shlex.join(command)}")
    size = (folder / picture.file).stat().st_size
    print(f"{picture.file:<28} {time.monotonic() - start:6.1f} s {size / 1e6:6.2f} MB", flush=True)
    if folder == HERE and size > LARGEST:
        raise SystemExit(f"{picture.file} is larger than {LARGEST / 1e6:g} MB: draw it smaller, or with more samples")


def main() -> None:
    """Make the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description="Remake the pictures of the gallery and its README.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="pictures to make; all by default")
    parser.add_argument("--draft", action="store_true", help="few samples, into out/gallery; no README")
    options = parser.parse_args()
    unknown = set(options.names) - {picture.name for picture in PICTURES}
    if unknown:
        raise SystemExit(f"there is no picture {', '.join(sorted(unknown))}")
    folder = DRAFTS if options.draft else HERE
    folder.mkdir(parents=True, exist_ok=True)
    if not options.draft:
        (HERE / "README.md").write_text(readme())
    for picture in PICTURES:
        if not options.names or picture.name in options.names:
            make(picture, folder, ["--samples", "4"] if options.draft else [])


if __name__ == "__main__":
    main()
